"""testbed check: is a scenario complete, consistent and physical?"""

from __future__ import annotations

from collections.abc import Sequence

from testbed.assembly.control import flight_clock
from testbed.assembly.engine import engine_of
from testbed.assembly.maneuver import profile_of
from testbed.assembly.platform import PlatformModel, nominal_body, true_platform
from testbed.cli.console import say, warn
from testbed.cli.options import changed_scenario
from testbed.experiment.planning import beyond_envelope, plan_maneuver, starts_of
from testbed.library.scenarios import naming
from testbed.scenario.maneuver import CsvManeuver
from testbed.scenario.scenario import Scenario


def check_scenario(source: str, changes: Sequence[str]) -> None:
    """Read a scenario and compile its platforms, where it can be flown; say what it is for.

    Raises:
        InputError: what is wrong with it, all at once.
    """
    scenario = changed_scenario(source, changes)
    with naming(scenario):
        nominal = nominal_body(scenario)
        if isinstance(scenario, Scenario):
            engine_of(scenario, true_platform(scenario).model, many=True)
            _read_table(scenario)
            if isinstance(nominal, PlatformModel) and not starts_of(scenario):
                plan = plan_maneuver(scenario, nominal)  # of a design, limits are known when it is done
                if words := beyond_envelope(scenario, nominal, plan.maneuver):
                    warn("note", words)
    say(f"{scenario.file.path}: a valid scenario ({scenario.name}). {scenario.description}")


def _read_table(scenario: Scenario) -> None:
    """Read the table of a maneuver that is one, which decides how long is flown."""
    if isinstance(scenario.maneuver, CsvManeuver):
        flight_clock(scenario, profile_of(scenario.maneuver, scenario).duration)
