"""What several commands make of the same options: a scenario with changed keys, a folder to resume in, its summary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.cli.console import say
from testbed.errors import InputError
from testbed.library.scenarios import overrides_of, read_scenario, require_flyable
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario


def changed_scenario(source: str, changes: Sequence[str]) -> BodyScenario:
    """Return a scenario with the keys that `--set` changes.

    Args:
        source: path of the scenario, or name of a shipped one.
        changes: KEY=VALUE each.

    Raises:
        InputError: the scenario cannot be used, or a change fits none of its keys.
    """
    return read_scenario(source, overrides_of(changes))


def changed_flight(source: str, changes: Sequence[str]) -> Scenario:
    """Return a scenario that can be flown; as `changed_scenario`."""
    return require_flyable(changed_scenario(source, changes))


def require_folder(what: str, out: Path | None, *, resume: bool) -> None:
    """Refuse `--resume` without the folder to resume in.

    Args:
        what: is resumed, such as `diagnosis`.
        out: the folder; None where none was given.
        resume: whether `--resume` was given.

    Raises:
        InputError: there is no folder.
    """
    if resume and out is None:
        raise InputError(f"--resume goes on with an interrupted {what}: name its folder with --out")


def print_folder(folder: Path) -> None:
    """Print where the results of a command and their page are."""
    say(f"Folder     {folder}")
    say(f"Report     {folder / 'report.html'}")
