"""One experiment, from scenario to estimates."""

from __future__ import annotations

from collections.abc import Callable

from testbed.assembly.platform import PlatformModel, nominal_platform, true_platform
from testbed.errors import InputError
from testbed.experiment.estimating import estimate_flight
from testbed.experiment.experiment import Estimation, Experiment
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.design import Start
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.scenario.scenario import Scenario


def conduct(scenario: Scenario, seed: int, progress: Callable[[Start], None] = lambda _: None) -> Experiment:
    """Plan the maneuver, fly it, estimate the inertia.

    Args:
        scenario: what to do.
        seed: of all sensor noise.
        progress: told of each start of a design as it ends.

    Raises:
        InputError: the platform cannot be built, or the maneuver cannot be designed or read.
    """
    nominal, truth = nominal_platform(scenario), true_platform(scenario)
    plan = plan_maneuver(scenario, nominal, progress)
    flown = fly_maneuver(scenario, nominal, truth, plan.maneuver, seed)
    return Experiment(
        scenario=scenario,
        seed=seed,
        nominal=nominal,
        truth=truth,
        plan=plan,
        flown=flown,
        estimation=None if flown.divergence else _estimation(scenario, nominal, truth, plan.maneuver, flown.record),
    )


def _estimation(
    scenario: Scenario, nominal: PlatformModel, truth: PlatformModel, maneuver: Maneuver, record: Record
) -> Estimation:
    """Estimate; a flight that gives no estimate, such as one that soon met the wall, is still worth keeping."""
    try:
        return estimate_flight(scenario, nominal, truth, maneuver, record)
    except InputError as error:
        failures = {str(name): str(error) for name in scenario.estimation.estimators}
        return Estimation(by_name={}, failures=failures, bound_std=None)
