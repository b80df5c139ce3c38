"""The command line. Engines are imported inside commands, so that `testbed --help` answers at once."""

from __future__ import annotations

from testbed.cli.entry import main

__all__ = ["main"]
