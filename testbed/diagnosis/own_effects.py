"""Whether effects from outside the library keep the contract where the runs at hand are predicted with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, Hypothesis, evaluated
from testbed.effects.checking import blamed_on_own, is_own
from testbed.errors import InputError, OwnEffectError
from testbed.prediction.integration import Values

_SHOWN = 0.01
"""Standard deviations of a sample that an effect moves it by at most where it is absent: no test sees a hundredth."""
_STEP = 1e-3
"""Of a parameter's typical size, half of a central difference: its square is what that errs by."""
_OFF = 0.02
"""Share of a derivative by which a central difference may miss it.

Source: chosen; hooks without `abs`, comparisons or `real` agree to 1e-5; what breaks the step is off by more."""


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
    samples = len(fit.residual) - fit.believed
    away = np.abs(added.residual[:samples] - fit.residual[:samples]).max()
    if not (np.isfinite(away) and np.isfinite(added.jacobian).all()):
        raise _refused(placed, "what it predicts where it is absent is no number")
    if away > _SHOWN:
        raise _refused(
            placed,
            f"where its parameters are {starts[0].tolist()}, and it should be absent, it moves a sample by "
            f"{away:.3g} standard deviations",
        )
    for index, parameter in enumerate(placed.effect.parameters):
        if not parameter.scanned:
            _require_analytic(runs, fit, placed, starts[0], index)


def _require_analytic(runs: Runs, fit: Fit, placed: Hypothesis, start: Array, index: int) -> None:
    """Refuse an effect whose derivative by a parameter, at its typical size, is not that of its prediction."""
    parameter = placed.effect.parameters[index]
    step = _STEP * abs(parameter.typical - parameter.absent)
    typical = np.array(start)
    typical[index] = parameter.typical
    above, below = typical.copy(), typical.copy()
    above[index] += step
    below[index] -= step
    try:
        stated, *ends = (evaluated(runs, (*fit.placed, placed), _with(fit, at)) for at in (typical, above, below))
    except (InputError, np.linalg.LinAlgError):
        return  # of its typical size it makes the motion run away, which says nothing of its hooks
    samples = len(fit.residual) - fit.believed
    column = stated.jacobian[:samples, 6 + len(fit.effect_values) + index]
    found = (ends[1].residual - ends[0].residual)[:samples] / (2.0 * step)  # measured less predicted
    missed = float(np.linalg.norm(found - column))
    if missed > _OFF * max(float(np.linalg.norm(found)), float(np.linalg.norm(column))):
        raise _refused(
            placed,
            f"its derivative by {parameter.name} is not that of its prediction: hooks are analytic in their values, "
            "without abs, comparisons, real or conjugate of anything that depends on them",
        )


def _with(fit: Fit, values: Array) -> Values:
    return replace(fit.values, effects=(*fit.values.effects, np.asarray(values, dtype=float)[None]))


def _refused(placed: Hypothesis, why: str) -> OwnEffectError:
    return OwnEffectError(
        f"{placed.key}: this effect cannot be predicted: {why}; docs/effects.md says what hooks take and return"
    )
