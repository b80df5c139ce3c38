"""testbed effects: the user's own library."""

from __future__ import annotations

from pathlib import Path

from testbed.cli.console import say
from testbed.effects.library import kept_effects, library_folder
from testbed.library.own_effects import save_effect as saved


def save_effect(diagnosis: Path, name: str, number: int | None) -> None:
    """Keep a formula of a diagnosis.

    Raises:
        InputError: as `testbed.library.own_effects.save_effect`.
    """
    say(f"Kept       {saved(diagnosis, name, number)}")
    say(f"           later diagnoses test for {name}, as for the effects of the library")


def list_kept() -> None:
    """Print the effects of the user's library.

    Raises:
        InputError: a file of it cannot be used.
    """
    kept = kept_effects().values()
    for effect in kept:
        say(f"{effect.id}: {effect.described('platform')}")
    if not kept:
        say(f"{library_folder()} holds no effects; `testbed effects save DIAGNOSIS NAME` keeps one there")
