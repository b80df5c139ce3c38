"""Bounds on an MJCF's memory, checked before MuJoCo reads it, which allocates whatever a file states."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from math import prod
from pathlib import Path
from struct import unpack
from xml.etree import ElementTree

from testbed.errors import InputError
from testbed.files import open_regular, read_bytes

MOST_TEXT = 10_000_000
"""Bytes of an MJCF; the shipped one has 7,000."""
MOST_FILE = 100_000_000
"""Bytes of a mesh, picture or height field; a mesh of a million triangles takes 50 MB."""
MOST_CELLS = 2**24
"""Of a height field or a texture: 4096 by 4096, which take 67 MB."""
MOST_COPIES = 10_000
"""Of a part that is repeated, and numbers that a <size> or a <numeric> reserves; the shipped platform has 14 bodies."""

_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
"""Left out: MuJoCo bears two hyphens in one, XML does not."""
MOST_INCLUDED = 100
"""Files; the shipped model has two."""

_CELLS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
_NUMBERS = {"numeric": ("size",), "user": ("dim",)}
_COPIES = ("replicate", "composite", "flexcomp")
_MOST_DIGITS = 20
"""Of a number that are read: all longer ones are too large as well."""
_FOLDERS = ("meshdir", "texturedir", "assetdir")


def require_bounded(path: Path) -> None:
    """Refuse an MJCF that asks for more memory than any platform takes.

    Args:
        path: of the MJCF; files that it names are relative to its folder.

    Raises:
        InputError: it cannot be read, is no XML, or asks for too much; the message says of what, and how much there may
            be.
    """
    problems = list(_problems(path, path.parent, seen=set()))
    if problems:
        raise InputError(f"{path}: {'; '.join(problems)}; mend the file")


def xml_root(path: Path) -> ElementTree.Element:
    """Return the root of a model's file, which is not larger than any that is read.

    Raises:
        InputError: it cannot be read, or is no XML.
    """
    text = read_bytes(path, "an MJCF file", MOST_TEXT)
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(f"{path}: is UTF-16 text, which MuJoCo does not read; save it as UTF-8")
    text = _COMMENT.sub(b"", text)
    if b"<xacro:" in text:
        raise InputError(
            f"{path}: is a xacro, of which a URDF is made: run `xacro {path.name}` and give what it prints"
        )
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{path}: not a readable MJCF: {error}; mend it there") from None


def _problems(path: Path, base: Path, seen: set[Path]) -> Iterator[str]:
    seen.add(path)
    root = xml_root(path)
    folders = [base, *(base / folder for element in root.iter("compiler") for folder in _named(element, _FOLDERS))]
    yield from _repeated(root)
    for element in root.iter():
        yield from _too_many(element)
        for name in _named(element, ("file",)):
            if element.tag != "include":
                yield from _file_problems(name, folders)
            elif base / name not in seen:  # MuJoCo refuses what is included twice
                yield from _included(name, base, seen)


def _included(name: str, base: Path, seen: set[Path]) -> Iterator[str]:
    if len(seen) > MOST_INCLUDED:
        yield f"includes more than {MOST_INCLUDED} files"
        return
    try:
        yield from _problems(base / name, base, seen)
    except InputError as error:
        yield f"of what it includes, {error}"


def _named(element: ElementTree.Element, attributes: tuple[str, ...]) -> Iterator[str]:
    return (element.attrib[name] for name in attributes if name in element.attrib)


def _too_many(element: ElementTree.Element) -> Iterator[str]:
    if element.tag == "size":
        numbers = [(name, _integer(text)) for name, text in element.attrib.items() if name != "memory"]
    else:
        numbers = [
            (name, _integer(text)) for name in _NUMBERS.get(element.tag, ()) for text in _named(element, (name,))
        ]
    for name, number in numbers:
        if number > MOST_COPIES:
            yield f"<{element.tag} {name}> is {number}, more than {MOST_COPIES}"
    sides = [_integer(text) for text in _named(element, _CELLS.get(element.tag, ()))]
    if prod(sides) > MOST_CELLS:
        yield f"a {element.tag} of {' x '.join(map(str, sides))} has more than {MOST_CELLS} cells"


def _repeated(root: ElementTree.Element) -> Iterator[str]:
    """Count copies through everything that repeats what stands in it."""
    waiting = [(root, 1)]
    while waiting:
        element, copies = waiting.pop()
        if element.tag in _COPIES:
            copies *= prod(_integer(text) for text in element.attrib.get("count", "1").split())
        if copies > MOST_COPIES:
            yield f"<{element.tag}> makes {copies} copies, more than {MOST_COPIES}"
        else:
            waiting += [(child, copies) for child in element]


def _integer(text: str) -> int:
    """Return a whole number; 1 for what is none, which MuJoCo refuses with its own words."""
    return int(text[:_MOST_DIGITS]) if text.isdecimal() else 1


def _file_problems(name: str, folders: list[Path]) -> Iterator[str]:
    for path in {folder / name for folder in folders}:
        if not path.exists():  # of several folders one has it; where none has, MuJoCo says so
            continue
        try:
            with open_regular(path) as file:
                head, size = file.read(24), path.stat().st_size
        except OSError as error:
            yield f"its file {name} cannot be read ({error.strerror})"
            continue
        if size > MOST_FILE:
            yield f"its file {name} is larger than {MOST_FILE / 1e6:g} MB"
        if head.startswith(b"\x89PNG") and len(head) == 24 and prod(unpack(">II", head[16:])) > MOST_CELLS:
            yield f"its picture {name} has more than {MOST_CELLS} pixels"
