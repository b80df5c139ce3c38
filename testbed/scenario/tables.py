"""The tables of docs/scenarios.md: every key, what it may be, its unit, its default and its meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

from testbed.scenario.keys import DISCRIMINATORS

Node: TypeAlias = Mapping[str, Any]
"""A part of a JSON Schema."""

UNITS = {
    "_rad_s_per_sqrt_s": "rad/s/√s",
    "_N_m_s_rad": "N·m·s/rad",
    "_N_m_s": "N·m·s",
    "_kg_m2": "kg·m²",
    "_rad_s2": "rad/s²",
    "_A_m2": "A·m²",
    "_m_s2": "m/s²",
    "_rad_s": "rad/s",
    "_N_m": "N·m",
    "_m_s": "m/s",
    "_1_s": "1/s",
    "_rad": "rad",
    "_deg": "°",
    "_hz": "Hz",
    "_kg": "kg",
    "_s": "s",
    "_m": "m",
    "_T": "T",
}
"""Unit that the end of a key names; longer ends first."""

_BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
_WORDS = {"string": "text", "boolean": "true or false"}


def key_tables(schema: Node) -> str:
    """Return one Markdown table for the top level and one for every form of every section.

    Args:
        schema: as from `scenario_schema`.
    """
    return "\n".join(_section("", schema, schema["$defs"]))


def unit_of(key: str) -> str:
    """Return the unit that a key's end names; empty for a pure number, a text or a choice."""
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), "")


def _section(name: str, section: Node, definitions: Node) -> Iterator[str]:
    nested = {key: _forms(node, definitions) for key, node in section["properties"].items()}
    needed = dict.fromkeys(
        section.get("dependentSchemas", ()), "required where a platform with [cluster] or [[actuators]] flies"
    )
    needed |= dict.fromkeys(section.get("required", ()), "required")
    yield from (_heading(name, section), "", section["description"], "")
    if section["properties"].keys() - set(DISCRIMINATORS):
        yield from ("| key | value | unit | default | meaning |", "|---|---|---|---|---|")
    for key, node in section["properties"].items():
        if key not in DISCRIMINATORS:  # those stand in the heading
            table = "list of tables" if _repeats(node) else "table"
            yield _row(key, table if nested[key] else _value(node), node, needed.get(key))
    yield ""
    for key, forms in nested.items():
        brackets = "[[{}]]" if _repeats(section["properties"][key]) else "[{}]"
        for form in forms:
            yield from _section(brackets.format(f"{name.strip('[]')}.{key}".removeprefix(".")), form, definitions)


def _repeats(node: Node) -> bool:
    """Return whether a key holds a list of tables."""
    items = node.get("items") if node.get("type") == "array" else None
    return isinstance(items, Mapping) and ("$ref" in items or any("$ref" in form for form in items.get("oneOf", ())))


def _forms(node: Node, definitions: Node) -> list[Node]:
    """The tables that a key may hold; none where it holds a plain value."""
    if _repeats(node):
        return _forms(node["items"], definitions)
    if "$ref" in node:
        return [definitions[node["$ref"].rpartition("/")[2]]]
    return [form for part in node.get("oneOf", ()) for form in _forms(part, definitions)]


def _heading(name: str, section: Node) -> str:
    properties = section["properties"]
    chosen = [f"`{key} = {json.dumps(properties[key]['const'])}`" for key in DISCRIMINATORS if key in properties]
    title = f"### `{name}`" if name else "### Top level"
    return f"{title} with {', '.join(chosen)}" if chosen else title


def _row(key: str, value: str, node: Node, needed: str | None) -> str:
    default = needed or _default(node)
    return f"| `{key}` | {value} | {unit_of(key)} | {default} | {' '.join(node['description'].split())} |"


def _default(node: Node) -> str:
    return f"`{json.dumps(node['default'])}`" if "default" in node else "omitted"


def _value(node: Node) -> str:
    if "const" in node or "enum" in node:
        choices = node.get("enum") or [node["const"]]
        return " or ".join(f"`{json.dumps(choice)}`" for choice in choices)
    if "oneOf" in node:
        return " or ".join(_value(part) for part in node["oneOf"])
    if node["type"] == "array":
        return _list(node)
    if node.get("format") == "path":
        return "path"
    bounds = (f"{sign} {node[key]:g}" for key, sign in _BOUNDS.items() if key in node)
    return " ".join([_WORDS.get(node["type"]) or str(node["type"]), ", ".join(bounds)]).strip()


def _list(node: Node) -> str:
    fixed = "prefixItems" in node
    entry = _value(node["prefixItems"][0] if fixed else node["items"])
    noun, _, rest = entry.partition(" ")
    plural = f"{noun}s {rest}".strip() if noun in ("number", "integer", "list") else entry
    return f"list of {len(node['prefixItems'])} {plural}" if fixed else f"list of {plural}"
