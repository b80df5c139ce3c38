"""What a document shows of a program's output, held against what the program prints."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout

import pytest

_NUMBER = re.compile(r"-?\d+(\.\d+)?(e-?\d+)?")


def shown_program(page: str) -> tuple[str, str]:
    """Return the program of a page that is followed by its output, and that output."""
    code, shown = re.search(r"```python\n((?:(?!```).)*)```\n(?:(?!```).)*\n```\n(.*?)```", page, re.DOTALL).groups()
    return code, shown


def require_printed(page: str, tolerance: float) -> None:
    """Run a page's program, and require the words that the page shows, and its numbers to a tolerance.

    Machines differ in the last digits of an estimate.
    """
    code, shown = shown_program(page)
    output = io.StringIO()
    with redirect_stdout(output):
        exec(compile(code, "page", "exec"), {})
    require_same(shown, output.getvalue(), tolerance)


def require_same(shown: str, made: str, tolerance: float) -> None:
    """Require the same words in two texts, and the same numbers to an absolute tolerance."""
    texts = shown.split(), made.split()
    words, words_made = ([word for word in text if not _NUMBER.fullmatch(word)] for text in texts)
    assert words == words_made
    numbers, numbers_made = ([float(word) for word in text if _NUMBER.fullmatch(word)] for text in texts)
    assert numbers == pytest.approx(numbers_made, abs=tolerance)
