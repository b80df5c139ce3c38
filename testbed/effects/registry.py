"""All named effects, in the order in which reports list them."""

from __future__ import annotations

from collections.abc import Mapping

from testbed.effects.actuator_delay import ActuatorDelay
from testbed.effects.actuator_lag import ActuatorLag
from testbed.effects.body_torque import BodyTorque
from testbed.effects.contact import Contact
from testbed.effects.contract import Effect
from testbed.effects.flexible_appendage import FlexibleAppendage
from testbed.effects.gimbal_backlash import GimbalBacklash
from testbed.effects.gimbal_coulomb_friction import GimbalCoulombFriction
from testbed.effects.gimbal_lag import GimbalLag
from testbed.effects.gimbal_misalignment import GimbalMisalignment
from testbed.effects.gimbal_viscous_friction import GimbalViscousFriction
from testbed.effects.gimbal_zero import GimbalZero
from testbed.effects.gyro_bandwidth import GyroBandwidth
from testbed.effects.gyro_bias import GyroBias
from testbed.effects.gyro_drift import GyroDrift
from testbed.effects.gyro_latency import GyroLatency
from testbed.effects.gyro_misalignment import GyroMisalignment
from testbed.effects.gyro_noise import GyroNoise
from testbed.effects.gyro_quantization import GyroQuantization
from testbed.effects.gyro_saturation import GyroSaturation
from testbed.effects.gyro_scale import GyroScale
from testbed.effects.inertia import Inertia
from testbed.effects.inertial_torque import InertialTorque
from testbed.effects.quadratic_drag import QuadraticDrag
from testbed.effects.reading_effect import ReadingEffect
from testbed.effects.rotor_imbalance import RotorImbalance
from testbed.effects.rotor_speed import RotorSpeed
from testbed.effects.rotor_spin_down import RotorSpinDown
from testbed.effects.slosh import Slosh
from testbed.effects.tether import Tether
from testbed.effects.viscous_drag import ViscousDrag

_PREDICTED: tuple[Effect, ...] = (
    Inertia(),
    ViscousDrag(),
    QuadraticDrag(),
    BodyTorque(),
    InertialTorque(),
    Tether(),
    Contact(),
    FlexibleAppendage(),
    Slosh(),
    RotorSpeed(),
    RotorSpinDown(),
    GimbalZero(),
    GimbalMisalignment(),
    GimbalLag(),
    GimbalViscousFriction(),
    GimbalCoulombFriction(),
    GimbalBacklash(),
    ActuatorLag(),
    ActuatorDelay(),
    GyroBias(),
    GyroDrift(),
    GyroScale(),
    GyroMisalignment(),
    GyroLatency(),
    GyroBandwidth(),
    GyroSaturation(),
)

_ON_READINGS: tuple[ReadingEffect, ...] = (GyroNoise(), GyroQuantization(), RotorImbalance())

EFFECTS: Mapping[str, Effect] = {effect.id: effect for effect in _PREDICTED}
"""Those that change what is predicted, by id."""
READING_EFFECTS: Mapping[str, ReadingEffect] = {effect.id: effect for effect in _ON_READINGS}
"""Those that change how the gyro's samples scatter about it, by id."""
