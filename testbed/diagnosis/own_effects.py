"""Whether effects from outside the library keep the contract where the runs at hand are predicted with them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, Hypothesis, evaluated
from testbed.effects.checking import blamed_on_own, is_own
from testbed.effects.contract import Parameter
from testbed.errors import InputError, OwnEffectError
from testbed.prediction.integration import Values
from testbed.prediction.prediction import common_size

_SHOWN = 0.01
"""Standard deviations of a sample that an effect moves it by at most where it is absent.

Source: chosen; no test sees a hundredth, and rounding is far below it."""
_STEP = 1e-5
"""Of a parameter's typical size, half of a central difference: small enough that hardly a sample changes its branch, as
where a gyro saturates, and large beside rounding.

Source: measured, with 1e-3 `gyro_saturation` of the library failed."""
_OFF = 0.02
"""Share of what the effect makes of a derivative by which a central difference may miss it.

Source: chosen; the library's 148 hypotheses in a set with gyros, one with applied torque and `mixed` pass, `abs` and
`real` are off by tens of percent."""
_ROUNDING = 1e-5
"""Share of a derivative that a central difference with this step may miss, the effect apart: rounding over the step."""


def require_kept(runs: Runs, fit: Fit, hypotheses: Sequence[Hypothesis]) -> None:
    """Refuse effects from outside the library that predict no numbers, act where they are absent, or are not analytic.

    Args:
        runs: that are predicted.
        fit: the model that the effects are added to.
        hypotheses: those that are tested, of the library too.

    Raises:
        OwnEffectError: names the effect and what is wrong.
    """
    for placed in hypotheses:
        if is_own(placed.effect):
            with blamed_on_own([placed.effect]):
                _require_kept(runs, fit, placed)


def _require_kept(runs: Runs, fit: Fit, placed: Hypothesis) -> None:
    starts = placed.effect.starts(placed.component, runs.grid)
    if not len(starts):
        return
    try:
        added = evaluated(runs, (*fit.placed, placed), _with(fit, starts[0]))
    except (InputError, np.linalg.LinAlgError) as error:
        raise _refused(placed, "what it predicts where it is absent is no number, or runs away") from error
    away = np.abs(added.measured - fit.measured).max()
    if not (np.isfinite(away) and np.isfinite(added.jacobian).all()):
        raise _refused(placed, "what it predicts where it is absent is no number")
    absent = [each.absent for each in placed.effect.parameters]
    if starts[0].tolist() == absent and away > _SHOWN:  # a scan starts where the effect may show already
        raise _refused(
            placed,
            f"where its parameters are {absent}, and it should be absent, it moves a sample by {away:.3g} standard "
            "deviations",
        )
    _require_analytic(runs, fit, placed, starts[0])


class _Move(NamedTuple):
    """A small change of some parameters: what it is by, the values on either side, and how far each column goes."""

    by: str
    above: Values
    below: Values
    columns: dict[int, float]


def _require_analytic(runs: Runs, fit: Fit, placed: Hypothesis, start: Array) -> None:
    """Refuse an effect with which derivatives are not those of the prediction, at its typical size.

    By each of its parameters, and by the inertia: what it makes of the motion has to be analytic as well.
    """
    typical = np.array([value if each.scanned else each.typical for each, value in _parameters(placed, start)])
    at, samples = partial(evaluated, runs, (*fit.placed, placed)), len(fit.measured)
    before = fit.jacobian[:samples, : common_size(fit.values.effects)]
    try:
        stated = at(_with(fit, typical)).jacobian[:samples]
        for move in _moves(fit, placed, typical):
            above, below = (at(each).measured for each in (move.above, move.below))
            found = 0.5 * (below - above)  # measured less predicted
            missed = float(np.linalg.norm(found - _along(stated, move)))
            added = float(np.linalg.norm(found - _along(before, move)))
            if missed > max(_OFF * added, _ROUNDING * float(np.linalg.norm(found))):
                raise _refused(
                    placed,
                    f"its derivative by {move.by} is not that of its prediction: hooks are analytic in all that they "
                    "take, without abs, comparisons, real or conjugate of it",
                )
    except (InputError, np.linalg.LinAlgError):
        return  # of its typical size it makes the motion run away, which says nothing of its hooks


def _moves(fit: Fit, placed: Hypothesis, typical: Array) -> Iterator[_Move]:
    for index, (each, _) in enumerate(_parameters(placed, typical)):
        if not each.scanned:
            step = np.zeros(len(typical))
            step[index] = _STEP * abs(each.typical - each.absent)
            around = _with(fit, typical + step), _with(fit, typical - step)
            yield _Move(each.name, *around, {common_size(fit.values.effects) + index: step[index]})
    at, step = _with(fit, typical), _STEP * fit.theta
    around = replace(at, theta=at.theta + step), replace(at, theta=at.theta - step)
    yield _Move("the inertia", *around, dict(enumerate(step)))


def _parameters(placed: Hypothesis, values: Array) -> Iterator[tuple[Parameter, float]]:
    return zip(placed.effect.parameters, values, strict=True)


def _along(jacobian: Array, move: _Move) -> Array:
    """Return what columns, of which the last ones may be missing, say of a move, shape (samples,)."""
    seen = {each: length for each, length in move.columns.items() if each < jacobian.shape[1]}
    return np.asarray(jacobian[:, list(seen)] @ np.array(list(seen.values())))


def _with(fit: Fit, values: Array) -> Values:
    return replace(fit.values, effects=(*fit.values.effects, np.asarray(values, dtype=float)[None]))


def _refused(placed: Hypothesis, why: str) -> OwnEffectError:
    return OwnEffectError(
        f"{placed.key}: this effect cannot be predicted: {why}; docs/effects.md says what hooks take and return"
    )
