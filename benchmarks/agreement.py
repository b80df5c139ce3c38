"""Every flight that another engine has flown too, and what ours differs by: the figures of docs/reference/agreement.md.

python -m benchmarks.agreement [--freeze]

With --freeze Basilisk flies its part again first, in an environment of its own under build/, and the trajectories in
tests/agreement/basilisk/platforms are written anew.
"""

from __future__ import annotations

import subprocess
import sys

import numpy as np

from benchmarks.environments import BASILISK, environment
from support.agreement import FOLDER, PLATFORMS, difference, frozen, orbited
from support.tumbling_brick import damping_of, predicted, published, rates, tumbled

SCRIPTS = ("make_platforms.py", "make_orbit.py")
STEPS = (1.25e-3, 0.625e-3)
ORBIT_STEPS = (1.0, 0.5)
BRICK_STEPS = (2.5e-3, 1.25e-3)


def main() -> None:
    """Print a table of differences of the body rate, rad/s."""
    if "--freeze" in sys.argv[1:]:
        freeze()
    print(f"{'':44s}" + "".join(f"{name:>24s}" for name in ("at our step", "at half of it", "theirs from converged")))
    for name in PLATFORMS:
        _print_row(f"Basilisk, {name}, 10 s, {1e3 * STEPS[0]:g} ms", [difference(name, step) for step in STEPS], name)
    reference = frozen("orbit").body_rate
    orbit = [np.abs(orbited(step) - reference).max() for step in ORBIT_STEPS]
    _print_row(f"Basilisk, orbit, 5400 s, {ORBIT_STEPS[0]:g} s", orbit, "orbit")
    _print_bricks()


def freeze() -> None:
    """Fly everything in Basilisk again and write its trajectories."""
    python = environment(*BASILISK)
    for script in SCRIPTS:
        subprocess.run([str(python), str(FOLDER / script)], check=True)


def _print_bricks() -> None:
    undamped, damped = published("case02"), published("case03")
    first, fourth = undamped[undamped["simulation"] == 1], damped[damped["simulation"] == 4]
    found = [np.abs(tumbled(first["time_s"], step) - rates(first)).max() for step in BRICK_STEPS]
    _print_row(f"NASA, case 02, MuJoCo, 30 s, {1e3 * BRICK_STEPS[0]:g} ms", found)
    rows = np.rint(10.0 * first["time_s"]).astype(int)
    law = np.abs(predicted(np.linspace(0.0, 30.0, 301))[rows] - rates(first)).max()
    _print_row("NASA, case 02, dynamics.gyrostat, 30 s", [law])
    found = []
    for step in BRICK_STEPS:
        half_steps = np.arange(2 * round(fourth["time_s"][-1] / step) + 3) * step / 2.0
        found.append(np.abs(tumbled(fourth["time_s"], step, damping_of(fourth, half_steps)) - rates(fourth)).max())
    _print_row(f"NASA, case 03, MuJoCo, 7 s, {1e3 * BRICK_STEPS[0]:g} ms", found)
    ends = rates(undamped[undamped["time_s"] == 30.0])
    _print_row("NASA, case 02, five simulations apart, 30 s", [np.abs(ends - ends[0]).max()])
    other = damped[damped["simulation"] == 1]
    _print_row("NASA, case 03, two simulations apart, 7 s", [np.abs(rates(other) - rates(fourth)).max()])


def _print_row(what: str, found: list[float], file: str | None = None) -> None:
    shown = [f"{each:.1e}" for each in found] + [""] * (2 - len(found))
    print(f"{what:44s}" + "".join(f"{each:>24s}" for each in (*shown, _step_error(file) if file else "")))


def _step_error(name: str) -> str:
    """Return what a file says of its own step: by how much a coarser one changes the body rate."""
    line = (FOLDER / "platforms" / f"{name}.csv").read_text(encoding="utf-8").splitlines()[1]
    return line.split(" by ")[1].split()[0]


if __name__ == "__main__":
    main()
