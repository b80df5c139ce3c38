"""How large an effect has to be to be seen, and effects made to be of a wanted size."""

from __future__ import annotations

from dataclasses import replace

from concealing.case import Case
from concealing.effect import HiddenEffect
from concealing.guidance import software_of
from concealing.library import KINDS, LISTED
from concealing.power import NOISES, degrees_of, detectable_norm, noise_sized, searched
from concealing.signature import signal


def hypotheses(actuation: str) -> int:
    """Return how many effects, each in each of its components, a diagnosis has to tell apart."""
    return sum(len(kind.components) for kind in LISTED.values() if actuation in kind.actuation)


def detectable(case: Case, hidden: HiddenEffect) -> float:
    """Return the norm at which an effect is of its smallest detectable size."""
    return detectable_norm(degrees_of(KINDS[hidden.effect], hidden), hypotheses(case.actuation))


def sized(case: Case, hidden: HiddenEffect, target: float) -> tuple[HiddenEffect, float]:
    """Return an effect of such a size that its signature alone has a norm, within a tenth, and that norm.

    Args:
        case: to put it in, without any effect.
        hidden: of a typical size.
        target: in sigma.

    Raises:
        UnreachableError: none was found that shows as much.
    """
    if hidden.effect in NOISES:
        samples = sum(run.duration * case.telemetry.gyro_rate for run in case.runs)
        return noise_sized(hidden, target, samples, software_of(case.scenario).sensors.gyro_noise), target
    return searched(KINDS[hidden.effect], hidden, target, lambda tried: signal(replace(case, effects=(tried,))))
