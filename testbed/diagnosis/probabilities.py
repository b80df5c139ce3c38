"""How probable each explanation is, from the Bayesian information criterion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from testbed.diagnosis.latent import LatentTorque
from testbed.diagnosis.screening import Screening

_LATENT_PARAMETERS = 1


def probabilities_of(screening: Screening | None, latent: LatentTorque | None) -> Mapping[str, float]:
    """Return exp(-BIC/2), normalised over none, every refitted hypothesis and a torque of unknown origin.

    Args:
        screening: of the hypotheses against a model.
        latent: torque that the model with the best of them leaves; None where it was not looked at.
    """
    if screening is None:
        return {}
    bic = {"none": 0.0} | {candidate.placed.key: candidate.bic for candidate in screening.candidates}
    if latent is not None:
        best = min(bic.values())
        bic["unknown"] = best + _LATENT_PARAMETERS * np.log(latent.torque_B.size) - latent.likelihood_ratio
    least = min(bic.values())
    weight = {name: float(np.exp(-0.5 * (value - least))) for name, value in bic.items()}
    total = sum(weight.values())
    return {name: value / total for name, value in weight.items()}
