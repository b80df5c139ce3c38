"""The effects that were refitted in each step, the most probable first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

from testbed.diagnosis.candidates import Candidate, Screening, accepted, probabilities_of
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.settings import PriorOdds
from testbed.diagnosis.state import Diagnosis
from testbed.report.frame.blocks import Block, Cell, Column, Paragraph, Section, Table
from testbed.report.wording import figures

_MEANING = (
    "The χ² reduction is of the fitted runs; of effects on the noise, twice the log-likelihood ratio of the samples' "
    "scatter. B is the Bayes factor against no missing effect, integrated over the prior of an effect's size, the "
    "held-out runs included. What lies within 6 of the greatest 2 ln B is indistinguishable from it; where no model is "
    "exact, so is what differs by no more than from run to run, or from window to window. Such a class has one "
    "probability, and its member with the greatest 2 ln B is added, unless a more plausible one or a case of it is in "
    "the class. The p-value is family-wise, over all effects that were tested."
)


def ranking_section(diagnosis: Diagnosis) -> Iterator[Section]:
    """Yield the section, once the effects were looked at: a table for each step, and one of what was left then."""
    screenings = [step.screening for step in diagnosis.steps]
    if diagnosis.remaining is not None:
        screenings.append(diagnosis.remaining)
    tables: list[Block] = [
        _table(added, each, on_the_noise(diagnosis), diagnosis.untested(each))
        for added, each in enumerate(screenings)
        if each.candidates
    ]
    if tables:
        meaning = f"{_MEANING} {_prior_words(diagnosis.runs.prior_odds)}"
        yield Section(title="Effects, ranked", blocks=(Paragraph(text=meaning), *tables))


def _prior_words(odds: PriorOdds) -> str:
    return (
        f"Before the data, the odds of no missing effect against all effects together are {odds.none:g} to 1, those of "
        f"each kind of torque that is not listed against one effect {odds.unmodelled:g} to 1 ([diagnosis] in the "
        "scenario changes them)."
    )


RANKING = ("component", "probability", "χ² reduction", "2 ln B", "p-value")
"""What stands behind each effect."""


def on_the_noise(diagnosis: Diagnosis) -> tuple[NoiseHypothesis, ...]:
    """Return the effects on the gyro's noise to rank with the others, where nothing was found."""
    return () if diagnosis.added else diagnosis.new_noise


def ranking_rows(
    screening: Screening,
    noise: Sequence[NoiseHypothesis] = (),
    untested: Mapping[str, float] = MappingProxyType({}),
) -> Iterator[tuple[str, ...]]:
    """Yield an effect and what stands under `RANKING`; an equivalence class has one probability.

    Args:
        screening: whose candidates are ranked.
        noise: effects on the gyro's noise, which take the places of others with a smaller Bayes factor.
        untested: 2 ln B of effects for which a channel is missing, by name (`Diagnosis.untested`).
    """
    others = {each.key: each.log_bayes_factor for each in noise} | dict(untested)
    probability = probabilities_of(screening, others=others)
    close = screening.close if accepted(screening) is not None else ()
    # A class may be larger than what is listed, as steps back and effects on the noise add to what was refitted.
    members = [candidate.key for candidate in close if candidate.key in probability]
    both: list[Candidate | NoiseHypothesis] = [*screening.candidates, *noise]
    ranked = sorted((each for each in both if each.key in probability), key=lambda each: -each.log_bayes_factor)
    first = next((each.key for each in ranked if each.key in members), None)
    for each in ranked:
        own = f"{sum(probability.get(key, 0.0) for key in (members if each.key in members else [each.key])):.3f}"
        yield (
            each.effect.id,
            each.component,
            "same class" if each.key in members and each.key != first else own,
            f"{each.chi_square_reduction:.1f}",
            f"{each.log_bayes_factor:+.1f}",
            figures(each.p_value, 1) if each.p_value > 0.0 else "< 1e-300",
        )


def _table(added: int, screening: Screening, noise: Sequence[NoiseHypothesis], untested: Mapping[str, float]) -> Table:
    titles = (f"With {added} added" if added else "Nothing added", *RANKING)
    rows = tuple(tuple(Cell(text=text) for text in row) for row in ranking_rows(screening, noise, untested))
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, numeric=False)
