"""What the maneuver designs reach and how long a solve takes, beside the figures of the paper's Table 1.

Run with `python -m benchmarks.design`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.ratios import Ratio
from benchmarks.slsqp import slsqp_ratios
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.cmg.cluster import cluster_momentum, momentum_jacobian
from testbed.cmg.singularity import envelope_fraction, singularity_measure, sphere_directions
from testbed.dynamics.inertia import theta_of
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.maneuver.body_rate_design import body_rate_design
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.design import BodyRateLimits, Design, DesignProblem, GimbalLimits, Search
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.information import Information, maneuver_information
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.penalty import Penalty
from testbed.maneuver.profiles import basic_profile
from testbed.scenario.reader import read_scenario

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "gimbal_d_optimal.toml"
SAMPLE_RATE, PREFILTER, NOISE, DURATION = 16.0, 0.8, 0.025, 5.0
STARTS = 6
CRITERIA: tuple[Criterion, ...] = ("D", "A", "E", "condition")
CLUSTER_TORQUE, CLUSTER_MOMENTUM = np.array([0.040, 0.040, 0.047]), np.array([0.0210, 0.0210, 0.0254])  # eq. (31)


def main() -> None:
    """Print every figure with the bound that it has to keep."""
    platform = nominal_platform(read_scenario(SCENARIO))
    print(
        "figures of Ψ_fᵀΨ_f; cond. is that of Ψ_f, as in Table 1; of the starts' costs (logarithms) the best is flown"
    )
    print_information("basic profile (0.099, 21.27, 0.0036, 3.271)", maneuver_information(basic_profile(), 16.0, 0.8))
    for penalty in (None, Penalty()):
        for criterion in CRITERIA:
            print_body_rate_design(platform, criterion, penalty)
    for criterion in CRITERIA:
        print_gimbal_design(platform, criterion, body_rate=np.inf)
    for criterion in CRITERIA[:2]:
        print_gimbal_design(platform, criterion, body_rate=0.3)


def ratios() -> list[Ratio]:
    """Return the rows of the paper's design against SciPy's SLSQP on the same program."""
    platform = nominal_platform(read_scenario(SCENARIO))
    limits = BodyRateLimits(cluster_torque=CLUSTER_TORQUE, cluster_momentum=CLUSTER_MOMENTUM, body_rate=0.3)
    return slsqp_ratios(problem(platform, "D", 24), limits)


def problem(platform: PlatformModel, criterion: Criterion, control_points: int) -> DesignProblem:
    """Return the paper's experiment: 5 s, 16 Hz, γ = 0.8 s."""
    return DesignProblem(
        name=criterion,
        criterion=criterion,
        duration=DURATION,
        control_points=control_points,
        sample_rate=SAMPLE_RATE,
        prefilter_time_constant=PREFILTER,
        inertia=platform.inertia,
        cluster=platform.cluster,
    )


def print_body_rate_design(platform: PlatformModel, criterion: Criterion, penalty: Penalty | None) -> None:
    """Design within |ω| ≤ 0.3 rad/s (D: det ≥ 1e5; A: trace ≤ 1.0; E: min ≥ 4.5; a solve ≤ 2 s)."""
    limits = BodyRateLimits(cluster_torque=CLUSTER_TORQUE, cluster_momentum=CLUSTER_MOMENTUM, body_rate=0.3)
    search = Search(starts=STARTS, seed=1)
    design = body_rate_design(problem(platform, criterion, 24), limits, search, penalty)
    print_design(f"body rate, {criterion}, {'hard limits' if penalty is None else 'penalty'}", design)


def print_gimbal_design(platform: PlatformModel, criterion: Criterion, body_rate: float) -> None:
    """Design within 0.95 of the gimbal-rate limit (A: trace ≤ 0.45; D: trace ≤ 0.50; a solve ≤ 15 s)."""
    limits = GimbalLimits(
        gimbal_rate=0.95 * 2.0,
        gimbal_torque=0.015,
        cluster_torque=CLUSTER_TORQUE,
        gimbal_acceleration=10.0,
        envelope_fraction=0.95,
        min_singularity_measure=0.3,
        body_rate=body_rate,
    )
    starts = STARTS if criterion in CRITERIA[:2] else 2
    design = gimbal_design(problem(platform, criterion, 16), limits, Search(starts=starts, seed=1))
    print_design(f"gimbal, {criterion}, |ω| ≤ {body_rate} rad/s", design)
    print_use(platform, design.maneuver)
    for known in (True, False):
        bound = bound_of(platform, design.maneuver, start_known=known)
        print(f"    bound, start {'known    ' if known else 'estimated'}: {np.round(1e3 * bound, 3)} e-3 kg m2")


def print_design(title: str, design: Design) -> None:
    """Print figures, costs of all starts and times."""
    print_information(title, design.information)
    costs = ", ".join(f"{start.cost:.3f}" for start in design.starts)
    seconds = [start.seconds for start in design.starts]
    print(f"    costs {costs}; a solve {np.median(seconds):.1f} s, at most {max(seconds):.1f} s")
    print(f"    set-up {design.setup_seconds:.2f} s")


def print_information(title: str, information: Information) -> None:
    """Print one row of Table 1."""
    print(
        f"{title}: min {information.min_eigenvalue:.3g}, trace {information.trace_inverse:.4g}, "
        f"det {information.determinant:.3g}, cond {information.regressor_condition_number:.3f}"
    )


def print_use(platform: PlatformModel, maneuver: Maneuver) -> None:
    """Print how much of each limit a gimbal-space design uses, on a fine grid."""
    reference = maneuver.reference(np.linspace(0.0, maneuver.duration, 4001))
    cluster, angle = platform.cluster, reference.gimbal_angle
    momentum = cluster_momentum(cluster, angle, reference.gimbal_rate)
    jacobian = momentum_jacobian(cluster, angle)
    print(
        f"    gimbal rate {np.abs(reference.gimbal_rate).max():.3f} rad/s, "
        f"body rate {np.abs(reference.body_rate).max():.2f} rad/s, "
        f"envelope {envelope_fraction(cluster, momentum, sphere_directions(2000)).max():.3f}, "
        f"singularity measure {singularity_measure(jacobian, cluster.rotor_momentum).min():.3f}"
    )


def bound_of(platform: PlatformModel, maneuver: Maneuver, *, start_known: bool) -> np.ndarray:
    """Return the Cramér-Rao bound's standard deviations of the motion as designed, shape (6,), kg·m²."""
    gyro_time = np.arange(0.0, DURATION + 1e-9, 1.0 / SAMPLE_RATE)
    actuator_time = np.linspace(0.0, DURATION, 401)
    telemetry = Telemetry(
        gyro_time=gyro_time,
        body_rate=maneuver.reference(gyro_time).body_rate,
        gyro_noise=NOISE,
        actuator_time=actuator_time,
        gimbals=GimbalTelemetry(cluster=platform.cluster, angle=maneuver.reference(actuator_time).gimbal_angle),
        initial_momentum="zero" if start_known else "estimated",
    )
    return np.sqrt(np.diag(cramer_rao_bound(telemetry, theta_of(platform.inertia), np.zeros(3)))[:6])


if __name__ == "__main__":
    main()
