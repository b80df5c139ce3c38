"""What the repetition of a zero-g campaign keeps of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from testbed.estimation.combine import CombinedEstimate
from testbed.reproduction.zero_g_cuts import Cut


@dataclass(frozen=True, kw_only=True)
class CampaignOutcome:
    """One repetition.

    Attributes:
        combined: eq. (33) by estimator.
        cuts: of all its flights, judged by the truth.
        usable: time of each flight used, s.
    """

    combined: Mapping[str, CombinedEstimate]
    cuts: tuple[Cut, ...]
    usable: tuple[float, ...]
