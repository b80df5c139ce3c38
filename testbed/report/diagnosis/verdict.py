"""The verdict of a diagnosis in sentences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from math import isfinite

from testbed.diagnosis.findings import Addition, changed_inertia, doubt_words
from testbed.diagnosis.missed_records import MISSED
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.model_notices import changed_since_healthy
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.effects.contract import NamedEffect, Quantity
from testbed.effects.formula import Formula
from testbed.report.diagnosis.misfit import (
    gimbals_words,
    in_other_noise,
    misfit_change_words,
    misfit_words,
    shows_in_gyro,
)
from testbed.report.frame.blocks import Notice
from testbed.report.wording import BAND, chance_words, decimals_for, figures_to, listed


def diagnosis_verdict(diagnosis: Diagnosis) -> Notice:
    """Return the answer in a sentence or two."""
    verdict, changed = _of_effects(diagnosis), changed_inertia(diagnosis)
    if diagnosis.verdict is None or changed is None or not changed.sure:
        return verdict
    unit = inertia_unit(diagnosis.nominal_theta)
    show = partial(unit.shown, decimals=decimals_for(changed.std, unit))
    found = zip(PARAMETER_NAMES, changed.difference, changed.std, strict=True)
    differences = listed(f"{name} {show(value)} ± {show(std)}" for name, value, std in found if isfinite(value))
    text = f"The inertia is not that of the healthy records: in {unit.text} it differs by {differences}."
    return Notice(tone="bad" if verdict.tone == "bad" else "warn", text=f"{text} {verdict.text}")


def _of_effects(diagnosis: Diagnosis) -> Notice:
    names = [effect_name(each.effect, each.component) for each in diagnosis.added]
    classes = list(map(_alike, diagnosis.added))
    gap = _over_windows(diagnosis) + _fall(_without_effects(diagnosis), diagnosis.gap)
    if diagnosis.verdict is None:
        return Notice(tone="warn", text=f"Interrupted: incomplete, without a verdict. {_so_far(names)}")
    if diagnosis.verdict == "none":
        text = "Nothing is missing that these data show: the nominal model, its inertia re-estimated, has a misfit of "
        # The misfit above the verdict is in the noise before: two numbers of one model need a reason.
        noise = ", in the noise that its residual shows" if in_other_noise(diagnosis.gap_before, diagnosis.gap) else ""
        text += f"{misfit_words(diagnosis.gap)}, and a gap of {gap_words(diagnosis.gap)}{noise}; noise alone gives 1."
        if diagnosis.differing is not None and diagnosis.differing.placed is not None:
            placed = diagnosis.differing.placed
            text += (
                f" {effect_name(placed.effect, placed.component)} differs from run to run as in the healthy records."
            )
        changed = [effect_name(each.effect, each.component) for each in changed_since_healthy(diagnosis)]
        if changed:
            text += f" But it is not as in the healthy records, see the notes: {listed(changed)}."
        return Notice(tone="warn" if changed else "good", text=f"{text}{_far_words(diagnosis.gap)}")
    if diagnosis.verdict == "named":
        doubts = list(doubt_words(diagnosis))
        doubtful = f" Doubtful: {'; '.join(doubts)}." if doubts else ""
        return Notice(
            tone="warn" if doubts else "good", text=f"Missing in the nominal model: {listed(names)}. {gap}{doubtful}"
        )
    if diagnosis.verdict == "ambiguous":
        if diagnosis.unmodelled_is_more_probable:
            classes[0].append("a torque that no effect of the library gives")
        apart = [f"{first} from {listed(others)}" for first, *others in classes if others]
        sure = [first for first, *others in classes if not others]
        alike = f"These data cannot distinguish {', nor '.join(apart)}."
        further = f" Also missing: {listed(sure)}." if sure else ""
        return Notice(tone="warn", text=f"Something is missing in the nominal model. {alike}{further} {gap}")
    if diagnosis.alone and diagnosis.unnamed:
        return Notice(tone="warn", text=_alone_words(diagnosis))
    found = f"Named in part: {listed(map(' or '.join, classes))}. " if names else ""
    noise = "the noise as the samples show it" if diagnosis.scatter else "noise alone"
    misfit, gap = misfit_words(diagnosis.gap), gap_words(diagnosis.gap)
    left = f"{_unexplained_words(diagnosis)}: a misfit of {misfit}, a gap of {gap}; {noise} is 1."
    further = f"{_slow_words(diagnosis)}{_missed_words(diagnosis)}{shape_words(diagnosis)}{_chance_words(diagnosis)}"
    return Notice(tone="bad", text=f"{found}{left}{further}")


def _unexplained_words(diagnosis: Diagnosis) -> str:
    """Say that nothing explains the residual, or an effect that is one too many, or that its size differs does."""
    if diagnosis.differing is not None:
        placed, most = diagnosis.differing.placed, f"differs from run to run, the most in {diagnosis.differing.record}"
        if placed is None:
            return f"That the inertia {most}, explains more than any effect of the library"
        name = effect_name(placed.effect, placed.component)
        return f"That {name} {most}, or has another form, explains more than any further effect"
    if not diagnosis.unnamed or len(diagnosis.steps) < SETTINGS.most_effects:
        return "No effect of the library explains the residual"
    further = listed(effect_name(each.placed.effect, each.placed.component) for each in diagnosis.unnamed)
    return f"Beside these, the most that are named together, {further} would explain the most of the residual"


def _without_effects(diagnosis: Diagnosis) -> Gap:
    """Return the gap that the effects close: in the noise in which they were added, unless they are on the noise.

    What a re-estimated noise explains is no effect's: the misfit of the baseline in the noise before would count it.
    """
    if diagnosis.steps and not diagnosis.scatter and not diagnosis.retracted:
        return diagnosis.steps[0].before
    return diagnosis.gap_before


def _alike(added: Step | NoiseHypothesis) -> list[str]:
    """Return the name of an effect that was added, and of those that the data do not distinguish from it."""
    return [effect_name(added.effect, added.component), *names_of_all(added.look_alikes)]


def _alone_words(diagnosis: Diagnosis) -> str:
    """Say what a single run shows, which gets no name."""
    alike = listed(effect_name(each.placed.effect, each.placed.component) for each in diagnosis.unnamed)
    missing = (
        f"Something is missing in the nominal model, which has a misfit of {misfit_words(diagnosis.gap)}, and a gap "
        f"of {gap_words(diagnosis.gap)}; noise alone gives 1."
    )
    return f"{missing} What explains it best: {alike}. A single run gets no name, as no other could verify it."


def shape_words(diagnosis: Diagnosis) -> str:
    """Return the shape of an unmodelled torque, and the effects that were retracted."""
    shape, text = diagnosis.shape_left, ""
    if shape is not None:
        text = f" The residual fits a torque that {shape.words} ({chance_words(shape.p_value)})."
        if shape.words.startswith("oscillates"):
            text += " A panel or a liquid that already swings as a run begins leaves one: cut records where it rests."
    kept = {step.key for step in diagnosis.steps}
    gone = [effect_name(each.effect, each.component) for each in diagnosis.retracted if each.key not in kept]
    if gone:
        text += f" Retracted, as {_better_words(diagnosis)} has higher posterior odds: {listed(gone)}."
    return text


def _better_words(diagnosis: Diagnosis) -> str:
    """Say what stands in the place of effects that were retracted."""
    if diagnosis.walks:
        return "a gyro's bias that walks at random"
    return "the formula in their place" if _has_formula(diagnosis) else "an unmodelled torque"


def _has_formula(diagnosis: Diagnosis) -> bool:
    return any(isinstance(step.placed.effect, Formula) for step in diagnosis.steps)


def share_words(diagnosis: Diagnosis) -> str:
    """Return how much of what a torque of any shape would explain goes with the effects; empty where none stood out."""
    share = diagnosis.torque_explained
    return (
        ""
        if share is None
        else f"The effects explain {100.0 * share:.0f} % of what a torque of any shape would explain."
    )


def _over_windows(diagnosis: Diagnosis) -> str:
    """Say why a misfit may be none where an effect was named: the torque's noise is estimated with every model."""
    if not diagnosis.runs.known_in_part or diagnosis.explained <= 0.0:
        return ""
    return (
        "Over windows, what a model does not explain counts as noise of the torque, and its misfit is hardly any; with "
        f"the effects the evidence, 2 ln B, is larger by {diagnosis.explained:.1f}. "
    )


def _fall(before: Gap, after: Gap) -> str:
    gimbals = gimbals_words(before, after)
    if shows_in_gyro(before) or not gimbals:
        first = f"The misfit beyond noise: {misfit_change_words(before, after)}."
    else:
        first = f"The gyro alone shows no more than noise. {gimbals}."
    held_out = f", {before.heldout:.3f} -> {after.heldout:.3f} on those held out"
    held = held_out if isfinite(after.heldout) else ""
    return f"{first} The gap: {before.fit:.3f} -> {after.fit:.3f} on the fitted runs{held}; noise alone is 1."


def _far_words(gap: Gap) -> str:
    """Say of held-out runs that are missed, though by no more than the fitted ones leave open."""
    if not gap.heldout > MISSED * gap.fit:
        return ""
    return " The fitted runs leave the inertia too uncertain to predict those held out: fly longer, or turn faster."


def _slow_words(diagnosis: Diagnosis) -> str:
    """Say what is unexplained of a residual that in size is no more than noise: a torque that it follows slowly."""
    latent = diagnosis.latent
    if latent is None or latent.p_value >= SETTINGS.unexplained_p_value or shows_in_gyro(diagnosis.gap):
        return ""
    return f" It is small, but more than noise it follows a torque that changes slowly: {chance_words(latent.p_value)}."


def _missed_words(diagnosis: Diagnosis) -> str:
    """Say that the actuators do something else than they are asked for, if they do."""
    missed = diagnosis.actuators_missed
    if missed <= SETTINGS.channel_missed:
        return ""
    return f" The actuators do not do what they were asked for: the model misses it by {missed:.1f} times its noise."


def _chance_words(diagnosis: Diagnosis) -> str:
    """Say that noise alone may have failed the test, where it is one of three and by little."""
    if not diagnosis.hardly_left_over:
        return ""
    return " That is little evidence: noise alone fails one of the three tests of the residual in 3 % of data sets."


def _so_far(names: list[str]) -> str:
    return f"Found so far: {listed(names)}." if names else "No effect was found so far."


def effect_name(effect: NamedEffect, component: str) -> str:
    """Return an effect and its place, e.g. `rotor_speed (cmg3)`."""
    return f"{effect.id} ({component})"


def names_of_all(placed: Iterable[Hypothesis | NoiseHypothesis]) -> list[str]:
    """Return effects with all their places, each effect once, e.g. `actuator_weak (2, 5 and 1)`, in the order given."""
    places: dict[str, list[str]] = {}
    for each in placed:
        places.setdefault(each.effect.id, []).append(each.component)
    return [f"{effect} ({listed(components)})" for effect, components in places.items()]


def gap_words(gap: Gap) -> str:
    """Return a gap's numbers, in sigma."""
    held_out = f" fitted, {gap.heldout:.3f} held out" if isfinite(gap.heldout) else ""
    return f"{gap.fit:.3f}{held_out}"


def quantity_words(quantity: Quantity) -> str:
    """Return a parameter with its 95 % interval."""
    low, high = quantity.value - BAND * quantity.std, quantity.value + BAND * quantity.std
    value, *ends = (figures_to(each, quantity.std) for each in (quantity.value, low, high))
    return f"{quantity.name} = {f'{value} {quantity.unit}'.removesuffix(' 1')} (95 %: {' to '.join(ends)})"


def agreement_words(agreement: Agreement) -> str:
    """Say whether the runs agree on the size of an effect."""
    said = "more than chance makes them" if agreement.disagrees else "no more than chance makes them"
    return f"the {len(agreement.runs)} runs differ by {said} ({chance_words(agreement.p_value)})"


def disagreement_words(diagnosis: Diagnosis, agreements: Iterable[Agreement]) -> Iterator[str]:
    """Yield what to say of effects whose size differs between runs by more than chance, where all seems explained."""
    for each in agreements:
        if each.disagrees and not diagnosis.left_over:
            name = effect_name(each.placed.effect, each.placed.component)
            yield (
                f"{name}: {agreement_words(each)}; what is missing may change from run to run, or be something else, "
                "and the interval of one size for all holds of neither"
            )


def addition_words(addition: Addition) -> Iterator[str]:
    """Yield lines on an effect: description, parameters, its equivalence class, the experiment that resolves it."""
    yield addition.effect.measured(addition.component, addition.quantities)
    yield from (quantity_words(quantity) for quantity in addition.quantities)
    yield from (f"doubtful: {doubt}" for doubt in addition.doubts)
    if addition.look_alikes:
        others = listed(names_of_all(addition.look_alikes))
        yield f"indistinguishable from: {others}"
        yield f"to distinguish: {addition.effect.confirm}"
