"""An extension of griffe for the site: a parameter shows the type of its annotation, not the name of its check."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import griffe


class PlainTypes(griffe.Extension):
    """Shows `Seed | None`, where Seed is an `Annotated[int, ...]`, as `int | None`."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:  # noqa: ANN401 - griffe passes more than is used
        """Change the parameters of the library's functions."""
        modules = [each for each in pkg["library"].modules.values() if not each.is_alias]
        attributes = [each for module in modules for each in module.attributes.values() if not each.is_alias]
        checks = {each.path: each.value for each in attributes if _is_annotated(each.value)}
        for function in (function for module in modules for function in _functions(module)):
            for parameter in function.parameters:
                parameter.annotation = _plain(parameter.annotation, checks)


def _functions(within: griffe.Module | griffe.Class) -> Iterator[griffe.Function]:
    yield from (each for each in within.functions.values() if not each.is_alias)
    for inner in within.classes.values():
        if not inner.is_alias:
            yield from _functions(inner)


def _is_annotated(value: Any) -> bool:  # noqa: ANN401 - griffe has many kinds of expressions
    return isinstance(value, griffe.ExprSubscript) and value.left.canonical_path == "typing.Annotated"


def _plain(annotation: Any, checks: Mapping[str, griffe.Expr]) -> Any:  # noqa: ANN401
    if isinstance(annotation, griffe.ExprName) and annotation.canonical_path in checks:
        return _plain(checks[annotation.canonical_path], checks)
    if _is_annotated(annotation):
        return _plain(annotation.slice.elements[0], checks)
    if isinstance(annotation, griffe.ExprBinOp):
        left, right = _plain(annotation.left, checks), _plain(annotation.right, checks)
        return griffe.ExprBinOp(left=left, operator=annotation.operator, right=right)
    if isinstance(annotation, griffe.ExprSubscript):
        return griffe.ExprSubscript(left=annotation.left, slice=_plain(annotation.slice, checks))
    if isinstance(annotation, griffe.ExprTuple):
        elements = [_plain(each, checks) for each in annotation.elements]
        return griffe.ExprTuple(elements=elements, implicit=annotation.implicit)
    return annotation
