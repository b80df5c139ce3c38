"""The loop of a plan: propose, fly, add, diagnose, until there is an outcome or a flight is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import log
from typing import Literal, NamedTuple

import numpy as np

from testbed.assembly.extension import SCENARIO
from testbed.assembly.platform import PlatformModel, nominal_platform, true_platform
from testbed.diagnosis.copies import Flights
from testbed.diagnosis.data import joined
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import DivergedFlightError, InputError
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.formats.parts import Provenance as FileProvenance
from testbed.formats.plan import PlanFlight, PlannedFlight, PlanResult, Wish
from testbed.identification.identify import identify
from testbed.library.diagnoses import diagnose
from testbed.library.records import Records
from testbed.library.scenarios import naming
from testbed.maneuver.maneuver import Maneuver
from testbed.next_experiment.flight import NextFlight
from testbed.outputs.plan_folder import PlanFolder, new_records, source_of
from testbed.outputs.provenance import Provenance, provenance
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.report.plan import wish_words
from testbed.report.verdict import leading_estimator
from testbed.scenario.platform import Truth
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.sequential.choosing import chosen_flight, flights_to_choose_among, most_gained
from testbed.sequential.evidence import Evidence, candidates_of, evidence_of
from testbed.sequential.expected_gain import EffectGoal, class_goal, goal_of
from testbed.sequential.forecasts import Forecasts
from testbed.sequential.refining import refinement_of
from testbed.sequential.robust import robust_space
from testbed.sequential.wanted import (
    ANY,
    EffectWanted,
    InertiaWanted,
    Named,
    Wanted,
    verified,
)

Progress = Callable[[str], None]
After = Callable[[PlanResult], None]
Maneuvers = Literal["chosen", "own"]
SCHEMA = 1
_VISIBLE = 1.0
"""σ²: members of a class that no flight brings farther apart by more count as inseparable, as in
`next_experiment.search.VISIBLE`."""
_VERIFIABLE = 2
"""Flights with which a diagnosis begins to give names: one to fit and one to verify on."""


def silent(_: object) -> None:
    """Report nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanSetup:
    """What decides a plan.

    Attributes:
        scenario: as it was read, with the truth where it has one.
        wanted: what the flights are for.
        alpha: probability of a false name.
        most_flights: at which it ends in any case.
        seed: of simulated flights.
        maneuvers: chosen, or the scenario's own.
        folder: that keeps the flights.
        progress: called with what is being done.
    """

    scenario: Scenario
    wanted: Wanted
    alpha: float
    most_flights: int
    seed: int
    maneuvers: Maneuvers
    folder: PlanFolder
    progress: Progress

    @property
    def simulated(self) -> bool:
        """Whether the scenario says what flies: a [truth], be it empty."""
        return "truth" in self.scenario.model_fields_set

    @cached_property
    def believed(self) -> Scenario:
        """The scenario without its truth: all that estimates, diagnoses and proposals see."""
        estimation = self.scenario.estimation.model_copy(update={"initial_momentum": "estimated"})
        believed = self.scenario.model_copy(update={"truth": Truth(), "estimation": estimation})
        believed.model_fields_set.discard("truth")
        return believed

    @cached_property
    def nominal(self) -> PlatformModel:
        """The platform as believed."""
        with naming(self.scenario):
            return nominal_platform(self.believed)

    @cached_property
    def own(self) -> Maneuver:
        """The scenario's own maneuver."""
        self.progress("the scenario's own maneuver")
        with naming(self.scenario):
            return plan_maneuver(self.believed, self.nominal).maneuver

    @cached_property
    def forecasts(self) -> Forecasts:
        """What flights within the limits would show, whatever the inertia and whichever unit fails."""
        return Forecasts(space=robust_space(self.believed))

    @cached_property
    def candidates(self) -> list[NextFlight]:
        """Flights to choose among."""
        self.progress("flights within the limits")
        return flights_to_choose_among(self.forecasts.space, self.own)

    def origin(self, command: str) -> Provenance:
        """Return what makes the plan; plan.json has the hash of each record's file beside its flight."""
        deciding = {
            "seed": str(self.seed),
            "wanted": self.wanted.text,
            "alpha": str(self.alpha),
            "most_flights": str(self.most_flights),
            "maneuvers": self.maneuvers,
        }
        return provenance(self.scenario, self.scenario.file, command, deciding=deciding)


class Planned(NamedTuple):
    """How far a plan has come.

    Attributes:
        result: what plan.json holds.
        records: of all flights, their telemetry alone.
        origin: what made it.
    """

    result: PlanResult
    records: Records
    origin: Provenance


def planned_in(
    setup: PlanSetup, records: Records | None, command: str, *, resume: bool = False, after: After = silent
) -> Planned:
    """Go on with a plan in its folder as far as there is something to do.

    Args:
        setup: what decides it.
        records: flown already; those that the folder has are left out.
        command: that was given.
        resume: whether the folder holds the plan's beginning.
        after: called with what is known after every flight.

    Raises:
        InputError: as `plan`.
    """
    origin = setup.origin(command)
    state, known = setup.folder.kept() if resume else (_begun(setup, origin), [])
    if resume:
        _require_same(setup, state)
        state = state.model_copy(update={"most_flights": setup.most_flights})
        if state.outcome in (None, "used_up"):
            used_up = len(state.flights) >= setup.most_flights
            state = state.model_copy(update={"outcome": "used_up", "next": None} if used_up else {"outcome": None})
    given = () if records is None else new_records(state, records.runs)
    flights = Flights()
    for record in (*known, *given):
        flights.add(record)
    try:
        for further, records_so_far in _flights(setup, state, known, given):
            state, known = further, records_so_far
            setup.folder.keep(state, setup.scenario, known)
            after(state)
    except KeyboardInterrupt:
        if state.flights:
            setup.folder.finish(state, origin)
        raise
    setup.folder.finish(state, origin)
    return Planned(result=state, records=Records(tuple(known)), origin=origin)


def _begun(setup: PlanSetup, origin: Provenance) -> PlanResult:
    wanted = setup.wanted
    return PlanResult(
        schema_version=SCHEMA,
        scenario=setup.scenario.name,
        wanted=Wish(
            effect=wanted.text if isinstance(wanted, EffectWanted) else None,
            inertia_std_kg_m2=dict(wanted.std) if isinstance(wanted, InertiaWanted) else None,
        ),
        alpha=setup.alpha,
        hypotheses=None,
        most_flights=setup.most_flights,
        seed=setup.seed,
        simulated=setup.simulated,
        maneuvers=setup.maneuvers,
        outcome=None,
        names=[],
        flights=[],
        next=None,
        notices=[],
        provenance=FileProvenance.model_validate(origin.reproducible),
    )


def _require_same(setup: PlanSetup, state: PlanResult) -> None:
    """Refuse to go on with another plan than was begun: its error rate would be that of neither.

    Raises:
        InputError: what differs is named.
    """
    now = _begun(setup, setup.origin(""))
    for key in ("wanted", "alpha", "seed", "maneuvers"):
        if getattr(now, key) != getattr(state, key):
            raise InputError(
                f"{setup.folder.path}: was begun with another {key} ({_said(getattr(state, key))}): repeat the command "
                "as it was, or begin in a new folder"
            )
    if state.provenance.scenario_sha256 != setup.scenario.file.stamp.sha256:
        raise InputError(
            f"{setup.folder.path}: was begun with another scenario, or other --set; its own is {SCENARIO} in that "
            "folder: give that, or begin in a new folder"
        )


def _said(value: object) -> str:
    if isinstance(value, Wish):
        return value.effect or f"inertia {value.inertia_std_kg_m2}"
    return str(value)


def _flights(
    setup: PlanSetup, state: PlanResult, known: list[Record], given: Sequence[Record]
) -> Iterator[tuple[PlanResult, list[Record]]]:
    """Yield what is known, and all records, after every flight and every choice of one, until nothing can be done."""
    waiting, evidence = list(given), None
    while state.outcome is None:
        if waiting:
            record, scenario = waiting.pop(0), None
        elif state.next is not None and setup.simulated:
            setup.progress(f"flight {state.next.number}, in MuJoCo")
            record, scenario = _flown(setup, state.next), state.next.scenario
        elif state.next is None:
            state = state.model_copy(update={"next": _chosen(setup, state, known, evidence)})
            yield state, known
            continue
        else:
            return
        known = [*known, telemetry_only(record)]
        state, evidence = _assessed(setup, state, known, scenario)
        yield state, known


def _flown(setup: PlanSetup, planned: PlannedFlight) -> Record:
    """Fly in MuJoCo what is planned, on the truth of the scenario.

    Raises:
        DivergedFlightError: what went wrong, and when.
    """
    own = planned.gain is None
    believed = setup.believed if own else read_scenario(setup.folder.path / planned.scenario)
    assert isinstance(believed, Scenario)
    flown = believed.model_copy(update={"truth": setup.scenario.truth})
    with naming(setup.scenario):
        nominal, truth = nominal_platform(flown), true_platform(flown)
        maneuver = setup.own if own else plan_maneuver(flown, nominal).maneuver
    seed = int(np.random.SeedSequence([setup.seed, planned.number]).generate_state(1)[0])
    run = fly_maneuver(flown, nominal, truth, maneuver, seed)
    if run.divergence:
        raise DivergedFlightError(f"{setup.scenario.name}: flight {planned.number} came to no end: {run.divergence}")
    return replace(run.record, details=replace(run.record.details, name=f"flight_{planned.number:02d}"))


def _assessed(
    setup: PlanSetup, state: PlanResult, known: list[Record], scenario: str | None
) -> tuple[PlanResult, Evidence]:
    """Return what is known with a new flight, the last of the records."""
    number = len(known)
    setup.progress(f"flight {number}: e-values of all effects")
    evidence = _evidence(setup, known)
    wish = setup.wanted if isinstance(setup.wanted, EffectWanted) else EffectWanted()
    candidates = candidates_of(evidence, wish.effect, wish.component)
    if not candidates:
        raise InputError(
            f"{wish.text}: these records lack what it takes to test for it, or the platform has no such component; "
            "`testbed effects` lists what each effect needs"
        )
    log_e, leading = evidence.log_mean(candidates, len(candidates)), candidates[0]
    named, names, theta, std = None, list[str](), None, None
    outcome: Literal["named", "class", "inertia", "used_up"] | None = None
    if isinstance(setup.wanted, InertiaWanted):
        theta, std = _inertia(setup, known)
        outcome = "inertia" if setup.wanted.reached(np.array(std)).all() else None
    elif log_e >= -log(setup.alpha) and number >= _VERIFIABLE:
        named = _named(setup, known, evidence)
        names = verified(setup.wanted, named, evidence.by_key, len(candidates), setup.alpha)
        outcome = None if not names else "named" if named.verdict == "named" else "class"
    if outcome is None and number >= setup.most_flights:
        outcome = "used_up"
    flight = PlanFlight(
        number=number,
        record=known[-1].details.name,
        scenario=scenario,
        source_sha256=source_of(known[-1]) if scenario is None else None,
        log_e_value=log_e,
        leading=leading,
        leading_log_e_value=evidence.by_key[leading],
        verdict=None if named is None else named.verdict,
        named=[] if named is None else ["|".join(members) for members in named.classes],
        theta_kg_m2=theta,
        std_kg_m2=std,
    )
    changes = {
        "hypotheses": len(candidates),
        "outcome": outcome,
        "names": names,
        "flights": [*state.flights, flight],
        "next": None,
        "notices": list(_notices(setup, [*state.flights, flight])),
    }
    return state.model_copy(update=changes), evidence


def _evidence(setup: PlanSetup, known: Sequence[Record]) -> Evidence:
    data = data_set_of(known, setup.believed, setup.nominal)
    runs = joined(data.runs, data.heldout)
    if not runs.driven_by_momentum:
        raise InputError(
            f"{setup.scenario.name}: flights are planned for platforms whose actuators' momentum is measured; these "
            "records have none"
        )
    return evidence_of(runs, EFFECTS, theta_of(setup.nominal.inertia))


def _inertia(setup: PlanSetup, known: Sequence[Record]) -> tuple[list[float], list[float]]:
    """Return the combined estimate of all flights and its stated standard deviations, kg·m²."""
    setup.progress(f"flight {len(known)}: the inertia from all flights")
    combined = identify(setup.believed, setup.nominal, known).combined.by_name
    best = combined[leading_estimator(combined)]
    return best.theta.tolist(), best.std.tolist()


def _named(setup: PlanSetup, known: Sequence[Record], evidence: Evidence) -> Named:
    """Diagnose all flights; of an equivalence class, ask whether any flight would distinguish its members."""
    state = diagnose(
        setup.believed,
        Records(tuple(known)),
        progress=lambda what: setup.progress(f"flight {len(known)}: diagnosis, {what}"),
        propose=False,
    ).state
    classes = [[step.key, *(each.key for each in step.look_alikes)] for step in state.steps]
    undecided = [state.unmodelled_is_more_probable or _distinguishable(setup, members, evidence) for members in classes]
    return Named(verdict=str(state.verdict), classes=classes, undecided=undecided)


def _distinguishable(setup: PlanSetup, members: Sequence[str], evidence: Evidence) -> bool:
    """Return whether any flight of this platform distinguishes the members of a class."""
    if len(members) == 1:
        return False
    goal = class_goal(evidence, members)
    return goal is None or most_gained(goal, evidence.runs, setup.forecasts, setup.candidates) > _VISIBLE


def _chosen(setup: PlanSetup, state: PlanResult, known: list[Record], evidence: Evidence | None) -> PlannedFlight:
    """Return what to fly next: first the scenario's own maneuver, then what is expected to show the most."""
    number = len(known) + 1
    own = PlannedFlight(
        number=number,
        scenario=SCENARIO,
        release="the scenario's own maneuver",
        gain=None,
        worst_gain=None,
        worst_case=None,
    )
    if not known or setup.maneuvers == "own":
        return own
    evidence = _evidence(setup, known) if evidence is None else evidence
    goal = goal_of(evidence, setup.wanted)
    better = (
        refinement_of(evidence, goal, setup.forecasts.space, setup.progress) if isinstance(goal, EffectGoal) else None
    )
    chosen = chosen_flight(goal, evidence.runs, setup.forecasts, setup.candidates, setup.progress, better)
    if chosen is None:
        return own
    purpose = f"Flight {number} of a campaign for {wish_words(state)}: the one of which the most is expected."
    return PlannedFlight(
        number=number,
        scenario=setup.folder.propose(setup.believed, chosen.flight, number, purpose),
        release=f"released {chosen.flight.released_as}",
        gain=chosen.gain,
        worst_gain=chosen.worst,
        worst_case=chosen.worst_case,
    )


def _notices(setup: PlanSetup, flights: Sequence[PlanFlight]) -> Iterator[str]:
    missing = [flight for flight in flights if flight.log_e_value >= -log(setup.alpha)]
    if isinstance(setup.wanted, InertiaWanted) and missing:
        yield (
            f"from flight {missing[0].number} on the model lacks an effect, most probably {flights[-1].leading}: the "
            f"inertia is off by more than its standard deviations say; ask for the name first (effect {ANY!r})"
        )
    if isinstance(setup.wanted, EffectWanted) and not missing and len(flights) >= setup.most_flights:
        yield (
            "e-values are of effects on the motion that the gyro shows; `testbed diagnose` with these records tests as "
            "well for what the actuators' own channels show, for events and for the noise"
        )
    if isinstance(setup.wanted, InertiaWanted) and len(setup.wanted.std) < len(PARAMETER_NAMES):
        others = [name for name in PARAMETER_NAMES if name not in setup.wanted.std]
        yield f"of {', '.join(others)} nothing was wanted"
