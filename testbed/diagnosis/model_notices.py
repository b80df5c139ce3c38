"""What there is to know of a diagnosis's model that is no effect: trims, healthy records, what was set aside."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import scipy

from testbed.diagnosis.findings import quantities_of
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.noise_by_record import noise_by_record
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.effects.contract import Quantity
from testbed.prediction.grid import begin_of_runs, run_at


def model_notices(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what there is to know of the model that is no effect.

    Trims, instants, an inertia at its limit, what ran away, and formulas that explain as much.
    """
    return (
        *_trim_words(diagnosis),
        *_given_words(diagnosis),
        *_known_noise_words(diagnosis),
        *_noise_by_record_words(diagnosis),
        *_instant_words(diagnosis),
        *_inertia_words(diagnosis),
        *_unexplained_words(diagnosis),
        *_set_aside_words(diagnosis),
        *_rival_words(diagnosis),
        *_given_up_words(diagnosis),
    )


def _rival_words(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.rivals:
        yield (
            "torques by formulas, which no library lists, explain these records nearly as well as what is named: "
            f"{', '.join(diagnosis.rivals)}"
        )


def _given_up_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Say what became of names that were shown as they were found."""
    if diagnosis.given_up:
        names = ", ".join(f"{each.effect.id} ({each.component})" for each in diagnosis.given_up)
        yield f"added on the way and out again, as it does not stand out beside what was found later: {names}"


def _trim_words(diagnosis: Diagnosis) -> Iterator[str]:
    trims = diagnosis.model.trims
    if not len(trims):
        return
    each_trim = zip(diagnosis.runs.trim_names, trims, diagnosis.model.trim_std, strict=True)
    shown = "; ".join(f"{name} ({', '.join(map(_with_error, each, std))})" for name, each, std in each_trim)
    of_each = "all records together" if diagnosis.runs.trim_group else "each record"
    yield (
        f"a constant torque of the actuators in body axes, their trim, is estimated for {of_each} beside the initial "
        f"rates: {shown} N·m; by itself, a constant torque on the body cannot be distinguished from it"
    )


def _with_error(value: float, std: float) -> str:
    return f"{value:.3g} ± {std:.1g}" if np.isfinite(std) else "not determined"


def _given_words(diagnosis: Diagnosis) -> Iterator[str]:
    for placed in diagnosis.model.placed:
        if placed.given:
            sizes = _sizes(quantities_of(diagnosis.runs, diagnosis.model, placed))
            yield f"in the nominal model, and fitted with it: {placed.key}, {sizes}{_healthy_words(diagnosis, placed)}"


def _healthy_words(diagnosis: Diagnosis, placed: Hypothesis) -> str:
    """Say what healthy records show of an effect, and whether it is another one here; empty where there are none."""
    belief = diagnosis.model.belief
    if belief is None or not belief.records:
        return ""
    healthy = f"; in the healthy records {_sizes(placed.effect.quantities(*belief.effect(placed.key)))}"
    chance = _chance_of_change(diagnosis, placed)
    if chance > SETTINGS.inertia_p_value:
        return healthy
    return (
        f"{healthy}; the difference is more than chance (p = {chance:.1g}): it, or what disturbs the platform, changed"
    )


def changed_since_healthy(diagnosis: Diagnosis) -> tuple[Hypothesis, ...]:
    """Return effects of the nominal model whose sizes differ from those of the healthy records by more than chance."""
    given = (each for each in diagnosis.model.placed if each.given)
    return tuple(each for each in given if _chance_of_change(diagnosis, each) <= SETTINGS.inertia_p_value)


def _chance_of_change(diagnosis: Diagnosis, placed: Hypothesis) -> float:
    """Return the chance of as large a difference from healthy records; 1 where there are none."""
    belief = diagnosis.model.belief
    if belief is None or not belief.records:
        return 1.0
    square, directions = diagnosis.model.surprise(placed)
    if not directions:
        return 1.0
    # How much these differ is known from as many as there are.
    return float(scipy.stats.f.sf(square / directions, directions, belief.records - 1))


def _sizes(quantities: Iterable[Quantity]) -> str:
    return ", ".join(f"{each.name} {each.value:.3g} ± {each.std:.2g}" for each in quantities)


def _known_noise_words(diagnosis: Diagnosis) -> Iterator[str]:
    for each in diagnosis.scatter:
        if diagnosis.as_in_reference(each):
            yield f"in the healthy records as well, and nothing new: {each.key}, of the gyro's noise"


def _noise_by_record_words(diagnosis: Diagnosis) -> Iterator[str]:
    found = noise_by_record(diagnosis)
    if (
        found.differs and not diagnosis.runs.known_in_part
    ):  # there most of it is what turns the platform beside commands
        each_record = ", ".join(f"{name} {ratio:.2f}" for name, ratio in found.ratio.items())
        yield (
            "the gyro is not as noisy in every record; its noise over what is stated, from the fastest changes: "
            f"{each_record}; gyro_noise_rad_s beside a record states that of its own"
        )


def _instant_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield in which run an effect happened once; runs that are held out are not laid end to end with the others."""
    runs = diagnosis.runs
    for placed in diagnosis.model.placed:
        quantities = quantities_of(runs, diagnosis.model, placed) if placed.effect.instant else ()
        for each in quantities:
            if each.name == placed.effect.instant:
                run = run_at(runs.grid, each.value)
                late = each.value - float(begin_of_runs(runs.grid)[run])
                yield (
                    f"{placed.key}: {each.name} = {each.value:.4g}, in the fitted runs laid end to end, is "
                    f"{late:.4g} ± {each.std:.2g} s on the clock of {runs.names[run]}"
                )


def _inertia_words(diagnosis: Diagnosis) -> Iterator[str]:
    belief = diagnosis.model.belief
    if belief is None:
        return
    if belief.reach < SETTINGS.least_reference_scatter:
        yield (
            "the inertia is taken as it is stated, and its interval says nothing: commands explain too little of the "
            "motion; platform.inertia_uncertainty lets it be estimated"
            if diagnosis.runs.known_in_part
            else 'the inertia is taken as it is stated: inertia = "known"'
        )
        return
    if diagnosis.runs.known_in_part:
        yield (
            "over windows only the inertia's ratio to the torque per command shows, and that has a factor of its own "
            f"about each axis: the moments are as stated, to {belief.log_ratio_std:.2g} of them; "
            "platform.inertia_uncertainty states another share"
        )
    _, limits = belief.ways(diagnosis.model.theta)
    if limits.any():
        which = "larger" if limits.sum() > 0.0 else "smaller"
        yield (
            f"the records want a {which} inertia than a factor of {np.exp(belief.reach):.2g} from the nominal one, to "
            "which it is held: torque per command, or what turns the platform beside it, is not as stated; "
            "platform.inertia_uncertainty widens the limit"
        )


def _unexplained_words(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.verdict == "unexplained":
        yield (
            "the intervals of the inertia hold of a model that lacks nothing: what is unexplained may move it by many "
            "times as much"
        )
        yield from _walking_words(diagnosis)


def _walking_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Say that a gyro's bias that walks would leave nothing, too, though it is no clear name among all hypotheses."""
    walks = [each for each in diagnosis.noise_candidates if each.walks]
    as_torque = 0.0 if diagnosis.latent is None else diagnosis.latent.likelihood_ratio
    for each in walks:
        if each.finding.p_value < SETTINGS.unexplained_p_value and each.chi_square_reduction > as_torque:
            size, error = each.size
            yield (
                "a gyro's bias that walks at random explains the residual at least as well as a torque that changes "
                f"slowly: by {size:.2g} ± {error:.1g} rad/s/√s (p = {each.finding.p_value:.1g}); "
                "gyro.rate_random_walk_rad_s_per_sqrt_s states it, where the gyro is known to have such a walk"
            )


def _set_aside_words(diagnosis: Diagnosis) -> Iterator[str]:
    screenings = [step.screening for step in diagnosis.steps]
    last = [] if diagnosis.remaining is None else [diagnosis.remaining]
    every = (*screenings, *last)
    runaway = dict.fromkeys(each.key for screening in every for each in screening.set_aside)
    if runaway:
        yield f"set aside, as no motion of a body could be fitted with it: {', '.join(runaway)}"
    cancelling = dict.fromkeys(each.key for screening in every for each in screening.cancelling)
    if cancelling:
        yield (
            "set aside, as it and another effect would cancel each other, two large errors of which next to nothing is "
            f"left: {', '.join(cancelling)}"
        )
