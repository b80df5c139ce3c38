"""testbed effects: the user's own library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from testbed.cli.console import entry, say
from testbed.effects.formula import Formula
from testbed.effects.library import KeptFormula, kept_formulas, library_folder
from testbed.library.own_effects import save_effect as saved


def save_effect(diagnosis: Path, name: str, number: int | None) -> None:
    """Keep a formula of a diagnosis.

    Raises:
        InputError: as `testbed.library.own_effects.save_effect`.
    """
    say(f"Kept       {saved(diagnosis, name, number)}")
    say(f"           later diagnoses test for {name}, as for the effects of the library")


def _sizes(kept: KeptFormula, effect: Formula) -> Iterator[str]:
    """Yield the size of each coefficient as it was found, and the constants."""
    for size, law in zip(kept.sizes, effect.pattern.laws, strict=True):
        yield f"{size:.3g} {law.coefficient_unit}"
    for value, constant in zip(kept.constants, effect.parameters, strict=False):
        yield f"{constant.name} {value:.3g} {constant.unit}"


def list_kept() -> None:
    """Print the effects of the user's library: what each says, its law as kept, where it is from and where it is.

    Raises:
        InputError: a file of it cannot be used.
    """
    held = kept_formulas()
    for path, kept in held.items():
        effect = kept.effect
        say(f"{kept.name}: {effect.described('platform')}")
        entry("Law", kept.formula)
        entry("Size", ", ".join(_sizes(kept, effect)))
        entry("From", kept.source or "not stated")
        entry("File", str(path))
    if not held:
        say(f"{library_folder()} holds no effects; `testbed effects save DIAGNOSIS NAME` keeps one there")
