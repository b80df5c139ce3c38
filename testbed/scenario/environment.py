"""What the platform flies in: free, on an air bearing in a laboratory, or on an orbit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from testbed.dynamics.environment import EARTH, EARTH_RADIUS
from testbed.quantities import Dipole, Drag, Gravity, MagneticField, Offset, SignedTorque
from testbed.rotation.quaternion import tilts
from testbed.scenario.estimation import Estimation
from testbed.scenario.maneuver import ActuatorDesign, ActuatorPoints, GimbalDesign, GimbalPoints, Maneuver
from testbed.scenario.platform import Initial, Platform, Truth
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Three

_NOTHING = (0.0, 0.0, 0.0)
_FASTEST = math.sqrt(EARTH / EARTH_RADIUS**3)
"""rad/s, the mean motion at the ground."""


class Free(Section):
    """Nothing acts on the platform: free fall, or a flight too short for anything to matter."""

    kind: Literal["free"]
    """What the platform flies in: nothing that acts on it."""


class AirBearing(Section):
    """The platform turns on a pivot, an air bearing's ball, in a laboratory; the inertial z axis points up."""

    kind: Literal["air_bearing"]
    """What the platform flies in: a ball joint, gravity and air."""
    gravity_m_s2: Gravity = 9.80665
    """Gravity, along the inertial -z axis."""
    center_of_mass_offset_m: Three[Offset] = _NOTHING
    """Where the centre of mass is believed to be, from the pivot, body axes; it is estimated together with the
    inertia."""
    drag_N_m_s_rad: Drag = 0.0
    """Torque of air and bearing film over the body rate, the same about every axis."""
    tilt_limit_rad: Annotated[float, Field(gt=0, le=math.pi)] | None = None
    """Largest angle between the body z axis and the vertical that the bearing allows; maneuvers beyond it are refused;
    omitted: none."""


class Orbit(Section):
    """The platform is on a circular orbit of the Earth.

    The inertial axes are the local ones at time zero: x forward, y against the orbit's normal, z down.
    """

    kind: Literal["orbit"]
    """What the platform flies in: gravity gradient, magnetic field and constant torques of a circular orbit."""
    altitude_m: Annotated[float, Field(gt=0, le=1e9)] | None = None
    """Height above the ground; or mean_motion_rad_s."""
    mean_motion_rad_s: Annotated[float, Field(gt=0)] | None = None
    """How fast the orbit is flown around; or altitude_m."""
    magnetic_field_T: Three[MagneticField] = _NOTHING
    """The Earth's magnetic field, local axes, which turn with the orbit; constant in them over the flight."""
    magnetic_dipole_A_m2: Three[Dipole] = _NOTHING
    """Magnetic dipole that the platform is believed to have, body axes."""
    torque_N_m: Three[SignedTorque] = _NOTHING
    """Constant torque of air and sunlight, local axes."""

    @model_validator(mode="after")
    def _consistent(self) -> Orbit:
        refuse(self._conflicts())
        return self

    @property
    def rate(self) -> float:
        """Mean motion, rad/s."""
        if self.mean_motion_rad_s is not None:
            return self.mean_motion_rad_s
        assert self.altitude_m is not None
        return math.sqrt(EARTH / (EARTH_RADIUS + self.altitude_m) ** 3)

    def _conflicts(self) -> Iterator[Conflict]:
        if (self.altitude_m is None) == (self.mean_motion_rad_s is None):
            yield Conflict(key="altitude_m", text="and mean_motion_rad_s: state one of them, the other follows")
        elif self.mean_motion_rad_s is not None and self.mean_motion_rad_s >= _FASTEST:
            text = f"{self.mean_motion_rad_s} is an orbit below the ground, where it is {_FASTEST:.6g}; use less"
            yield Conflict(key="mean_motion_rad_s", text=text)


Environment: TypeAlias = Annotated[Free | AirBearing | Orbit, Field(discriminator="kind")]
FREE = Free(kind="free")
_OF_TRUTH = {
    "center_of_mass_offset_m": "air_bearing",
    "drag_N_m_s_rad": "air_bearing",
    "magnetic_dipole_A_m2": "orbit",
    "gravity_gradient_factor": "orbit",
}
"""Keys of [truth] that belong to an environment, and its kind."""


def truth_conflicts(environment: Free | AirBearing | Orbit | None, truth: Truth) -> Iterator[Conflict]:
    """Find what is said of the flown platform in an environment that it does not fly in."""
    if environment is None:
        return
    for key, kind in _OF_TRUTH.items():
        if getattr(truth, key) is not None and environment.kind != kind:
            text = f'is of environment.kind = "{kind}", but it is "{environment.kind}"; change one of them'
            yield Conflict(key=f"truth.{key}", text=text)


def mass_conflicts(environment: Free | AirBearing | Orbit, platform: Platform | None) -> Iterator[Conflict]:
    """Find an air bearing whose platform has no mass, stated or of a model: gravity's torque is in proportion to it."""
    if not isinstance(environment, AirBearing) or platform is None:
        return
    if platform.mass_kg is None and platform.model is None:
        text = "is missing; add it: on an air bearing gravity acts on it"
        yield Conflict(key="platform.mass_kg", text=text)


def start_conflicts(environment: Free | AirBearing | Orbit | None, initial: Initial) -> Iterator[Conflict]:
    """Find a platform that starts away from its pivot, or tilted beyond what the bearing allows."""
    if not isinstance(environment, AirBearing):
        return
    for key in ("position_m", "velocity_m_s"):
        if any(getattr(initial, key)):
            yield Conflict(
                key=f"initial.{key}", text="is of a platform that floats, but it stands on a bearing; omit it"
            )
    limit, tilt = environment.tilt_limit_rad, float(tilts(np.array(initial.attitude_quat_NB)))
    if limit is not None and tilt > limit:
        text = f"is tilted by {tilt:.3g} rad, more than environment.tilt_limit_rad = {limit}; start less tilted"
        yield Conflict(key="initial.attitude_quat_NB", text=text)


def conservation_conflicts(
    environment: Free | AirBearing | Orbit | None, maneuver: Maneuver | None, estimation: Estimation | None
) -> Iterator[Conflict]:
    """Find what takes the total momentum for conserved, on a bearing where gravity changes it."""
    if not isinstance(environment, AirBearing):
        return
    if isinstance(maneuver, GimbalDesign | GimbalPoints | ActuatorDesign | ActuatorPoints):
        text = f'is "{maneuver.parametrization}": its body rate follows from a momentum that gravity changes here'
        yield Conflict(key="maneuver.parametrization", text=f'{text}; use "body_rate"')
    if estimation is not None and estimation.alignments:
        text = (
            "are estimated of platforms whose momentum is conserved, but on an air bearing gravity changes it; omit it"
        )
        yield Conflict(key="estimation.alignments", text=text)
