"""What to fly next where effects remain indistinguishable, in sentences and as a section of the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from testbed.diagnosis.detectable import INERTIA, hidden_by_inertia
from testbed.diagnosis.findings import inertia_change
from testbed.diagnosis.state import Diagnosis
from testbed.next_experiment.flight import Path
from testbed.next_experiment.proposal import Proposal, Separation
from testbed.report.frame.blocks import Cell, Column, Paragraph, Section, Table
from testbed.report.wording import figures, listed

_MOVED: Mapping[Path, str] = {
    "gimbal": "its gimbals",
    "actuator": "its actuators",
    "body_rate": "its body rate",
}
_TIMES = ("not at all", "once", "twice", "three times", "four times", "five times")


def pair_words(separation: Separation) -> str:
    """Return the names of two indistinguishable models."""
    if INERTIA in separation.keys:
        (effect,) = (_name(key) for key in separation.keys if key != INERTIA)
        return f"{effect} of its typical size and a different inertia"
    return listed(_name(key) for key in separation.keys)


def distance_words(separation: Separation) -> str:
    """Return the distance of two models now, and after a flight."""
    now, after = figures(separation.now, 2), figures(separation.after, 2)
    if not separation.separable:
        return f"{now} sigma apart, and no flight of this platform brings them beyond {after}: they stay one class"
    return f"{now} sigma apart now, {after} after one flight"


def flight_words(proposal: Proposal) -> str:
    """Return how to fly next, in a sentence or two."""
    if proposal.flight is None:
        return "No flight within this platform's limits distinguishes them."
    path = f"{_MOVED[proposal.flight.path]} on the path that the scenario holds"
    often = f"Fly it {_TIMES[proposal.times]} and add the records to the data."
    short = "" if proposal.enough else " Even then they may look alike: a stronger effect or a better gyro would tell."
    return f"Release the platform {proposal.flight.released_as}, {path}. {often}{short}"


def purpose_words(proposal: Proposal) -> str:
    """Return what the next flight is for, in a sentence."""
    pairs = dict.fromkeys(pair_words(each) for each in proposal.separations if each.separable)
    return f"Distinguishes what the records so far do not: {'; '.join(pairs)}."


def no_design_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield why there is no next flight of a platform that is not flown, and which experiment would help."""
    alike = [member.effect for each in diagnosis.added if each.look_alikes for member in (each, *each.look_alikes)]
    experiments = {effect.id: effect.confirm for effect in alike}
    if experiments:
        shown = " ".join(f"{name}: {confirm}" for name, confirm in experiments.items())
        yield (
            "no next flight is designed, as this scenario is not flown: that takes gimbals or wheels, a controller and "
            f"a maneuver. Experiments that show one of the effects by itself: {shown}"
        )


def same_inertia_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield what the change of the inertia may be as well, of a platform that is not flown to tell them apart."""
    # Under applied torque the inertia is known as its ratio to the torque per command, of which notices say more.
    if diagnosis.runs.trimmed or not inertia_change(diagnosis).significant:
        return
    components: dict[str, list[str]] = {}
    for placed in hidden_by_inertia(diagnosis):
        components.setdefault(placed.effect.id, []).append(placed.component)
    if components:
        names = listed(f"{effect} ({', '.join(places)})" for effect, places in components.items())
        yield (
            f"The inertia is not the nominal one. An error of {names}, which would not be seen here at its typical "
            "size, is the same as another inertia: the intervals of J hold without it"
        )


def next_section(proposal: Proposal | None) -> Iterator[Section]:
    """Yield the section, where effects remain indistinguishable."""
    if proposal is None:
        return
    columns = ("Indistinguishable", "now", "after one flight", "wanted")
    rows = tuple(
        (
            Cell(text=pair_words(each)),
            Cell(text=figures(each.now, 2)),
            Cell(text=figures(each.after, 2), tone="good" if each.after >= each.wanted else "warn"),
            Cell(text=figures(each.wanted, 2) if each.separable else "inseparable"),
        )
        for each in proposal.separations
    )
    note = (
        "Distance between what the two models predict, in sigma, after the one that is not true has fitted its own "
        "parameters, the inertia and the initial rates as well as it can; the closer of the two ways round."
    )
    table = Table(columns=tuple(Column(title=title) for title in columns), rows=rows, note=note)
    yield Section(title="What to fly next", blocks=(Paragraph(text=flight_words(proposal)), table))


def _name(key: str) -> str:
    """Return a model's name, e.g. `rotor_speed (cmg3)`."""
    effect, _, component = key.partition(":")
    return f"{effect} ({component})"
