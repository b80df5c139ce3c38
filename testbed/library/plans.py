"""Flying until a verdict is sure: propose, fly, add, diagnose, stop."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Literal

from testbed.errors import InputError
from testbed.formats.plan import PlanFlight, PlanResult
from testbed.library.arguments import AnyPath, GivenScenario, Number, Seed, Switch, Text, Whole, checked, give
from testbed.library.notebook import Shown
from testbed.library.plan_flights import After, Maneuvers, PlanSetup, Progress, planned_in, silent
from testbed.library.records import GivenRecords, Records
from testbed.library.scenarios import require_flyable
from testbed.outputs.folder import reserved_folder
from testbed.outputs.plan_folder import PlanFolder
from testbed.outputs.provenance import Provenance
from testbed.report.frame.blocks import Page
from testbed.report.plan import plan_page, plan_verdict, wish_words
from testbed.scenario.scenario import Scenario
from testbed.sequential.wanted import (
    ANY,
    Wanted,
    effect_wanted,
    inertia_wanted,
    require_component,
)

if TYPE_CHECKING:
    import pandas as pd

GivenEffect = Annotated[Text, give("'any', an effect's id such as 'gimbal_zero', or 'gimbal_zero:cmg3'")]
GivenManeuvers = Annotated[Maneuvers, give("'chosen' or 'own'")]
GivenStd = Annotated[
    Number | Mapping[Text, Number],
    give("a standard deviation in kg·m², such as 1e-5, or some by name, such as {'J11': 1e-5}"),
]
ALPHA = 0.05
"""Probability of a false name. Source: convention, that of the diagnosis's family-wise error."""
MOST_FLIGHTS = 20
"""Source: chosen, the length of the campaigns on which false names are counted (docs/how-to/fly-until-sure.md)."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FlightPlan(Shown):
    """Flights until a verdict is sure.

    Attributes:
        result: what plan.json holds: what is wanted, every flight with its e-values, the outcome, what to fly next.
        records: of all flights, their telemetry alone.
        folder: that keeps them; None of a plan in memory.
        origin: what made it.
    """

    result: PlanResult
    records: Records
    folder: Path | None
    origin: Provenance

    @property
    def outcome(self) -> Literal["named", "class", "inertia", "used_up"] | None:
        """How it ended; None while flights are missing."""
        return self.result.outcome

    @property
    def names(self) -> tuple[str, ...]:
        """What is named, the effect with the most evidence first; none without a name."""
        return tuple(self.result.names)

    @property
    def next_scenario(self) -> Path | None:
        """Scenario of the flight that is to be flown next; None where there is none, or no folder."""
        if self.result.next is None or self.folder is None:
            return None
        return self.folder / self.result.next.scenario

    @property
    def verdict(self) -> str:
        """What it ended with, in a sentence."""
        return plan_verdict(self.result).text

    def __str__(self) -> str:
        """Return what is wanted and the verdict."""
        return f"Flights of {self.result.scenario} for {wish_words(self.result)}. {self.verdict}"

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each flight: record, e-values as natural logarithms, diagnosis."""
        import pandas as pd  # noqa: PLC0415 - an optional extra

        flights = [flight.model_dump() for flight in self.result.flights]
        return pd.DataFrame(flights, columns=list(PlanFlight.model_fields)).set_index("number")

    def _page(self) -> Page:
        return plan_page(self.result, self.origin.listed)


@checked
def plan(
    scenario: GivenScenario,
    records: GivenRecords | None = None,
    *,
    effect: GivenEffect | None = None,
    inertia_std: GivenStd | None = None,
    flights: Whole = MOST_FLIGHTS,
    alpha: Number = ALPHA,
    seed: Seed | None = None,
    maneuvers: GivenManeuvers = "chosen",
    folder: AnyPath | None = None,
    resume: Switch = False,
    progress: Progress = silent,
    after: After = silent,
) -> FlightPlan:
    """Fly until an effect is named for sure, or the inertia is known well enough.

    A scenario with a [truth] is flown in MuJoCo until there is an outcome. Without one, the plan says what to fly next
    and returns; called again with the new record, the same folder and `resume`, it goes on.

    Args:
        scenario: the nominal model, with the maneuver of the first flight.
        records: flights flown already, in their order; with `resume`, those that the folder has are left out.
        effect: whose name is wanted: `any`, an id such as `gimbal_zero`, or `gimbal_zero:cmg3`; any where neither this
            nor an inertia is wanted.
        inertia_std: standard deviation wanted of all inertia parameters, or of some by name, kg·m².
        flights: at most.
        alpha: probability of a name although there is no effect, at whatever flight the plan stops.
        seed: of the noise of simulated flights; the scenario's where None.
        maneuvers: `chosen` by expected gain from the second flight on, or the scenario's `own` in every flight.
        folder: keeps every flight as it comes; in memory only where None.
        resume: whether to go on in the folder.
        progress: called with what is being done.
        after: called with what is known after every flight.

    Raises:
        InputError: scenario, records, wish or folder cannot be used.
        DivergedFlightError: a simulated flight diverged; the flights before it are kept.

    Example:
        >>> import testbed as tb
        >>> scenario = tb.read_scenario("basic", {"truth.inertia_kg_m2": [[0.02, 0, 0], [0, 0.021, 0], [0, 0, 0.026]]})
        >>> tb.plan(scenario, inertia_std=1e-3, maneuvers="own").outcome
        'inertia'
    """
    flown = require_flyable(scenario)
    wanted = wanted_of(flown, effect, inertia_std)
    require_plan(alpha, flights)
    with ExitStack() as stack:
        if folder is None:
            if resume:
                raise InputError("resume goes on with a plan in a folder: give the folder too")
            path = Path(stack.enter_context(TemporaryDirectory()))
        else:
            path = stack.enter_context(reserved_folder(Path(folder), "plan", resume=resume)).path
        setup = PlanSetup(
            scenario=flown,
            wanted=wanted,
            alpha=alpha,
            most_flights=flights,
            seed=flown.seed if seed is None else seed,
            maneuvers=maneuvers,
            folder=PlanFolder(path=path),
            progress=progress,
        )
        found = plan_in(setup, records, "testbed.plan", resume=resume, after=after)
    return found if folder is not None else replace(found, folder=None)


def wanted_of(scenario: Scenario, effect: str | None, inertia_std: float | str | Mapping[str, float] | None) -> Wanted:
    """Return what is wanted; arguments as of `plan`, the standard deviations also as the command line has them.

    Raises:
        InputError: both are, or what is wanted does not exist, at least not on this platform.
    """
    if inertia_std is None:
        wish = effect_wanted(ANY if effect is None else effect)
        require_component(wish, scenario)
        return wish
    if effect is not None:
        raise InputError("an effect's name and an inertia are wanted: plan one after the other, from the same records")
    if isinstance(inertia_std, Mapping):
        return inertia_wanted(",".join(f"{name}={value}" for name, value in inertia_std.items()))
    return inertia_wanted(str(inertia_std))


def require_plan(alpha: float, flights: int) -> None:
    """Refuse an error rate or a number of flights that none can have.

    Raises:
        InputError: which of them it is.
    """
    if not 0.0 < alpha < 1.0:
        raise InputError(f"alpha = {alpha:g}: give a probability above 0 and below 1, such as {ALPHA}")
    if flights < 1:
        raise InputError(f"flights = {flights}: give 1 or more")


def plan_in(
    setup: PlanSetup, records: Records | None, command: str, *, resume: bool = False, after: After = silent
) -> FlightPlan:
    """Go on with a plan in its folder as far as there is something to do; arguments as of `planned_in`.

    Raises:
        InputError: as `plan`.
    """
    planned = planned_in(setup, records, command, resume=resume, after=after)
    return FlightPlan(result=planned.result, records=planned.records, folder=setup.folder.path, origin=planned.origin)
