"""The libraries of the optional extra `testbed[logs]`, loaded when a log needs them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from testbed.errors import InputError

EXTRA = "pip install 'testbed[logs]'"
"""What installs them."""


def library(module: str, purpose: str) -> Any:  # noqa: ANN401 - a module
    """Return a module of the extra.

    Args:
        module: its dotted name.
        purpose: what it is for, for the message: "reading ULog".

    Raises:
        InputError: it is not installed; the message says what installs it.
    """
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        raise InputError(f"{purpose} needs the package {package}, which is not installed: {EXTRA}") from None
