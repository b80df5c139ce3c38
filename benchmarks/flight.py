"""What the simulation costs and how exact it is: speed beside bare MuJoCo, momentum, step, tracking.

Run with `python -m benchmarks.flight`.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.paired import paired, seconds
from benchmarks.ratios import Ratio
from testbed.assembly.platform import nominal_platform, true_plant
from testbed.experiment.flying import Sortie, fly_maneuver, prepare_flight
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.plant.plant import Plant
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.simulation.loop import fly

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
BATCH = 25
PAIRS, BATCH_PAIRS = 15, 5


def main() -> None:
    """Print every figure with the bound that it has to keep."""
    print_speed()
    print_help_time()
    scenario = read_scenario(SCENARIOS / "gimbal_d_optimal.toml")
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    print_tracking(scenario, maneuver)
    print_step(scenario, maneuver)


def ratios() -> list[Ratio]:
    """Return the speed of simulation and control over bare MuJoCo, one flight and many side by side."""
    scenario = read_scenario(SCENARIOS / "zero_g.toml")
    return [speed_ratio(scenario, flights=1), speed_ratio(scenario, flights=BATCH)]


def speed_ratio(scenario: Scenario, *, flights: int) -> Ratio:
    """Time simulation and control of flights side by side against bare mj_step at the same step, in pairs."""
    platform = nominal_platform(scenario)
    sorties = [Sortie(scenario=scenario, truth=platform, seed=scenario.seed + index) for index in range(flights)]
    flight = prepare_flight(scenario, sorties, platform, plan_maneuver(scenario, platform).maneuver)
    steps = flight.clock.ticks * flight.clock.control_steps

    def plant() -> Plant:
        return true_plant([(scenario, platform)] * flights)

    def bare() -> float:
        start, data = plant(), mujoco.MjData(platform.model)
        data.qpos[:], data.qvel[:] = start.qpos[0], start.qvel[0]
        data.ctrl[start.layout.rotor_motor] = 1.0
        return flights * seconds(lambda: mujoco.mj_step(platform.model, data, steps))

    def loop() -> float:
        start = plant()
        return seconds(lambda: fly(start, flight))

    pairs = PAIRS if flights == 1 else BATCH_PAIRS
    times = paired(loop, bare, pairs)
    simulated = flights * flight.clock.ticks * flight.clock.period
    return Ratio(
        what="speed of simulation and control over bare MuJoCo steps, "
        + ("one flight" if flights == 1 else f"{flights} flights side by side, one thread"),
        ours=f"{simulated / times.ours:.0f} simulated s per s",
        theirs=f"mj_step {simulated / times.theirs:.0f} simulated s per s",
        ratio=times.ratio,
        target="at least 0.60",
        command="python -m benchmarks.flight",
        note=f"{steps} steps of {1e3 * flight.clock.step:g} ms a flight, median of {pairs} pairs",
    )


def print_speed() -> None:
    """Print the speeds beside bare MuJoCo."""
    for row in ratios():
        print(f"{row.what}: {row.ratio:.3f}   ({row.target})")


def print_help_time() -> None:
    """Time `testbed --help`."""
    command = [str(Path(sys.executable).with_name("testbed")), "--help"]
    times = [seconds(lambda: subprocess.run(command, check=True, capture_output=True)) for _ in range(5)]
    print(f"testbed --help: {min(times):.2f} s   (below 0.4 s)")


def print_tracking(scenario: Scenario, maneuver: Maneuver) -> None:
    """Fly the gimbal-space design without noise, and with its scenario's over 40 seeds."""
    platform = nominal_platform(scenario)
    quiet = scenario.model_copy(update={"gyro": scenario.gyro.model_copy(update={"noise_rad_s": 0.0})})
    calm = fly_maneuver(quiet, platform, platform, maneuver, 1).summary
    print(
        f"tracking, noise-free: rms {np.array2string(calm.tracking_rms, precision=5)} rad/s (at most 0.003), "
        f"saturated {calm.saturated:g} s, smallest singularity measure {calm.min_singularity_measure:.2f}, "
        f"momentum drift {calm.momentum_drift:.1e} (at most 1e-7)"
    )
    noisy = [fly_maneuver(scenario, platform, platform, maneuver, seed).summary for seed in range(40)]
    saturated = np.array([summary.saturated for summary in noisy])
    rms = np.mean([summary.tracking_rms for summary in noisy], axis=0)
    print(
        f"tracking with the scenario's noise, 40 seeds: rms {np.array2string(rms, precision=5)} rad/s, saturated "
        f"mean {saturated.mean():.4f} s, largest {saturated.max():g} s (at most 0.05)"
    )


def print_step(scenario: Scenario, maneuver: Maneuver) -> None:
    """Fly the same noise with the shipped step and with one ten times smaller."""
    rates = []
    for divisor in (1, 10):
        clock = scenario.simulation.model_copy(update={"step_s": scenario.simulation.step_s / divisor})
        finer = scenario.model_copy(update={"simulation": clock})
        platform = nominal_platform(finer)
        record = fly_maneuver(finer, platform, platform, maneuver, 1).record
        rates.append(record.channels["true_body_rate"])
    error = np.abs(rates[0] - rates[1]).max()
    print(
        f"body rate of the {scenario.simulation.step_s:g} s step against a tenth of it: {error:.1e} rad/s (below 1e-6)"
    )


if __name__ == "__main__":
    main()
