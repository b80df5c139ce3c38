"""What each physical quantity of a scenario or a record may be: as wide as anything that has flown, with room to spare.

Beyond these bounds lie slips of the pen and numbers whose squares overflow or vanish; neither gives a flight. What
flies is between a chip satellite of 4 g and 35 mm (KickSat's Sprite, 2014) and the International Space Station of
420 t, 109 m and 2e8 kg·m², with control moment gyros of 4,760 N·m·s and 258 N·m.
"""

from __future__ import annotations

from math import pi
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field

LONGEST = 3600.0
"""s. Hundreds of times the length of a flight; a longer run is a slip of the pen that would fill the memory."""


def _zero_or(least: float) -> AfterValidator:
    def check(value: float) -> float:
        if 0.0 < value < least:
            raise ValueError(f"is {value:g}, less than anything has ({least:g}); write 0 for none")
        return value

    return AfterValidator(check)


Mass: TypeAlias = Annotated[float, Field(ge=1e-4, le=1e6)]
"""kg; the rotor of a chip satellite would weigh 0.1 g."""
Edge: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e3)]
"""m."""
Radius: TypeAlias = Annotated[float, Field(ge=0, le=1e3)]
"""m."""
Room: TypeAlias = Annotated[float, Field(ge=1e-2, le=1e4)]
"""m; an aircraft's cabin is 2 m wide, and no flight here leaves a hall."""
Place: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4)]
"""m."""
Velocity: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4)]
"""m/s; in orbit 7,800."""
Moment: TypeAlias = Annotated[float, Field(ge=1e-12, le=1e9)]
"""kg·m²; a disc of 0.1 g and 1 mm radius has 5e-11."""
MomentSpread: TypeAlias = Annotated[float, Field(ge=0, le=1e9)]
"""kg·m²."""
Momentum: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e6)]
"""N·m·s."""
Torque: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e6)]
"""N·m."""
TorqueNoise: TypeAlias = Annotated[float, Field(ge=0, le=1e6), _zero_or(1e-15)]
"""N·m; a millionth of the smallest torque."""
Friction: TypeAlias = Annotated[float, Field(ge=0, le=1e3), _zero_or(1e-15)]
"""N·m·s/rad; of a bearing. A CubeSat's wheel has 1e-9, the gimbal of a large gyro 1."""
FrictionTorque: TypeAlias = Annotated[float, Field(ge=0, le=1e3), _zero_or(1e-12)]
"""N·m; of a bearing that is hardly loaded."""
Imbalance: TypeAlias = Annotated[float, Field(ge=0, le=1e3), _zero_or(1e-15)]
"""kg·m; of a rotor. A CubeSat's wheel has 1e-8 to 5e-7."""
SignedTorque: TypeAlias = Annotated[float, Field(ge=-1e6, le=1e6)]
"""N·m."""
Gravity: TypeAlias = Annotated[float, Field(ge=0.01, le=100)]
"""m/s²; small moons have 0.01, Jupiter 25."""
Offset: TypeAlias = Annotated[float, Field(ge=-10, le=10)]
"""m; from a pivot to the centre of mass."""
Drag: TypeAlias = Annotated[float, Field(ge=0, le=1e3), _zero_or(1e-15)]
"""N·m·s/rad; of air and an air bearing's film."""
Dipole: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4)]
"""A·m²; magnetorquers of large satellites reach 1e3."""
MagneticField: TypeAlias = Annotated[float, Field(ge=-1, le=1)]
"""T; the Earth's is 6e-5 at the ground."""
SignedMomentum: TypeAlias = Annotated[float, Field(ge=-1e6, le=1e6)]
"""N·m·s; of a wheel that turns either way."""
Angle: TypeAlias = Annotated[float, Field(ge=-1e3, le=1e3)]
"""rad; gimbals may turn over and over, 160 times here."""
SmallAngle: TypeAlias = Annotated[float, Field(ge=-1, le=1)]
"""rad; of what should be aligned. Beyond 1 rad it is another axis."""
AngleNoise: TypeAlias = Annotated[float, Field(ge=0, le=pi), _zero_or(1e-12)]
"""rad; encoders of 32 bits resolve 1.5e-9."""
BodyRate: TypeAlias = Annotated[float, Field(ge=-1e4, le=1e4)]
"""rad/s; a thousand turns a second bursts any satellite."""
RateLimit: TypeAlias = Annotated[float, Field(ge=1e-6, le=1e4)]
"""rad/s; the Earth turns by 7.3e-5."""
RateSpread: TypeAlias = Annotated[float, Field(ge=0, le=1e3)]
"""rad/s."""
RateNoise: TypeAlias = Annotated[float, Field(ge=0, le=1e3, allow_inf_nan=False), _zero_or(1e-12)]
"""rad/s; the best space gyros, of 6e-5 deg/√h, have 1.7e-8 at a sample a second."""
Drift: TypeAlias = Annotated[float, Field(ge=-10, le=10)]
"""rad/s²; as a bias that grows by a whole gyro range within a second."""
VelocitySpread: TypeAlias = Annotated[float, Field(ge=0, le=1e3)]
"""m/s."""
Acceleration: TypeAlias = Annotated[float, Field(ge=1e-6, le=1e6)]
"""rad/s²."""
ScaleError: TypeAlias = Annotated[float, Field(ge=-0.9, le=9)]
"""A pure number; at -1 the sensor shows nothing."""
ScaleSpread: TypeAlias = Annotated[float, Field(ge=0, le=0.3)]
"""A pure number; beyond, every tenth thousandth draw would pass -1."""
Bandwidth: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e5)]
"""rad/s; the fastest servos of gimbals reach 1e3."""
Corner: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e5)]
"""Hz."""
Gain: TypeAlias = Annotated[float, Field(ge=0, le=1e3)]
"""1/s; faster than any body follows."""
PositiveGain: TypeAlias = Annotated[float, Field(ge=1e-6, le=1e3)]
"""1/s."""
DampingRatio: TypeAlias = Annotated[float, Field(ge=0.01, le=100)]
"""A pure number; servos have 0.4 to 2."""
Weight: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e6)]
"""A pure number; steering laws take 1e-3 to 10."""
Factor: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e3)]
"""A pure number."""
Latency: TypeAlias = Annotated[float, Field(ge=0, le=10)]
"""s; the flights here last as long, and a gyro's latency is milliseconds."""
CorrelationTime: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e9)]
"""s; 30 years are as good as for ever."""
