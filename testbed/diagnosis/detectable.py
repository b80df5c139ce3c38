"""Which effects these records would have shown, from which size on, and which of them look alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, groupby

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.screening import blur_of
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import Signature, distinguishability, smallest_detectable
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.testable import confounding
from testbed.effects.contract import Quantity
from testbed.effects.formula import ID as FORMULA

INERTIA = "inertia"
"""The effect that is always in the model."""


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """The smallest size of an effect that these data would have shown.

    Attributes:
        placed: effect and component.
        multiple: of the typical size; infinite where this motion does not show the effect at all.
        smallest: the effect's parameters at that size, as they are reported; empty where infinite.
        typical: at their typical size.
        by_frequency: of an effect whose frequency is not known, the same at each that was looked at, about the axis
            that shows the least; multiple and smallest are then those of the frequency that shows the least.
        sized_by: names of the parameters that grow with its size, of an effect that has others, such as a frequency.
    """

    placed: Hypothesis
    multiple: float
    smallest: tuple[Quantity, ...]
    typical: tuple[Quantity, ...]
    by_frequency: tuple[Detectable, ...] = ()
    sized_by: frozenset[str] = frozenset()

    @property
    def seen_when_typical(self) -> bool:
        """Whether the effect would have been found at its typical size."""
        return self.multiple <= 1.0


def first_screening(diagnosis: Diagnosis) -> Screening | None:
    """Return the hypotheses against the baseline; None where they were not looked at yet."""
    return diagnosis.steps[0].screening if diagnosis.steps else diagnosis.remaining


def shown_signatures(screening: Screening | None) -> tuple[Signature, ...]:
    """Return the signatures that a reader is shown: the inertia is in every model already, and no list has formulas."""
    if screening is None:
        return ()
    return tuple(each for each in screening.signatures if each.placed.effect.id not in (INERTIA, FORMULA))


def detectable_sizes(diagnosis: Diagnosis) -> tuple[Detectable, ...]:
    """Return the smallest detectable size of every effect, in the order in which effects are listed."""
    screening = first_screening(diagnosis)
    if screening is None:
        return ()
    grid = diagnosis.runs.grid
    return tuple(
        _detectable(each, screening.tested, blur_of(each.placed, grid), free=grid.turns_freely)
        for each in shown_signatures(screening)
    )


def _detectable(signature: Signature, tested: int, blur: Array, *, free: bool) -> Detectable:
    if signature.reaches:
        return _over_frequencies(signature, tested)
    effect = signature.placed.effect
    absent = np.array([parameter.absent for parameter in effect.parameters])
    typical = np.array([parameter.typical for parameter in effect.parameters])
    multiple = smallest_detectable(signature, tested)
    if blur.any():  # the covariance of a size grows by it
        length = np.linalg.norm(signature.columns @ (typical - absent))
        multiple *= float(np.hypot(1.0, length * np.linalg.norm(blur / (typical - absent))))
    none = np.zeros(len(absent))
    with np.errstate(over="ignore", invalid="ignore"):  # a gain is the exponential of its parameter
        smallest = effect.quantities(absent + multiple * (typical - absent), none) if np.isfinite(multiple) else ()
    hidden = set() if free else _without_columns(signature)
    return Detectable(
        placed=signature.placed,
        multiple=multiple,
        smallest=tuple(each for each in smallest if each.name not in hidden and np.isfinite(each.value)),
        typical=tuple(each for each in effect.quantities(typical, none) if each.name not in hidden),
    )


def _over_frequencies(signature: Signature, tested: int) -> Detectable:
    """Return the size that is seen whatever the frequency, with the sizes that are seen at each."""
    placed, none = signature.placed, np.zeros(signature.placed.size)
    typical = placed.effect.quantities(np.array([each.typical for each in placed.effect.parameters]), none)
    sizes = []
    for _, axes in groupby(signature.reaches, key=lambda reach: float(reach.absent[0])):
        pairs = [(each.multiple(tested), each) for each in axes]
        shown = [pair for pair in pairs if np.isfinite(pair[0])]  # not axes that a bearing holds
        multiple, reach = max(shown or pairs, key=lambda pair: pair[0])
        # Of what no size shows, such as a mode far above the gyro's rate, there is no smallest one.
        smallest, twice = (
            placed.effect.quantities(reach.absent + times * multiple * reach.typical, none)
            if np.isfinite(multiple)
            else ()
            for times in (1.0, 2.0)
        )
        sizes.append(
            Detectable(
                placed=placed,
                multiple=multiple,
                smallest=smallest,
                typical=typical,
                sized_by=frozenset(
                    one.name for one, other in zip(smallest, twice, strict=True) if one.value != other.value
                ),
            )
        )
    worst = max(sizes, key=lambda size: size.multiple)
    return replace(worst, by_frequency=tuple(sizes))


def _without_columns(signature: Signature) -> set[str]:
    """Return the names of an effect's parameters that change nothing about the axes about which a rig turns."""
    lengths = np.linalg.norm(signature.columns, axis=0)
    pairs = zip(signature.placed.effect.parameters, lengths, strict=True)
    return {parameter.name for parameter, length in pairs if length == 0.0 and not parameter.scanned}


def hidden_by_inertia(diagnosis: Diagnosis) -> list[Hypothesis]:
    """Return the effects that would pass for another inertia: of their typical size they would not be seen."""
    return [
        size.placed
        for size in detectable_sizes(diagnosis)
        if INERTIA in size.placed.effect.look_alikes and not size.seen_when_typical
    ]


def confounded(diagnosis: Diagnosis) -> tuple[tuple[Hypothesis, Hypothesis], ...]:
    """Return the hypotheses that were not tested, each with the effect in the final model that confounds it."""
    screening, present = first_screening(diagnosis), diagnosis.model.placed
    candidates = [] if screening is None else [each.placed for each in screening.signatures]
    pairs = [(each, confounding(each, present)) for each in candidates]
    return tuple((candidate, by) for candidate, by in pairs if by is not None)


def distances(signatures: tuple[Signature, ...]) -> Array:
    """Return how distinguishable every two effects are, shape (E, E): 0 for aliases, 1 for orthogonal signatures."""
    apart = np.zeros((len(signatures), len(signatures)))
    for one, other in combinations(range(len(signatures)), 2):
        apart[one, other] = apart[other, one] = distinguishability(signatures[one], signatures[other])
    return apart


def pairs_alike(diagnosis: Diagnosis) -> tuple[tuple[Hypothesis, Hypothesis, float], ...]:
    """Return the effects that these data hardly distinguish, the closest first, with their distance."""
    shown = tuple(each for each in shown_signatures(first_screening(diagnosis)) if each.rank)
    apart = distances(shown)
    pairs = [
        (shown[one].placed, shown[other].placed, float(apart[one, other]))
        for one, other in combinations(range(len(shown)), 2)
        if apart[one, other] < SETTINGS.confounded_sine
    ]
    return tuple(sorted(pairs, key=lambda pair: pair[2]))
