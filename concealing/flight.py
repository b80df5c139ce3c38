"""Several runs side by side, from release on: the craft as it is, under the controller as flown."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from concealing.craft import Array
from concealing.integration import step, steps_for
from concealing.mechanics import Inputs, Mechanics
from concealing.sensors import Noise, SensorNumbers, encoder_reading, gyro_reading


class Order(NamedTuple):
    """What the controller asks for through one period.

    Attributes:
        torque: demand on each gimbal motor, (B, M), N·m.
        gimbal_rate: that the steering law wants, (B, M), rad/s.
    """

    torque: Array
    gimbal_rate: Array


class Guidance(Protocol):
    """The controller on board."""

    def order(self, tick: int, encoder: Array, gyro: Array | None) -> Order:
        """Return what to do from a tick on, given readings, (B, M) and (B, 3); the gyro's where it has a sample."""
        ...


@dataclass(frozen=True, kw_only=True)
class Clock:
    """Control ticks, and how many of them lie between two samples of the gyro.

    Attributes:
        period: s.
        ticks: whole periods in the flight.
        gyro_ticks: periods between two gyro samples.
    """

    period: float
    ticks: int
    gyro_ticks: int

    @property
    def times(self) -> Array:
        """Start of every period and the end of the last, s."""
        return np.arange(self.ticks + 1) * self.period


@dataclass(frozen=True, kw_only=True)
class Recording:
    """One row per control tick, K in all, of B runs.

    Attributes:
        time: (K,), s.
        gyro: (K, B, 3), rad/s; NaN between samples.
        encoder: (K, B, M), rad.
        tachometer: (K, B, M), rad/s.
        motor_torque: measured, (K, B, M), N·m.
        rate_order: (K, B, M), rad/s.
        body_rate: true, (K, B, 3), rad/s.
    """

    time: Array
    gyro: Array
    encoder: Array
    tachometer: Array
    motor_torque: Array
    rate_order: Array
    body_rate: Array


@dataclass(frozen=True, kw_only=True)
class FlightLog(Recording):
    """A recording with the true state at the ticks and on the integrator's own grid.

    Attributes:
        state: true, (K, B, n).
        demand: in the period before each tick, (K, B, M), N·m.
        fine_time: (F,), s.
        fine_state: (F, B, n).
    """

    state: Array
    demand: Array
    fine_time: Array
    fine_state: Array


class _Readings(NamedTuple):
    """What the sensors show at a tick; the gyro's only where it has a sample."""

    gyro: Array | None
    encoder: Array
    tachometer: Array
    motor_torque: Array
    body_rate: Array


class Trace:
    """States on the integrator's grid, the gyro's view of the past, and which way each motor last pushed."""

    def __init__(self, mechanics: Mechanics, clock: Clock, start: Array) -> None:
        """Begin at release.

        Args:
            mechanics: of the craft.
            clock: ticks.
            start: state at release, (B, n).
        """
        self.time: list[float] = []
        self.state: list[Array] = []
        self._mechanics, self._released = mechanics, mechanics.velocities(0.0, start).body_rate
        self._angle = start[:, mechanics.slices["angle"]]
        self._lead = np.zeros_like(self._angle)
        periods = mechanics.craft.gyro.latency / clock.period
        self._age = int(np.ceil(periods - 1e-9))
        self.share = self._age - periods
        """Of each period, after which the rate is seen that a later tick's reading shows."""
        self._views: list[Array] = []

    def note(self, time: float, state: Array) -> None:
        """Write down a state."""
        self.time.append(time)
        self.state.append(state)

    def view(self, time: float, state: Array) -> None:
        """Remember what the gyro will show later."""
        if self._mechanics.craft.gyro.bandwidth < np.inf:
            self._views.append(state[:, self._mechanics.slices["lowpass"]])
        else:
            self._views.append(self._mechanics.velocities(time, state).body_rate)

    def seen(self, tick: int) -> Array:
        """Return the rate that a reading at a tick shows: what was viewed `age` periods before."""
        before = tick - self._age
        return self._views[before] if before >= 0 else self._released

    def mean_seen(self, tick: int, ticks: int, share: float) -> Array:
        """Return the mean of what readings show over a share of so many periods before a tick, by trapezoids."""
        views = np.array([self.seen(tick - before) for before in range(ticks, -1, -1)])
        grown = np.concatenate([np.zeros_like(views[:1]), np.cumsum(0.5 * (views[1:] + views[:-1]), axis=0)])
        begin = ticks * (1.0 - share)
        first = min(int(begin), ticks - 1)
        before = grown[first] + (begin - first) * (grown[first + 1] - grown[first])
        return (grown[-1] - before) / (ticks * share)

    def lead(self, angle: Array) -> Array:
        """Return which way each motor last pushed, once a tick."""
        moved, self._angle = angle - self._angle, angle
        self._lead = np.where(moved == 0.0, self._lead, np.sign(moved))
        return self._lead


@dataclass(frozen=True, kw_only=True)
class Instruments:
    """Sensors with their noise, on their clock.

    Attributes:
        mechanics: of the craft.
        trace: of its flight.
        clock: ticks.
        sensors: nominal noise.
        noise: drawn numbers.
    """

    mechanics: Mechanics
    trace: Trace
    clock: Clock
    sensors: SensorNumbers
    noise: Noise

    def read(self, tick: int, state: Array, demand: Array) -> _Readings:
        """Return the readings at a tick; `demand` is that of the period before."""
        mechanics, sensors, noise = self.mechanics, self.sensors, self.noise
        time, angle = tick * self.clock.period, state[:, mechanics.slices["angle"]]
        rates = mechanics.velocities(time, state)
        torque = mechanics.motor_torque(state, rates.gimbal_rate, demand)
        return _Readings(
            gyro=self.gyro(tick, state),
            encoder=encoder_reading(
                mechanics.craft.encoders,
                angle,
                self.trace.lead(angle),
                sensors.encoder_noise * noise.encoder[tick],
                sensors.encoder_step,
            ),
            tachometer=mechanics.shown_speed(time, rates.rotor_speed)
            + sensors.tachometer_noise * noise.tachometer[tick],
            motor_torque=torque + sensors.torque_noise * noise.torque[tick],
            body_rate=rates.body_rate,
        )

    def gyro(self, tick: int, state: Array) -> Array | None:
        """Return the gyro's reading, (B, 3), rad/s; None between its samples. To be called at every tick, in order."""
        time = tick * self.clock.period
        if self.trace.share == 0.0:
            self.trace.view(time, state)
        if tick % self.clock.gyro_ticks:
            return None
        gyro, noise = self.mechanics.craft.gyro, self.noise
        scatter = self.sensors.gyro_noise * noise.gyro[tick] + gyro.extra_noise * noise.extra[tick]
        seen = self.trace.seen(tick)
        if gyro.averaging > 0.0:
            seen = self.trace.mean_seen(tick, self.clock.gyro_ticks, gyro.averaging)
        return gyro_reading(gyro, seen, time, scatter, noise.walk[tick])


def fly(
    mechanics: Mechanics,
    start: Array,
    guidance: Guidance,
    clock: Clock,
    sensors: SensorNumbers,
    noise: Noise,
    refinement: float = 1.0,
) -> FlightLog:
    """Fly to the end of the clock.

    Args:
        mechanics: of the craft.
        start: state at release, (B, n).
        guidance: controller.
        clock: ticks.
        sensors: nominal noise.
        noise: drawn numbers.
        refinement: of the integrator's steps, for tests of its error.
    """
    trace = Trace(mechanics, clock, start)
    instruments = Instruments(mechanics=mechanics, trace=trace, clock=clock, sensors=sensors, noise=noise)
    state, demand, rows = start, np.zeros_like(start[:, mechanics.slices["angle"]]), []
    for tick, time in enumerate(clock.times):
        readings = instruments.read(tick, state, demand)
        order = guidance.order(tick, readings.encoder, readings.gyro)
        rows.append(_row(readings) | {"rate_order": order.gimbal_rate, "state": state, "demand": demand})
        trace.note(time, state)
        if tick < clock.ticks:
            demand = order.torque
            state = through_period(mechanics, trace, state, time, clock.period, Inputs(demand), refinement)
    return FlightLog(
        time=clock.times,
        fine_time=np.array(trace.time),
        fine_state=np.array(trace.state),
        **{name: np.array([row[name] for row in rows]) for name in rows[0]},
    )


def _row(readings: _Readings) -> dict[str, Array]:
    gyro = np.full_like(readings.body_rate, np.nan) if readings.gyro is None else readings.gyro
    return readings._asdict() | {"gyro": gyro}


def through_period(
    mechanics: Mechanics, trace: Trace, state: Array, time: float, period: float, inputs: Inputs, refinement: float
) -> Array:
    """Integrate one control period, in pieces that end at blows and where the gyro looks.

    Args:
        mechanics: of the craft.
        trace: of its flight, into which the states on the way are written.
        state: at the period's start, (B, n).
        time: then, s.
        period: s.
        inputs: held through it.
        refinement: of the integrator's steps.

    Returns:
        The state at its end.
    """
    look, calm = time + trace.share * period, time + min(mechanics.restless, period)
    blows = {impulse.time for impulse in mechanics.craft.impulses if time < impulse.time <= time + period}
    looks = {look} if trace.share > 0.0 else set()
    here = time
    for there in sorted(blows | looks | {calm, time + period}):
        fastest = mechanics.fastest if there <= calm else mechanics.calm
        for now, size in _steps(here, there, fastest, refinement):
            state = step(lambda at, value: mechanics.derivative(at, value, inputs), now, state, size)
            if now + 1.5 * size < there:
                trace.note(now + size, state)
        if there in blows:
            state = _struck(mechanics, state, there)
        if there in looks:
            trace.view(there, state)
        if there < time + period:
            trace.note(there, state)
        here = there
    return state


def _steps(start: float, end: float, fastest: float, refinement: float) -> Iterator[tuple[float, float]]:
    count = steps_for(end - start, fastest, refinement)
    size = (end - start) / count
    return ((start + index * size, size) for index in range(count))


def _struck(mechanics: Mechanics, state: Array, time: float) -> Array:
    """Add the blows of one time to the whole momentum; the gimbals, free to turn, keep their own."""
    state = state.copy()
    attitude = state[:, mechanics.slices["attitude"]].reshape(-1, 3, 3)
    for impulse in mechanics.craft.impulses:
        if impulse.time == time:
            struck = slice(None) if impulse.run is None else min(impulse.run, len(state) - 1)
            state[struck, mechanics.slices["momentum"]] += attitude[struck] @ impulse.momentum
    return state


def follow(
    mechanics: Mechanics,
    start: Array,
    demand: Callable[[int], Array],
    period: float,
    ticks: int,
    refinement: float = 1.0,
) -> Array:
    """Return the states at the ticks of a flight under given torque demands, (ticks + 1, B, n), without sensors."""
    states, state = [start], start
    for tick in range(ticks):
        inputs, time = Inputs(demand(tick)), tick * period
        for now, size in _steps(time, time + period, mechanics.fastest, refinement):
            state = step(lambda at, value, held=inputs: mechanics.derivative(at, value, held), now, state, size)
        states.append(state)
    return np.array(states)
