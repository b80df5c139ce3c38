"""Other methods on the sets of `benchmarks.formulas`: sparse regression by pysindy, symbolic regression by pyoperon.

The nominal model is fitted to the fit runs of a set as the diagnosis fits it. Both methods see what that leaves, and
neither knows of what is hidden. Each runs in an environment of its own under build/.

- SINDy gets our regressors: what every law of the grammar without a memory, about each axis of the body and of space,
  would change the body rate by, linearised, with what inertia and initial rates can do projected out; of oscillations
  the frequency that explains the most. An ensemble of sparse regressions names the laws whose terms stay in it, the
  one that makes up the most of the torque first (`foreign/sindy_formulas.py`).
- The symbolic regression gets the smoothed torque that the diagnosis estimates without any hypothesis, and all that
  formulas read: time, body rates, attitude, gimbal angles and rates. Its expressions of the three axes are named by the
  formula that explains the most of them (`foreign/operon_torques.py`).
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from scipy.interpolate import make_interp_spline

from benchmarks.environments import environment
from benchmarks.formula_sets import Said, patterns_of, placed_formulas
from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.formula_responses import Along
from testbed.diagnosis.latent import LatentTorque, latent_torque
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.diagnosis.torque_shapes import shape_knots
from testbed.diagnosis.torque_space import torque_responses
from testbed.dynamics.inertia import inertia_of
from testbed.formulas.grammar import classes
from testbed.formulas.motion import ATTITUDES, GIMBAL_RATES, GIMBALS, RATES, TIME
from testbed.formulas.pattern import Pattern
from testbed.prediction.grid import unit_count

_AT = " @ "
"""Between the law and the axis of a term."""
_WAVES = "sin(2*pi*f*t) + cos(2*pi*f*t)"
OTHER = "expression"
"""Named where no formula is what a symbolic regression found."""
FOREIGN = Path(__file__).with_name("foreign")
REQUIREMENTS = {"sindy": ("sindy-venv", "pysindy==2.1.0"), "operon": ("operon-venv", "pyoperon==0.6.2")}
SCRIPTS = {"sindy": "sindy_formulas.py", "operon": "operon_torques.py"}
METHODS = tuple(REQUIREMENTS)
_AXES = ("x", "y", "z", "Nx", "Ny", "Nz")
_SLOWEST_HZ, _FASTEST_HZ, _STEP_HZ = 0.3, 4.0, 0.05
"""Of oscillations whose frequency is looked for: those of the diagnosis, in runs of 5 s."""
_TAKEN_UP = 0.02
"""Share of an expression by which a formula may explain less of it than the best one, and be alike."""
_SHOWN = 0.5
"""Share of an expression that a formula has to explain to be its name."""


def write_set(path: Path, runs: Runs, fit: Fit) -> None:
    """Write what the other methods see of a set.

    Args:
        path: of an npz: `inertia` (3, 3), kg·m²; of each run r `time_r` (N,), s, and `residual_r` (N, 3) and
            `columns_r` (N, 3, K), rad/s and rad/s per unit torque; `terms`, the law and the axis of every column; at
            the knots of all runs `torque` (M, 3), N·m, `features` (M, F), and what each law makes about each axis,
            `unit_torques` (M, 3, K); `names` of the features.
        runs: that are fitted.
        fit: of the nominal model.
    """
    seen = _Seen(runs, fit)
    laws = {**seen.laws(), **seen.best_wave()}
    latent, values = latent_torque(runs, fit), np.stack(list(laws.values()))
    features = {name: seen.along.moment.value(name) for name in _read(seen.units)}
    content = dict(
        inertia=inertia_of(fit.theta),
        terms=np.array([f"{law}{_AT}{axis}" for law in laws for axis in _AXES]),
        torque=latent.torque_B.reshape(-1, 3),
        features=seen.at(latent, np.stack(list(features.values()), axis=-1)),
        unit_torques=seen.at(latent, unit_torques(seen.along, values)).astype(np.float32),
        names=np.array(list(features)),
        **seen.by_run("residual", seen.residual[:, None]),
        **seen.by_run("columns", seen.columns(values)),
        **{f"time_{index}": run.gyro_time for index, run in enumerate(runs.grid.runs)},
    )
    with path.open("wb") as file:
        np.savez_compressed(file, **content)


class _Seen:
    """A set's residual, and what torques along its motion do to it; what the nominal model can do is projected out."""

    def __init__(self, runs: Runs, fit: Fit) -> None:
        self._runs, self._knots = runs, shape_knots(runs)
        self._taken = orthonormal(fit.jacobian[: runs.samples])
        self._responses = torque_responses(runs, fit, self._knots)[: len(runs.names)]
        self.residual = projected_out(fit.residual[: runs.samples], self._taken)
        self.along, self.units = Along.of(runs, fit), unit_count(runs.grid)

    def laws(self) -> dict[str, Array]:
        """Return the laws without memory and constants along the motion, each (R, N), by their text."""
        every = [law for of_class in classes(self.units).values() for laws in of_class for law in laws if not law.names]
        return dict(zip(map(str, every), self.along.products(every, {}), strict=True))

    def best_wave(self) -> dict[str, Array]:
        """Return the sine and the cosine of the frequency that explains the most of the residual, likewise."""
        return max(self._waves(), key=lambda waves: self._explained(np.stack(list(waves.values()))))

    def columns(self, values: Array) -> Array:
        """Return what unit torques by laws do to the whitened samples about each of the axes, shape (samples, L 6).

        Args:
            values: of the laws along the motion, shape (L, R, N).
        """
        by_frame = [
            np.concatenate(
                [
                    response @ own.reshape(response.shape[1], -1)
                    for response, own in zip(
                        self._responses, self.along.torques(values, frame, self._knots), strict=True
                    )
                ]
            )
            for frame in ("B", "N")
        ]
        rows = len(self.residual)
        together = np.concatenate([each.reshape(rows, -1, 3) for each in by_frame], axis=2).reshape(rows, -1)
        return projected_out(together, self._taken)

    def by_run(self, name: str, whitened: Array) -> dict[str, Array]:
        """Return columns of shape (samples, K) as rad/s, one array (N, 3, K) for each run, named `NAME_RUN`."""
        parts = zip(self._runs.by_run(whitened), self._runs.sigma, strict=True)
        return {f"{name}_{index}": part * sigma[:, None] for index, (part, sigma) in enumerate(parts)}

    def at(self, latent: LatentTorque, values: Array) -> Array:
        """Return values along the motion, shape (R, N, ...), at the knots of the smoothed torque, (M, ...)."""
        runs = zip(self.along.time, latent.knot_time - latent.knot_time[:, :1], values, strict=True)
        return np.concatenate([make_interp_spline(time, own, k=1)(knots) for time, knots, own in runs])

    def _waves(self) -> Iterator[dict[str, Array]]:
        for frequency in np.arange(_SLOWEST_HZ, _FASTEST_HZ, _STEP_HZ):
            phase = 2.0 * np.pi * frequency * self.along.time
            yield {"sin(2*pi*f*t)": np.sin(phase), "cos(2*pi*f*t)": np.cos(phase)}

    def _explained(self, values: Array) -> float:
        """Return the share of the residual that laws explain together."""
        basis = orthonormal(self.columns(values))
        return float(np.linalg.norm(basis.T @ self.residual))


def unit_torques(along: Along, values: Array) -> Array:
    """Return the torques that laws make about each of the axes along the motion, shape (R, N, 3, L 6), body axes."""
    body = np.broadcast_to(np.eye(3), along.moment.attitude.shape)
    space = np.swapaxes(along.moment.attitude, -1, -2)  # its columns are the axes of N in B
    axes = np.concatenate([body, space], axis=-1)
    every = np.moveaxis(values, 0, -1)[..., None, :, None] * axes[..., :, None, :]
    return every.reshape(*every.shape[:3], -1)


def _read(units: int) -> tuple[str, ...]:
    """Return the names of all that formulas read."""
    return (TIME, *RATES, *ATTITUDES, *GIMBALS[:units], *GIMBAL_RATES[:units])


def said_of(folder: Path, method: str) -> dict[str, Said]:
    """Return what a method says of the sets of a folder, by the stem of each npz.

    Raises:
        UnavailableError: the method cannot be installed.
    """
    python = environment(*REQUIREMENTS[method])
    done = subprocess.run([str(python), str(FOREIGN / SCRIPTS[method]), str(folder)], check=True, capture_output=True)
    answers = [json.loads(line) for line in done.stdout.decode().splitlines()]
    if method == "sindy":
        return {each["set"]: sindy_said(each["weights"]) for each in answers}
    return {each["set"]: operon_said(folder / f"{each['set']}.npz", np.array(each["torque"])) for each in answers}


def sindy_said(weights: Mapping[str, float]) -> Said:
    """Return what a sparse regression says, from the weight of every term that stays: its laws, the heaviest first."""
    by_term: dict[tuple[str, str], float] = {}
    for term, weight in weights.items():
        law, axis = term.split(_AT)
        key = (_WAVES if law in _WAVES.split(" + ") else law, axis)
        by_term[key] = by_term.get(key, 0.0) + weight
    named = placed_formulas(by_term)
    return Said(named=tuple(f"formula:{each}" for each in named[:1]), alike=tuple(named[1:]))


def operon_said(path: Path, torque: Array) -> Said:
    """Return the formula that expressions are: the shortest of those that explain the most of them.

    Args:
        path: of the set.
        torque: that the expressions make at the knots, shape (M, 3), N·m; zero about axes with a constant one.
    """
    power = float((torque**2).sum())
    if power == 0.0:
        return Said()
    with np.load(path) as kept:
        terms, unit = [str(each).split(_AT) for each in kept["terms"]], kept["unit_torques"]
    laws = list(dict.fromkeys(_WAVES if law in _WAVES.split(" + ") else law for law, _ in terms))
    explained: dict[Pattern, float] = {}
    for pattern in patterns_of(laws):
        own = [index for index, (law, axis) in enumerate(terms) if is_term(pattern, law, axis)]
        basis = orthonormal(np.asarray(unit[..., own], dtype=float).reshape(torque.size, -1))
        explained[pattern] = float(((basis.T @ torque.ravel()) ** 2).sum()) / power
    most = max(explained.values())
    if most < _SHOWN:
        return Said(named=(OTHER,))
    alike = sorted((each for each in explained if explained[each] > most - _TAKEN_UP), key=lambda each: each.length)
    return Said(named=(f"formula:{alike[0]}",), alike=tuple(map(str, alike[1:])))


def is_term(pattern: Pattern, law: str, axis: str) -> bool:
    """Return whether a law about an axis is a part of a formula."""
    frame = "N" if axis.startswith("N") else "B"
    return law in map(str, pattern.laws) and pattern.frame == frame and pattern.placement in ("B", "N", axis)
