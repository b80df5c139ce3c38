"""Coverage of estimates from flights that thrusters turn, flown by SciPy: python -m benchmarks.thrusters [SEEDS].

Bodies of 0.05 to 100 kg·m² whose nominal inertia is a tenth off, sampled at 4 to 20 Hz; sixteen jets whose thrusts are
held for half a second, or torques that change smoothly. Each case is flown once and measured with the noise of many
seeds, or flown anew by every seed where the thrusts themselves are uncertain.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from support.thrusters import body_scenario, turned, turned_by_held
from testbed.arrays import Array, Matrix3, Series, Vector3, Vectors3
from testbed.assembly.platform import Body, nominal_body
from testbed.dynamics.inertia import theta_of
from testbed.estimation.combine import CombinedEstimate
from testbed.experiment.combining import combine_estimations
from testbed.experiment.measured import estimate_record
from testbed.identification.identify import uninterrupted_parts
from testbed.records.record import Record, RunDetails
from testbed.scenario.body import BodyScenario

SEEDS = 60
DURATION = 40.0
"""s."""
NOISE = 5e-4
"""rad/s."""
ACCELERATION = 0.15
"""rad/s² that a jet gives."""
HELD_FOR, FIRING = 0.5, 0.3
"""s for which a thrust is held, and share of the jets that fire."""
SPREAD = 0.02
"""Share by which each thrust is off, where it is."""
NORMAL_95 = 1.96
FIRST = np.array([0.05, -0.03, 0.02])
"""rad/s."""
SCENARIO = """
schema = 1
name = "thrusters"
description = "A body that thrusters turn."
seed = 1
[platform]
inertia_kg_m2 = {inertia}
[gyro]
sample_rate_hz = {rate}
noise_rad_s = {noise}
[estimation]
estimators = ["ls", "iv", "iv_momentum", "output_error"]
prefilter_time_constant_s = 0.8
instrument = "iterated"
initial_momentum = "estimated"
[estimation.uncertainty]
gyro_bias_rad_s = 0.0
gyro_scale_factor = 0.0
gyro_misalignment_rad = 0.0
applied_torque_relative = {off}
[diagnosis]
applied_torque = "{torque}"
{jets}
"""


@dataclass(frozen=True, kw_only=True)
class Case:
    """Flights of one body.

    Attributes:
        size: of its moments of inertia, kg·m².
        rate: of gyro and torque, Hz.
        torque: held from sample to sample, or smooth.
        off: share by which each thrust is off at random.
        lost: rows in the middle of the record that are lost.
    """

    size: float
    rate: float
    torque: Literal["held", "smooth"]
    off: float = 0.0
    lost: int = 0

    @property
    def name(self) -> str:
        """What is printed."""
        more = f", thrusts off by {self.off:.0%}" if self.off else ""
        more += f", {self.lost} rows lost" if self.lost else ""
        return f"{self.size:g} kg m2, {self.rate:g} Hz, {self.torque}{more}"


CASES = (
    Case(size=0.05, rate=20.0, torque="held"),
    Case(size=4.0, rate=10.0, torque="held"),
    Case(size=100.0, rate=4.0, torque="held"),
    Case(size=4.0, rate=4.0, torque="smooth"),
    Case(size=4.0, rate=10.0, torque="held", lost=1),
    Case(size=4.0, rate=10.0, torque="smooth", lost=20),
    Case(size=4.0, rate=10.0, torque="held", off=SPREAD),
)


def inertia_of_size(size: float) -> Matrix3:
    """Return an inertia with products, kg·m²."""
    turn = np.linalg.qr(np.eye(3) + 0.15 * np.random.default_rng(3).normal(size=(3, 3)))[0]
    return np.asarray(turn @ np.diag([0.8 * size, size, 1.25 * size]) @ turn.T)


def jets(size: float) -> Array:
    """Return the torque of each of sixteen jets at full thrust, eight and their opposites, shape (16, 3), N·m."""
    half = np.random.default_rng(4).normal(size=(8, 3))
    half *= ACCELERATION * size / np.linalg.norm(half, axis=1, keepdims=True)
    return np.concatenate([half, -half])


def flown(case: Case, time: Series, rng: np.random.Generator) -> tuple[Vectors3, Array]:
    """Return the body rate, rad/s, and what was commanded: the thrust of each jet, or where they are smooth torques.

    Args:
        case: the body and its torques.
        time: of the samples, s.
        rng: of what the thrusts are off by.
    """
    inertia, per_jet = inertia_of_size(case.size), jets(case.size)
    draw = np.random.default_rng(11)
    if case.torque == "smooth":
        waves, phases = draw.uniform(0.2, 1.6, (3, 3)), draw.uniform(0.0, 2.0 * np.pi, (3, 3))

        def torque(at: float) -> Vector3:
            return np.asarray(ACCELERATION * case.size * np.sin(waves * at + phases).sum(axis=1) / 1.5)

        return turned(time, FIRST, inertia, torque), np.array([torque(at) for at in time])
    hold = round(HELD_FOR * case.rate)
    firing = (draw.random((len(time) // hold + 1, len(per_jet))) < FIRING).astype(float)
    thrust = np.repeat(firing, hold, axis=0)[: len(time)]
    given = (thrust * (1.0 + case.off * rng.standard_normal(len(per_jet)))) @ per_jet
    return turned_by_held(time, FIRST, inertia, given), thrust


def scenario_of(case: Case) -> BodyScenario:
    """Return the scenario of a case: a nominal inertia without products, a tenth too large, and the jets."""
    tables = [
        f"[[thrusters]]\nposition_m = {position}\ndirection = {direction}"
        for position, direction in map(_arm_and_direction, jets(case.size))
    ]
    text = SCENARIO.format(
        inertia=(1.1 * np.diag(np.diag(inertia_of_size(case.size)))).tolist(),
        rate=case.rate,
        noise=NOISE,
        off=case.off,
        torque="held" if case.torque == "held" else "sampled",
        jets="\n".join(tables) if case.torque == "held" else "",
    )
    return body_scenario(text, "thrusters.toml")


def _arm_and_direction(torque: Vector3) -> tuple[list[float], list[float]]:
    """Return where a thruster of 1 N sits, m, and which way it pushes, to make a torque, N·m."""
    across = np.cross(torque, np.eye(3)[np.argmin(np.abs(torque))])
    direction = across / np.linalg.norm(across)
    return np.cross(direction, torque).tolist(), direction.tolist()


def records(case: Case, seeds: int) -> Iterator[Record]:
    """Yield what was measured with the noise of each seed."""
    time = np.arange(round(DURATION * case.rate) + 1) / case.rate
    kept = np.ones(len(time), dtype=bool)
    kept[len(time) // 2 : len(time) // 2 + case.lost] = False
    flight = flown(case, time, np.random.default_rng(0))
    for seed in range(seeds):
        rng = np.random.default_rng(1000 + seed)
        body_rate, commanded = flown(case, time, rng) if case.off else flight
        measured = body_rate + NOISE * rng.standard_normal(body_rate.shape)
        commands = "motor_thrust" if case.torque == "held" else "applied_torque"
        yield Record(
            time=time[kept],
            channels={"body_rate": measured[kept], commands: commanded[kept]},
            details=RunDetails(name=f"flight_{seed}", gyro_noise=NOISE, source="measured"),
        )


def main(seeds: int) -> None:
    """Print how often the 95 % intervals hold the truth, and how large the errors are in standard deviations."""
    for case in CASES:
        truth = theta_of(inertia_of_size(case.size))
        errors: dict[str, list[Array]] = {}
        scenario = scenario_of(case)
        nominal = nominal_body(scenario)
        for record in records(case, seeds):
            for name, estimate in combined(scenario, nominal, record).items():
                errors.setdefault(name, []).append((estimate.theta - truth) / estimate.std)
        for name, each in errors.items():
            missed = np.array(each)
            covered, size = (np.abs(missed) < NORMAL_95).mean(), np.sqrt((missed**2).mean())
            print(f"{case.name:45s} {name:12s} in 95 %: {covered:6.1%}, rms error {size:.2f} std", flush=True)


def combined(scenario: BodyScenario, nominal: Body, record: Record) -> Mapping[str, CombinedEstimate]:
    """Return the estimates of a record, of its parts together where it has gaps."""
    parts = uninterrupted_parts(record, scenario, nominal)
    return combine_estimations({part.details.name: estimate_record(scenario, nominal, part) for part in parts}).by_name


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS)
