"""The shipped scenarios as they are flown beside the paper: in MuJoCo throughout, as the pages say."""

from __future__ import annotations

from testbed.assembly.engine import with_engine
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario


def paper_scenario(name: str) -> Scenario:
    """Return a shipped scenario, flown in MuJoCo whatever its own engine.

    Args:
        name: of its file, without the ending.
    """
    return with_engine(read_scenario(shipped_scenario(name)), "mujoco")
