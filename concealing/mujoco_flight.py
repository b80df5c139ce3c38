"""Cases flown in MuJoCo, in the closed loop with the controller as flown: an engine that nobody here wrote."""

from __future__ import annotations

import mujoco
import numpy as np

from concealing.case import Case
from concealing.craft import Array, Craft, Motion
from concealing.flight import Clock, Recording
from concealing.flown import Flown, as_flown, clock_of, epochs, guidance_of, noise_of, released_rates
from concealing.guidance import software_of
from concealing.mujoco_craft import compiled
from concealing.sensors import encoder_reading, gyro_reading

_UNITS = range(1, 7)


class _Platforms:
    """B runs of one model, side by side, with what acts on them written in before every step."""

    def __init__(self, craft: Craft, model: mujoco.MjModel, released: Array, epoch: Array) -> None:
        self._craft, self._model, self._epoch = craft, model, epoch
        self._all = [mujoco.MjData(model) for _ in released]
        self._angle = [model.joint(f"cmg{unit}_gimbal").qposadr[0] for unit in _UNITS]
        self._motor = [model.actuator(f"cmg{unit}_gimbal_motor").id for unit in _UNITS]
        self._gimbal = [model.joint(f"cmg{unit}_gimbal").dofadr[0] for unit in _UNITS]
        self._rotor = [model.joint(f"cmg{unit}_rotor").dofadr[0] for unit in _UNITS]
        self._servo = [model.actuator(f"cmg{unit}_rotor_motor").id for unit in _UNITS]
        self._held_speed = model.actuator_gainprm[self._servo, 0].copy()
        for data, rate in zip(self._all, released, strict=True):
            data.qvel[3:6] = rate
            data.qvel[self._rotor] = craft.units.rotor_speed
            data.ctrl[self._servo] = 1.0

    @property
    def step(self) -> float:
        """s."""
        return float(self._model.opt.timestep)

    @property
    def body_rate(self) -> Array:
        return np.array([data.qvel[3:6] for data in self._all])

    @property
    def gimbal_angle(self) -> Array:
        return np.array([data.qpos[self._angle] for data in self._all])

    @property
    def rotor_speed(self) -> Array:
        return np.array([data.qvel[self._rotor] for data in self._all])

    @property
    def motor_torque(self) -> Array:
        """Of the last step, (B, M), N·m."""
        return np.array([data.qfrc_actuator[self._gimbal] for data in self._all])

    def advance(self, time: float, torque: Array) -> None:
        """Fly one step under motor torque demands, (B, M), N·m."""
        middle = time + self.step / 2
        self._model.actuator_gainprm[self._servo, 0] = self._held_speed * np.exp(-self._craft.units.spin_down * middle)
        external = self._external_torque(time)
        for data, demand, acting in zip(self._all, torque, external, strict=True):
            data.ctrl[self._motor] = demand
            data.qfrc_applied[3:6] = acting
            mujoco.mj_step(self._model, data)

    def _external_torque(self, time: float) -> Array:
        """Return the sum of all torques on the bus at a step's beginning, and the blows in it, (B, 3), body axes."""
        craft, total = self._craft, np.zeros((len(self._all), 3))
        if craft.torques:
            motion = Motion(time, self._epoch, self._attitude(), np.eye(3)[None], self.body_rate)
            total += sum(torque(motion) for torque in craft.torques)
        for impulse in craft.impulses:
            if time <= impulse.time < time + self.step:
                struck = slice(None) if impulse.run is None else min(impulse.run, len(total) - 1)
                total[struck] += impulse.momentum / self.step
        return total

    def _attitude(self) -> Array:
        matrices = np.empty((len(self._all), 9))
        for matrix, data in zip(matrices, self._all, strict=True):
            mujoco.mju_quat2Mat(matrix, data.qpos[3:7])
        return matrices.reshape(-1, 3, 3)


class _GyroView:
    """The true rate as the gyro sees it: low-passed, and late."""

    def __init__(self, craft: Craft, step: float, released: Array) -> None:
        self._latency = craft.gyro.latency / step
        decay = 2.0 * np.pi * craft.gyro.bandwidth * step
        passed = -np.expm1(-decay)
        self._keep = 1.0 - passed
        self._now = 1.0 - passed / decay  # a straight line through each step
        self._rates, self._seen = [released], [released]

    def note(self, rate: Array) -> None:
        """Take the true rate one step later."""
        before = 1.0 - self._keep - self._now
        self._seen.append(self._keep * self._seen[-1] + before * self._rates[-1] + self._now * rate)
        self._rates.append(rate)

    def rate(self) -> Array:
        """Return what the gyro shows now, between steps in proportion, (B, 3)."""
        place = max(len(self._seen) - 1 - self._latency, 0.0)
        below = int(place)
        above = min(below + 1, len(self._seen) - 1)
        return self._seen[below] + (place - below) * (self._seen[above] - self._seen[below])


def fly_in_mujoco(case: Case, *, quiet: bool = False) -> Flown:
    """Fly all runs of a case in MuJoCo.

    Args:
        case: what to fly.
        quiet: without any noise of the sensors, on board and recorded.

    Raises:
        ValueError: no MJCF element stands for an effect of the case.
    """
    known, clock = software_of(case.scenario), clock_of(case)
    craft, sensors = as_flown(case, quiet=quiet)
    noise = noise_of(case, clock, len(craft.units.spin_inertia))
    released = released_rates(case)
    platforms = _Platforms(craft, compiled(craft, known), released, epochs(case))
    view = _GyroView(craft, platforms.step, released)
    guidance, rows = guidance_of(case, known, clock), []
    for tick, time in enumerate(clock.times):
        gyro = None
        if tick % clock.gyro_ticks == 0:
            scatter = sensors.gyro_noise * noise.gyro[tick] + craft.gyro.extra_noise * noise.extra[tick]
            gyro = gyro_reading(craft.gyro, view.rate(), time, scatter, noise.walk[tick])
        angle = platforms.gimbal_angle
        encoder = encoder_reading(
            craft.encoders,
            angle,
            np.zeros_like(angle),
            sensors.encoder_noise * noise.encoder[tick],
            sensors.encoder_step,
        )
        order = guidance.order(tick, encoder, gyro)
        shown = platforms.rotor_speed / craft.tachometer_scale * np.exp(craft.units.spin_down * time)
        rows.append(
            {
                "gyro": np.full_like(released, np.nan) if gyro is None else gyro,
                "encoder": encoder,
                "tachometer": shown + sensors.tachometer_noise * noise.tachometer[tick],
                "motor_torque": platforms.motor_torque + sensors.torque_noise * noise.torque[tick],
                "rate_order": order.gimbal_rate,
                "body_rate": platforms.body_rate,
            }
        )
        if tick < clock.ticks:
            _through_period(platforms, view, clock, tick, order.torque)
    log = Recording(time=clock.times, **{name: np.array([row[name] for row in rows]) for name in rows[0]})
    return Flown(case=case, craft=craft, clock=clock, sensors=sensors, log=log)


def _through_period(platforms: _Platforms, view: _GyroView, clock: Clock, tick: int, torque: Array) -> None:
    steps = round(clock.period / platforms.step)
    for step in range(steps):
        platforms.advance(tick * clock.period + step * platforms.step, torque)
        view.note(platforms.body_rate)
