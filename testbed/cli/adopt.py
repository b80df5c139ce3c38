"""testbed adopt: a scenario from a model of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table

from testbed.cli.console import further_command, say, show, warn
from testbed.errors import InputError
from testbed.library.adoption import Adoption, adopt

_AGREES = 1e-8
"""rad/s over 10 s: what other engines agree with (docs/reference/agreement.md); the step's own error is less."""


def adopt_model(
    model: Path, out: Path | None, wheel: Sequence[str], rotor: Sequence[str], ignore: Sequence[str]
) -> None:
    """Find the platform in a model, print what was taken for what, and write its scenario.

    Args:
        model: path of the MJCF or URDF.
        out: file of the scenario; None for one of the model's name in the current folder.
        wheel: joints that are reaction wheels.
        rotor: joints that are rotors of gyros.
        ignore: joints that are locked.

    Raises:
        InputError: the model lacks something, or the scenario cannot be written.
    """
    target = Path(f"{model.stem}.toml") if out is None else out
    if target.exists():
        raise InputError(f"{target}: exists; choose another file with --out")
    adopted = adopt(model, name=None if out is None else out.stem, wheel=wheel, rotor=rotor, ignore=ignore)
    _print(adopted)
    path = adopted.save(target)
    say(f"{path}: what the model does not say is marked `replace it` there; then {further_command('check', path)}")


def _print(adopted: Adoption) -> None:
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in ("joint", "taken for", "because it"):
        table.add_column(column, overflow="fold")
    for part in adopted.parts:
        table.add_row(*part)
    show(table)
    say()
    say("Otherwise: --wheel NAME, --rotor NAME (of a gyro), --ignore NAME (locked as drawn); each may be repeated.")
    moments = ", ".join(f"{moment:.6g}" for moment in adopted.inertia.diagonal())
    say(f"Mass {adopted.mass:.6g} kg, moments of inertia {moments} kg m² about the centre of mass, body axes.")
    for note in adopted.notes:
        warn("not flown", note)
    say(f"Moved by the same torques for 10 s, its body rate is within {adopted.difference:.1e} rad/s of the model's.")
    if adopted.difference > _AGREES:
        left = "see what is not flown, or ignore a joint"
        digits = "as nothing is left out, by the few digits that its file gives of axes and inertias"
        warn("differs", f"from the model by more than rounding: {left if adopted.notes else digits}")
