"""One experiment, from scenario to estimates."""

from __future__ import annotations

from collections.abc import Callable

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.experiment.aligning import align_flight
from testbed.experiment.experiment import Experiment
from testbed.experiment.flying import Sortie, fly_sorties
from testbed.experiment.planning import Plan, plan_maneuver, require_flyable_by
from testbed.experiment.running_estimators import MeasuredFlight, estimate_flight
from testbed.maneuver.design import Start
from testbed.scenario.scenario import Scenario


def conduct(
    scenario: Scenario,
    seed: int,
    progress: Callable[[Start], None] = lambda _: None,
    *,
    plan: Plan | None = None,
    flown_scenario: Scenario | None = None,
) -> Experiment:
    """Plan the maneuver, fly it, estimate the inertia.

    Args:
        scenario: what to do.
        seed: of all sensor noise.
        progress: called with each start of a design as it ends.
        plan: the maneuver; planned first where absent.
        flown_scenario: with the truth, the start and the gyro that are flown where the controller, the designer and
            the estimators believe otherwise, as in a dispersed run; the scenario's own where absent.

    Raises:
        InputError: the platform cannot be built, or the maneuver cannot be designed or read, or is another platform's.
    """
    drawn = scenario if flown_scenario is None else flown_scenario
    nominal, truth = nominal_platform(scenario), true_platform(drawn)
    if plan is None:
        plan = plan_maneuver(scenario, nominal, progress)
    else:
        require_flyable_by(scenario, nominal, plan.maneuver)
    (flown,) = fly_sorties(scenario, [Sortie(scenario=drawn, truth=truth, seed=seed)], nominal, plan.maneuver)
    estimation, aligning = None, None
    if not flown.divergence and scenario.estimation.alignments:
        aligning = align_flight(drawn, nominal, truth, flown.record)
    if not flown.divergence:
        estimation = estimate_flight(MeasuredFlight(drawn, truth, flown.record), nominal, plan.maneuver)
    return Experiment(
        scenario=drawn,
        seed=seed,
        nominal=nominal,
        truth=truth,
        plan=plan,
        flown=flown,
        estimation=estimation,
        aligning=aligning,
    )
