"""plan.json: flights until a verdict is sure, and the state from which a later command goes on with them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from testbed.formats.parts import Part, Provenance, Six


class Wish(Part):
    """What the campaign is to end with: one of both."""

    effect: str | None
    """The name of an effect: `any`, an id, or `effect:component`; null where the inertia is wanted."""
    inertia_std_kg_m2: dict[str, float] | None
    """Standard deviation of inertia parameters by name, kg·m²; null where an effect is wanted."""


class PlanFlight(Part):
    """One flight, and what all flights up to it say."""

    number: int
    """Of the flight, from 1, a pure number."""
    record: str
    """Name of its record; records/NAME.parquet has it."""
    scenario: str | None
    """What was flown, relative to this folder; null of a record that was there when the campaign began."""
    source_sha256: str | None
    """Hash of the file that the record was read from, hexadecimal; null of a simulated flight."""
    log_e_value: float
    """Natural logarithm of the e-value of what is wanted (of any effect, where the inertia is) against no effect."""
    leading: str
    """The effect with the largest e-value, as `effect:component`."""
    leading_log_e_value: float
    """Natural logarithm of its own e-value, which counts one in as many as there are hypotheses."""
    verdict: Literal["none", "named", "ambiguous", "unexplained"] | None
    """Of a diagnosis of all flights; null where the e-value did not ask for one."""
    named: list[str]
    """What the diagnosis names, each as `effect:component`, with `|` between those that it cannot distinguish."""
    theta_kg_m2: Six | None
    """Combined estimate of the inertia, kg·m²; null where an effect is wanted."""
    std_kg_m2: Six | None
    """Its stated standard deviations, kg·m²; null likewise."""


class PlannedFlight(Part):
    """What to fly next."""

    number: int
    """Of the flight, from 1, a pure number."""
    scenario: str
    """Its scenario, relative to this folder."""
    release: str
    """How the platform is let go, and what the flight is, in words."""
    gain: float | None
    """Expected growth of the logarithm of the odds of what is wanted, or fall of the logarithm of the worst ratio of a
    standard deviation to the wanted one; null of the scenario's own maneuver."""
    worst_gain: float | None
    """The least that is expected of that logarithm with an inertia 20 % off or one failed unit; null likewise."""
    worst_case: str | None
    """Which of these cases it is; null likewise."""


class PlanResult(Part):
    """plan.json: flights until a verdict is sure, one after the other, and what to fly next."""

    model_config = ConfigDict(populate_by_name=True)

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    scenario: str
    """Name of the scenario."""
    wanted: Wish
    """What the campaign is to end with."""
    alpha: float
    """Probability of a name although there is no effect, 0 to 1, at whatever flight the campaign stops."""
    hypotheses: int | None
    """Number of effects and components that share the prior, a pure number; null before the first flight."""
    most_flights: int
    """At which the campaign ends in any case, a pure number."""
    seed: int
    """Of the noise of simulated flights."""
    simulated: bool
    """Whether flights are flown in MuJoCo, on the truth of the scenario; else the user flies them."""
    maneuvers: Literal["chosen", "own"]
    """Whether flights are chosen by their expected gain, or are all of the scenario's own maneuver."""
    outcome: Literal["named", "class", "inertia", "used_up"] | None
    """`named`: the effect in `names`; `class`: one of those in `names`, which no flight of this platform distinguishes;
    `inertia`: known as well as wanted; `used_up`: neither in the flights allowed. Null while flights are missing."""
    names: list[str]
    """What is named, each as `effect:component`, that with the most evidence first."""
    flights: list[PlanFlight]
    """In order."""
    next: PlannedFlight | None
    """What to fly next; null once there is an outcome."""
    notices: list[str]
    """What a reader has to know, a sentence each."""
    provenance: Provenance
    """What decides the result."""
