"""What is uncertain of actuators and gyro while the inertia is estimated."""

from __future__ import annotations

from dataclasses import astuple, dataclass


@dataclass(frozen=True, kw_only=True)
class Uncertainty:
    """Standard deviations of what is taken for exact; independent of each other, constant over a run, normal.

    Attributes:
        rotor_momentum: of each rotor's momentum, as a share of it.
        applied_torque: of each thruster's torque, or of the torque about each body axis, as a share of it.
        gimbal_zero: of each encoder's zero, rad.
        gimbal_misalignment: of each unit's gimbal axis about its spin axis and about its transverse axis, rad.
        gyro_bias: of each gyro axis, rad/s.
        gyro_scale: of each gyro axis's scale factor, as a share of it.
        gyro_misalignment: of each gyro axis towards each of the two others, rad.
    """

    rotor_momentum: float = 0.0
    applied_torque: float = 0.0
    gimbal_zero: float = 0.0
    gimbal_misalignment: float = 0.0
    gyro_bias: float = 0.0
    gyro_scale: float = 0.0
    gyro_misalignment: float = 0.0

    @property
    def nothing(self) -> bool:
        """Whether all is known exactly."""
        return not any(astuple(self))


EXACT = Uncertainty()
"""Actuators exactly as believed, and a gyro with nothing but white noise."""

USUAL = Uncertainty(
    rotor_momentum=0.002,
    applied_torque=0.02,
    gimbal_zero=0.001,
    gimbal_misalignment=0.001,
    gyro_bias=0.002,
    gyro_scale=0.002,
    gyro_misalignment=0.001,
)
"""Where nothing is stated. Angles: the data sheets of factory-calibrated MEMS units give 0.05 to 0.1 deg from axis to
axis (ADIS16467, ADIS16475), and a machined seat of 50 mm holds a gimbal axis to 0.05 mm. Momentum: a rotor's inertia is
weighed to some 0.2 %, its speed is known far better. Torque: 2 % of a thrust is an assumption, of the order of what a
thrust stand reaches; a calibration of one's own belongs into the scenario. Bias: 0.1 deg/s, what remains of a MEMS
gyro's turn-on bias without a zeroing at rest. Scale: 0.2 %, as angles."""
