"""The flight that best distinguishes the closest pair of models: the best of sampled flights, refined.

What is maximised is the smallest distance of all pairs, each in shares of what is wanted of it (T-optimality).

Source: Atkinson and Fedorov, "Optimal design: experiments for discriminating between several models", Biometrika 1975.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from testbed.next_experiment.criterion import Choice, DiscriminationCriterion
from testbed.next_experiment.refinement import refined
from testbed.next_experiment.sampling import sampled_flights

VISIBLE = 1.0
"""Sigma: models that no drawn flight brings farther apart by more are said to be inseparable: less than noise makes of
one number, as of a gyro 4 ms late and one of 38 Hz bandwidth at 16 Hz (docs/separation.md)."""


def chosen_flight(
    criterion: DiscriminationCriterion, progress: Callable[[str], None] = lambda _: None
) -> Choice | None:
    """Return the flight that best distinguishes all distinguishable pairs; None where no flight keeps the limits.

    A drawn one that suffices is taken as it is: its release does the work. Else the best one's path is refined.

    Args:
        criterion: of flights.
        progress: called with what is being done.
    """
    progress("flights that distinguish the effects")
    flights = sampled_flights(criterion.space)
    if not flights:
        return None
    distances = criterion.distances(flights)
    separable = np.sqrt(np.maximum(distances**2 - criterion.now**2, 0.0)).max(axis=0) > VISIBLE
    margins = (distances / criterion.wanted)[:, separable].min(axis=1, initial=np.inf)
    best = int(margins.argmax())
    choice = Choice(flight=flights[best], distances=distances[best], separable=separable)
    return choice if margins[best] >= 1.0 else refined(criterion, choice, progress)
