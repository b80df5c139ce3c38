"""The paper's first piece of future work: a longer maneuver, of an orbiting satellite."""

from __future__ import annotations

from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.reproduction.scenarios import paper_scenario

SCENARIO = "orbit"


def orbit(seed: int) -> Experiment:
    """Design, fly and estimate the maneuver of scenarios/orbit.toml once.

    Args:
        seed: of all sensor noise.
    """
    return conduct(paper_scenario(SCENARIO), seed)
