"""Every run against the model without and with the effects, as page and recording show it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from testbed.arrays import Array, Series, Vectors3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import Fit
from testbed.diagnosis.scatter import added_variance
from testbed.diagnosis.state import Diagnosis


@dataclass(frozen=True, kw_only=True, eq=False)
class RunResiduals:
    """A run against the model without and with the effects.

    Attributes:
        name: of the run.
        held_out: whether it was not fitted.
        time: of the gyro's samples, shape (N,), s.
        measured: ω, shape (N, 3), rad/s.
        nominal: what the nominal model predicts of it, inertia and initial rates re-estimated, rad/s.
        extended: what the model with all effects predicts, rad/s.
        before: (measured - nominal) / σ, with the noise that is stated.
        after: (measured - extended) / σ, with the noise as the model has it.
    """

    name: str
    held_out: bool
    time: Series
    measured: Vectors3
    nominal: Vectors3
    extended: Vectors3
    before: Array
    after: Array


def residuals_of(diagnosis: Diagnosis) -> tuple[RunResiduals, ...]:
    """Return every run, put together from its windows, against both models, held-out ones last."""
    shown = list(_residuals(diagnosis, diagnosis.runs, (diagnosis.baseline, diagnosis.model), held_out=False))
    heldout = diagnosis.heldout
    if heldout is not None:
        before = fitted_initial_rates(_as_stated(diagnosis, heldout), diagnosis.baseline)
        after = fitted_initial_rates(heldout, diagnosis.model)
        shown += _residuals(diagnosis, heldout, (before, after), held_out=True)
    if not diagnosis.runs.windowed:
        return tuple(shown)
    return tuple(_together(list(windows)) for _, windows in groupby(shown, lambda run: run.name))


def _together(windows: Sequence[RunResiduals]) -> RunResiduals:
    def joined(series: Callable[[RunResiduals], Array]) -> Array:
        return np.concatenate([series(window) for window in windows])

    return replace(
        windows[0],
        time=joined(lambda window: window.time),
        measured=joined(lambda window: window.measured),
        nominal=joined(lambda window: window.nominal),
        extended=joined(lambda window: window.extended),
        before=joined(lambda window: window.before),
        after=joined(lambda window: window.after),
    )


def _as_stated(diagnosis: Diagnosis, runs: Runs) -> Runs:
    """Return runs with the noise that is stated: what was found to be more of it, and what is told, taken back."""
    return replace(runs.with_sigma(np.sqrt(runs.sigma**2 - added_variance(diagnosis.scatter))), told=())


def _residuals(diagnosis: Diagnosis, runs: Runs, fits: tuple[Fit, Fit], *, held_out: bool) -> Iterator[RunResiduals]:
    before, after = (runs.by_run(fit.residual) for fit in fits)
    stated = _as_stated(diagnosis, runs).sigma
    names = runs.windowed or runs.names
    for index, (name, run) in enumerate(zip(names, runs.grid.runs, strict=True)):
        yield RunResiduals(
            name=name,
            held_out=held_out,
            time=run.gyro_time,
            measured=run.body_rate,
            nominal=run.body_rate - stated[index] * before[index],
            extended=run.body_rate - runs.sigma[index] * after[index],
            before=before[index],
            after=after[index],
        )
