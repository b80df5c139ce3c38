"""Code and documents use the field's terms: words that only this project's authors would understand do not return.

`docs/glossary.md` has the terms. Identifiers, docstrings, comments and messages of the package are scanned, and the
documents beside README and CHANGELOG; the notes are dated and stay as they were written.
"""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "testbed").rglob("*.py"))
NOTES = ROOT / "docs" / "notes"
"""Dated: they say what was thought on their day."""
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(page for page in sorted((ROOT / "docs").rglob("*.md")) if page.parent != NOTES),
    *sorted((ROOT / "testbed").rglob("*.html")),
]
BESIDE = sorted(
    path for room in ("benchmarks", "concealing", "support", "tests") for path in (ROOT / room).rglob("*.py")
)
INSTEAD = {
    r"\btold\b": "estimated, reported, identified, printed, distinguished",
    r"\bsought\b": "searched, tested for",
    r"\blikelier\b": "posterior odds, more probable",
    r"\bbeforehand\b": "prior, a priori",
    r"\bblows?\b": "impulse",
    r"\blooked over\b": "residual checked",
    r"\btaken back\b|\btakes? back\b": "retracted",
    r"\bunlisted\b": "unmodelled",
    r"\btorques? of no effect\b|\btorques? that no effect (makes|names)\b": "unmodelled torque",
    r"\bwhat is left\b|\bwhat \w+ (\w+ )?leaves?\b": "residual",
    r"\basked of\b": "tested for; commanded",
    r"\bstands beside\b": "is reported with",
    r"\blook-alikes?\b": "indistinguishable, confounded",
}
"""The field's word for every one that is not to be used."""
FILE_FORMATS = {
    "'unlisted'": "a stratum in the answers of sealed blind cases",
    '"unlisted"': "the same",
    '"taken_back"': "a key of diagnosis.json",
    "`taken_back`": "the same, in the documents",
    "`unlisted`": "the stratum, in the documents",
    "benchmarks.blind_unlisted": "the name of a command",
}
"""Parts of file formats, each with what it is; only quoted, and never an identifier."""


@cache
def words_of(text: str) -> str:
    """Return a text in lower case, its identifiers taken apart at underscores and capitals."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", text)
    return " ".join(re.sub(r"[_\s#\"']+", " ", apart).split()).lower()


@cache  # most identifiers return, in the same module and in others
def found_in(text: str) -> tuple[str, ...]:
    """Return the words of a text that are not to be used, with those to use."""
    if text in FILE_FORMATS:
        return ()
    for quoted in FILE_FORMATS:
        text = text.replace(quoted, "")
    return tuple(
        f"{match[0]!r}: {instead}"
        for pattern, instead in INSTEAD.items()
        for match in re.finditer(pattern, words_of(text))
    )


def pieces_of(path: Path) -> Iterator[tuple[int, str]]:
    """Yield identifiers, texts and comments of a module; lines that follow each other in one text are read together."""
    text: tuple[int, list[str]] | None = None
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        piece = token.type in (tokenize.STRING, tokenize.COMMENT) or "STRING" in tokenize.tok_name[token.type]
        if piece:
            text = (token.start[0], []) if text is None else text
            text[1].append(token.string)
        elif token.type != tokenize.NL and text is not None:
            yield text[0], text[1][0] if len(text[1]) == 1 else " ".join(text[1])
            text = None
        if token.type == tokenize.NAME:
            yield token.start[0], token.string
    if text is not None:
        yield text[0], " ".join(text[1])


def paragraphs_of(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the paragraphs of a document with the line of each; the rows of a table are one paragraph each."""
    first, lines = 1, []
    for number, line in enumerate([*path.read_text(encoding="utf-8").splitlines(), ""], start=1):
        if not line.strip() or line.startswith("|"):
            yield first, " ".join(lines)
            yield number, line
            first, lines = number + 1, []
        else:
            lines.append(line)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_package_uses_the_words_of_the_field(path):
    found = [f"{path.relative_to(ROOT)}:{line}: {word}" for line, text in pieces_of(path) for word in found_in(text)]
    assert not found, "\n".join(found)


def test_identifiers_beside_the_package_use_the_words_of_the_field():
    assert not [
        f"{path.relative_to(ROOT)}:{token.start[0]}: {token.string}"
        for path in BESIDE
        for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline)
        if token.type == tokenize.NAME and "told" in words_of(token.string).split()
    ]


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_the_documents_use_the_words_of_the_field(path):
    pieces = paragraphs_of(path)
    found = [f"{path.relative_to(ROOT)}:{line}: {word}" for line, text in pieces for word in found_in(text)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("_is_told_alike", "told"),
        ("TorqueTold", "told"),
        ('"a torque of" "no effect"', "torque of no effect"),
        ("what the model\n    leaves", "what the model leaves"),
        ("taken_back", "taken back"),
    ],
)
def test_words_are_found_inside_identifiers_and_across_lines(text, word):
    assert [each.split(":")[0] for each in found_in(text)] == [f"'{word}'"]


@pytest.mark.parametrize("text", ['"taken_back"', "a toldo", "leaves an entry out", "the stratum `unlisted`"])
def test_file_formats_and_ordinary_words_are_left_alone(text):
    assert not found_in(text)


def test_the_glossary_points_at_files_that_exist():
    for name in re.findall(r"`(testbed/[^`]+)`", (ROOT / "docs/glossary.md").read_text(encoding="utf-8")):
        assert (ROOT / name).exists(), name
