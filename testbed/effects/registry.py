"""All named effects, in the order in which reports list them."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from importlib.metadata import entry_points

from testbed.effects.actuator_delay import ActuatorDelay
from testbed.effects.actuator_gain import ActuatorGain
from testbed.effects.actuator_lag import ActuatorLag
from testbed.effects.actuator_misaligned import ActuatorMisaligned
from testbed.effects.actuator_rate_limit import ActuatorRateLimit
from testbed.effects.actuator_weak import ActuatorWeak
from testbed.effects.air_drag import AirDrag
from testbed.effects.body_torque import BodyTorque
from testbed.effects.center_of_mass_offset import CenterOfMassOffset
from testbed.effects.checking import require_usable
from testbed.effects.contact import Contact
from testbed.effects.contract import Effect
from testbed.effects.dry_friction import DryFriction
from testbed.effects.flexible_appendage import FlexibleAppendage
from testbed.effects.gimbal_backlash import GimbalBacklash
from testbed.effects.gimbal_coulomb_friction import GimbalCoulombFriction
from testbed.effects.gimbal_lag import GimbalLag
from testbed.effects.gimbal_misalignment import GimbalMisalignment
from testbed.effects.gimbal_viscous_friction import GimbalViscousFriction
from testbed.effects.gimbal_zero import GimbalZero
from testbed.effects.gravity_gradient import GravityGradient
from testbed.effects.gyro_averaging import GyroAveraging
from testbed.effects.gyro_bandwidth import GyroBandwidth
from testbed.effects.gyro_bias import GyroBias
from testbed.effects.gyro_clock_drift import GyroClockDrift
from testbed.effects.gyro_drift import GyroDrift
from testbed.effects.gyro_latency import GyroLatency
from testbed.effects.gyro_misalignment import GyroMisalignment
from testbed.effects.gyro_noise import GyroNoise
from testbed.effects.gyro_noise_color import GyroNoiseColor
from testbed.effects.gyro_quantization import GyroQuantization
from testbed.effects.gyro_rate_random_walk import GyroRateRandomWalk
from testbed.effects.gyro_saturation import GyroSaturation
from testbed.effects.gyro_scale import GyroScale
from testbed.effects.inertia import Inertia
from testbed.effects.inertial_torque import InertialTorque
from testbed.effects.library import kept_effects
from testbed.effects.magnetic_dipole import MagneticDipole
from testbed.effects.noise_effect import NoiseEffect
from testbed.effects.quadratic_drag import QuadraticDrag
from testbed.effects.rotor_acceleration_reaction import RotorAccelerationReaction
from testbed.effects.rotor_imbalance import RotorImbalance
from testbed.effects.rotor_speed import RotorSpeed
from testbed.effects.rotor_spin_down import RotorSpinDown
from testbed.effects.slosh import Slosh
from testbed.effects.telemetry_skew import TelemetrySkew
from testbed.effects.tether import Tether
from testbed.effects.thrust_offset import ThrustOffset
from testbed.effects.viscous_drag import ViscousDrag
from testbed.effects.wheel_coulomb_friction import WheelCoulombFriction
from testbed.effects.wheel_delay import WheelDelay
from testbed.effects.wheel_imbalance import WheelImbalance
from testbed.effects.wheel_inertia import WheelInertia
from testbed.effects.wheel_lag import WheelLag
from testbed.effects.wheel_misalignment import WheelMisalignment
from testbed.effects.wheel_speed_bias import WheelSpeedBias
from testbed.effects.wheel_torque_scale import WheelTorqueScale
from testbed.effects.wheel_viscous_friction import WheelViscousFriction
from testbed.errors import InputError

_PREDICTED: tuple[Effect, ...] = (
    Inertia(),
    ViscousDrag(),
    QuadraticDrag(),
    DryFriction(),
    BodyTorque(),
    InertialTorque(),
    Tether(),
    Contact(),
    FlexibleAppendage(),
    Slosh(),
    CenterOfMassOffset(),
    AirDrag(),
    GravityGradient(),
    MagneticDipole(),
    RotorSpeed(),
    RotorSpinDown(),
    GimbalZero(),
    GimbalMisalignment(),
    GimbalLag(),
    GimbalViscousFriction(),
    GimbalCoulombFriction(),
    GimbalBacklash(),
    WheelInertia(),
    WheelMisalignment(),
    WheelSpeedBias(),
    WheelViscousFriction(),
    WheelCoulombFriction(),
    WheelTorqueScale(),
    WheelLag(),
    WheelDelay(),
    ActuatorLag(),
    ActuatorDelay(),
    ActuatorGain(),
    ActuatorRateLimit(),
    ActuatorWeak(),
    ActuatorMisaligned(),
    ThrustOffset(),
    RotorAccelerationReaction(),
    TelemetrySkew(),
    GyroBias(),
    GyroDrift(),
    GyroScale(),
    GyroMisalignment(),
    GyroLatency(),
    GyroClockDrift(),
    GyroBandwidth(),
    GyroAveraging(),
    GyroSaturation(),
)

_ON_READINGS: tuple[NoiseEffect, ...] = (
    GyroNoise(),
    GyroNoiseColor(),
    GyroQuantization(),
    GyroRateRandomWalk(),
    RotorImbalance(),
    WheelImbalance(),
)

_GROUP = "testbed.effects"
"""Entry points of other packages: each is an effect, or a class of one."""

EFFECTS: dict[str, Effect] = {effect.id: effect for effect in _PREDICTED}
"""Those that change what is predicted, by id."""
NOISE_EFFECTS: Mapping[str, NoiseEffect] = {effect.id: effect for effect in _ON_READINGS}
"""Those that change how the gyro's samples scatter about it, by id."""


def register_effect(effect: Effect) -> Effect:
    """Let every further diagnosis test for an effect; what is registered already is not replaced.

    A package does it for all who install it by an entry point in its pyproject.toml:

        [project.entry-points."testbed.effects"]
        dry_friction = "my_package:DryFriction"

    Args:
        effect: of your own.

    Returns:
        The effect.

    Raises:
        InputError: it is none, its id is taken, or it does not keep the contract; the message says in what.
    """
    if not isinstance(effect, Effect):
        raise InputError(f"{effect!r}: is no effect; derive its class from testbed.Effect")
    if effect.id in EFFECTS or effect.id in NOISE_EFFECTS:
        raise InputError(f"{effect.id}: an effect of this id is registered already; choose another id")
    require_usable(effect)
    EFFECTS[effect.id] = effect
    return effect


def _register_installed() -> None:
    """Register the effects of other packages.

    Raises:
        InputError: one of them cannot be loaded; the message names its package.
    """
    for entry in entry_points(group=_GROUP):
        try:
            found = entry.load()
            register_effect(found() if isinstance(found, type) else found)
        except Exception as error:  # whatever another package does wrong
            raise InputError(f"the effect {entry.name} of {entry.value} cannot be used: {error}") from error


def _require_known_look_alikes() -> None:
    """Refuse installed effects that look like none that there is.

    Raises:
        InputError: names them, and the nearest ids.
    """
    ids = [*EFFECTS, *NOISE_EFFECTS]
    for effect in EFFECTS.values():
        for unknown in [each for each in effect.look_alikes if each not in ids]:
            near = difflib.get_close_matches(unknown, ids, n=3)
            meant = f"; did you mean {' or '.join(near)}?" if near else ""
            raise InputError(
                f"{effect.id}: cannot be used: its look_alikes name {unknown!r}, which is no effect{meant}"
            )


_register_installed()
_require_known_look_alikes()


def _register_kept() -> None:
    """Register the formulas of the user's own library.

    Raises:
        InputError: one of them cannot be used, or its name is taken; the message names its file.
    """
    for path, effect in kept_effects().items():
        try:
            register_effect(effect)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error


_register_kept()
