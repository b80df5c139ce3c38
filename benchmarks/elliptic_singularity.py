"""What steering laws do at the elliptic internal singularity of four gyros: python -m benchmarks.elliptic_singularity.

The platform of scenarios/pyramid4.toml turns up about body x, so that its gyros have to gain momentum along x from
zero. On the way lies the singularity at which two units stand at 90 degrees and two at zero; no null motion leads
around it. Every law flies the same reference without noise and without the gyro's feedback; printed is how far the
platform falls behind.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

import testbed as tb

RATES = (0.2, 0.3, 0.4, 0.5)
"""rad/s, to which the platform turns up about x: the singularity lies at 0.25, the whole envelope at 0.67."""
_DITHERED = {"damping": 0.01, "decay": 10.0, "dither": 0.1, "dither_rate_rad_s": np.pi / 2}
LAWS: dict[str, dict[str, float]] = {
    "moore_penrose": {},
    "singularity_robust": {"damping": 0.01, "decay": 10.0},
    "generalized_singularity_robust": _DITHERED,
    "off_diagonal_singularity_robust": _DITHERED,
}
_DURATION = 20.0
_SHARES = (0.0, 0.0, 0.25, 0.6, 0.9, 1.0, 1.0, 1.0, 1.0, 0.9, 0.6, 0.25, 0.0, 0.0)
"""Control points of the body rate, from rest to rest in 20 s."""


class Crossing(NamedTuple):
    """How a law got through.

    Attributes:
        furthest: largest difference of the body rate from its reference, rad/s.
        rms: of this difference about all axes, rad/s.
        held: largest momentum that the gyros held along x, N·m·s.
        saturated: share of the flight during which a gimbal was at its rate limit.
    """

    furthest: float
    rms: float
    held: float
    saturated: float


def crossed(rate: float, law: str) -> Crossing:
    """Return how a law gets the platform up to a rate, rad/s, and back to rest."""
    run = tb.fly(tb.read_scenario("pyramid4", _changes(rate, law)), seed=1)
    channels = run.record.channels
    behind = channels["true_body_rate"] - channels["reference_body_rate"]
    return Crossing(
        furthest=float(np.abs(behind).max()),
        rms=float(np.sqrt((behind**2).mean())),
        held=float(np.abs(channels["true_cluster_momentum"][:, 0]).max()),
        saturated=float(channels["gimbal_rate_saturated"].any(axis=1).mean()),
    )


def _changes(rate: float, law: str) -> dict[str, Any]:
    """Return the keys of pyramid4.toml that differ."""
    return {
        "maneuver": {
            "kind": "control_points",
            "parametrization": "body_rate",
            "duration_s": _DURATION,
            "body_rate_rad_s": [[rate * share, 0.0, 0.0] for share in _SHARES],
        },
        "simulation.duration_s": _DURATION,
        "gyro.noise_rad_s": 0.0,
        "controller.feedback": False,
        "controller.steering": {"law": law} | LAWS[law],
    }


def main() -> None:
    """Print a row for each rate and law."""
    print("rate, rad/s  law                              furthest  rms     held, N m s  at a rate limit")
    for rate in RATES:
        for law in LAWS:
            found = crossed(rate, law)
            print(
                f"{rate:11.2f}  {law:31s}  {found.furthest:8.4f}  {found.rms:.4f}  {found.held:11.5f}  "
                f"{found.saturated:14.0%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
