"""One experiment, from scenario to estimates."""

from __future__ import annotations

from collections.abc import Callable

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.experiment.estimating import try_estimate_flight
from testbed.experiment.experiment import Experiment
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.design import Start
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
    estimation = None
    if not flown.divergence:
        estimation = try_estimate_flight(scenario, nominal, truth, plan.maneuver, flown.record)
    return Experiment(
        scenario=scenario,
        seed=seed,
        nominal=nominal,
        truth=truth,
        plan=plan,
        flown=flown,
        estimation=estimation,
    )
