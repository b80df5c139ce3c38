"""Design the maneuvers that blind data sets fly: python -m concealing.make_maneuvers [SCENARIO]."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from concealing.guidance import POOL, software_of
from testbed.experiment.planning import plan_maneuver

_COUNT = 12


def main(scenario: Path) -> None:
    """Write one design per seed, each from a single start so that they differ."""
    known = software_of(scenario)
    section = known.scenario.maneuver.model_copy(update={"starts": 1})
    single = known.scenario.model_copy(update={"maneuver": section})
    made = []
    for seed in range(_COUNT):
        maneuver = plan_maneuver(single, known.nominal, seed=seed).maneuver
        points = np.round(maneuver.gimbal_angle.c, 6)
        made.append({"duration_s": maneuver.duration, "gimbal_angle_rad": points.tolist()})
    header = {"command": f"python -m concealing.make_maneuvers {scenario.name}"}
    POOL.write_text(json.dumps({**header, "maneuvers": made}, indent=None) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "scenarios/diagnose.toml"))
