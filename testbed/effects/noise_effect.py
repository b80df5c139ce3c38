"""Effects on how the gyro's samples scatter about what is predicted: what they see, and what they say of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from testbed.arrays import Array, Flags, Matrix3, Vector3
from testbed.effects.contract import NamedEffect
from testbed.estimation.noise_spectrum import NoiseSpectrum
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True, eq=False)
class Readings:
    """What the gyro gave against what a model predicts, of all runs that are fitted.

    Attributes:
        measured: of each run, shape (N, 3), rad/s, as the gyro gave them.
        residual: measured less predicted, of each run, shape (N, 3), rad/s.
        sigma: standard deviation in the model, of each run and axis, shape (R, 3), rad/s.
        runs: their telemetry.
        inertia: J of the model, shape (3, 3), kg·m².
        parameters: number of those that were fitted to the readings.
        spectrum: level and colour of the noise, estimated from the residual's fast part; None where that was not done.
        stated: whether the standard deviation is stated; else it is an estimate, beyond which there is no noise.
        white: whether the residual is known to be noise alone; else only its fastest changes estimate the noise.
        live: about which axes each run turns, shape (R, 3); about the others the gyro is compared with nothing.
        absorbed: what the model's P parameters can make of the samples of each run, shape (N, 3, P), rad/s; none where
            nobody looks beside them for what is slow.
        slow_bias: how the bias was found to wander; None where it is as the telemetry states.
    """

    measured: Sequence[Array]
    residual: Sequence[Array]
    sigma: Array
    runs: Sequence[Telemetry]
    inertia: Matrix3
    parameters: int
    spectrum: NoiseSpectrum | None = None
    stated: bool = True
    white: bool = False
    live: Flags = field(default_factory=lambda: np.ones((1, 3), dtype=bool))
    absorbed: Sequence[Array] = ()
    slow_bias: SlowBias | None = None

    def whitened(self, values: Array, run: int) -> Array:
        """Return what stands in one run's samples over σ, as if the noise had no colour and the bias stood still.

        Args:
            values: shape (N, 3) or (N, 3, C), rad/s.
            run: its index.
        """
        scaled: Array = values / self.sigma[run].reshape(3, *[1] * (values.ndim - 2))
        telemetry = self.runs[run]
        bias = self.slow_bias or telemetry.slow_bias
        if bias is not None:
            scaled = bias.whitened(scaled, telemetry.gyro_time, self.sigma[run])
        return scaled if self.spectrum is None else self.spectrum.color.decorrelated(scaled, telemetry.gyro_time)

    @property
    def whitened_residual(self) -> list[Array]:
        """Residual of each run likewise, shape (N, 3)."""
        return [self.whitened(residual, run) for run, residual in enumerate(self.residual)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Finding:
    """What readings say of one effect on their distribution.

    Attributes:
        values: of its parameters, shape (K,).
        std: their standard errors, shape (K,).
        chi_square_reduction: twice the logarithm of the likelihood ratio with and without it.
        freedom: numbers that this took from the readings.
        p_value: of what was seen, if the effect is not there; one test.
        variance: that it adds to each axis' readings, shape (3,), rad²/s².
        explained: the part of every run's residual that it estimates sample by sample, shape (N, 3), rad/s; None if it
            only adds variance.
        noise_freedom: degrees of freedom with which its noise is known.
        slow_bias: how the bias wanders by it; None where it adds no such noise.
    """

    values: Array
    std: Array
    chi_square_reduction: float
    freedom: int
    p_value: float
    variance: Vector3
    explained: Sequence[Array] | None = None
    noise_freedom: float = np.inf
    slow_bias: SlowBias | None = None


class NoiseEffect(NamedEffect):
    """An effect on how the gyro's samples scatter about what is predicted; it has no mean that could be fitted.

    Attributes:
        like_tachometers: whether the residual noise of wheels' tachometers looks like it, where no torque of the
            wheels is known that would tell what they hold.
    """

    like_tachometers: ClassVar[bool] = False

    def held_out_gain(self, component: str, values: Array, readings: Readings) -> float:  # noqa: ARG002
        """Return twice the logarithm of how much more probable it makes readings from which it was not estimated.

        Args:
            component: where it sits.
            values: of its parameters, shape (K,).
            readings: of held-out runs against the present model.
        """
        return 0.0

    @abstractmethod
    def found(self, component: str, readings: Readings) -> Finding | None:
        """Return what the readings say of it, None where they cannot hold it.

        Args:
            component: where it sits.
            readings: against the present model.
        """
