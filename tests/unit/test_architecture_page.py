"""docs/architecture.md lists what changes in place; the caches are counted here."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REMEMBERING = {"lru_cache", "cache"}


def decorators() -> Counter[tuple[str, str]]:
    """Return how many functions of every room have a decorator of each name."""
    found: Counter[tuple[str, str]] = Counter()
    for path in (ROOT / "testbed").rglob("*.py"):
        room = path.relative_to(ROOT / "testbed").parts[0]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for each in getattr(node, "decorator_list", []):
                called = each.func if isinstance(each, ast.Call) else each
                if isinstance(called, ast.Name):
                    found[room, called.id] += 1
    return found


def listed(word: str) -> dict[str, int]:
    """Return the rooms and numbers of the table's row that holds a word."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    (row,) = (line for line in page.splitlines() if line.startswith("|") and word in line)
    return {name.rstrip("/"): int(count) for name, count in re.findall(r"`(\S+)` (\d+)", row.split("|")[1])}


def test_every_cache_is_on_the_page():
    counted = decorators()
    remembering: Counter[str] = Counter()
    for (room, name), count in counted.items():
        remembering[room] += count if name in REMEMBERING else 0
    assert listed("`lru_cache`") == dict(+remembering)
    assert listed("`cached_property`") == {
        room: count for (room, name), count in counted.items() if name == "cached_property"
    }
