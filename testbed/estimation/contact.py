"""Contacts found in a record: the total angular momentum jumps, and no actuator explains it.

Between contacts the momentum H is conserved: Γ(ω) θ - Rᵀ H = -h - (J(d) - J(0)) ω. Source: the conservation of momentum
behind paper eq. (1). Both searches test this one equation for a step of H, by a generalised likelihood ratio:

- `first_contact` runs through the samples. A recursive fit starts from the nominal inertia, unsure of it, and from any
  momentum; at every sample it tests whether H has changed by a step within the last few. What comes later does not
  count: it finds the first contact of several, up to which a record can be used.
- `likeliest_jumps` fits inertia and momentum to the whole record with one step at each of its samples in turn. It needs
  no nominal inertia, and sees smaller steps; of several contacts it finds the largest.

docs/notes/2026-11-23-one-of-each.md compares them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import NamedTuple

import numpy as np
import scipy

from testbed.arrays import Array, Series, Theta, Vector3, Vectors3
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.actuation import actuation
from testbed.estimation.identifiability import inertia_size
from testbed.estimation.momentum_equation import momentum_equation
from testbed.estimation.telemetry import Telemetry, covered_part

WINDOW = 4
"""Samples within which a step is looked for: a gentle touch shows in the mean of several."""
ALARM = 30.0
"""χ² of 3 degrees of freedom: 1.4e-6 by chance, 4e-4 in the 300 questions that 5 s at 16 Hz are asked."""
DOUBT = 7.8
"""χ² of 3 degrees of freedom, 5 % by chance: a sample before the step that is beyond it is taken for its beginning."""
MODEL_ERROR = 0.1
"""Standard deviation of each nominal inertia parameter, as a share of the mean moment."""
WANDER = 0.3
"""Change of H per sample that is not called a step, in standard deviations of the gyro: what a model lacks is slow."""
QUIETEST = 1e-4
"""rad/s; below it encoders and interpolation are louder than the gyro."""
FASTEST = 20.0
"""rad/s; standard deviation of the body rate that H at the start is worth, beyond any."""
_APART = 0.2
"""s; nearer instants of a run are the same touch: ten times as far as a search may begin from an instant to arrive."""
_SHOWN = 1e-6
"""Share of what samples show best of a jump, below which a direction of it does not show.

Source: chosen; on five data sets of three platforms none has less than 0.3, and squares of 1e-8 are rounding."""
JUMP_CHANCE = 1e-3
"""p-value of a jump anywhere in a run, times its samples (Bonferroni), below which the run shows one, and is fitted
rather than held out: of the five runs of 200 sets one has it by chance."""


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Where a record first shows a contact.

    Attributes:
        last_free: time of the last sample before it, s.
        first_seen: time of the first sample that shows it, s.
        rate_jump_B: what it changed the body rate by, within the samples looked at, rad/s, body axes.
    """

    last_free: float
    first_seen: float
    rate_jump_B: Vector3

    @property
    def rate_jump(self) -> float:
        """Size of the change, rad/s."""
        return float(np.linalg.norm(self.rate_jump_B))


class _Equation(NamedTuple):
    """The samples as equations for (θ, H)/size whose noise is the gyro's: regressor (N, 3, 9), response (N, 3)."""

    regressor: Array
    response: Vectors3
    noise: float


class _Posterior(NamedTuple):
    """The estimate from the samples so far of (θ, H)/size: mean (9,), covariance (9, 9)."""

    mean: Array
    covariance: Array


class _Step(NamedTuple):
    """A step of H: the first sample that shows it, its χ², and the change of the body rate."""

    sample: int
    surprise: float
    rate_jump_B: Vector3


def first_contact(telemetry: Telemetry, nominal_theta: Theta) -> Contact | None:
    """Return the first contact that a record shows; None where it shows none.

    Args:
        telemetry: one run.
        nominal_theta: the nominal inertia, kg·m², right to about a tenth.

    Raises:
        InputError: too few samples.
    """
    part = covered_part(telemetry)
    equation = _equation_of(part, nominal_theta)
    posterior = _learned(_unsure(nominal_theta), equation, 0)
    posteriors, surprises = deque([posterior], WINDOW), [0.0]
    for sample in range(1, len(equation.response)):
        steps = _steps(equation, sample, posteriors)
        likeliest = max(steps, key=lambda step: step.surprise)
        if likeliest.surprise > ALARM:
            return _contact(part.gyro_time, likeliest, surprises)
        surprises.append(steps[-1].surprise)
        posteriors.append(_learned(posteriors[-1], equation, sample))
    return None


def _equation_of(telemetry: Telemetry, nominal_theta: Theta) -> _Equation:
    """Scale the momentum equation's rows by J(d)⁻¹, so that their noise is the gyro's, and its unknowns by the size."""
    equation = momentum_equation(telemetry, telemetry.body_rate)
    change_B = actuation(telemetry, telemetry.gyro_time).inertia_change_B
    scale = np.linalg.inv(inertia_of(nominal_theta) + change_B)
    return _Equation(
        regressor=inertia_size(nominal_theta) * scale @ equation.regressor,
        response=np.matvec(scale, equation.response),
        noise=max(telemetry.gyro_noise, QUIETEST),
    )


def _unsure(nominal_theta: Theta) -> _Posterior:
    mean = np.concatenate([nominal_theta / inertia_size(nominal_theta), np.zeros(3)])
    return _Posterior(mean, np.diag([MODEL_ERROR**2] * 6 + [FASTEST**2] * 3))


def _learned(posterior: _Posterior, equation: _Equation, sample: int) -> _Posterior:
    """Return the posterior after one more sample, and before H wanders until the next: a Kalman filter's round."""
    mean, covariance = posterior
    rows = equation.regressor[sample]
    seen = covariance @ rows.T
    gain = np.linalg.solve(rows @ seen + equation.noise**2 * np.eye(3), seen.T).T
    wander = np.diag([0.0] * 6 + [(WANDER * equation.noise) ** 2] * 3)
    later = covariance - gain @ seen.T
    return _Posterior(mean + gain @ (equation.response[sample] - rows @ mean), (later + later.T) / 2.0 + wander)


def _steps(equation: _Equation, last: int, posteriors: Sequence[_Posterior]) -> list[_Step]:
    """Return the step that each window ending with a sample shows, the longest window first.

    Args:
        equation: of all samples.
        last: index of the windows' last sample.
        posteriors: before each of the windows, the latest last.
    """
    first = last + 1 - len(posteriors)
    return [_step(equation, slice(first + back, last + 1), posterior) for back, posterior in enumerate(posteriors)]


def _step(equation: _Equation, window: slice, posterior: _Posterior) -> _Step:
    """Ask the mean residual of a window, each sample predicted from before the window, whether chance explains it."""
    rows = equation.regressor[window].mean(axis=0)
    residual = rows @ posterior.mean - equation.response[window].mean(axis=0)
    variance = rows @ posterior.covariance @ rows.T + equation.noise**2 / (window.stop - window.start) * np.eye(3)
    return _Step(window.start, float(residual @ np.linalg.solve(variance, residual)), residual)


def _contact(time: Series, step: _Step, surprises: Sequence[float]) -> Contact:
    """Return the contact that a step is; samples just before it that were doubtful saw its beginning."""
    first = step.sample
    while first > 1 and surprises[first - 1] > DOUBT:
        first -= 1
    return Contact(last_free=float(time[first - 1]), first_seen=float(time[first]), rate_jump_B=step.rate_jump_B)


def shows_a_jump(run: Telemetry) -> bool:
    """Return whether a jump of the momentum explains more of a run than chance would at any of its samples.

    Args:
        run: as `log_chance_of_jump`.
    """
    return log_chance_of_jump(run) < log(JUMP_CHANCE)


def log_chance_of_jump(run: Telemetry) -> float:
    """Return the logarithm of the p-value of the likeliest jump in a run, times its samples (Bonferroni).

    Args:
        run: its telemetry; its inertia is estimated with the jump.
    """
    found = likeliest_jumps(run, 1)
    return float(log(len(run.gyro_time)) + scipy.stats.chi2.logsf(found[0][0], 3)) if found else 0.0


def likeliest_jumps(run: Telemetry, count: int) -> list[tuple[float, float]]:
    """Return the instants between samples at which a jump of the momentum explains the most, best first.

    Γ(ω) θ - Rᵀ (H₀ + ΔH after the instant) = Y is linear in θ, H₀ and ΔH. With each instant stands twice the logarithm
    of the likelihood ratio with and without the jump.

    Args:
        run: its telemetry.
        count: of instants, at most.
    """
    equation = momentum_equation(run, run.body_rate)
    live = np.array(run.live)
    rows = equation.regressor[:, live, :9].reshape(-1, 9)
    shown = np.linalg.norm(rows, axis=0) > 0.0  # about an axis that a bearing holds nothing is
    basis = np.linalg.qr(rows[:, shown] / np.linalg.norm(rows[:, shown], axis=0))[0]
    response = equation.response[:, live].ravel()
    residual = response - basis @ (basis.T @ response)
    turned = rows[:, 6:][:, shown[6:]]
    by_sample = (each.reshape(len(run.gyro_time), -1, each.shape[-1]) for each in (turned, basis, residual[:, None]))
    share = np.clip(
        _explained(*by_sample) / max(float(residual @ residual), np.finfo(float).tiny), 0.0, 1.0 - np.finfo(float).eps
    )
    return peaks(-len(residual) * np.log1p(-share), (run.gyro_time[1:] + run.gyro_time[:-1]) / 2.0, count)


def _explained(turned: Array, basis: Array, residual: Array) -> Array:
    """Return by how much a jump at each instant between samples lowers the sum of squares, shape (N-1,).

    Sums over the samples on one side of the instant give what the momentum cannot take of the jump, in the time of one
    instant. A jump before it is one behind it with the momentum changed: the shorter side counts, of which less
    cancels.

    Args:
        turned: what the samples show of a jump, shape (N, A, 3), of A live axes.
        basis: orthonormal, of what they show of inertia and momentum, shape (N, A, B).
        residual: beside it, shape (N, A, 1).
    """
    jump, count = np.swapaxes(turned, -1, -2), len(turned)
    products = jump @ turned, jump @ basis, jump @ residual
    before = [np.cumsum(each, axis=0)[:-1] for each in products]
    behind = [np.cumsum(each[::-1], axis=0)[-2::-1] for each in products]
    of_jump, taken, slope = (
        np.concatenate([one[: count // 2], other[count // 2 :]]) for one, other in zip(before, behind, strict=True)
    )
    free = of_jump - taken @ np.swapaxes(taken, -1, -2)
    step = np.linalg.pinv(free, rcond=_SHOWN**2, hermitian=True) @ slope
    return np.asarray(np.sum(slope * step, axis=(-2, -1)))


def peaks(scores: Series, instants: Series, count: int) -> list[tuple[float, float]]:
    """Return score and instant of the best in a run, best first, none near a better one.

    Args:
        scores: of each instant, shape (N,).
        instants: shape (N,), s.
        count: of those returned, at most.
    """
    kept: list[tuple[float, float]] = []
    for index in np.argsort(scores)[::-1]:
        if len(kept) < count and all(abs(instants[index] - instant) > _APART for _, instant in kept):
            kept.append((float(scores[index]), float(instants[index])))
    return kept
