"""The flight software: the testbed's own controller on its nominal model. Nothing here knows what is true.

Its controller, splines, cluster and scenario reader are the testbed's; the craft that it flies is not.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from concealing.craft import Array, PlatformNumbers
from concealing.flight import Clock, Order
from concealing.sensors import SensorNumbers
from testbed.assembly.control import flight_controller
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.cmg.cluster import platform_momentum
from testbed.control.controller import Controller, ControllerState, Seen, Target, command, controller_at_rest
from testbed.maneuver.gimbal_maneuver import gimbal_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.splines import clamped_spline
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.simulation import flight as software

POOL = Path(__file__).with_name("maneuvers.json")


@dataclass(frozen=True, kw_only=True)
class Software:
    """A scenario's nominal numbers and what flies on them.

    Attributes:
        scenario: as read.
        nominal: compiled platform.
    """

    scenario: Scenario
    nominal: PlatformModel

    @property
    def platform(self) -> PlatformNumbers:
        """Plain numbers for an engine that shares no equations."""
        cluster = self.scenario.cluster
        return PlatformNumbers(
            inertia=self.nominal.inertia,
            mass=self.scenario.platform.mass_kg,
            units=cluster.units,
            skew_deg=cluster.skew_deg,
            mounting_radius=cluster.mounting_radius_m,
            rotor_momentum=cluster.rotor_momentum_N_m_s,
            spin_inertia=cluster.rotor_spin_inertia_kg_m2,
            transverse_inertia=cluster.rotor_transverse_inertia_kg_m2,
            gimbal_inertia=cluster.gimbal_inertia_kg_m2,
            torque_limit=cluster.gimbal_torque_limit_N_m,
            servo_bandwidth=cluster.gimbal_servo_bandwidth_rad_s,
        )

    @property
    def sensors(self) -> SensorNumbers:
        """Nominal noise."""
        scenario = self.scenario
        return SensorNumbers(
            gyro_noise=scenario.gyro.noise_rad_s,
            encoder_noise=scenario.encoder.noise_rad,
            encoder_step=scenario.encoder.quantization_rad,
            tachometer_noise=scenario.tachometer.noise_rad_s,
            torque_noise=scenario.torque_sensor.noise_N_m,
        )

    def controller(self, control_rate: float, gyro_rate: float, *, feedback: bool) -> Controller:
        """Return the controller for other clocks than the scenario's, with or without the gyro's feedback."""
        scenario = self.scenario
        changed = scenario.model_copy(
            update={
                "gyro": scenario.gyro.model_copy(update={"sample_rate_hz": gyro_rate}),
                "simulation": scenario.simulation.model_copy(update={"control_rate_hz": control_rate}),
                "controller": scenario.controller.model_copy(update={"feedback": feedback}),
            }
        )
        return flight_controller(changed, self.nominal)


@lru_cache(maxsize=4)
def software_of(scenario: Path) -> Software:
    """Read a scenario once."""
    read = read_scenario(scenario)
    return Software(scenario=read, nominal=nominal_platform(read))


@lru_cache(maxsize=1)
def pool() -> tuple[tuple[float, Array], ...]:
    """Return the designed maneuvers: duration, s, and control points of the gimbal angles, (n, 6), rad."""
    made = json.loads(POOL.read_text(encoding="utf-8"))["maneuvers"]
    return tuple((entry["duration_s"], np.array(entry["gimbal_angle_rad"])) for entry in made)


@lru_cache(maxsize=64)
def planned_maneuver(scenario: Path, index: int, spin: tuple[float, float, float]) -> Maneuver:
    """Return one of the pool as it would be flown from a planned release spin, rad/s."""
    known = software_of(scenario).nominal
    duration, points = pool()[index]
    return gimbal_maneuver(
        f"pool {index}",
        clamped_spline(duration, points),
        inertia=known.inertia,
        cluster=known.cluster,
        total_momentum_B=platform_momentum(known.cluster, known.inertia, np.array(spin), points[0], np.zeros(6)),
    )


class OnBoard:
    """The controller of several runs side by side, each on its own maneuver."""

    def __init__(self, controller: Controller, maneuvers: Sequence[Maneuver], clock: Clock) -> None:
        """Sample the maneuvers.

        Args:
            controller: model and gains.
            maneuvers: one per run.
            clock: of the flight.
        """
        self._controller, self._clock = controller, clock
        sampled = [_targets(maneuver, controller, clock) for maneuver in maneuvers]
        self._tick_rate = np.stack([targets.tick_rate for targets in sampled], axis=1)
        self._targets = [
            Target(*map(np.stack, zip(*targets, strict=True)))
            for targets in zip(*(each.by_tick for each in sampled), strict=True)
        ]
        self._state: ControllerState = controller_at_rest(
            np.stack([each.tick_gimbal_angle[0] for each in sampled]), np.zeros((len(sampled), 0))
        )
        self._rate_error = np.zeros((len(maneuvers), 3))

    def order(self, tick: int, encoder: Array, gyro: Array | None) -> Order:
        """See `flight.Guidance`."""
        if gyro is not None:
            self._rate_error = self._tick_rate[tick] - gyro
        target = self._targets[min(tick, len(self._targets) - 1)]
        seen = Seen(encoder, self._state.commanded_momentum)  # without wheels
        self._state, asked = command(
            self._controller, self._state, target, self._rate_error, seen, tick * self._clock.period
        )
        return Order(asked.torque, asked.gimbal_rate)


def _targets(maneuver: Maneuver, controller: Controller, clock: Clock) -> software.Targets:
    return software.targets_of(
        maneuver,
        software.Clock(step=clock.period, control_steps=1, telemetry_ticks=1, ticks=clock.ticks),
        controller,
        preferred_gimbal_angle=None,
        initial_momentum_B=np.zeros(3),  # used for maneuvers without gimbal angles only
    )


class NoGuidance:
    """Nobody on board: a platform whose torque was planned beforehand."""

    def order(self, tick: int, encoder: Array, gyro: Array | None) -> Order:  # noqa: ARG002 - the role's signature
        """See `flight.Guidance`."""
        return Order(np.zeros_like(encoder), np.zeros_like(encoder))
