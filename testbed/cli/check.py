"""testbed check: is a scenario complete, consistent and physical?"""

from __future__ import annotations

from pathlib import Path

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.cli.console import say
from testbed.scenario.reader import read_scenario


def check_scenario(path: Path) -> None:
    """Read a scenario and compile its platforms; say what it would fly.

    Raises:
        InputError: what is wrong with it, all at once.
    """
    scenario = read_scenario(path)
    nominal_platform(scenario)
    true_platform(scenario)
    say(f"{path}: a valid scenario ({scenario.name}). {scenario.description}")
