"""How much of a real quadcopter's angular acceleration is explained with late motors, on flights that were held out.

Run with `python -m benchmarks.crazyflie`; with `--picture` it draws docs/images/crazyflie.png too.

Effects are fitted to the fit runs alone, as `testbed diagnose` fits them: in windows, with a factor of the torque per
command about each axis and a trim in each record, and in the noise that the model leaves. Held-out pieces are compared
whole: rates through a zero-phase low-pass of 20 Hz, differentiated, against J⁻¹ (τ - ω × J ω) through the same one.
Each piece has a trim of its own.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import butter, sosfiltfilt

from testbed.arrays import Array, Theta
from testbed.assembly.platform import nominal_body
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.fitting import fitted, in_torque_noise, starts_of
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid, grid_of
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario
from testbed.signals import AXES

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "data" / "crazyflie"
PICTURE = ROOT / "docs" / "images" / "crazyflie.png"
LAG, DELAY = ("actuator_lag", "actuators"), ("actuator_delay", "actuators")
REACTION = ("rotor_acceleration_reaction", "z")
MODELS: dict[str, tuple[tuple[str, str], ...]] = {
    "static": (),
    "delay": (DELAY,),
    "lag": (LAG,),
    "lag + delay": (LAG, DELAY),
    "lag + reaction": (LAG, REACTION),
    "lag + delay + reaction": (LAG, DELAY, REACTION),
}
"""Effect and component of each; the reaction is that of rotors to their own acceleration."""
START = 0.02
"""s, of every lag, delay and lead: from zero they would have to be distinguished before they are there."""
CUT_OFF = 20.0
"""Hz."""
SHOWN = ("roll_pitch_5", 2.0, 4.0)
"""Record and times, s, of the picture."""
EXCITED = {"x": "roll_pitch", "y": "roll_pitch", "z": "yaw"}
"""Which flights turn about an axis."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """A held-out record on an even grid.

    Attributes:
        name: of the record.
        grid: of the record alone.
        body_rate: ω at the grid's half steps, shape (T, 3), rad/s.
    """

    name: str
    grid: Grid
    body_rate: Array

    @property
    def time(self) -> Array:
        """Shape (T,), s."""
        return np.asarray(self.grid.time[0])

    @property
    def measured(self) -> Array:
        """Low-passed angular acceleration, shape (T, 3), rad/s²."""
        return np.asarray(np.gradient(self._smooth(self.body_rate), self.time, axis=0))

    def predicted(self, fit: Fit) -> Array:
        """Return what a fitted model makes of the measured rates and the torques asked for, shape (T, 3), rad/s²."""
        torque_B = self.grid.applied_torque_B
        for placed, value in zip(fit.placed, fit.values.effects, strict=True):
            torque_B = placed.hooks.actuator_response(torque_B, value, self.grid)
        inertia = inertia_of(fit.theta)
        gyroscopic_B = np.cross(self.body_rate, self.body_rate @ inertia)
        return self._smooth(np.linalg.solve(inertia, (torque_B[0, 0] - gyroscopic_B).T).T)

    def _smooth(self, values: Array) -> Array:
        low_pass = butter(2, CUT_OFF, fs=1.0 / (self.time[1] - self.time[0]), output="sos")
        return np.asarray(sosfiltfilt(low_pass, values, axis=0))


def main() -> None:
    """Print the held-out R² of every model and axis."""
    fits, pieces = fits_and_pieces()
    axes = ", ".join(EXCITED)
    print(f"{'model':22} {'fitted, ms':>18}  {'deviance':>8}  held-out R² of the angular acceleration: {axes}")
    for name, fit in fits.items():
        own = fit.effect_values[len(fit.effect_values) - len(MODELS[name]) :]
        fitted_ms = " + ".join(f"{1e3 * value:.1f}" for value in own)
        shares = "  ".join(f"{r_squared(pieces, fit, axis):6.3f}" for axis in AXES)
        print(f"{name:22} {fitted_ms:>18}  {fit.deviance:8.0f}  {shares}")
    if "--picture" in sys.argv:
        draw(fits, next(piece for piece in pieces if piece.name == SHOWN[0]))


def fits_and_pieces() -> tuple[dict[str, Fit], list[Piece]]:
    """Return every model, fitted to the fit runs, and the records that were held out."""
    scenario, records = read_body_scenario(shipped_scenario("crazyflie")), read_data_set(DATA)
    nominal = nominal_body(scenario)
    data = data_set_of(records, scenario, nominal)
    fits = {name: _fit(data, effects, theta_of(nominal.inertia)) for name, effects in MODELS.items()}
    held_out = [record for record in records if record.details.role == "heldout"]
    return fits, [_piece(record.details.name, telemetry_of(record, scenario, nominal)) for record in held_out]


def r_squared(pieces: Sequence[Piece], fit: Fit, axis: str) -> float:
    """Return 1 - Σ(measured - predicted)² / Σ(measured - mean)² over all held-out pieces that turn about an axis."""
    column = AXES.index(axis)
    turning = [piece for piece in pieces if piece.name.startswith(EXCITED[axis])]
    measured = np.concatenate([piece.measured[:, column] for piece in turning])
    missed = [piece.measured[:, column] - piece.predicted(fit)[:, column] for piece in turning]
    left = np.concatenate([each - each.mean() for each in missed])  # the mean is the trim's
    return 1.0 - float((left**2).sum() / ((measured - measured.mean()) ** 2).sum())


def draw(fits: dict[str, Fit], piece: Piece) -> None:
    """Draw measured, static and extended roll acceleration over some seconds of one held-out flight."""
    _, first, last = SHOWN
    rows = (piece.time >= first) & (piece.time <= last)
    figure, axes = plt.subplots(figsize=(8.0, 3.0), layout="constrained")
    lines = (
        ("measured", piece.measured, "black", 2.0),
        ("static torque of the commands", piece.predicted(fits["static"]), "tab:red", 1.0),
        ("with lag, delay and reaction", piece.predicted(fits["lag + delay + reaction"]), "tab:blue", 1.5),
    )
    for label, values, color, width in lines:
        axes.plot(piece.time[rows], values[rows, 0], label=label, color=color, linewidth=width)
    axes.set(xlabel="time [s]", ylabel="roll acceleration [rad/s²]", xlim=(first, last))
    axes.set_title(f"{piece.name}, held out")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small")
    figure.savefig(PICTURE, dpi=110)


def _fit(data: DataSet, effects: Sequence[tuple[str, str]], theta: Theta) -> Fit:
    placed = [Hypothesis(effect=EFFECTS[name], component=component) for name, component in effects]
    starts = [*starts_of(data.runs, data.given), *([np.array([START])] * len(placed))]
    fit = fitted(data.runs, [*data.given, *placed], theta, starts)
    return in_torque_noise(data.runs, None, fit)[2]


def _piece(name: str, telemetry: Telemetry) -> Piece:
    grid = grid_of([telemetry])
    even = np.stack([np.interp(grid.time[0], telemetry.gyro_time, rate) for rate in telemetry.body_rate.T], axis=1)
    return Piece(name=name, grid=grid, body_rate=even)


if __name__ == "__main__":
    main()
