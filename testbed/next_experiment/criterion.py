"""How far flights bring the models apart that the present data allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags
from testbed.diagnosis.data import Runs
from testbed.next_experiment.competing_hypotheses import HypothesisPairs, present_contrast
from testbed.next_experiment.distance import Contrast, contrast
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.forecast import blank_runs, forecast, forecast_columns
from testbed.next_experiment.space import FlightSpace


@dataclass(frozen=True, kw_only=True, eq=False)
class DiscriminationCriterion:
    """How well flights distinguish the models of every pair.

    Attributes:
        hypotheses: competing models and their pairs.
        runs: the present ones.
        space: platform and limits.
        present: contrast of every pair in the present data.
    """

    hypotheses: HypothesisPairs
    runs: Runs
    space: FlightSpace
    present: tuple[Contrast, ...]

    @property
    def wanted(self) -> Array:
        """Of every pair, shape (Q,), sigma."""
        return np.array([pair.wanted for pair in self.hypotheses.pairs])

    @property
    def now(self) -> Array:
        """Distance of every pair in the present data, shape (Q,), sigma."""
        return np.array([float(each.distance[0]) for each in self.present])

    def distances(self, flights: Sequence[NextFlight], times: int = 1) -> Array:
        """Return every pair's distance once each flight is added to the present data, shape (F, Q), sigma.

        Args:
            flights: of one duration.
            times: that each is flown.
        """
        blank, models = blank_runs(flights, self.runs, self.space.platform), self.hypotheses.models
        samples = [forecast(each.model, flights, blank) for each in models]
        columns = {
            index: forecast_columns(models[index].model, flights, blank)
            for index in {pair.imitator for pair in self.hypotheses.pairs}
        }
        apart = []
        for pair, present in zip(self.hypotheses.pairs, self.present, strict=True):
            difference = samples[pair.truth] - samples[pair.imitator]
            shown = contrast(difference, columns[pair.imitator], models[pair.imitator].common)
            apart.append(present.with_(shown, times).distance)
        return np.stack(apart, axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """The flight that was found.

    Attributes:
        flight: to fly.
        distances: of every pair once it is flown and added, shape (Q,), sigma.
        separable: which pairs some flight brings apart, shape (Q,).
    """

    flight: NextFlight
    distances: Array
    separable: Flags


def criterion_of(hypotheses: HypothesisPairs, runs: Runs, space: FlightSpace) -> DiscriminationCriterion:
    """Return the criterion for flights."""
    models = hypotheses.models
    present = tuple(present_contrast(models[pair.truth], models[pair.imitator]) for pair in hypotheses.pairs)
    return DiscriminationCriterion(hypotheses=hypotheses, runs=runs, space=space, present=present)
