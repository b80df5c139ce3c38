"""What an effect from outside the library has to keep, checked where it is registered and where it is predicted."""

from __future__ import annotations

import difflib
import re
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from numbers import Real
from pathlib import Path
from typing import get_args

import numpy as np
import scipy

from testbed.effects.contract import Channel, Effect, Parameter
from testbed.errors import InputError, OwnEffectError
from testbed.prediction.hooks import Hooks, overrides

_ID = re.compile(r"[a-z][a-z0-9_]*")
_PARTS = tuple(name for name in vars(Hooks) if not name.startswith("_") and callable(getattr(Hooks, name)))
_MISTAKES = (ArithmeticError, AttributeError, LookupError, NameError, TypeError, ValueError)
"""What a slip of the pen raises; an `InputError`, which says already what was wrong, is none of these."""


def require_usable(effect: Effect) -> None:
    """Refuse an effect that does not keep the contract.

    Raises:
        InputError: names all that is wrong.
    """
    problems = [*_problems(effect)]
    if not problems:
        problems = [text for component in effect.components for text in _hooks_problems(effect, component)]
    if problems:
        raise InputError(f"{effect.id or type(effect).__name__}: this effect cannot be used: {'; '.join(problems)}")


def _problems(effect: Effect) -> Iterator[str]:
    """Yield what is wrong with what an effect says of itself."""
    if not (isinstance(effect.id, str) and _ID.fullmatch(effect.id)):
        yield f"id = {effect.id!r} is no name in small letters, digits and underscores, such as dry_friction"
    for name in ("components", "look_alikes", "needs"):
        given = getattr(effect, name)
        if isinstance(given, str) or not all(isinstance(each, str) and each for each in given):
            yield f"{name} = {given!r} is no tuple of names: write ('platform',), with the comma"
    if not effect.components:
        yield "components has no entry, such as ('platform',)"
    if unknown := [each for each in effect.needs if each not in get_args(Channel)]:
        yield f"needs {', '.join(map(repr, unknown))}, which is none of {', '.join(get_args(Channel))}"
    for name in ("sentence", "confirm"):
        if not (isinstance(given := getattr(effect, name, None), str) and given):
            yield f"{name} is no sentence"
    if not effect.parameters or not all(isinstance(each, Parameter) for each in effect.parameters):
        yield "parameters is no tuple of testbed.Parameter, of at least one"
        return
    names = [each.name for each in effect.parameters]
    if len(set(names)) < len(names):
        yield f"two of its parameters have one name: {', '.join(names)}"
    for each in effect.parameters:
        yield from _parameter_problems(each)


def _parameter_problems(parameter: Parameter) -> Iterator[str]:
    sizes = {name: getattr(parameter, name) for name in ("typical", "lower", "upper", "absent")}
    if wrong := [f"{name} = {size!r}" for name, size in sizes.items() if not isinstance(size, Real)]:
        yield f"{parameter.name}: no number: {', '.join(wrong)}"
        return
    if not parameter.lower < parameter.upper:
        yield f"{parameter.name}: its lower bound, {parameter.lower:g}, is not below its upper one, {parameter.upper:g}"
        return
    for name in ("typical", "absent"):
        value = getattr(parameter, name)
        if not parameter.lower <= value <= parameter.upper:
            yield f"{parameter.name}: {name} = {value:g} lies outside its bounds"
    if parameter.typical == parameter.absent and not parameter.scanned:
        yield f"{parameter.name}: typical = {parameter.typical:g} is where the effect is absent"


def _hooks_problems(effect: Effect, component: str) -> Iterator[str]:
    """Yield what is wrong with what enters the prediction at a component."""
    try:
        hooks = effect.hooks(component)
    except _MISTAKES as error:
        yield f"hooks({component!r}) raises {type(error).__name__}: {error}"
        return
    if not isinstance(hooks, Hooks):
        yield f"hooks({component!r}) returns {hooks!r} and no testbed.Hooks"
    elif not overrides(hooks, *_PARTS):
        own = [name for name in dir(hooks) if not name.startswith("_") and not hasattr(Hooks, name)]
        near = {name: difflib.get_close_matches(name, _PARTS, n=1) for name in own}
        meant = [f"{name}: did you mean {match[0]}?" for name, match in near.items() if match]
        remedy = "; ".join(meant) or f"override one of {', '.join(_PARTS)}"
        yield f"hooks({component!r}) changes nothing in the prediction; {remedy}"


def is_own(effect: Effect) -> bool:
    """Return whether an effect comes from outside the library."""
    return not type(effect).__module__.startswith("testbed.")


@contextmanager
def blamed_on_own(effects: Sequence[Effect]) -> Iterator[None]:
    """Say of an error in a prediction which effect from outside the library made it, and in which line.

    Args:
        effects: in the model that is predicted; where all are the library's own, an error passes as it is.

    Raises:
        OwnEffectError: in the place of the error.
    """
    try:
        yield
    except _MISTAKES as error:
        own = [each.id for each in effects if is_own(each)]
        if not own:
            raise
        frames = traceback.extract_tb(error.__traceback__)
        lines = [f"{Path(each.filename).name}, line {each.lineno}" for each in frames if not _is_known(each.filename)]
        where = lines[-1] if lines else "in what its hooks return"
        raise OwnEffectError(
            f"{' or '.join(own)}: this effect cannot be predicted: {type(error).__name__}: {error} ({where}); "
            "docs/effects.md says what hooks take and return"
        ) from error


def _is_known(file: str) -> bool:
    """Return whether a file is the testbed's or a library's that it builds on, and so not where the slip is."""
    known = (Path(__file__).parents[1], *(Path(str(module.__file__)).parent for module in (np, scipy)))
    return any(Path(file).is_relative_to(each) for each in known)
