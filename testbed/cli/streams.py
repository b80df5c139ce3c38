"""Standard output and error that take any text, whatever the terminal can show and wherever they lead."""

from __future__ import annotations

import codecs
import io
import os
import sys
import unicodedata
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

TRANSLITERATED = "testbed.transliterated"
"""The error handler that writes a character which an encoding lacks in other words."""
_WRITTEN = {"±": "+-", "─": "-", "→": "->", "×": "x", "·": "*", "°": "deg", "√": "sqrt", "≤": "<=", "≥": ">=", "–": "-"}
"""What stands for characters that Unicode does not decompose."""
_OUTPUT_LOST = 2
"""Exit code where standard output could not be written, as for any other place that cannot be."""


def transliterated(text: str) -> str:
    """Return a text in ASCII: a letter with its accent as the letter, a Greek letter by its name, else `?`."""
    return "".join(map(_ascii, text))


def _ascii(character: str) -> str:
    if character.isascii():
        return character
    if character in _WRITTEN:
        return _WRITTEN[character]
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain or _named(character)


def _named(character: str) -> str:
    """Return a Greek letter's name, a byte of a file name that is no text as an escape, `?` for all else."""
    if 0xDC80 <= ord(character) <= 0xDCFF:  # how Python holds such a byte
        return f"\\x{ord(character) - 0xDC00:02x}"
    alphabet, _, letter = unicodedata.name(character, "").rpartition(" LETTER ")
    if not alphabet.startswith("GREEK"):
        return "?"
    return letter.capitalize() if alphabet.endswith("CAPITAL") else letter.lower()


def _replacement(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return transliterated(error.object[error.start : error.end]), error.end


codecs.register_error(TRANSLITERATED, _replacement)


class SturdyStream(io.TextIOWrapper):
    """A text stream that drops its output, without an error, once its device is full or its reader has gone."""

    failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text, or drop it."""
        self._attempt(lambda: super(SturdyStream, self).write(text))
        return len(text)

    def flush(self) -> None:
        """Flush what was written, or drop it."""
        self._attempt(super().flush)

    def _attempt(self, action: Callable[[], object]) -> None:
        try:
            action()
        except OSError as error:
            self.failure = self.failure or error
            with Path(os.devnull).open("wb") as nowhere:
                os.dup2(nowhere.fileno(), self.fileno())  # what is still held back goes there too


@contextmanager
def sturdy_streams() -> Iterator[Callable[[], int]]:
    """Let standard output and error survive a full device or a closed pipe for a block.

    Yields:
        A function to call at the end of the block. It returns the exit code: not 0 if output was lost, which it reports
        on standard error; 0 if all of it was written, or if the reader, such as `head`, had gone.
    """
    _occupy_standard_numbers()
    before = sys.stdout, sys.stderr
    output, complaints = (_sturdy(stream) for stream in before)
    sys.stdout, sys.stderr = output or before[0], complaints or before[1]
    try:
        yield lambda: _lost(output)
    finally:
        sys.stdout, sys.stderr = before
        for stream in (output, complaints):
            if stream is not None:
                stream.detach()  # or its end would close what it shares with the stream before


def _sturdy(stream: TextIO | None) -> SturdyStream | None:
    """Return a stream to where another one leads; None of one that was closed, or that something else has replaced."""
    if not isinstance(stream, io.TextIOWrapper):
        return None
    return SturdyStream(
        stream.buffer,
        encoding=stream.encoding,
        errors=TRANSLITERATED,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


def _occupy_standard_numbers() -> None:
    """Open what the shell has closed (`>&-`), or the first file that is written would be taken for the terminal."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def _lost(output: SturdyStream | None) -> int:
    if output is None:
        return 0
    output.flush()
    if output.failure is None or isinstance(output.failure, BrokenPipeError):
        return 0
    reason = output.failure.strerror
    print(
        f"error: standard output: cannot be written ({reason}); what it should show is lost, written files are whole",
        file=sys.stderr,
    )
    return _OUTPUT_LOST
