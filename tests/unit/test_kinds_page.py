"""CONTRIBUTING.md lists the files that know reaction wheels by name, which another kind of actuator adds to."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "testbed"
SECTION = "## A new kind of actuator"


def section() -> str:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return page.partition(SECTION)[2].partition("\n## ")[0]


def listed() -> set[str]:
    """Return the files of both tables, relative to the package."""
    found: set[str] = set()
    for line in section().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if not line.startswith("| `"):
            continue
        room = cells[1].strip("`")
        for name in re.findall(r"`([\w*./]+\.py)`", cells[2]):
            paths = [PACKAGE / name] if room == name else list((PACKAGE / room).rglob(name))
            assert paths, f"{room}{name}: no such file"
            found |= {str(path.relative_to(PACKAGE)) for path in paths}
    return found


def names_in(path: Path) -> Iterator[str]:
    """Yield identifiers and the words that are used as keys; no text and no comments."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        named = (getattr(node, key, None) for key in ("id", "attr", "arg", "name", "asname"))
        yield from (name for name in named if isinstance(name, str))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.fullmatch(r"\w+", node.value):
            yield node.value


def naming_wheels() -> set[str]:
    return {
        str(path.relative_to(PACKAGE))
        for path in PACKAGE.rglob("*.py")
        if any("wheel" in name.lower() for name in names_in(path))
    }


def test_every_file_that_knows_wheels_by_name_is_listed_and_no_other():
    assert listed() == naming_wheels()


def test_the_numbers_of_files_and_rooms_are_those_of_the_code():
    files = naming_wheels()
    rooms = {name.partition("/")[0] for name in files}
    found = re.search(r"known by name in (\d+) files of (\d+) rooms", section().replace("\n", " "))
    assert found is not None
    assert (int(found[1]), int(found[2])) == (len(files), len(rooms))
