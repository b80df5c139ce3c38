"""How far flights bring the models apart that the present data allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags
from testbed.diagnosis.data import Runs
from testbed.next_experiment.distance import Contrast, contrast
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.forecast import blank_runs, forecast, forecast_columns
from testbed.next_experiment.limits import Room
from testbed.next_experiment.rivals import Contest, present_contrast


@dataclass(frozen=True, kw_only=True, eq=False)
class Judge:
    """Tells how far flights bring pairs apart.

    Attributes:
        contest: rivals and pairs.
        runs: the present ones.
        room: cluster and limits.
        present: what the present data say of every pair.
    """

    contest: Contest
    runs: Runs
    room: Room
    present: tuple[Contrast, ...]

    @property
    def wanted(self) -> Array:
        """Of every pair, shape (Q,), sigma."""
        return np.array([pair.wanted for pair in self.contest.pairs])

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
        blank, rivals = blank_runs(flights, self.runs, self.room.cluster), self.contest.rivals
        samples = [forecast(rival.model, flights, blank) for rival in rivals]
        columns = {
            index: forecast_columns(rivals[index].model, flights, blank)
            for index in {pair.imitator for pair in self.contest.pairs}
        }
        apart = []
        for pair, present in zip(self.contest.pairs, self.present, strict=True):
            difference = samples[pair.truth] - samples[pair.imitator]
            shown = contrast(difference, columns[pair.imitator], rivals[pair.imitator].common)
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


def judge_of(contest: Contest, runs: Runs, room: Room) -> Judge:
    """Return the judge of a contest's flights."""
    rivals = contest.rivals
    present = tuple(present_contrast(rivals[pair.truth], rivals[pair.imitator]) for pair in contest.pairs)
    return Judge(contest=contest, runs=runs, room=room, present=present)
