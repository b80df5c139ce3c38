"""E-values of all effects of the library after so many flights, from the gyro's samples of all of them together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import exp, inf, log

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Theta
from testbed.diagnosis.candidates import NONE
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis, orthonormal, projected_out
from testbed.diagnosis.signatures import Signature, signatures
from testbed.diagnosis.size_prior import SizePrior
from testbed.diagnosis.testable import hypotheses
from testbed.effects.contract import Effect
from testbed.sequential.e_value import log_e_value


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What flights say of every effect against the model without any.

    Attributes:
        runs: all flights, the gyro's samples alone: they were never held out.
        fit: inertia and initial rates, fitted to them without an effect.
        by_key: natural logarithm of the e-value of every hypothesis, such as `rotor_speed:cmg3`.
        signatures: of every hypothesis, at that start of its scan at which the data say most for it.
    """

    runs: Runs
    fit: Fit
    by_key: Mapping[str, float]
    signatures: Mapping[str, Signature]

    def log_mean(self, candidates: Iterable[str], among: int) -> float:
        """Return the logarithm of the e-value of some hypotheses together, each with an equal share of the prior.

        The mean of e-values over fixed shares is one; of hypotheses that were left out it counts as zero.

        Args:
            candidates: their keys.
            among: number of all hypotheses that share the prior.
        """
        values = [self.by_key[key] for key in candidates if key in self.by_key]
        return float(logsumexp(values)) - log(among) if values else -inf

    @property
    def shares(self) -> Mapping[str, float]:
        """Posterior share of each hypothesis, and of none, at even prior odds.

        None is zero, however sure another is: it still has a share of what that one has to be distinguished from.
        """
        values = np.array([0.0, *(each - log(len(self.by_key)) for each in self.by_key.values())])
        shares = np.maximum(np.exp(values - logsumexp(values)), np.finfo(float).tiny)
        return dict(zip((NONE, *self.by_key), shares.tolist(), strict=True))


def evidence_of(runs: Runs, effects: Mapping[str, Effect], theta: Theta) -> Evidence:
    """Return the e-values of all effects that can act in every flight; what happened once no next flight would verify.

    The model is linearised where inertia and initial rates fit all flights without an effect (Laplace's method).

    Args:
        runs: of all flights, with the noise that is stated.
        effects: the library, by id.
        theta: nominal inertia, from which the fit starts and with which the prior of forces goes, shape (6,), kg·m².

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    moment = runs.mean_moment(theta)
    testable, _ = hypotheses(runs, {name: each for name, each in effects.items() if each.recurs}, moment)
    fit = fitted(runs, [], theta, [])
    nuisance = orthonormal(fit.jacobian)
    residual = projected_out(fit.residual, nuisance)
    square, freedom = float(residual @ residual), len(residual) - nuisance.shape[1]
    by_key: dict[str, float] = {}
    best: dict[str, Signature] = {}
    for key, group in groupby(signatures(runs, fit, testable), key=lambda each: each.placed.key):
        starts = list(group)
        values = [_log_e_value(each, square, freedom, moment) for each in starts]
        by_key[key] = float(logsumexp(values)) - log(len(values))  # a mean over the values of a scan
        best[key] = starts[int(np.argmax(values))]
    return Evidence(runs=runs, fit=fit, by_key=by_key, signatures=best)


def _log_e_value(signature: Signature, square: float, freedom: int, moment: float) -> float:
    prior = SizePrior.of(signature.placed.effect, signature.start, moment)
    free = ~prior.searched
    here = signature.here
    information = here.information[np.ix_(free, free)]
    return float(log_e_value(information, here.slope[free], square, freedom, prior.typical[free]))


def candidates_of(evidence: Evidence, effect: str | None, component: str | None) -> list[str]:
    """Return the keys of the hypotheses that a wish allows, the one with the most evidence first.

    Args:
        evidence: of all of them.
        effect: id; None for any.
        component: where; None for anywhere.
    """
    keys = [
        key
        for key, each in evidence.signatures.items()
        if effect in (None, each.placed.effect.id) and component in (None, each.placed.component)
    ]
    return sorted(keys, key=lambda key: -evidence.by_key[key])


def leading(evidence: Evidence, candidates: Sequence[str], most: int) -> list[Hypothesis]:
    """Return those hypotheses with the largest posterior shares."""
    return [evidence.signatures[key].placed for key in candidates[:most]]


def chance_bound(log_value: float) -> float:
    """Return 1/E, the probability by which any stopping rule meets as large an e-value without an effect, at most 1."""
    return exp(min(0.0, -log_value))
