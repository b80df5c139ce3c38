"""Simulated platforms, one or many: the only mutable object of the testbed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import mujoco
import numpy as np
from mujoco.batch import Batch

from testbed.arrays import Array, Flags, Indices, Matrices3, Units, UnitSeries, Vectors3
from testbed.dynamics.environment import OrbitTorque
from testbed.formulas.torque import Torque
from testbed.plant.formula_torques import FormulaTorques, Slopes, stepped
from testbed.plant.geometry import total_momentum, unit_count, unit_names, wheel_count, wheel_names
from testbed.plant.gyrostat_batch import GyrostatBatch
from testbed.plant.layout import described_state, layout_of
from testbed.plant.properties import InitialState
from testbed.rotation.quaternion import matrix_of, matrix_or_identity

Model: TypeAlias = mujoco.MjModel
"""A compiled platform, named here so that no other room has to import MuJoCo."""
RotorMode: TypeAlias = Literal["constant_speed", "free"]
Engine: TypeAlias = Literal["mujoco", "compiled"]
"""What steps platforms: MuJoCo, or the compiled equations of motion of a gyrostat."""

_RATE_BOUND = 1e4
"""rad/s. No rate of this platform comes near it; a state beyond it has diverged."""
_LARGEST_TURN = 1.0
"""rad in a step: what a rule of fourth order errs by in each is then about 1/5!, a hundredth of the turn.

Source: formula: the fifth term of the exponential series."""


class Plant:
    """One platform or many, flying side by side; every array has the platforms on its first axis.

    The gimbal motors take torque demands; each motor's own limit and tachometer loop are inside the model. The rotor
    servos hold their speed (`constant_speed`) or stay disengaged (`free`); in both modes a rotor whose momentum is
    beyond its limit is braked, and `rotor_clamped` says so. A platform that diverges stays in its last finite state;
    the others fly on. What one platform does depends neither on the others nor on the number of threads, bit for bit.
    """

    def __init__(
        self,
        models: Sequence[Model],
        *,
        initial: Sequence[InitialState],
        rotor_momentum: UnitSeries,
        rotor_momentum_limit: Units | float = math.inf,
        rotors: RotorMode = "constant_speed",
        wheel_momentum: UnitSeries | None = None,
        wheel_momentum_limit: Units | float = math.inf,
        orbit_torque: OrbitTorque | None = None,
        torques: Sequence[Torque] = (),
        threads: int = 1,
        engine: Engine = "mujoco",
    ) -> None:
        """Put platforms into their initial states.

        Args:
            models: compiled platforms of one layout, B of them; the same object where they are alike.
            initial: pose, rates and gimbal angles of each at the start; the gimbals stand still.
            rotor_momentum: Js·Ω at the start, shape (B, M), N·m·s.
            rotor_momentum_limit: of each, shape (M,), or of all, N·m·s.
            rotors: what the rotor servos do.
            wheel_momentum: Jw·Ω of the reaction wheels at the start, shape (B, W), N·m·s; at rest where None.
            wheel_momentum_limit: to which their drives push them, shape (W,), N·m·s.
            orbit_torque: what an orbit does to the platforms; nothing where None.
            torques: by formulas, on each of the platforms.
            threads: that step the platforms.
            engine: what steps them; "compiled" for platforms with nothing `testbed.plant.gyrostat.uncovered`, on which
                no formulas act.
        """
        self.models = tuple(models)
        self.layout = layout_of(self.models[0])
        self.divergence: dict[int, str] = {}
        """What went wrong with each platform that diverged, with time and state."""
        compiled = engine == "compiled"
        self._batch = GyrostatBatch(models, threads, orbit_torque) if compiled else _batch(self.models, threads)
        self.qpos: Array = self._batch.bind("qpos")
        """Live view of MuJoCo's positions, shape (B, nq); copy to keep."""
        self.qvel: Array = self._batch.bind("qvel")
        """Live view of MuJoCo's velocities, shape (B, nv); copy to keep."""
        self.joint_torque: Array = self._batch.bind("qfrc_actuator")
        """Live view of the actuator torque on every degree of freedom in the last step, shape (B, nv), N·m."""
        self.contacts: Array = self._batch.bind("ncon")
        """Live view of the number of contacts with the cabin in the last step, shape (B,)."""
        self._control, self._time = self._batch.bind("ctrl"), self._batch.bind("time")
        self._orbit_torque = orbit_torque
        self._torque_before: Vectors3 | None = None
        self._applied: Array = self._batch.bind("qfrc_applied")
        self._spin_inertia = np.stack([spin_inertia(model) for model in self.models])
        self.wheel_inertia: UnitSeries = np.stack([wheel_inertia(model) for model in self.models])
        """Jw of the reaction wheels, shape (B, W), kg·m²."""
        self._wheel_speed_limit = wheel_momentum_limit / self.wheel_inertia
        self._wheel_loop_gain = np.stack([_wheel_loop_gain(model) for model in self.models])
        self.wheel_clamped: Flags = np.zeros_like(self.wheel_inertia, dtype=np.bool_)
        """Which wheels are at their momentum limit and asked to go beyond, shape (B, W)."""
        self._speed_limit = rotor_momentum_limit / self._spin_inertia
        self._always_engaged = rotors == "constant_speed"
        self._place(initial, rotor_momentum)
        if wheel_momentum is not None:
            self.qvel[:, self.layout.wheel_speed] = wheel_momentum / self.wheel_inertia
        self._engage_rotor_servos()
        self._formulas = self._formulas_of(torques) if torques else None
        self.flying: Flags = np.ones(len(self.models), dtype=np.bool_)
        """Which platforms have not diverged, shape (B,)."""
        self._last_time, self._last_qpos, self._last_qvel = self._time.copy(), self.qpos.copy(), self.qvel.copy()

    @property
    def gimbal_angle(self) -> UnitSeries:
        """True gimbal angles, shape (B, M), rad."""
        return self.qpos[:, self.layout.gimbal_angle]

    @property
    def gimbal_rate(self) -> UnitSeries:
        """True gimbal rates, shape (B, M), rad/s."""
        return self.qvel[:, self.layout.gimbal_rate]

    @property
    def body_rate(self) -> Vectors3:
        """Live view of the true body rates, shape (B, 3), rad/s, body axes."""
        return self.qvel[:, self.layout.body_rate]

    @property
    def rotor_clamped(self) -> Flags:
        """Which rotors are beyond their momentum limit, shape (B, M)."""
        speed = np.abs(self.qvel[:, self.layout.rotor_speed])
        return np.asarray(speed > self._speed_limit * (1.0 + 1e-9), dtype=np.bool_)

    @property
    def wheel_speed(self) -> UnitSeries:
        """True speeds of the reaction wheels relative to the body, shape (B, W), rad/s."""
        return self.qvel[:, self.layout.wheel_speed]

    def total_momentum(self, platform: int, qpos: Array, qvel: Array) -> Vectors3:
        """Return the momentum of a platform along its motion; see `testbed.plant.geometry.total_momentum`."""
        if isinstance(self._batch, GyrostatBatch):
            return self._batch.total_momentum(platform, qpos, qvel)
        return total_momentum(self.models[platform], qpos, qvel)

    def advance(
        self, gimbal_torque_demand: UnitSeries, steps: int, wheel_torque_demand: UnitSeries | None = None
    ) -> None:
        """Hold the motors' torque demands for a number of integrator steps.

        Platforms join `divergence` whose state is no longer finite, that have a rate beyond any that they can have, or
        that turn further in a step than the integration follows.

        Args:
            gimbal_torque_demand: shape (B, M) or (M,), N·m, before the tachometer loop and the motor's limit.
            steps: integrator steps.
            wheel_torque_demand: of the reaction wheels, shape (B, W) or (W,), N·m, before the drive's speed loop and
                the motor's limit; held from before where None.
        """
        self._last_time[:], self._last_qpos[:], self._last_qvel[:] = self._time, self.qpos, self.qvel
        self._control[:, self.layout.gimbal_motor] = gimbal_torque_demand
        if wheel_torque_demand is not None:
            self._control[:, self.layout.wheel_motor] = self._within_speed(wheel_torque_demand)
        if not self._always_engaged:
            self._engage_rotor_servos()
        self._step(steps)
        bounded = np.abs(self.qvel).max(axis=1) < _RATE_BOUND
        turn = np.abs(self.body_rate).max(axis=1) * self.models[0].opt.timestep
        diverged = np.flatnonzero(self.flying & ~(bounded & (turn < _LARGEST_TURN)))  # also true for NaN
        if diverged.size:
            self._ground(diverged)

    def _step(self, steps: int) -> None:
        if self._formulas is not None:
            with np.errstate(over="ignore", invalid="ignore"):  # of what runs away `advance` makes an end
                for _ in range(steps):
                    self._step_by_stages(self._formulas)
            return
        if self._orbit_torque is None or isinstance(self._batch, GyrostatBatch):  # which knows of the orbit
            self._batch.step(np.flatnonzero(self.flying), nstep=steps)
            return
        for _ in range(steps):
            self._applied[:, self.layout.body_rate] = self._mean_orbit_torque(self._orbit_torque)
            self._batch.step(np.flatnonzero(self.flying), nstep=1)

    def _formulas_of(self, torques: Sequence[Torque]) -> FormulaTorques:
        """Return the formulas with the platforms where they start, and begin their memories."""
        self._activation, self._memory = self._batch.bind("act"), np.zeros((len(self.models), 0))
        self._rates = self._batch.bind("qacc"), self._batch.bind("act_dot")
        formulas = FormulaTorques(
            torques=tuple(torques), layout=self.layout, first_NA=matrix_of(self.qpos[:, self.layout.attitude])
        )
        self._memory = formulas.first_memory(formulas.moment(self._time.copy(), self.qpos, self.qvel))
        return formulas

    def _step_by_stages(self, formulas: FormulaTorques) -> None:
        """Take one step of MuJoCo's own rule, the torques evaluated at each of its stages."""
        assert not isinstance(self._batch, GyrostatBatch), "its equations have no such torques"
        batch, ids = self._batch, np.flatnonzero(self.flying)
        time, step = self._time.copy(), self.models[0].opt.timestep

        def slopes_at(share: float, state: Slopes) -> Slopes:
            self.qpos[ids], self.qvel[ids], self._activation[ids] = (part[ids] for part in state[:3])
            self._time[ids] = time[ids] + share * step
            at, memory = formulas.moment(time + share * step, state[0], state[1]), state[3]
            torque_B = formulas.torque(at, memory)
            if self._orbit_torque is not None:
                torque_B = torque_B + self._orbit_torque(float(time[0] + share * step), self._attitude_NB)
            self._applied[:, self.layout.body_rate] = torque_B
            batch.forward(ids)
            acceleration, activation_rate = (rate.copy() for rate in self._rates)
            return state[1].copy(), acceleration, activation_rate, formulas.memory_rate(at, memory)

        before = self.qpos.copy(), self.qvel.copy(), self._activation.copy(), self._memory
        after = stepped(step, before, slopes_at, self._moved)
        self.qpos[ids], self.qvel[ids], self._activation[ids] = (part[ids] for part in after[:3])
        self._memory = after[3]
        self._time[ids] = time[ids] + step

    def _moved(self, state: Slopes, slopes: Slopes, time: float) -> Slopes:
        """Return a state some time later; of positions, attitudes turn by the body rate."""
        qpos = state[0].copy()
        for model, own, velocity in zip(self.models, qpos, slopes[0], strict=True):
            mujoco.mj_integratePos(model, own, velocity, time)
        return qpos, *(part + time * slope for part, slope in zip(state[1:], slopes[1:], strict=True))

    @property
    def _attitude_NB(self) -> Matrices3:
        return matrix_or_identity(self.qpos[:, self.layout.attitude])

    def _mean_orbit_torque(self, torque_of: OrbitTorque) -> Vectors3:
        """Return the torque in the middle of the next step, by its last two values: it changes as the attitude does."""
        torque_B = torque_of(float(self._time.flat[0]), self._attitude_NB)
        before = torque_B if self._torque_before is None else self._torque_before
        self._torque_before = torque_B
        return np.asarray(1.5 * torque_B - 0.5 * before)

    def _within_speed(self, demand: UnitSeries) -> UnitSeries:
        """Return the demand, without what would push a wheel beyond its momentum limit: its drive does not."""
        speed = self.wheel_speed
        held = self._wheel_loop_gain * speed  # at which the speed loop asks for no torque
        self.wheel_clamped = (np.abs(speed) >= self._wheel_speed_limit) & ((demand - held) * speed > 0.0)
        return np.where(self.wheel_clamped, held, demand)

    def _ground(self, diverged: Indices) -> None:
        """Put platforms back into their last finite state and leave them there."""
        for platform in diverged:
            self.divergence[int(platform)] = self._describe_divergence(int(platform))
        self.qpos[diverged], self.qvel[diverged] = self._last_qpos[diverged], self._last_qvel[diverged]
        self.flying[diverged] = False

    def _place(self, initial: Sequence[InitialState], rotor_momentum: UnitSeries) -> None:
        layout = self.layout
        for platform, start in enumerate(initial):
            qpos, qvel = self.qpos[platform], self.qvel[platform]
            qpos[layout.attitude] = start.attitude / np.linalg.norm(start.attitude)
            qpos[layout.gimbal_angle] = start.gimbal_angle
            qvel[layout.body_rate] = start.body_rate
            if qpos[layout.position].size:
                qpos[layout.position], qvel[layout.velocity] = start.position, start.velocity
        self.qvel[:, layout.rotor_speed] = rotor_momentum / self._spin_inertia

    def _engage_rotor_servos(self) -> None:
        engaged = 1.0 if self._always_engaged else self.rotor_clamped.astype(np.float64)
        self._control[:, self.layout.rotor_motor] = engaged

    def _describe_divergence(self, platform: int) -> str:
        state = described_state(self.layout, self._last_qpos[platform], self._last_qvel[platform])
        return (
            f"the simulation diverged between t = {self._last_time[platform]:.6g} s and "
            f"{self._time[platform]:.6g} s. The last finite state was {state}. "
            "Try a smaller simulation.step_s or a softer gimbal servo"
        )


def _batch(models: Sequence[Model], threads: int) -> Batch:
    """Return platforms that MuJoCo steps."""
    batch = Batch(models[0], len(models), threads)
    if any(model is not models[0] for model in models):
        batch.set_models(models)
    return batch


def _wheel_loop_gain(model: Model) -> Units:
    """Return the gain of the loop on each wheel's speed, in the drive's own torque, shape (W,), N·m·s/rad."""
    motors = [model.actuator(name).id for name in wheel_names("motor", wheel_count(model))]
    return np.asarray(-model.actuator_biasprm[motors, 2] / model.actuator_gainprm[motors, 0])


def spin_inertia(model: Model) -> Units:
    """Return Js of the CMG units' rotors, shape (M,), kg·m²."""
    return _about(model, unit_names("rotor", unit_count(model)), 0)


def wheel_inertia(model: Model) -> Units:
    """Return Jw of the reaction wheels, shape (W,), kg·m²."""
    return _about(model, wheel_names("rotor", wheel_count(model)), 2)


def _about(model: Model, bodies: tuple[str, ...], axis: int) -> Units:
    return np.array([model.body_inertia[model.body(name).id, axis] for name in bodies])
