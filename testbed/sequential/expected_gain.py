"""What further flights are expected to show: growth of the e-values of effects, or precision of the inertia.

Everything follows from Gram matrices of whitened derivatives by (θ, φ), every flight's initial rate projected out:
those of several flights add up. Of an effect k and a rival j the information on φ_k with θ and φ_j unknown is the Schur
complement N. A flight that raises it by ΔN raises the logarithm of the e-value of k against j by ½ φᵀ ΔN φ in the mean
(growth rate), here averaged over the posterior of φ.

Source: Grünwald, de Heide, Koolen, "Safe testing", J. R. Stat. Soc. B (2024), for the growth rate as what to maximise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from testbed.arrays import Array, Theta
from testbed.diagnosis.candidates import NONE
from testbed.diagnosis.model import Fit, Hypothesis, evaluated
from testbed.diagnosis.size_prior import SizePrior
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.next_experiment.distance import contrast
from testbed.sequential.evidence import Evidence
from testbed.sequential.wanted import EffectWanted, InertiaWanted

MOST_RIVALS = 10
"""Hypotheses that a flight is chosen for, those with the largest posterior shares. Their derivatives are taken of every
flight. Source: chosen; with five, before any stood out, chosen flights took 2, 5, 7, 8 flights to a name where the own
maneuver took 2, 5, 9, 4 (`python -m benchmarks.fly_until_sure`, seed 90850, without refinement)."""
_INERTIA = len(PARAMETER_NAMES)
_A_PAIR = 2
_SCARCE = 1e-11
"""Share of the best-known direction's information below which one is not known, as in `next_experiment.distance`."""


class Goal(Protocol):
    """What flights are chosen for."""

    @property
    def model(self) -> Fit:
        """Fitted to the present flights, with the effects in question at next to nothing."""
        ...

    def gains(self, shown: Array) -> Array:
        """Return what is expected of flights, the more the better, shape (F,).

        Args:
            shown: Gram matrix of each, shape (F, C, C).
        """
        ...


def information_of(columns: Array, common: int) -> Array:
    """Return Gram matrices of derivatives by what flights share, all else projected out, shape (F, common, common).

    Args:
        columns: whitened, shape (F, S, common + own).
        common: parameters that all flights share.
    """
    return contrast(np.zeros(columns.shape[:2]), columns, common).information


@dataclass(frozen=True, kw_only=True, eq=False)
class EffectGoal:
    """Growth of the evidence of those hypotheses that may be the wanted effect.

    Attributes:
        model: with these and their rivals.
        present: Gram matrix of the present flights, shape (C, C).
        moments: E[φ φᵀ] of each hypothesis by its posterior, shapes (K, K).
        shares: posterior share of each, and of none.
        none: that of none.
        wanted: which are wanted.
    """

    model: Fit
    present: Array
    moments: tuple[Array, ...]
    shares: tuple[float, ...]
    none: float
    wanted: tuple[bool, ...]

    @property
    def leading(self) -> tuple[Hypothesis, Hypothesis | None] | None:
        """The most probable wanted hypothesis and its most probable rival, that None where it is no effect at all.

        Nothing is leading as long as no effect at all is more probable than any.
        """
        ranked = sorted(range(len(self.shares)), key=lambda index: -self.shares[index])
        first = next(index for index in ranked if self.wanted[index])
        if self.shares[first] < self.none:
            return None
        rival = next((index for index in ranked if index != first), None)
        placed = self.model.placed
        no_effect = rival is None or self.shares[rival] < self.none
        return placed[first], None if no_effect or rival is None else placed[rival]

    def gains(self, shown: Array) -> Array:
        """Return the mean growth of the log odds of each wanted hypothesis against its rivals, by their shares."""
        total: Array = np.zeros(len(shown))
        weight = sum(share for share, wanted in zip(self.shares, self.wanted, strict=True) if wanted)
        for index, (share, wanted) in enumerate(zip(self.shares, self.wanted, strict=True)):
            if wanted:
                total = total + share / weight * self._growth(index, shown)
        return np.asarray(total, dtype=np.float64)

    def _growth(self, index: int, shown: Array) -> Array:
        """Return that of one: against none, and against every other hypothesis, by their posterior shares."""
        rivals = [(self.none, self._nuisance(None))]
        rivals += [(share, self._nuisance(other)) for other, share in enumerate(self.shares) if other != index]
        own, weight = self._own(index), sum(share for share, _ in rivals)
        growth: Array = np.zeros(len(shown))
        for share, nuisance in rivals:
            growth += share / weight * 0.5 * self._gained(self.moments[index], shown, own, nuisance)
        return np.asarray(growth)

    def _gained(self, moment: Array, shown: Array, own: Sequence[int], nuisance: Sequence[int]) -> Array:
        """Return the mean of φᵀ ΔN φ of flights, shape (F,)."""
        added = left_of(self.present + shown, own, nuisance) - left_of(self.present[None], own, nuisance)
        return np.asarray(np.einsum("ij,fji->f", moment, added), dtype=np.float64)

    def _own(self, index: int) -> list[int]:
        own = self.model.own(self.model.placed[index])
        return list(range(_INERTIA + own.start, _INERTIA + own.stop))

    def _nuisance(self, rival: int | None) -> list[int]:
        return [*range(_INERTIA), *([] if rival is None else self._own(rival))]

    def apart(self, shown: Array) -> Array:
        """Return how far flights bring the first hypothesis from any other one at most, squared, σ², shape (F,)."""
        own = self._own(0)
        others = range(1, len(self.shares))
        apart = [self._gained(self.moments[0], shown, own, self._nuisance(each)) for each in others]
        return np.asarray(np.max(apart, axis=0))


@dataclass(frozen=True, kw_only=True, eq=False)
class ClassGoal:
    """Telling the members of an equivalence class apart, the named one from any other.

    Attributes:
        members: of the class, the named one first.
    """

    members: EffectGoal

    @property
    def model(self) -> Fit:
        """With all members."""
        return self.members.model

    def gains(self, shown: Array) -> Array:
        """Return the largest squared distance that flights add between the named one and another, σ², shape (F,)."""
        return self.members.apart(shown)


@dataclass(frozen=True, kw_only=True, eq=False)
class InertiaGoal:
    """Standard deviations of the inertia.

    Attributes:
        model: fitted to the present flights, without effects.
        present: Gram matrix of the present flights, shape (6, 6).
        limits: standard deviations that are wanted, infinite where none is, shape (6,), kg·m².
    """

    model: Fit
    present: Array
    limits: Theta

    def gains(self, shown: Array) -> Array:
        """Return by how much the worst ratio of standard deviation to wanted one falls, as a logarithm."""
        return np.asarray(np.log(self._worst(self.present[None])) - np.log(self._worst(self.present + shown)))

    def _worst(self, information: Array) -> Array:
        scale = np.sqrt(np.maximum(np.einsum("fcc->fc", information), np.finfo(float).tiny))
        scaled = information / (scale[:, :, None] * scale[:, None, :])
        variance = np.einsum("fcc->fc", np.linalg.pinv(scaled, rcond=_SCARCE, hermitian=True)) / scale**2
        return np.asarray((np.sqrt(variance) / self.limits).max(axis=1), dtype=np.float64)


def left_of(information: Array, own: Sequence[int], nuisance: Sequence[int]) -> Array:
    """Return Schur complements: what is known of some parameters with others unknown, shape (F, K, K).

    Args:
        information: shape (F, C, C).
        own: indices of the former, K of them.
        nuisance: of the latter.
    """
    scale = np.sqrt(np.maximum(np.einsum("fcc->fc", information), np.finfo(float).tiny))
    scaled = information / (scale[:, :, None] * scale[:, None, :])
    across = scaled[:, own][:, :, nuisance]
    inverse = np.linalg.pinv(scaled[:, nuisance][:, :, nuisance], rcond=_SCARCE, hermitian=True)
    left = scaled[:, own][:, :, own] - across @ inverse @ np.swapaxes(across, -1, -2)
    return np.asarray(left * scale[:, own][:, :, None] * scale[:, own][:, None, :])


def goal_of(evidence: Evidence, wanted: EffectWanted | InertiaWanted) -> Goal:
    """Return what the next flight is chosen for.

    Args:
        evidence: of the flights so far.
        wanted: of the campaign.
    """
    if isinstance(wanted, InertiaWanted):
        model, common = evidence.fit, _INERTIA
        return InertiaGoal(model=model, present=_present(model, common), limits=wanted.limits)
    return _effect_goal(evidence, list(_in_question(evidence, wanted)), wanted)


def class_goal(evidence: Evidence, members: Sequence[str]) -> ClassGoal | None:
    """Return the goal of distinguishing hypotheses, the first one from the others; None where fewer than two show.

    Args:
        evidence: of the flights so far.
        members: keys.
    """
    shown = [evidence.signatures[key].placed for key in members if key in evidence.by_key and _is_seen(evidence, key)]
    return None if len(shown) < _A_PAIR else ClassGoal(members=_effect_goal(evidence, shown, EffectWanted()))


def _effect_goal(evidence: Evidence, chosen: Sequence[Hypothesis], wanted: EffectWanted) -> EffectGoal:
    starts = tuple(evidence.signatures[each.key].start[None] for each in chosen)
    model = evaluated(evidence.runs, tuple(chosen), replace(evidence.fit.values, effects=starts))
    shares = evidence.shares
    return EffectGoal(
        model=model,
        present=_present(model, _INERTIA + len(model.effect_values)),
        moments=tuple(_moment(evidence, each) for each in chosen),
        shares=tuple(shares[each.key] for each in chosen),
        none=shares[NONE],
        wanted=tuple(wanted.allows(each.key) for each in chosen),
    )


def _in_question(evidence: Evidence, wanted: EffectWanted) -> Iterator[Hypothesis]:
    """Yield the most probable wanted hypotheses that any flight showed at all, and then the most probable others."""
    seen = [key for key in sorted(evidence.by_key, key=lambda key: -evidence.by_key[key]) if _is_seen(evidence, key)]
    first = [key for key in seen if wanted.allows(key)]
    most = MOST_RIVALS if len(first) == len(seen) else MOST_RIVALS - 1
    others = [key for key in seen if key not in first[:most]]
    for key in [*first[:most], *others][:MOST_RIVALS]:
        yield evidence.signatures[key].placed


def _is_seen(evidence: Evidence, key: str) -> bool:
    return evidence.signatures[key].rank > 0


def _moment(evidence: Evidence, placed: Hypothesis) -> Array:
    """Return E[φ φᵀ] of a hypothesis by its posterior at the typical size, scanned parameters as they are."""
    signature = evidence.signatures[placed.key]
    prior = SizePrior.of(placed.effect, signature.start, evidence.runs.mean_moment(evidence.fit.theta))
    free = ~prior.searched
    information = signature.here.information[np.ix_(free, free)] + np.diag(1.0 / prior.typical[free] ** 2)
    covariance = np.linalg.inv(information)
    mean = covariance @ signature.slope[free]
    moment = np.zeros((len(free), len(free)))
    moment[np.ix_(free, free)] = covariance + np.outer(mean, mean)
    return moment


def _present(model: Fit, common: int) -> Array:
    return np.asarray(information_of(model.jacobian[None], common)[0])
