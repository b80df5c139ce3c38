"""The next flight as a scenario that can be flown as it stands."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import tomli_w

from testbed.arrays import Array
from testbed.assembly.extension import SCENARIO, Keys
from testbed.files import whole_file
from testbed.next_experiment.flight import NextFlight
from testbed.scenario.body import scenario_keys
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

_DIGITS = 9
"""Of numbers that are written: 1e-9 rad and rad/s, a millionth of what any sensor here resolves."""
_NULL_MOTION = 1.0
"""1/s, where the scenario has none: without it the gimbals leave their path."""


def write_next(scenario: Scenario, flight: NextFlight, purpose: str, folder: Path) -> Path:
    """Write scenario.toml: the nominal platform, released and moved as the flight says; return its path.

    Args:
        scenario: the nominal one.
        flight: to fly.
        purpose: what it is for, in a sentence.
        folder: where; made where it is missing.

    Raises:
        InputError: the flight is none that can be flown.
    """
    keys = _flown(scenario_keys(scenario), flight)
    keys |= {"name": f"{scenario.name}-next", "description": purpose}
    folder.mkdir(parents=True, exist_ok=True)
    if scenario.platform.model is not None:
        keys["platform"]["model"] = Path(shutil.copy(scenario.platform.model, folder)).name
    with whole_file(folder / SCENARIO) as part:
        part.write_text("# Which of the indistinguishable effects is it?\n" + tomli_w.dumps(keys), encoding="utf-8")
    read_scenario(folder / SCENARIO)
    return folder / SCENARIO


def _flown(keys: Keys, flight: NextFlight) -> Keys:
    """Return the keys with the flight's start and maneuver; what each flight of a campaign draws anew is left out."""
    keys.pop("dispersion", None)
    start = {
        "body_rate_rad_s": flight.body_rate,
        "gimbal_angle_rad": flight.initial_gimbal_angle,
        "wheel_momentum_N_m_s": flight.initial_wheel_momentum,
    }
    keys.setdefault("initial", {}).update({key: _rounded(values) for key, values in start.items() if len(values)})
    keys["maneuver"] = {
        "kind": "control_points",
        "parametrization": flight.path,
        "duration_s": flight.duration,
        **{key: [_rounded(point) for point in points] for key, points in _rows(flight) if points.shape[1]},
    }
    controller = keys["controller"]
    steering, along = controller["steering"], flight.path != "body_rate"
    if along and flight.units:
        steering["preferred_gimbal_angle_rad"] = "maneuver"
        steering["null_motion_gain_1_s"] = steering.get("null_motion_gain_1_s") or _NULL_MOTION
    elif not along:  # the actuators follow without null motion, as the flight has it
        steering.pop("preferred_gimbal_angle_rad", None)
        steering["null_motion_gain_1_s"] = 0.0
    if len(flight.initial_wheel_momentum):
        controller.setdefault("wheels", {})["null_motion"] = "maneuver" if along else "none"
    keys["estimation"]["initial_momentum"] = "estimated"
    return keys


def _rows(flight: NextFlight) -> Iterator[tuple[str, Array]]:
    """Yield the keys of the control points, and these."""
    if flight.path == "body_rate":
        yield "body_rate_rad_s", flight.control_points
        return
    yield "gimbal_angle_rad", flight.control_points[:, : flight.units]
    yield "wheel_momentum_N_m_s", flight.control_points[:, flight.units :]


def _rounded(values: Array) -> list[float]:
    return [round(float(value), _DIGITS) + 0.0 for value in values]
