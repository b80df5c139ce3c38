"""Ctrl-C and termination requests: handled even if the parent process ignored them, deferred during writes."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from io import StringIO
from types import FrameType

_HEARD = (signal.SIGINT, signal.SIGTERM)
HEARING = 1.0
"""s, the longest that a command waits in one go for another process. A signal that comes between Python's last look for
one and the start of a wait, or that the system gives to another thread, is heard at the wait's end only."""


class Interrupted(Exception):  # noqa: N818 - a person's wish, no error
    """Ctrl-C, or a request to end; its argument, if it has one, says what became of the results."""


@contextmanager
def heard_interrupts() -> Iterator[None]:
    """Let SIGINT (Ctrl-C) and SIGTERM (batch systems, containers) raise KeyboardInterrupt for a block.

    Also where the parent process ignores or blocks them, as a shell does for background commands: whoever started the
    command has to be able to end it.
    """
    handlers = (signal.default_int_handler, _as_ctrl_c)
    before = [signal.signal(number, handler) for number, handler in zip(_HEARD, handlers, strict=True)]
    held_back = signal.pthread_sigmask(signal.SIG_UNBLOCK, _HEARD)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held_back)
        for number, handler in zip(_HEARD, before, strict=True):
            signal.signal(number, handler)


def _as_ctrl_c(signum: int, frame: FrameType | None) -> None:
    """Do what Ctrl-C does now, which a design remembers."""
    handler = signal.getsignal(signal.SIGINT)
    assert callable(handler)
    handler(signum, frame)


@contextmanager
def raised_interrupts() -> Iterator[None]:
    """Raise KeyboardInterrupt at a block's end if Ctrl-C came in it.

    For an optimiser that stops at it with a warning, and keeps the exception to itself.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed = False
    with ExitStack() as silenced:

        def note(signum: int, frame: FrameType | None) -> None:
            nonlocal pressed
            pressed = True
            silenced.enter_context(redirect_stderr(StringIO()))
            signal.default_int_handler(signum, frame)

        before = signal.signal(signal.SIGINT, note)
        try:
            yield
        except Exception:
            if pressed:  # a library kept the exception until another call came upon it (SystemError)
                raise KeyboardInterrupt from None
            raise
        finally:
            signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


@contextmanager
def deferred_interrupts() -> Iterator[None]:
    """Defer Ctrl-C and termination requests to the end of a block.

    By their handlers: a blocked signal would be delivered to another thread, and interrupt this one all the same.
    """
    if threading.current_thread() is not threading.main_thread():  # no other one is ever interrupted
        yield
        return
    waiting: list[int] = []
    before = [signal.signal(number, lambda came, _: waiting.append(came)) for number in _HEARD]
    try:
        yield
    finally:
        for number, handler in zip(_HEARD, before, strict=True):
            signal.signal(number, handler)
        for came in waiting[:1]:
            signal.raise_signal(came)
