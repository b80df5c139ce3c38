"""One simulated platform: the only mutable object of the testbed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal, TypeAlias

import mujoco
import numpy as np

from testbed.arrays import Array, Flags, Units, Vector3
from testbed.errors import DivergedError
from testbed.plant.geometry import unit_names
from testbed.plant.layout import described_state, layout_of
from testbed.plant.properties import InitialState

Model: TypeAlias = mujoco.MjModel
"""A compiled platform, named here so that no other room has to import MuJoCo."""
RotorMode: TypeAlias = Literal["constant_speed", "free"]

_RATE_BOUND = 1e4
"""rad/s. No rate of this platform comes near it; a state beyond it has diverged."""


class Plant:
    """A platform flying in MuJoCo.

    The gimbal motors take torque demands; each motor's own limit and tachometer loop are inside the model. The rotor
    servos hold their speed (`constant_speed`) or stay disengaged (`free`); in both modes a rotor whose momentum is
    beyond its limit is braked, and `rotor_clamped` says so.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        *,
        initial: InitialState,
        rotor_momentum: Units,
        rotor_momentum_limit: float = math.inf,
        rotors: RotorMode = "constant_speed",
    ) -> None:
        """Put a platform into its initial state.

        Args:
            model: compiled platform.
            initial: pose, rates and gimbal angles at the start; the gimbals stand still.
            rotor_momentum: Js·Ω at the start, shape (6,), N·m·s.
            rotor_momentum_limit: N·m·s.
            rotors: what the rotor servos do.
        """
        self.model = model
        self.layout = layout_of(model)
        self._data = mujoco.MjData(model)
        self._spin_inertia = model.body_inertia[[model.body(name).id for name in unit_names("rotor")], 0]
        self._speed_limit = rotor_momentum_limit / self._spin_inertia
        self._always_engaged = rotors == "constant_speed"
        self._place(initial, rotor_momentum)
        self._engage_rotor_servos()
        self._last_time, self._last_qpos, self._last_qvel = 0.0, self.qpos.copy(), self.qvel.copy()

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return float(self._data.time)

    @property
    def qpos(self) -> Array:
        """Live view of MuJoCo's position vector, shape (nq,); copy to keep."""
        return self._data.qpos  # type: ignore[no-any-return]

    @property
    def qvel(self) -> Array:
        """Live view of MuJoCo's velocity vector, shape (nv,); copy to keep."""
        return self._data.qvel  # type: ignore[no-any-return]

    @property
    def gimbal_angle(self) -> Units:
        """True gimbal angles, shape (6,), rad."""
        return self._data.qpos[self.layout.gimbal_angle]  # type: ignore[no-any-return]

    @property
    def body_rate(self) -> Vector3:
        """Live view of the true body rate, shape (3,), rad/s, body axes."""
        return self._data.qvel[self.layout.body_rate]  # type: ignore[no-any-return]

    @property
    def joint_torque(self) -> Array:
        """Live view of the actuator torque on every degree of freedom in the last step, shape (nv,), N·m."""
        return self._data.qfrc_actuator  # type: ignore[no-any-return]

    @property
    def contacts(self) -> int:
        """Number of contacts with the cabin in the last step."""
        return int(self._data.ncon)

    @property
    def rotor_clamped(self) -> Flags:
        """Which rotors are beyond their momentum limit, shape (6,)."""
        speed = np.abs(self._data.qvel[self.layout.rotor_speed])
        return np.asarray(speed > self._speed_limit * (1.0 + 1e-9), dtype=np.bool_)

    def advance(self, gimbal_torque_demand: Units, steps: int) -> None:
        """Hold the gimbal motors' torque demands for a number of integrator steps.

        Args:
            gimbal_torque_demand: shape (6,), N·m, before the tachometer loop and the motor's limit.
            steps: integrator steps.

        Raises:
            DivergedError: the state is no longer finite, or a rate is beyond any that the platform can have.
        """
        self._last_time, self._last_qpos[:], self._last_qvel[:] = self._data.time, self._data.qpos, self._data.qvel
        self._data.ctrl[self.layout.gimbal_motor] = gimbal_torque_demand
        if not self._always_engaged:
            self._engage_rotor_servos()
        mujoco.mj_step(self.model, self._data, steps)
        fastest = np.abs(self._data.qvel).max()
        if not fastest < _RATE_BOUND:  # also true for NaN
            raise DivergedError(self._describe_divergence())

    def _place(self, initial: InitialState, rotor_momentum: Units) -> None:
        data, layout = self._data, self.layout
        data.qpos[layout.position] = initial.position
        data.qpos[layout.attitude] = initial.attitude / np.linalg.norm(initial.attitude)
        data.qpos[layout.gimbal_angle] = initial.gimbal_angle
        data.qvel[layout.velocity] = initial.velocity
        data.qvel[layout.body_rate] = initial.body_rate
        data.qvel[layout.rotor_speed] = rotor_momentum / self._spin_inertia

    def _engage_rotor_servos(self) -> None:
        engaged = np.ones(6) if self._always_engaged else self.rotor_clamped.astype(np.float64)
        self._data.ctrl[self.layout.rotor_motor] = engaged

    def _describe_divergence(self) -> str:
        state = described_state(self.layout, self._last_qpos, self._last_qvel)
        return (
            f"the simulation diverged between t = {self._last_time:.6g} s and {self.time:.6g} s. "
            f"The last finite state was {state}. Try a smaller simulation.step_s or a softer gimbal servo"
        )


@contextmanager
def quiet_warnings() -> Iterator[None]:
    """Keep MuJoCo from writing MUJOCO_LOG.TXT into the current folder; divergence raises an error instead (trap 3)."""
    mujoco.set_mju_user_warning(lambda _message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)
