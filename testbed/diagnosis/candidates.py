"""Hypotheses refitted and compared: posterior probability, the choice, and its equivalence class."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, inf, log, sqrt
from types import MappingProxyType

import numpy as np
from scipy.special import chdtrc, logsumexp, ndtr

from testbed.arrays import Array, Series
from testbed.diagnosis.model import AtComponent, Fit, Hypothesis
from testbed.diagnosis.settings import SETTINGS, PriorOdds
from testbed.diagnosis.signatures import Signature


def mean_over_scan(found: float, elsewhere: Sequence[float], scan_count: int) -> float:
    """Return the log Bayes factor of an effect scanned over a grid of start values with equal priors: their mean odds.

    Args:
        found: twice the logarithm of the odds at the start value with the largest odds.
        elsewhere: at other start values.
        scan_count: number of start values; those without an entry have odds of zero.
    """
    odds = 0.5 * np.array([found, *elsewhere])
    unseen = log(scan_count - len(odds)) if scan_count > len(odds) else -inf
    return 2.0 * float(logsumexp([*odds, unseen]) - log(scan_count))


def favoured_over_none(odds: Iterable[float], needed: float) -> bool:
    """Return whether the posterior odds favour one of several effects over none, prior odds included.

    Args:
        odds: twice the logarithm of each one's posterior odds against none, at even prior odds.
        needed: odds that all of them together have to exceed.
    """
    return float(logsumexp(0.5 * np.array(list(odds)))) > log(needed)


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate(AtComponent):
    """A hypothesis refitted together with all else in the model.

    Attributes:
        placed: effect and component.
        fit: the model with it.
        chi_square_reduction: χ² of the present model less that of this one; where the torque's noise is estimated with
            every model, the deviance (`Fit.deviance`).
        rank: directions that the data show of the effect.
        trials_penalty: logarithm of the factor by which a scan over start values lowers its odds (`mean_over_scan`).
        heldout_log_likelihood_gain: twice the increase of the held-out runs' log-likelihood.
        size_penalty: by how much the prior of its size lowers its evidence below the reduction of χ² (`SizePrior`).
        log_bayes_factor: of all runs, on the deviance scale: 2 ln B, less twice the trials penalty.
        by_run: the same of the model's gyro residual in every run, shape (R,).
        p_value: of the reduction of χ², times the number of hypotheses and of each one's start values (Bonferroni),
            divided by the held-out likelihood ratio: its mean is 1 without the effect, so that the quotient is a
            p-value too. Not below the family-wise error if the fitted runs alone do not show the effect.
        nothing_new: what it explains that healthy records differ by as well; part of neither reduction nor gain.
    """

    placed: Hypothesis
    fit: Fit
    chi_square_reduction: float
    rank: int
    trials_penalty: float
    size_penalty: float
    heldout_log_likelihood_gain: float
    log_bayes_factor: float
    by_run: Series
    p_value: float
    nothing_new: float = 0.0

    @property
    def fits(self) -> float:
        """Improvement of the fit of all runs over the present model, without a penalty for its parameters.

        What healthy records differ by as well counts: which of two effects fits better does not depend on it.
        """
        explained = self.chi_square_reduction + self.heldout_log_likelihood_gain + self.nothing_new
        return explained - 2.0 * self.trials_penalty

    @property
    def plausible(self) -> bool:
        """Whether hardware has such parameters."""
        values = self.fit.effect_values[self.fit.own(self.placed)].tolist()
        return all(each.is_plausible(value) for each, value in zip(self.effect.parameters, values, strict=True))

    @property
    def blurred(self) -> bool:
        """Whether it has no size of its own beside another effect over windows, where samples are not all that counts.

        What healthy records differ by is in the covariance, and in the evidence only as far as one effect feels it.
        """
        if self.fit.torque_noise is None or sum(not each.given for each in self.fit.placed) == 1:
            return False
        own, parameters = self.fit.own(self.placed), self.effect.parameters
        sized = np.flatnonzero([not each.scanned for each in parameters])
        size = self.fit.effect_values[own][sized] - np.array([parameters[index].absent for index in sized])
        covariance = self.fit.covariance[6:, 6:][own, own][np.ix_(sized, sized)]
        if not np.isfinite(covariance).all():
            return True
        square = float(size @ np.linalg.pinv(covariance, hermitian=True) @ size)
        return bool(chdtrc(len(sized), square) > SETTINGS.family_wise_error)

    @property
    def cancels(self) -> bool:
        """Whether it and another effect that was found, or all others, make samples of which together little is left.

        Two large errors that hide each other can have any small difference; the evidence of one beside the other does
        not count how rare it is that they agree.
        """
        own, placed = self.fit.contribution(self.placed), self.fit.placed
        others = [self.fit.contribution(each) for each in placed if not each.given and each.key != self.placed.key]
        return any(_cancel([own, other]) for other in others) or _cancel([own, *others])

    @property
    def significant(self) -> bool:
        """Whether it is significant at the family-wise error."""
        return self.p_value < SETTINGS.family_wise_error


def implausibility(fit: Fit) -> float:
    """Return twice the logarithm of the odds against a model's effects having parameters as no hardware has.

    Zero where all are plausible. Of an estimate near a limit its interval counts, and against no effect are odds longer
    than `implausible_odds`.
    """
    return sum(_implausibility(fit, each) for each in fit.placed if not each.given)


def _implausibility(fit: Fit, placed: Hypothesis) -> float:
    own, parameters = fit.own(placed), placed.effect.parameters
    values = fit.effect_values[own]
    if all(each.is_plausible(value) for each, value in zip(parameters, values.tolist(), strict=True)):
        return 0.0
    try:
        std = np.sqrt(np.maximum(np.diag(fit.covariance)[6:][own], 0.0))
    except np.linalg.LinAlgError:
        std = np.zeros(len(values))
    std = np.where(np.isfinite(std), np.maximum(std, _POINT), _POINT)
    low, high = np.array([each.plausible for each in parameters]).T
    inside = ndtr((high - values) / std) - ndtr((low - values) / std)
    return -2.0 * log(max(float(inside.min()), 1.0 / SETTINGS.implausible_odds))


_POINT = np.finfo(float).tiny
"""In the place of no standard deviation."""


def _cancel(contributions: Sequence[Array]) -> bool:
    together = np.sum(contributions, axis=0)
    return bool(together @ together < SETTINGS.cancelled * sum(each @ each for each in contributions))


@dataclass(frozen=True, kw_only=True, eq=False)
class Screening:
    """All hypotheses against the present model.

    Attributes:
        signatures: of each hypothesis at its best start.
        tested: number of hypotheses, which share the family-wise error alike.
        candidates: refitted ones, the one with the most evidence first.
        linearised: evidence of the others by their linearisation, by key.
        set_aside: hypotheses whose refit is the motion of no body; they cannot be compared.
        cancelling: hypotheses that would cancel another effect in the model; they are no candidates.
        prior_odds: of none and of what is not modelled.
    """

    signatures: tuple[Signature, ...]
    tested: int
    candidates: tuple[Candidate, ...]
    linearised: Mapping[str, float] = field(default_factory=dict)
    set_aside: tuple[Hypothesis, ...] = ()
    cancelling: tuple[Hypothesis, ...] = ()
    prior_odds: PriorOdds = field(default_factory=PriorOdds)

    def tests(self, placed: Hypothesis) -> bool:
        """Return whether a hypothesis was tested; none is that an effect in the model confounds."""
        return any(each.placed.key == placed.key for each in self.signatures)

    def odds(self, candidate: Candidate) -> float:
        """Return twice the logarithm of a candidate's posterior odds against none; all candidates have equal priors."""
        return candidate.log_bayes_factor - 2.0 * log(self.tested)

    @property
    def close(self) -> tuple[Candidate, ...]:
        """Candidates that are indistinguishable from the best one."""
        return tuple(candidate for candidate in self.candidates if _is_close(candidate, self.candidates[0]))


def accepted(screening: Screening) -> Candidate | None:
    """Return the effect to add to the model, if there is one.

    1. The hypothesis with the most evidence is there: its p-value is below the family-wise error, and its posterior
       odds are above even ones.
    2. Where it is the first effect, the posterior odds of its class against none exceed even, prior odds included.
       Beside another effect they have to be those of `further_name_odds`.
    3. Of its class, and of those that are there as well, the one with the most evidence is added. What is implausible,
       such as a gyro of half a hertz, gives way to what is not, skewed telemetry to a late gyro that fits as well, and
       a constant torque to a weak actuator that is a case of it.
    """
    if not screening.candidates or not _is_there(screening, screening.candidates[0]):
        return None
    is_first = sum(not each.given for each in screening.candidates[0].fit.placed) == 1
    needed = screening.prior_odds.none if is_first else SETTINGS.further_name_odds
    if not favoured_over_none((screening.odds(each) for each in screening.close), needed):
        return None
    there = [candidate for candidate in screening.close if _is_there(screening, candidate)]
    first = [candidate for candidate in there if not any(_goes_before(other, candidate) for other in there)]
    return max(first, key=lambda candidate: (candidate.plausible, candidate.log_bayes_factor))


def _goes_before(other: Candidate, candidate: Candidate) -> bool:
    """Return whether an effect is named before another of its class: a case of it, or as good a fit and more usual.

    What is implausible goes before nothing.
    """
    if not other.plausible:
        return False
    usual = other.effect.id in candidate.effect.yields_to and other.fits > candidate.fits - SETTINGS.tied_fits
    return usual or other.effect.id in candidate.effect.includes


def _is_there(screening: Screening, candidate: Candidate) -> bool:
    return candidate.significant and screening.odds(candidate) > 0.0 and not candidate.blurred


def _is_close(candidate: Candidate, best: Candidate) -> bool:
    """Return whether a candidate may be meant instead: by its evidence, or by its fit with but one parameter more.

    How much of it is nothing new is known less well than which of two explains more: beside healthy records one that
    has as much evidence before that may be meant as well, if hardware has such parameters. Where even the best model's
    residual exceeds the noise, differences count in units of its residual variance, and with many runs in units of
    their scatter from run to run; so they do over windows, where noise and torques that nobody commanded are one and no
    model is known to be right.
    """
    spread = max(1.0, best.fit.chi_square / best.fit.freedom)
    worse_fit = (
        best.chi_square_reduction
        + best.heldout_log_likelihood_gain
        - candidate.chi_square_reduction
        - candidate.heldout_log_likelihood_gain
    )
    more, tied = candidate.placed.size - best.placed.size, SETTINGS.indistinguishable * spread
    if best.log_bayes_factor - candidate.log_bayes_factor < tied or (more == 1 and worse_fit < tied):
        return True
    as_if_new = best.log_bayes_factor + best.nothing_new - candidate.log_bayes_factor - candidate.nothing_new
    if best.nothing_new > 0.0 and as_if_new < tied and candidate.plausible:
        return True
    worse = candidate.by_run - best.by_run
    if spread > SETTINGS.misfitting:
        return candidate.plausible and _differ_by_chance(worse)
    # A candidate that fits no worse has less evidence by its prior alone, in which chance has no part.
    return best.fit.torque_noise is not None and candidate.plausible and worse.sum() > 0.0 and _differ_by_chance(worse)


def _differ_by_chance(worse: Series) -> bool:
    """Return whether models that are both wrong differ by less than their difference does from run to run.

    Source: Vuong, "Likelihood ratio tests for model selection and non-nested hypotheses", Econometrica (1989).

    Args:
        worse: by how much χ² is larger in every run, shape (R,).
    """
    if len(worse) < SETTINGS.fewest_runs_that_scatter:
        return False
    return float(worse.sum()) < SETTINGS.apart_by_scatter * float(worse.std()) * sqrt(len(worse))


NONE, UNKNOWN = "none", "unknown"
BETWEEN = "|"
"""Separates the members of an equivalence class."""


def probabilities_of(
    screening: Screening | None, unmodelled: float = -inf, others: Mapping[str, float] = MappingProxyType({})
) -> Mapping[str, float]:
    """Return how probable it is that nothing is missing, of hypotheses with the most evidence, and of something else.

    Args:
        screening: of the hypotheses against a model.
        unmodelled: evidence of an unmodelled torque, against the same model.
        others: evidence of further hypotheses against the same model, by name.
    """
    if screening is None:
        return {}
    evidence = {candidate.key: candidate.log_bayes_factor for candidate in screening.candidates} | dict(others)
    most = sorted(evidence, key=lambda key: -evidence[key])[: SETTINGS.most_refits]
    odds = {key: evidence[key] - 2.0 * log(screening.tested) for key in most}
    small = [min(each, 0.0) for key, each in (*screening.linearised.items(), *evidence.items()) if key not in most]
    unknown = max(screening.tested + len(others) - len(most) - len(small), 0)
    unseen = (sum(exp(0.5 * each) for each in small) + unknown) / (screening.tested + len(others))
    return normalized(odds, screening.prior_odds.none, unmodelled, unseen)


def normalized(
    odds: Mapping[str, float], none: float, unmodelled: float = -inf, unseen: float = 0.0
) -> Mapping[str, float]:
    """Return how probable hypotheses are, that nothing is missing, and that something else is.

    Proportional to exp(odds/2). All hypotheses have equal priors. A hypothesis that was not refitted may be present and
    too small to detect: as far as its linearisation does not exclude it, its weight counts as unknown, as does that of
    an unmodelled torque.

    Args:
        odds: twice the logarithm of each one's posterior odds against none, by name.
        none: prior odds of none against all of them together.
        unmodelled: evidence of an unmodelled torque.
        unseen: weight of the hypotheses that are not listed.
    """
    most = max(0.0, unmodelled, *odds.values())
    weight = {key: exp(0.5 * (value - most)) for key, value in odds.items()}
    weight |= {
        NONE: none * exp(-0.5 * most),
        UNKNOWN: exp(0.5 * (unmodelled - most)) + unseen * exp(-0.5 * most),
    }
    total = sum(weight.values())
    return {key: value / total for key, value in weight.items()}


def by_class(probabilities: Mapping[str, float], members: Collection[str]) -> Mapping[str, float]:
    """Return probabilities with those of the effect that was found, and of its equivalence class, as one entry."""
    others = {key: value for key, value in probabilities.items() if key not in members}
    return {BETWEEN.join(members): sum(probabilities.get(key, 0.0) for key in members)} | others
