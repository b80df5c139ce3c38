"""The gate before a diagnosis: can these records be this platform's, in these units?

It comes before any model is fitted. What a library of effects explains is per cents of the motion. A factor of 57, an
inertia twice as large, or clocks that differ from run to run are mistakes and no effects, and each would be given the
name of one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from math import inf, log10
from typing import final

import numpy as np
import scipy
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.linalg import eigh
from typing_extensions import override

from testbed.arrays import Array, Covariance, Series, Theta
from testbed.diagnosis.arrangement import mistaken_arrangement
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.model import Fit, orthonormal
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.hooks import Hooks
from testbed.prediction.prediction import predicted_with_derivatives
from testbed.scenario.diagnosis import Doubt


@dataclass(frozen=True, kw_only=True)
class _Mistake:
    """A unit or sign of a whole channel that is not as it should be.

    Attributes:
        unit: that the channel is in.
        remedy: for its owner.
        body_rate: factor that brings the gyro to rad/s.
        torque: factor that brings the applied torque to N·m.
    """

    unit: str
    remedy: str
    body_rate: float = 1.0
    torque: float = 1.0

    @override
    def __str__(self) -> str:
        says = f"as if it were in {self.unit}: {self.remedy}"
        if self.torque != 1.0:
            return f"the applied torque is {1.0 / self.torque:.3g} times what the motion takes, {says}"
        return f"the gyro reads {1.0 / self.body_rate:.3g} times what the actuators predict, {says}"


_MISTAKES = (
    _Mistake(unit="deg/s", remedy="multiply it by 0.01745329252", body_rate=np.pi / 180),
    _Mistake(unit="rpm", remedy="multiply it by 0.1047197551", body_rate=np.pi / 30),
    _Mistake(unit="mrad/s", remedy="multiply it by 0.001", body_rate=1e-3),
    _Mistake(
        unit="rad/s of the other sign",
        remedy="turn the signs of the gyro, or those of the actuators",
        body_rate=-1.0,
    ),
    _Mistake(unit="mN·m", remedy="multiply it by 0.001", torque=1e-3),
    _Mistake(unit="N·cm", remedy="multiply it by 0.01", torque=1e-2),
    _Mistake(unit="µN·m", remedy="multiply it by 0.000001", torque=1e-6),
)
"""What the gyro, or else the applied torque, may be in: exact factors of units, and a turned sign."""
_DEPENDENT = 1e-10
"""Share of the largest singular value below which columns of unit length count as dependent: clock shifts and inertia
together; between rounding, 1e-16 of some 1e4 samples, and what any motion shows."""


@dataclass(frozen=True, kw_only=True)
class Gate:
    """What the gate refuses, unless somebody said to know better.

    Attributes:
        accepted: doubts that the scenario says to be none, by `accept` in [diagnosis].
        notices: what was let through in spite of a doubt, or is too weak a doubt to refuse for.
    """

    accepted: tuple[Doubt, ...] = ()
    notices: list[str] = field(default_factory=list)

    def refuse(self, doubt: Doubt, text: str) -> None:
        """Refuse records for a doubt, or note that they were let through.

        Args:
            doubt: by the word that accepts it.
            text: what is doubtful, and the remedy.

        Raises:
            InputError: the doubt was not accepted.
        """
        if doubt not in self.accepted:
            raise InputError(f'{text}; if they are right as they are, add "{doubt}" to accept in [diagnosis]')
        self.notices.append(f"accepted by the scenario: {text}")


def require_si(runs: Runs, theta: Theta, gate: Gate) -> None:
    """Refuse records that should not even be fitted.

    Args:
        runs: to be fitted.
        theta: of the nominal model, kg·m².
        gate: what is accepted.

    Raises:
        InputError: channels in other places, a gyro or an applied torque in another unit.
    """
    _require_arrangement(runs, theta, gate)
    missed = _nominally_missed(runs, theta)
    _require_unit(runs, theta, missed, gate)
    for run, name, share in zip(runs.grid.runs, runs.names, missed, strict=True):
        peak = float(np.abs(run.body_rate).max())
        if peak > SETTINGS.plausible_body_rate and share > SETTINGS.unexplained_rate_share:
            gate.refuse(
                "body_rate",
                f"{name}: the gyro reaches {peak:.4g} rad/s ({np.degrees(peak):.0f} deg/s), which looks like deg/s: "
                f"multiply it by {np.pi / 180:.10g}",
            )


def require_this_platform(runs: Runs, baseline: Fit, theta: Theta, gate: Gate) -> None:
    """Refuse records that the nominal model cannot be meant for.

    Args:
        runs: that were fitted.
        baseline: the nominal model fitted to them.
        theta: of the nominal model, kg·m².
        gate: what is accepted.

    Raises:
        InputError: another inertia by far, a motion that the actuators do not make, or clocks that differ between runs.
    """
    if not runs.driven_by_momentum:
        return  # torques are integrated: what a prediction misses grows without bounds, and says nothing of a mistake
    _require_inertia(baseline, theta, gate)
    shift = _ClockShifts(runs, baseline)
    shift.require_one_clock(gate)
    if (missed := _missed_by_fit(runs, shift.common_residual)).min() > SETTINGS.unexplained_rate_share:
        gate.refuse(
            "telemetry",
            f"the actuators' telemetry does not explain {missed.min():.0%} or more of the body rate in every run: "
            "check that the scenario is of this platform, and the order and signs of its units and axes",
        )


def require_explicable(runs: Runs, before: float, after: Fit, gate: Gate) -> None:
    """Refuse to name effects that together explain hardly any of a gap that no effect of this platform makes.

    Args:
        runs: that were fitted.
        before: gap of the baseline.
        after: the model that explains the most.
        gate: what is accepted.

    Raises:
        InputError: the gap that is left is by far too large; the message says whether the gyro shows it.
    """
    gap, gyro = after.root_mean_square, float(np.sqrt(np.mean(after.residual[: runs.samples] ** 2)))
    if not runs.driven_by_momentum or gap <= max(SETTINGS.hopeless_gap, SETTINGS.hopeless_gap_share * before):
        return
    sizes = f"the gap is {before:.3g} times the noise, and {gap:.3g} with the effects that explain the most of it"
    if gyro > SETTINGS.hopeless_gap:
        gate.refuse(
            "gap",
            f"{sizes}: these records are not of the scenario's platform; check its geometry, and the order and signs "
            "of units and axes",
        )
        return
    gate.refuse(
        "gap",
        f"{sizes}, but {gyro:.3g} in the gyro's samples alone: the gimbals have another servo than the scenario, or "
        "their telemetry has less noise than its prediction resolves; if it is simulated, give encoders and torques "
        "noise, as the scenario diagnose does, or else leave gimbal_torque and gimbal_rate_command out",
    )


def require_motion(runs: Runs, gate: Gate) -> None:
    """Refuse platforms at rest.

    Raises:
        InputError: no run turns by more than noise.
    """
    powers = [
        rates.var(axis=0).sum() / (sigma[live] ** 2).sum()
        for rates, sigma, live in zip(runs.measured, runs.sigma, runs.live, strict=True)
    ]
    if max(powers) < SETTINGS.least_motion:
        gate.refuse(
            "rest",
            f"the body rate of no run stands out of the gyro's noise (its power is {max(powers):.2g} times that of the "
            f"noise, and has to be {SETTINGS.least_motion:g}): a platform at rest identifies nothing; turn it more",
        )


def _missed(runs: Runs, parts: Sequence[Array], motion: Sequence[Array]) -> Array:
    """Return the ratio of a residual's power to that of the motion, of each run, shape (R,).

    Windows of one record count together: in one that hardly moves, a torque that is a thousand times too small misses
    nothing that noise does not hide.

    Args:
        runs: of the platform.
        parts: the residual of each run, shapes (N, 3), rad/s.
        motion: that is to be explained, likewise; it counts as no less than the noise.
    """
    noise = [
        SETTINGS.least_motion * rates.size * (sigma**2).mean()
        for rates, sigma in zip(runs.measured, runs.sigma, strict=True)
    ]
    powers = [
        [(part**2).sum(), (whole**2).sum(), least] for part, whole, least in zip(parts, motion, noise, strict=True)
    ]
    of_records = np.zeros((len(runs.record_names), 3))
    np.add.at(of_records, runs.record_of, powers)
    left, whole, least = of_records.T
    return np.asarray((left / np.maximum(whole, least))[runs.record_of])


def _missed_by_fit(runs: Runs, residual: Array) -> Array:
    """Return the share of the body rate's variance that a fit misses, of each run, shape (R,)."""
    parts = [part * sigma for part, sigma in zip(runs.by_run(residual), runs.sigma, strict=True)]
    return _missed(runs, parts, [rates - rates.mean(axis=0) for rates in runs.measured])


def _missed_by_torque(runs: Runs, theta: Theta) -> Array:
    """Return the share of what torques have to make of the body rate that the applied ones miss, each run's, (R,).

    By the balance of the angular momentum along the measured motion, which cannot run away as a prediction does:
    J ω + ∫ ω × J ω dt = ∫ τ dt, but for a straight line that the initial rate and a constant torque make.
    """
    inertia = inertia_of(theta)
    balances = [_balance(run, inertia) for run in runs.grid.runs]
    return _missed(runs, [needed - given for needed, given in balances], [needed for needed, _ in balances])


def _balance(run: Telemetry, inertia: Array) -> tuple[Array, Array]:
    """Return what torques have to make of a run's body rate, and what the applied ones do, both (N, 3), rad/s."""
    assert run.applied_torque is not None
    momentum = run.body_rate @ inertia
    turned = cumulative_trapezoid(np.cross(run.body_rate, momentum), run.gyro_time, axis=0, initial=0.0)
    impulse = cumulative_trapezoid(run.applied_torque, run.actuator_time, axis=0, initial=0.0)
    given = make_interp_spline(run.actuator_time, impulse, k=1)(run.gyro_time)
    needed_rate, given_rate = (
        np.where(run.live, scipy.signal.detrend(each, axis=0) @ np.linalg.inv(inertia), 0.0)
        for each in (momentum + turned, given)
    )
    return needed_rate, given_rate


def _require_arrangement(runs: Runs, theta: Theta, gate: Gate) -> None:
    """Refuse channels in other places: a mistake in all records, or else in single ones."""
    if (mistake := mistaken_arrangement(runs.grid.runs, theta)) is not None:
        gate.refuse("telemetry", mistake)
        return
    if len(runs.record_names) == 1:
        return
    for record, name in enumerate(runs.record_names):
        own = list(compress(runs.grid.runs, runs.record_of == record))
        if (mistake := mistaken_arrangement(own, theta)) is not None:
            gate.refuse("telemetry", f"{name}: {mistake}")


def _require_unit(runs: Runs, theta: Theta, as_given: Array, gate: Gate) -> None:
    """Compare with what the nominal model predicts: refitted, the inertia would take up any factor of a channel."""
    wrong = as_given > SETTINGS.unexplained_rate_share
    if not wrong.any():
        return
    for mistake in _MISTAKES:
        mended = wrong & (_nominally_missed(_without(mistake, runs), theta) < SETTINGS.unit_rate_share)
        if mended.any():
            names = dict.fromkeys(runs.record_names[record] for record in runs.record_of[mended])
            gate.refuse("unit", f"{', '.join(names)}: {mistake}")


def _nominally_missed(runs: Runs, theta: Theta) -> Array:
    if not runs.driven_by_momentum:
        return _missed_by_torque(runs, theta)
    try:
        return _missed_by_fit(runs, nominal_fit(runs, theta).residual)
    except InputError:  # the motion runs away
        return np.full(len(runs.names), np.inf)


def _without(mistake: _Mistake, runs: Runs) -> Runs:
    """Return the runs with the units that they should have."""
    mended = tuple(
        replace(
            run,
            body_rate=mistake.body_rate * run.body_rate,
            applied_torque=None if run.applied_torque is None else mistake.torque * run.applied_torque,
        )
        for run in runs.grid.runs
    )
    return replace(runs, grid=replace(runs.grid, runs=mended), sigma=abs(mistake.body_rate) * runs.sigma)


def _require_inertia(baseline: Fit, theta: Theta, gate: Gate) -> None:
    """Refuse an inertia that is another by a factor, beyond its uncertainty.

    Only of a model that the data bear out, or by a factor that a unit makes: where even the best inertia leaves more
    than noise, what is missing, such as friction, may stand in for inertia, and is to be looked for.
    """
    columns = baseline.jacobian[:, np.diag(baseline.normal) > 0.0]
    if orthonormal(columns).shape[1] < columns.shape[1]:
        return  # a motion that leaves a direction of the inertia open says nothing of it
    shown = baseline.shown[:6]
    covariance = np.where(np.outer(shown, shown), baseline.covariance[:6, :6], 0.0)
    for ratio in ratios_apart(baseline.theta, covariance, theta):
        said = f"the records show {ratio:.3g} times the scenario's inertia about one axis"
        # No unit makes an inertia negative: that is the far side of an infinite one, whose sign rounding decides.
        decades = inf if ratio <= 0.0 else abs(log10(ratio))
        a_unit = log10(SETTINGS.smallest_unit_factor) <= decades <= log10(SETTINGS.largest_unit_factor)
        if not a_unit and baseline.chi_square > SETTINGS.misfitting * baseline.freedom:
            gate.notices.append(f"without any effect, {said}: what is missing may stand in for it")
            return
        gate.refuse(
            "inertia",
            f"{said}: they are of another platform, or gyro or actuators are in other units; check the scenario's "
            "inertia and rotor momentum",
        )


def ratios_apart(theta: Theta, covariance: Covariance, nominal: Theta) -> Iterator[float]:
    """Yield the ratios of an inertia to the nominal one, about their common axes, that are none of one platform.

    They are beyond a factor of `largest_inertia_ratio`, by more than the uncertainty of the inertia.

    Args:
        theta: estimated, kg·m².
        covariance: of it, kg²·m⁴.
        nominal: θ of the nominal model, kg·m².
    """
    largest = SETTINGS.largest_inertia_ratio
    ratios, directions = eigh(inertia_of(theta), inertia_of(nominal))
    for ratio, direction in zip(ratios, directions.T, strict=True):
        slope = theta_of(np.outer(direction, direction)) * np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        doubt = SETTINGS.inertia_ratio_std * float(np.sqrt(max(slope @ covariance @ slope, 0.0)))
        if ratio - doubt > largest or ratio + doubt < 1.0 / largest:
            yield float(ratio)


@final
class _Shifted(Hooks):
    """The gyro's clock is late by its own amount in every run; to first order, which is enough to find it."""

    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        slope = CubicSpline(time, reading.real, axis=1)(time, 1)
        return np.asarray(reading - value[:, run, None, None] * slope)


@final
class _ClockShifts:
    """A shift of the gyro's clock in every run, fitted beside inertia and initial rates to first order."""

    def __init__(self, runs: Runs, baseline: Fit) -> None:
        self._runs = runs
        number = len(runs.names)
        values = replace(baseline.values, effects=(np.zeros((1, number)),))
        _, derivatives = predicted_with_derivatives(runs.grid, [_Shifted()], values, range(6, 6 + number))
        own = np.concatenate(runs.whitened_columns(derivatives))
        gyro = replace(baseline, residual=baseline.residual[: len(own)], jacobian=baseline.jacobian[: len(own)])
        self._shift, self._own_residual = _explained(gyro, own)
        _, self.common_residual = _explained(gyro, own.sum(axis=1, keepdims=True))

    def require_one_clock(self, gate: Gate) -> None:
        """Refuse clocks that differ between runs by more than half a sample, where that explains most of the gap."""
        own, common = (float(each @ each) for each in (self._own_residual, self.common_residual))
        gained, excess = common - own, common - len(self.common_residual)
        longest = float(self._runs.grid.gyro_interval.max())
        apart = np.ptp(self._shift) > SETTINGS.clock_shift_periods * longest
        by_chance = scipy.stats.chi2.sf(gained, max(len(self._shift) - 1, 1))
        if apart and gained > SETTINGS.clock_shift_gain * excess and by_chance < SETTINGS.clock_shift_p_value:
            late = zip(self._runs.names, self._shift, strict=True)
            shifts = ", ".join(f"{name} {1e3 * seconds:+.0f} ms" for name, seconds in late)
            gate.refuse(
                "clocks",
                f"the gyro is late against the actuators by a different time in every run ({shifts}): bring the "
                "channels of each run to one clock",
            )


def _explained(baseline: Fit, columns: Array) -> tuple[Array, Array]:
    """Fit columns and the baseline's parameters to its residual; return the columns' factors and the new residual."""
    together = np.hstack([baseline.jacobian, columns])
    scale = np.maximum(np.linalg.norm(together, axis=0), np.finfo(float).tiny)
    answer = np.linalg.lstsq(together / scale, baseline.residual, rcond=_DEPENDENT)[0]
    shift = (answer / scale)[-columns.shape[1] :]
    return np.asarray(shift), np.asarray(baseline.residual - (together / scale) @ answer)
