"""One estimate from several runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.dynamics.inertia_unit import inertia_words
from testbed.estimation.answer import Answer
from testbed.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True, repr=False)
class CombinedEstimate(Answer):
    """The weighted average of several runs."""

    def __repr__(self) -> str:
        return f"Estimate of all records together: {inertia_words(self.theta, self.std)}"


def combined(estimates: Sequence[Estimate]) -> CombinedEstimate:
    """Return θ̂ = P Σ P⁽ⁱ⁾⁻¹ θ̂⁽ⁱ⁾ with P = (Σ P⁽ⁱ⁾⁻¹)⁻¹ over one or more runs' estimates.

    On a pivot θ has the offset of the centre of mass behind it, and P⁽ⁱ⁾ is of both together. What is considered, such
    as a rotor's momentum, is the same in all runs: its shifts add up like the estimates.

    Source: paper eq. (33).
    """
    weights = np.array([np.linalg.inv(estimate.joint_covariance) for estimate in estimates])
    answers = np.array([estimate.joint for estimate in estimates])
    shifts = np.array([estimate.joint_considered for estimate in estimates])
    covariance = np.linalg.inv(weights.sum(axis=0))
    answer = covariance @ np.einsum("nij,nj->i", weights, answers)  # eq. (33)
    shift = covariance @ np.einsum("nij,njk->ik", weights, shifts)
    return CombinedEstimate(
        theta=answer[:6],
        covariance=covariance[:6, :6],
        considered=shift[:6],
        considered_kinds=estimates[0].considered_kinds,
        offset_error=answer[6:],
        offset_covariance=covariance[6:, 6:],
        offset_cross_covariance=covariance[:6, 6:],
        offset_considered=shift[6:],
        offset_spread=np.zeros_like(covariance[6:, 6:]),
    )
