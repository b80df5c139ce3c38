"""What a physical effect may change in the prediction: the contract between the effects and the integration.

Every hook does nothing unless an effect overrides it. `value` holds the effect's parameters, shape (P, K);
the results broadcast over runs R and parameter sets P. All arithmetic has to be analytic in `value`,
because derivatives are taken by a complex step: no abs, no comparison of values, no real parts but of what a branch is
chosen by (`sign_of` and `magnitude` are the analytic ones).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from testbed.arrays import Array, Series
from testbed.estimation.surroundings import Surroundings
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.wheel_impulses import Impulses


@dataclass(frozen=True, kw_only=True, eq=False)
class Instant:
    """The motion at one instant of all runs and parameter sets.

    Attributes:
        time: of each run, shape (R, 1), s.
        body_rate: ω, shape (R, P, 3), rad/s, body axes.
        attitude: R_RB, shape (R, P, 3, 3): turns body components into those of the body's axes at the run's first
            sample; the identity where no effect asks for it.
        state: the effect's own states, shape (R, P, S).
        first_NB: R_NR at each run's first sample, shape (R, 1, 3, 3); the identity where nothing acts from outside.
        surroundings: what acts on the first run from outside; the environment is that of all. None where nothing does.
    """

    time: Array
    body_rate: Array
    attitude: Array
    state: Array
    first_NB: Array = field(default_factory=lambda: np.eye(3))
    surroundings: Surroundings | None = None


class Hooks:
    """An effect in the prediction; this one changes nothing.

    Attributes:
        states: number of further states that the effect integrates.
        needs_attitude: whether its torque depends on the attitude.
        needs_rate: whether its torque, or its states' rates, depend on ω.
        predicts_gimbals: whether what it changes in the gimbals' channels is predicted, if it acts inside the units.
        quadratic: whether its states have rates that are polynomials of the second degree in them and in ω, and hold a
            momentum that is one in them, while nothing else of the motion counts and it gives no torque: such effects
            are followed as machine code while they are specks, all others step by step.
    """

    states: int = 0
    needs_attitude: bool = False
    needs_rate: bool = True
    predicts_gimbals: bool = True
    quadratic: bool = False

    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:  # noqa: ARG002
        """Return the units as they are instead of as telemetry has them."""
        return gimbals

    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:  # noqa: ARG002
        """Return h(t), shape (R, P, T, 3), N·m·s, for runs with or without gimbal angles."""
        return momentum_B

    def asked_torque(self, asked_B: Array, value: Array, grid: Grid) -> Array:  # noqa: ARG002
        """Return the torque that single actuators make of their commands, before all of them respond, N·m.

        As `Grid.applied_torque_B`; `Grid.thrust` has the commands, and `Grid.thrusters` what each makes of them.
        """
        return asked_B

    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:  # noqa: ARG002
        """Return the torque that the actuators give, N·m, for a commanded one; both as `Grid.applied_torque_B`."""
        return asked_B

    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:  # noqa: ARG002
        """Return the torque of the actuators, and of what acts like them, shape (R, P, T, 3), N·m."""
        return torque_B

    def torque(self, value: Array, at: Instant) -> Array:  # noqa: ARG002
        """Return the external torque, shape (R, P, 3), N·m, body axes."""
        return np.zeros(3)

    def initial_state(self, value: Array, body_rate: Array) -> Array:  # noqa: ARG002
        """Return the effect's states at the first sample of every run, where ω is (R, P, 3), shape (R, P, S)."""
        return np.zeros(self.states)

    def state_rate(self, value: Array, at: Instant) -> Array:  # noqa: ARG002
        """Return the rates of change of the effect's states, shape (R, P, S)."""
        return np.zeros(self.states)

    def hidden_inertia(self, value: Array) -> Array:  # noqa: ARG002
        """Return what of the whole inertia does not turn with the body, shape (P, 3, 3), kg·m²."""
        return np.zeros((3, 3))

    def added_inertia(self, value: Array, grid: Grid) -> Array:  # noqa: ARG002
        """Return what turns with the body beyond θ, shape (P, 3, 3), kg·m²."""
        return np.zeros((3, 3))

    def hidden_momentum(self, value: Array, state: Array) -> Array:  # noqa: ARG002
        """Return the momentum that the effect's states hold, shape (R, P, 3), N·m·s, body axes."""
        return np.zeros(3)

    def gyro_time_constant(self, value: Array) -> Array:  # noqa: ARG002
        """Return the time constant of a first-order low-pass in the gyro, shape (P,), s."""
        return np.zeros(1)

    def gyro_delay(self, value: Array) -> Array:  # noqa: ARG002
        """Return the latency of the gyro's samples, shape (P,), s."""
        return np.zeros(1)

    def held_torque_delay(self, value: Array) -> Array:  # noqa: ARG002
        """Return by how much a torque that is held from sample to sample acts late, shape (P,), s; early if negative.

        The whole motion is as late, and is read so much earlier: exactly, where the jumps of a torque that is moved
        along the grid would fall between its nodes.
        """
        return np.zeros(1)

    def gyro_clock_drift(self, value: Array) -> Array:  # noqa: ARG002
        """Return by which share of the records' time the gyro's clock is ahead of the actuators', shape (P,)."""
        return np.zeros(1)

    def gyro_averaging(self, value: Array) -> Array:  # noqa: ARG002
        """Return the share of its sample period over which the gyro averages, up to the sample's time, shape (P,)."""
        return np.zeros(1)

    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:  # noqa: ARG002
        """Return what the gyro reads, shape (P, N, 3), rad/s, instead of `reading`, at times of shape (N,)."""
        return reading

    def telemetry_lateness(self, value: Array) -> Array:  # noqa: ARG002
        """Return by how much the actuators' telemetry is late by the gyro's clock, shape (P,), s."""
        return np.zeros(1)

    def motor_torque(self, torque: Array, value: Array, gimbal_rate: Array) -> Array:  # noqa: ARG002
        """Return what the gimbal motors give, shape (P, K, M), N·m, instead of `torque`; rates alike, rad/s."""
        return torque

    def servo_lag(self, value: Array, units: int) -> Array:  # noqa: ARG002
        """Return the time constant by which each of M gimbals' motors stays behind its demand, shape (P, M), s."""
        return np.zeros((1, units))

    def wheel_lag(self, value: Array, wheels: int) -> Array:  # noqa: ARG002
        """Return the time constant by which each of W wheels' motors follows its command, shape (P, W), s."""
        return np.zeros((1, wheels))

    def wheel_delay(self, value: Array, wheels: int) -> Array:  # noqa: ARG002
        """Return how much later than its command each of W wheels' motors gives its torque, shape (P, W), s."""
        return np.zeros((1, wheels))

    def wheel_inertia_error(self, value: Array, wheels: int) -> Array:  # noqa: ARG002
        """Return by which share the wheels' spin inertias are larger than believed, shape (P, W)."""
        return np.zeros((1, wheels))

    def wheel_impulse(self, impulse: Array, value: Array, of: Impulses) -> Array:  # noqa: ARG002
        """Return what the wheels' motors give to their motion, shape (P, L, W), N·m·s, instead of `impulse`."""
        return impulse


def overrides(hook: Hooks, *parts: str) -> bool:
    """Return whether an effect changes any of some parts of the contract."""
    return any(getattr(type(hook), part) is not getattr(Hooks, part) for part in parts)


def sign_of(value: Array) -> Array:
    """Return the sign of the real part: analytic but at zero."""
    return np.sign(value.real)


def magnitude(value: Array) -> Array:
    """Return |value| as the analytic function that it is on either side of zero."""
    return value * sign_of(value)


def column(value: Array, index: int) -> Array:
    """Return one parameter so that it broadcasts against (R, P, 3), shape (P, 1).

    Args:
        value: shape (P, K).
        index: of the parameter.
    """
    return value[:, index, None]
