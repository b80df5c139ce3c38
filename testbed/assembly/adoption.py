"""The scenario of a platform that was found in a user's own model.

What a model cannot say is filled in, each number with a comment: it is there to be replaced.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import tomli_w

from testbed.arrays import Array, Units, Vector3
from testbed.cmg.cluster import Cluster
from testbed.cmg.singularity import envelope_radius
from testbed.cmg.wheels import Wheels, momentum_envelope
from testbed.plant.adopted import AdoptedPlatform, FoundGyro, Spinning

_REPLACE = "not in the model: replace it"
_SPEED = 200.0 * math.pi
"""rad/s, 6,000 turns a minute: data sheets of small wheels end at 5,000 to 8,000."""
_SPIN_UP = 10.0
"""s in which a wheel's motor takes it to its momentum limit; data sheets of small wheels have 5 to 20."""
_RATE_LIMIT = 2.0
"""rad/s of a gimbal, as the shipped platform's."""
_GIMBAL_TORQUE = 3.0
"""1/s: torque limit of a gimbal over its rotor's momentum, as the shipped platform's."""
_MARGIN = 1.1
"""Momentum limit of a gyro's rotor over its momentum, as the shipped platform's."""
_BANDWIDTH = 50.0
"""rad/s of gimbal servos, as the shipped platform's."""
_SHARE = 0.3
"""Of momentum and torque about each axis that the maneuver takes, so that all three together stay within them."""
_FASTEST = 0.3
"""rad/s; what needs no faster gyro."""
_TILTING = 0.02
"""rad/s about the axes that tilt a platform on a bearing: a turn to one side takes a sixth of the maneuver."""
_SHORTEST, _LONGEST = 10.0, 120.0
"""s of the maneuver."""
_STEEPEST = 12.0
"""Largest slope of the maneuver's spline, in peak rates over its duration: 2 between points that are a sixth apart."""
_FOLLOWED = 1.0
"""Bandwidth of the fastest wheel drive times the step: a fourth-order step then follows it to 1 % (1/120)."""
_HALVINGS = 9
"""Of the step at the most: it then follows 1e5 rad/s, the fastest drive that a scenario takes."""
_LEAST = 1e-9
"""N·m·s and N·m, the least that [limits] take; about a direction without any, which is refused, with its name."""
_ROUNDED = 1e-12
"""Share by which numbers are rounded to be read."""
_NONE = 1e-16
"""What is less is the rounding of a zero, in whichever unit."""
_SHAPE = (
    (0.0, 0.0, 0.0),
    (0.8, 0.35, 0.75),
    (-0.4, 0.95, -0.9),
    (1.0, -0.65, 1.0),
    (-0.95, -0.8, -0.6),
    (0.35, 1.0, 0.8),
    (0.8, -0.95, -1.0),
    (-0.8, 0.4, 0.7),
    (0.0, 0.0, 0.0),
)
"""Control points of the body rate in shares of its peak: turns about all axes that are not in step."""


def scenario_text(adopted: AdoptedPlatform, name: str) -> str:
    """Return the text of a scenario.

    Args:
        adopted: what was found.
        name: of the scenario.
    """
    return "\n\n".join(_sections(adopted, name)) + "\n"


def scenario_name(stem: str) -> str:
    """Return the name of a scenario after a file's, which may have any characters."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", stem)[:100] or "adopted"


def _sections(adopted: AdoptedPlatform, name: str) -> Iterator[str]:
    file = adopted.own.path.name
    counts = {"reaction wheel": len(adopted.wheels), "control moment gyro": len(adopted.gyros)}
    parts = [f"{count} {what}{'s' if count > 1 else ''}" for what, count in counts.items() if count]
    yield "\n".join(
        [
            f"# How well does the platform of {_plain(file)} learn its own inertia?",
            _line("schema", 1),
            _line("name", name),
            _line("description", f"Adopted from {_plain(file)}: {' and '.join(parts)}."),
            _line("seed", 1),
        ]
    )
    yield _section(
        "[platform] # J about the centre of mass, everything locked as drawn",
        _line("inertia_kg_m2", adopted.inertia.tolist()),
        _line("mass_kg", adopted.mass),
        _line("edge_m", _rounded(math.sqrt(2.0 * np.trace(adopted.inertia) / adopted.mass)), "of a cube like it"),
    )
    if adopted.bearing is not None:
        yield _section(
            "[environment] # the ball joint",
            _line("kind", "air_bearing"),
            _line("gravity_m_s2", adopted.bearing.gravity),
            _line("center_of_mass_offset_m", adopted.bearing.offset_B.tolist(), "from the pivot, as drawn"),
            _line("drag_N_m_s_rad", adopted.bearing.drag),
        )
    yield from (_wheel(wheel) for wheel in adopted.wheels)
    yield from _gyros(adopted.gyros)
    momentum, torque = _limits(adopted)
    yield _section(
        "[limits] # what all actuators together give about each axis",
        _line("cluster_torque_N_m", [_rounded(each) for each in torque]),
        _line("cluster_momentum_N_m_s", [_rounded(each) for each in momentum]),
    )
    yield from _start(adopted)
    yield from _flight(adopted, momentum, torque)


def _start(adopted: AdoptedPlatform) -> Iterator[str]:
    lines = []
    if any(wheel.speed for wheel in adopted.wheels):
        held = [wheel.spin_inertia * wheel.speed for wheel in adopted.wheels]
        lines.append(_line("wheel_momentum_N_m_s", held, "as in the model's first keyframe"))
    if adopted.bearing is not None:
        lines.append(_line("attitude_quat_NB", adopted.bearing.attitude.tolist(), "as drawn"))
    if lines:
        yield _section("[initial]", *lines)


def _wheel(wheel: Spinning) -> str:
    momentum, torque = _wheel_limits(wheel)
    lines = [
        _line("kind", "reaction_wheel"),
        _line("axis", wheel.axis_B.tolist()),
        _line("position_m", wheel.position_B.tolist(), "from the centre of mass"),
        _line("mass_kg", wheel.mass),
        _line("spin_inertia_kg_m2", wheel.spin_inertia),
        _line("transverse_inertia_kg_m2", _transverse(wheel)),
        _line("momentum_limit_N_m_s", momentum, _stated(wheel.speed_limit, "6,000 turns a minute")),
        _line("torque_limit_N_m", torque, _stated(wheel.torque_limit, "its momentum limit in 10 s")),
        _line("viscous_friction_N_m_s_rad", wheel.viscous_friction),
        _line("coulomb_friction_N_m", wheel.dry_friction),
    ]
    if _bandwidth(wheel) > 0.0:
        lines.append(_line("speed_loop_bandwidth_rad_s", _bandwidth(wheel)))
    return _section(f"[[actuators]] # {_plain(wheel.name)}", *lines)


def _gyros(gyros: Sequence[FoundGyro]) -> Iterator[str]:
    rates = [gyro.rate_limit for gyro in gyros if gyro.rate_limit is not None]
    torques = [gyro.torque_limit for gyro in gyros if gyro.torque_limit is not None]
    for gyro in gyros:
        momentum, rotor = _rotor_momentum(gyro), gyro.rotor
        largest = max(_rotor_momentum(each) for each in gyros)
        stated = rotor.speed or rotor.speed_limit
        yield _section(
            f"[[actuators]] # gimbal {_plain(gyro.name)}, rotor {_plain(rotor.name)}",
            _line("kind", "cmg"),
            _line("gimbal_axis", gyro.axis_B.tolist()),
            _line("spin_axis", rotor.axis_B.tolist(), "at gimbal angle zero, as drawn"),
            _line("position_m", rotor.position_B.tolist(), "from the centre of mass"),
            _line("rotor_momentum_N_m_s", momentum, _stated(stated, "6,000 turns a minute")),
            _line("rotor_momentum_limit_N_m_s", _MARGIN * momentum, _REPLACE),
            _line("rotor_spin_inertia_kg_m2", rotor.spin_inertia),
            _line("rotor_transverse_inertia_kg_m2", _transverse(rotor)),
            _line("rotor_mass_kg", rotor.mass),
            _line("gimbal_inertia_kg_m2", gyro.inertia),
            _line("gimbal_mass_kg", gyro.mass),
            _line("gimbal_rate_limit_rad_s", min(rates, default=_RATE_LIMIT), _stated(rates)),
            _line("gimbal_torque_limit_N_m", min(torques, default=_GIMBAL_TORQUE * largest), _stated(torques)),
            _line("gimbal_servo_bandwidth_rad_s", _BANDWIDTH, _REPLACE),
            _line("rotors", "constant_speed" if any(each.rotor.is_driven for each in gyros) else "free"),
        )


def _flight(adopted: AdoptedPlatform, momentum: Vector3, torque: Vector3) -> Iterator[str]:
    """Yield what decides a flight: nothing of it stands in a model."""
    rate, duration = _maneuver(adopted, momentum, torque)
    gyroscopic = bool(adopted.gyros)
    sampled = 16.0 if gyroscopic else 10.0
    yield _section(
        f"[gyro] # {_REPLACE}",
        _line("sample_rate_hz", sampled),
        _line("noise_rad_s", 0.0004, "of a small MEMS gyro at 10 Hz"),
    )
    points = "\n".join(f"  {_value([_rounded(each, 4) for each in row])}," for row in np.array(_SHAPE) * rate)
    yield _section(
        "[maneuver] # turns about all axes, each within a third of its limits",
        _line("kind", "control_points"),
        _line("parametrization", "body_rate"),
        _line("duration_s", duration),
        f"body_rate_rad_s = [\n{points}\n]",
    )
    yield _section(
        "[simulation]",
        _step(adopted),
        _line("duration_s", duration),
        _line("control_rate_hz", 80.0 if gyroscopic else 10.0),
        _line("telemetry_rate_hz", sampled),
    )
    yield _section("[controller]", _line("feedback", value=True))
    law = [_line("law", "singularity_robust"), _line("damping", 0.01), _line("decay", 10.0)]
    yield _section("[controller.steering]", *(law if gyroscopic else [_line("law", "moore_penrose")]))
    yield _section(
        "[estimation]",
        _line("estimators", ["ls", "iv", "iv_momentum", "output_error"]),
        _line("prefilter_time_constant_s", 0.8 if gyroscopic else 2.0),
        _line("instrument", "iterated"),
        _line("initial_momentum", "estimated"),
    )


def _step(adopted: AdoptedPlatform) -> str:
    """Return the line of the step: halved, it goes on dividing the control period."""
    usual = 0.00125 if adopted.gyros else 0.005
    fastest = max(map(_bandwidth, adopted.wheels), default=0.0)
    steps = usual * 0.5 ** np.arange(_HALVINGS + 1)
    step = next((float(each) for each in steps if each * fastest <= _FOLLOWED), float(steps[-1]))
    return _line("step_s", step, "" if step == usual else f"for the wheel drive of {_rounded(fastest, 4):g} rad/s")


def _maneuver(adopted: AdoptedPlatform, momentum: Vector3, torque: Vector3) -> tuple[Vector3, float]:
    """Return the peak rate about each axis, rad/s, and the duration, s."""
    moments = np.diag(adopted.inertia)
    rate = np.minimum(_SHARE * momentum / moments, _FASTEST)
    if adopted.bearing is not None:
        rate[:2] = np.minimum(rate[:2], _TILTING)
    needed = float((_STEEPEST * moments * rate / (_SHARE * torque)).max())
    duration = float(math.ceil(np.clip(needed, _SHORTEST, _LONGEST)))
    return np.asarray(rate * min(1.0, duration / needed)), duration


def _limits(adopted: AdoptedPlatform) -> tuple[Vector3, Vector3]:
    """Return the momentum, N·m·s, and the torque, N·m, of all actuators about each axis, shape (3,) each.

    A gyro gives a torque of its momentum times its gimbal's rate; 2/π of it in the mean over the gimbal's angles.
    """
    directions = np.eye(3)
    cluster, rate = _cluster(adopted.gyros), [gyro.rate_limit or _RATE_LIMIT for gyro in adopted.gyros]
    of_gyros = envelope_radius(cluster, directions)
    limits = np.array([_wheel_limits(wheel) for wheel in adopted.wheels]).reshape(-1, 2)
    by_momentum, by_torque = (_wheels(adopted.wheels, limits[:, column]) for column in (0, 1))
    momentum = of_gyros + momentum_envelope(by_momentum, directions)
    torque = 2.0 / math.pi * min(rate, default=0.0) * of_gyros + momentum_envelope(by_torque, directions)
    return np.maximum(momentum, _LEAST), np.maximum(torque, _LEAST)


def _cluster(gyros: Sequence[FoundGyro]) -> Cluster:
    none = np.zeros(len(gyros))
    return Cluster(
        gimbal_axis_B=np.array([gyro.axis_B for gyro in gyros]).reshape(-1, 3),
        spin_axis_B=np.array([gyro.rotor.axis_B for gyro in gyros]).reshape(-1, 3),
        rotor_momentum=np.array([_rotor_momentum(gyro) for gyro in gyros]),
        rotor_spin_inertia=none,
        rotor_transverse_inertia=none,
        gimbal_inertia=none,
    )


def _wheels(wheels: Sequence[Spinning], limit: Units) -> Wheels:
    axis_B = np.array([wheel.axis_B for wheel in wheels]).reshape(-1, 3)
    return Wheels(axis_B=axis_B, spin_inertia=limit, momentum_limit=limit, torque_limit=limit)


def _bandwidth(wheel: Spinning) -> float:
    """Return the bandwidth of the loop about a wheel's speed, rad/s; 0 without one."""
    return max(wheel.loop_gain / wheel.spin_inertia, 0.0)


def _wheel_limits(wheel: Spinning) -> tuple[float, float]:
    momentum = wheel.spin_inertia * (wheel.speed_limit or max(_SPEED, abs(wheel.speed)))
    return momentum, wheel.torque_limit or momentum / _SPIN_UP


def _rotor_momentum(gyro: FoundGyro) -> float:
    rotor = gyro.rotor
    return rotor.spin_inertia * (rotor.speed or rotor.speed_limit or _SPEED)


def _transverse(rotor: Spinning) -> float:
    """Return the transverse inertia; of a thin disc it is half of the other, and rounded no less than that."""
    return max(rotor.transverse_inertia, 0.5 * rotor.spin_inertia * (1.0 + 10.0 * _ROUNDED))


def _stated(value: object, otherwise: str = "") -> str:
    """Return the comment of a number that a model may state."""
    return "" if value else f"{_REPLACE}{f'; {otherwise}' if otherwise else ''}"


def _section(heading: str, *lines: str) -> str:
    return "\n".join([heading, *lines])


def _line(key: str, value: Any, comment: str = "") -> str:  # noqa: ANN401 - of any type that a key may have
    return f"{key} = {_value(value)}" + (f" # {comment}" if comment else "")


def _value(value: Any) -> str:  # noqa: ANN401 - likewise
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        value = float(f"{value:.12g}") if abs(value) > _NONE else 0.0
    return tomli_w.dumps({"value": value}).removeprefix("value = ").strip()


def _plain(text: str) -> str:
    """Return a text that fits into one line of a comment."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def _rounded(value: float | Array, digits: int = 3) -> float:
    return float(f"{float(value):.{digits}g}")
