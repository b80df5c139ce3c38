"""The misfit beyond noise, in words: before, after, on fitted and held-out runs, and what share is explained."""

from __future__ import annotations

from math import isclose

from testbed.diagnosis.misfit import BANDWIDTH, Misfit, explained
from testbed.diagnosis.state import Gap

MEANING = (
    f"what a torque on the body or an error of the gyro, of any shape up to {BANDWIDTH:g} Hz, would explain of the "
    "gyro's samples beyond noise"
)
"""Of the misfit, for the reader."""
_WHOLE = 100.0
"""σ from which on tenths say nothing."""
_SAME = 1e-6
"""Share by which a gap differs when it is computed twice in the same noise."""
_FITTED, _HELD_OUT = "on the fitted runs", "on those held out"


def misfit_words(gap: Gap) -> str:
    """Return the misfit of a model."""
    return _by_role(_left(gap.misfit), _left(gap.heldout_misfit))


def limit_words(gap: Gap) -> str:
    """Return what noise alone would make."""
    roles = [(gap.misfit, _FITTED), (gap.heldout_misfit, _HELD_OUT)]
    limits = [f"{_figures(misfit.noise_limit)} σ {where}" for misfit, where in roles if misfit is not None]
    return f"in 99 of 100 data sets noise alone makes less than {' and '.join(limits)}"


def misfit_change_words(before: Gap, after: Gap) -> str:
    """Return the misfit before and after a change of the model, and what share of it is explained."""
    heldout = _change(before.heldout_misfit, after.heldout_misfit)
    return _by_role(_change(before.misfit, after.misfit), heldout)


def in_other_noise(one: Gap, other: Gap) -> bool:
    """Return whether the noise was re-estimated between two gaps of the same model."""
    return not isclose(one.fit, other.fit, rel_tol=_SAME)


def gimbals_words(before: Gap, after: Gap) -> str:
    """Return by how much the actuators' own channels are explained better; empty where there are none."""
    one, other = before.misfit, after.misfit
    if one is None or other is None or not one.gimbals:
        return ""
    return f"χ² of the actuators' own channels: {one.gimbals:.0f} -> {other.gimbals:.0f}"


def shows_in_gyro(gap: Gap) -> bool:
    """Return whether the gyro's samples show a misfit that is more than noise."""
    return any(each is not None and each.beyond_noise for each in (gap.misfit, gap.heldout_misfit))


def _by_role(fitted: str, heldout: str) -> str:
    return f"{fitted} {_FITTED}" + (f", {heldout} {_HELD_OUT}" if heldout else "")


def _left(misfit: Misfit | None) -> str:
    if misfit is None:
        return ""
    return f"{_figures(misfit.sigma)} σ" + ("" if misfit.beyond_noise else " (as much as noise alone makes)")


def _change(before: Misfit | None, after: Misfit | None) -> str:
    if before is None or after is None:
        return ""
    share = explained(before, after)
    change = (
        "no more than noise" if share is None else f"{100.0 * share.share:.0f} ± {100.0 * share.std:.0f} % explained"
    )
    return f"{_figures(before.sigma)} -> {_figures(after.sigma)} σ ({change})"


def _figures(sigma: float) -> str:
    return f"{sigma:.1f}" if sigma < _WHOLE else f"{sigma:.0f}"
