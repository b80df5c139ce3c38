"""What the clock of a run must agree with: the sensors' and the loop's rates, the servos, what an estimate needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from testbed.scenario.actuators import ReactionWheels
from testbed.scenario.clocks import duration_conflicts, order_conflicts, rate_conflicts, step_conflicts
from testbed.scenario.gyros import Gyros
from testbed.scenario.maneuver import MIN_SAMPLES, CsvManeuver, Maneuver
from testbed.scenario.platform import Truth
from testbed.scenario.section import Conflict
from testbed.scenario.sensors import Gyro
from testbed.scenario.simulation import Simulation

ROTOR_SERVO_BANDWIDTH = 300.0
"""rad/s. Of the servos that the plant puts on the rotors; a test holds the two numbers equal."""
_STABILITY_LIMIT = 2.785
"""Largest rate of a servo, or of a formula's memory, times step that a fourth-order Runge-Kutta step bears."""

STEP_TURN = 1.0
"""rad by which an unbalanced wheel may turn in a step: a fourth-order step then integrates its force to 1 % (1/120)."""
MOST_TICKS = 400_000
"""Control periods of a flight: each takes 9 kB with its record, page and recording (measured at 16,000 to 160,000), all
of them 3.6 GB. An hour at 80 Hz has 288,000."""
_KILOBYTES_A_TICK = 9.0
MOST_STEPS = 200_000_000
"""Integration steps of a flight, an hour's work of one core at 17 µs each."""


def clock_conflicts(simulation: Simulation, gyro: Gyro | None) -> Iterator[Conflict]:
    """Find periods that do not divide, and a run that does not end with one."""
    rates = {
        "simulation.control_rate_hz": simulation.control_rate_hz,
        "simulation.telemetry_rate_hz": simulation.telemetry_rate_hz,
    }
    if gyro is not None:
        rates["gyro.sample_rate_hz"] = gyro.sample_rate_hz
    yield from step_conflicts(simulation.step_s, rates)
    yield from order_conflicts(rates, "simulation.control_rate_hz")
    yield from rate_conflicts(rates)
    if simulation.duration_s is not None:
        yield from duration_conflicts(simulation.duration_s, simulation.control_rate_hz)


def size_conflicts(simulation: Simulation, maneuver: Maneuver | None) -> Iterator[Conflict]:
    """Find a flight that no memory holds, or that would never end."""
    key, duration = _length(simulation, maneuver)
    if duration is not None and (problem := too_large(simulation, duration)):
        yield Conflict(key=key, text=problem)


def too_large(simulation: Simulation, duration: float) -> str:
    """Return why a flight of some duration, s, is too large; nothing where it is not."""
    ticks, steps = duration * simulation.control_rate_hz, duration / simulation.step_s
    if ticks > MOST_TICKS:
        return (
            f"{duration:g} s at control_rate_hz = {simulation.control_rate_hz:g} are {ticks:,.0f} control periods, "
            f"which take {ticks * _KILOBYTES_A_TICK / 1e6:.3g} GB; at most {MOST_TICKS:,} are flown: "
            f"{MOST_TICKS / simulation.control_rate_hz:.4g} s, or a lower rate"
        )
    if steps > MOST_STEPS:
        return (
            f"{duration:g} s in steps of {simulation.step_s:g} s are {steps:,.0f} steps; at most {MOST_STEPS:,} are "
            f"flown: {MOST_STEPS * simulation.step_s:.4g} s, or longer steps"
        )
    return ""


def stiffness_conflicts(
    simulation: Simulation, gyros: Gyros | None, wheels: Sequence[ReactionWheels] | None
) -> Iterator[Conflict]:
    """Find a step too long for the fastest servo that is always at work."""
    if gyros is None or wheels is None:
        return
    servos = {"wheel": max((each.speed_loop_bandwidth_rad_s or 0.0 for each in wheels), default=0.0)}
    if gyros.units:
        servos["gimbal"] = gyros.servo_bandwidth
        if gyros.rotors == "constant_speed":
            servos["rotor"] = ROTOR_SERVO_BANDWIDTH
    if not any(servos.values()):
        return
    fastest = max(servos, key=lambda servo: servos[servo])
    longest = _STABILITY_LIMIT / servos[fastest]
    if simulation.step_s >= longest:
        text = (
            f"{simulation.step_s} s is too long for the {fastest} servo of {servos[fastest]} rad/s; "
            f"stay below {longest:.3g} s"
        )
        yield Conflict(key="simulation.step_s", text=text)


def memory_conflicts(simulation: Simulation, truth: Truth | None) -> Iterator[Conflict]:
    """Find memories of formulas that are too short for the step."""
    for number, each in enumerate(() if truth is None else truth.torque, start=1):
        law = each.torque.law
        if simulation.step_s * law.fastest_rate >= _STABILITY_LIMIT:
            shortest = simulation.step_s * law.fastest_rate / _STABILITY_LIMIT * float(law.memory_constant or 0.0)
            text = (
                f"of entry {number} has a {law.memory} of {law.memory_constant:g} s, too short for steps of "
                f"{simulation.step_s:g} s; above {shortest:.3g} s they follow it, and without one it acts at once"
            )
            yield Conflict(key="truth.torque.formula", text=text)


def imbalance_conflicts(
    simulation: Simulation, truth: Truth | None, wheels: Sequence[ReactionWheels] | None
) -> Iterator[Conflict]:
    """Find a step too long for wheels that tremble."""
    if not truth or not wheels or not any(truth.wheel_imbalance_kg_m):
        return
    fastest = max(each.momentum_limit_N_m_s / each.spin_inertia_kg_m2 for each in wheels)
    if simulation.step_s * fastest > STEP_TURN:
        text = (
            f"{simulation.step_s} s is too long for truth.wheel_imbalance_kg_m: the fastest wheel turns by up to "
            f"{simulation.step_s * fastest:.3g} rad in it; stay at or below {STEP_TURN / fastest:.3g} s"
        )
        yield Conflict(key="simulation.step_s", text=text)


def sample_conflicts(simulation: Simulation, gyro: Gyro | None, maneuver: Maneuver | None) -> Iterator[Conflict]:
    """Find a run whose gyro samples are too few for an estimate."""
    key, duration = _length(simulation, maneuver)
    if gyro is None or duration is None:
        return
    samples = duration * gyro.sample_rate_hz
    if samples < MIN_SAMPLES:
        text = (
            f"{duration} s at gyro.sample_rate_hz = {gyro.sample_rate_hz} gives {samples:.3g} samples, "
            f"an estimate needs {MIN_SAMPLES}; fly {MIN_SAMPLES / gyro.sample_rate_hz:.3g} s or sample faster"
        )
        yield Conflict(key=key, text=text)


def _length(simulation: Simulation, maneuver: Maneuver | None) -> tuple[str, float | None]:
    """The key that decides how long is flown, and the length, s; None where a table of samples decides."""
    if simulation.duration_s is not None or maneuver is None or isinstance(maneuver, CsvManeuver):
        return "simulation.duration_s", simulation.duration_s
    return "maneuver.duration_s", maneuver.duration_s + simulation.settle_s
