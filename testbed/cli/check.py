"""testbed check: is a scenario complete, consistent and physical?"""

from __future__ import annotations

from pathlib import Path

from testbed.assembly.platform import nominal_body, true_platform
from testbed.cli.console import say
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.scenario import Scenario


def check_scenario(path: Path) -> None:
    """Read a scenario and compile its platforms, where it can be flown; say what it is for.

    Raises:
        InputError: what is wrong with it, all at once.
    """
    scenario = read_body_scenario(path)
    nominal_body(scenario)
    if isinstance(scenario, Scenario):
        true_platform(scenario)
    say(f"{path}: a valid scenario ({scenario.name}). {scenario.description}")
