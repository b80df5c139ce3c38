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
    shown_words, made = shown.split(), output.getvalue().split()
    assert [word for word in shown_words if not _NUMBER.fullmatch(word)] == [
        word for word in made if not _NUMBER.fullmatch(word)
    ]
    numbers = [[float(word) for word in words if _NUMBER.fullmatch(word)] for words in (shown_words, made)]
    assert numbers[0] == pytest.approx(numbers[1], abs=tolerance)
