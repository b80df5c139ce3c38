"""What the clock of a run must agree with: the sensors' and the loop's rates, the servos, what an estimate needs."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.scenario.clocks import duration_conflicts, order_conflicts, rate_conflicts, step_conflicts
from testbed.scenario.cluster import Cluster
from testbed.scenario.maneuver import MIN_SAMPLES, CsvManeuver, Maneuver
from testbed.scenario.section import Conflict
from testbed.scenario.sensors import Gyro
from testbed.scenario.simulation import Simulation

ROTOR_SERVO_BANDWIDTH = 300.0
"""rad/s. Of the servos that the plant puts on the rotors; a test holds the two numbers equal."""
_STABILITY_LIMIT = 2.785
"""Largest servo bandwidth times step that a fourth-order Runge-Kutta step bears."""


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


def stiffness_conflicts(simulation: Simulation, cluster: Cluster | None) -> Iterator[Conflict]:
    """Find a step too long for the fastest servo that is always at work."""
    if cluster is None:
        return
    servos = {"gimbal": cluster.gimbal_servo_bandwidth_rad_s}
    if cluster.rotors == "constant_speed":
        servos["rotor"] = ROTOR_SERVO_BANDWIDTH
    fastest = max(servos, key=lambda servo: servos[servo])
    longest = _STABILITY_LIMIT / servos[fastest]
    if simulation.step_s >= longest:
        text = (
            f"{simulation.step_s} s is too long for the {fastest} servo of {servos[fastest]} rad/s; "
            f"stay below {longest:.3g} s"
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
