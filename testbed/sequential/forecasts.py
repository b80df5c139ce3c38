"""What flights would show of effects and of the inertia, kept from one choice of a flight to the next.

The flights to choose among stay the same through a campaign, and most hypotheses in question stay too. What a flight
would show of a hypothesis depends on the inertia and the noise as estimated so far, both rounded here, so that it is
worked out once. Being functions of the present estimates alone, forecasts are the same for a campaign that was resumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.data import chosen as chosen_runs
from testbed.diagnosis.model import Fit
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.next_experiment.distance import free_of
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.forecast import blank_runs, forecast_columns
from testbed.sequential.robust import Case, RobustSpace

INERTIA_STEP = 0.01
"""Share of the mean moment of inertia to which J is rounded: next to the 20 % that flights have to be robust to it is
nothing, and after a flight or two J moves by less."""
_NOISE_DIGITS = 3
"""To which the standard deviation of the noise is rounded."""
_INERTIA = len(PARAMETER_NAMES)


class _Situation(NamedTuple):
    """What forecasts of one case depend on besides hypothesis and flight."""

    case: Case
    theta: tuple[float, ...]
    sigma: tuple[float, ...]


class _Kept(NamedTuple):
    """Whose derivatives are kept: a hypothesis at a start of its scan, or the inertia (key empty)."""

    situation: _Situation
    key: str
    start: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Forecasts:
    """Forecasts of the flights of a campaign.

    Attributes:
        space: platform, limits and cases.
    """

    space: RobustSpace
    _kept: dict[_Kept, dict[NextFlight, Array]] = field(default_factory=dict)

    def information(self, model: Fit, runs: Runs, flights: Sequence[NextFlight], case: Case) -> Array:
        """Return Gram matrices of whitened derivatives by θ and effects, initial rates projected out, shape (F, C, C).

        Args:
            model: with the hypotheses in question.
            runs: the flights so far, whose channels and noise further ones will have.
            flights: of one duration.
            case: in which they are flown.
        """
        like, theta = _typical(runs), _rounded(model.values.theta)
        situation = _Situation(case, tuple(theta[0].tolist()), tuple(like.sigma[0].tolist()))
        wanted = [_Kept(situation, "", ())]
        wanted += [
            _Kept(situation, placed.key, tuple(start[0].tolist()))
            for placed, start in zip(model.placed, model.values.effects, strict=True)
        ]
        at_rounded = replace(model, values=replace(model.values, theta=theta))
        self._complete(wanted, at_rounded, like, flights)
        return np.stack([_gram([self._kept[each][flight] for each in wanted]) for flight in flights])

    def _complete(self, wanted: Sequence[_Kept], model: Fit, like: Runs, flights: Sequence[NextFlight]) -> None:
        """Work out what is not kept yet."""
        for each in wanted:
            self._kept.setdefault(each, {})
        missing = [index for index, each in enumerate(wanted) if any(one not in self._kept[each] for one in flights)]
        if not missing:
            return
        unknown = [flight for flight in flights if any(flight not in self._kept[wanted[index]] for index in missing)]
        effects = [index - 1 for index in missing if index]
        part = replace(
            model,
            placed=tuple(model.placed[index] for index in effects),
            values=replace(model.values, effects=tuple(model.values.effects[index] for index in effects)),
        )
        columns = self._columns(part, like, unknown, wanted[0].situation.case)
        kept = {wanted[0]: columns[:, :, :_INERTIA]}
        begin = _INERTIA
        for index in effects:
            end = begin + model.values.effects[index].shape[1]
            kept[wanted[index + 1]] = columns[:, :, begin:end]
            begin = end
        for each, block in kept.items():
            self._kept[each].update(zip(unknown, block, strict=True))

    def _columns(self, model: Fit, like: Runs, flights: Sequence[NextFlight], case: Case) -> Array:
        """Return derivatives by θ and effects, initial rates projected out, shape (F, S, C)."""
        flown = [self.space.flown_in(case, flight) for flight in flights]
        blank = blank_runs(flown, case.runs(like), case.platform(self.space.platform))
        columns = forecast_columns(case.model(model), flown, blank)
        common = _INERTIA + sum(values.shape[1] for values in model.values.effects)
        return free_of(columns[..., common:], columns[..., :common])


def _gram(blocks: Sequence[Array]) -> Array:
    columns = np.concatenate(blocks, axis=1)
    return np.asarray(columns.T @ columns)


def _typical(runs: Runs) -> Runs:
    """Return one flight, with the noise of all of them, rounded."""
    sigma = np.sqrt(np.mean(runs.sigma**2, axis=0))
    rounded = [float(f"{each:.{_NOISE_DIGITS - 1}e}") for each in sigma]
    return chosen_runs(runs, [0]).with_sigma(np.array([rounded]))


def _rounded(theta: Array) -> Array:
    """Return inertia parameters, shape (1, 6), on steps that are round numbers: they stay while J moves a little."""
    step = INERTIA_STEP * float(np.mean(theta[0, :3]))
    step = float(f"{step:.0e}")
    return np.asarray(np.round(theta / step) * step)
