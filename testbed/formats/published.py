"""Bring the JSON Schemas of the testbed's files, and their pages in docs/reference/formats, up to date with the models.

Run `python -m testbed.formats.published` from the root of the repository.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from pydantic.json_schema import GenerateJsonSchema

from testbed.formats.campaign import CampaignResult
from testbed.formats.comparison import ComparisonResult
from testbed.formats.diagnosis import DiagnosisFile
from testbed.formats.estimates import EstimatesResult
from testbed.formats.parts import Part
from testbed.formats.plan import PlanResult
from testbed.formats.run import RunResult

FORMATS: Mapping[str, tuple[type[Part], str]] = {
    "result": (RunResult, "testbed run"),
    "montecarlo": (CampaignResult, "testbed montecarlo"),
    "diagnosis": (DiagnosisFile, "testbed diagnose"),
    "estimates": (EstimatesResult, "testbed estimate"),
    "comparison": (ComparisonResult, "testbed compare"),
    "plan": (PlanResult, "testbed campaign-plan"),
}
"""Model of each file, by its name without `.json`, and the command that writes it."""

_FILES = {model.__name__: f"[{name}.json]({name}.md)" for name, (model, _) in FORMATS.items()}
_TYPES = {"string": "text", "boolean": "true or false"}

SCHEMAS = Path("testbed/formats/schemas")
PAGES = Path("docs/reference/formats")

Node: TypeAlias = Mapping[str, Any]
"""A part of a JSON Schema."""


class _FileSchema(GenerateJsonSchema):
    """A key is its own title, and what has no value is absent or null as its description says: no default is stated."""

    def field_title_should_be_set(self, schema: object) -> bool:  # noqa: ARG002
        return False

    def default_schema(self, schema: Any) -> dict[str, Any]:  # noqa: ANN401 - pydantic's own typed dictionary
        inner: Any = schema["schema"]
        return self.generate_inner(inner["schema"] if inner["type"] == "nullable" else inner)


def file_schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema, draft 2020-12, of a file.

    Args:
        name: of the file without `.json`, one of `FORMATS`.
    """
    model, _ = FORMATS[name]
    schema = model.model_json_schema(schema_generator=_FileSchema)
    return {"$schema": _FileSchema.schema_dialect, **schema, "title": f"{name}.json"}


def published(root: Path) -> dict[Path, str]:
    """Return what each published file should contain.

    Args:
        root: of the repository.
    """
    files = {}
    for name in FORMATS:
        schema = file_schema(name)
        files[root / SCHEMAS / f"{name}.schema.json"] = json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
        files[root / PAGES / f"{name}.md"] = "\n".join(_page(name, schema)) + "\n"
    return files


def _page(name: str, schema: Node) -> Iterator[str]:
    _, command = FORMATS[name]
    link = f"../../../{SCHEMAS.as_posix()}/{name}.schema.json"
    yield from (f"# {name}.json", "", "<!-- Written by `python -m testbed.formats.published`. -->", "")
    about = schema["description"].partition(": ")[2]
    yield f"{about[:1].upper()}{about[1:]} `{command}` writes it, and"
    yield f"[{name}.schema.json]({link}) is its JSON Schema. A key is always there, with null where it has no value,"
    yield "unless its row says that it may be absent. Units are SI, inertia in body axes."
    yield from ("", *_table(schema))
    for title in _parts(schema):
        part = schema["$defs"][title]
        yield from ("", f"## {_words(title).capitalize()}", "", _line(part["description"]), "", *_table(part))


def _parts(schema: Node) -> list[str]:
    """Return the titles of all parts that have a table on the page, in the order in which tables name them."""
    found: dict[str, None] = {}
    waiting = [schema]
    while waiting:
        new = dict.fromkeys(title for title in _named(waiting.pop(0)["properties"]) if title not in found)
        found |= new
        waiting += [schema["$defs"][title] for title in new]
    return list(found)


def _named(node: object) -> Iterator[str]:
    """Yield the titles of the parts that a node refers to, but for whole files, which have pages of their own."""
    if isinstance(node, dict):
        if "$ref" in node and (title := _title(node)) not in _FILES:
            yield title
        yield from (title for each in node.values() for title in _named(each))
    elif isinstance(node, list):
        yield from (title for each in node for title in _named(each))


def _title(node: Node) -> str:
    return str(node["$ref"]).rpartition("/")[2]


def _words(title: str) -> str:
    """Return a part's title in words."""
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in title).strip()


def _line(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _table(part: Node) -> Iterator[str]:
    yield from ("| key | value | meaning |", "|---|---|---|")
    for key, node in part["properties"].items():
        yield f"| `{key}` | {_value(node)} | {_line(node['description'])} |"


def _value(node: Node, *, several: bool = False) -> str:
    """Return what a key may hold, in words; a part is a link to its table, a file to its page."""
    match node:
        case {"anyOf": forms}:
            return " or ".join(_value(each, several=several) for each in forms)
        case {"enum": values} | {"const": values}:
            return " or ".join(_json(each) for each in (values if "enum" in node else [values]))
        case {"$ref": _}:
            title = _title(node)
            words = _words(title)
            return _FILES.get(title, f"[{words}](#{words.replace(' ', '-')})")
        case {"type": "array", "items": items}:
            return f"list of {node.get('minItems', '')} {_value(items, several=True)}".replace("  ", " ")
        case {"type": "object", "additionalProperties": values}:
            return f"table of {_value(values, several=True)}"
        case _:
            word = _TYPES.get(node["type"]) or str(node["type"])
            return f"{word}s" if several else word


def _json(value: object) -> str:
    return f"`{json.dumps(value, ensure_ascii=False)}`"


def main() -> None:
    """Write the published files."""
    for path, text in published(Path()).items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
