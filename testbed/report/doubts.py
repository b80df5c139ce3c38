"""What puts an estimate in doubt, in sentences: each with its number, and with what to try."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.gate import ratios_apart
from testbed.dynamics.environment import Pivoted
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.estimation.agreement import REFUSED, Agreement
from testbed.estimation.answer import Answer
from testbed.estimation.body import is_body
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate
from testbed.estimation.residual_check import ResidualCheck
from testbed.estimation.telemetry_noise import Attenuation
from testbed.experiment.checking import Compared, NeglectedTorque
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.report.verdict import BIASED, leading_estimator
from testbed.report.wording import BAND, capitalized, chance_words, estimator_name, figures, figures_to, listed

DIAGNOSE = "try `testbed diagnose` on these records"
_TRIM = (
    'try estimation.constant_torque = "body" first, as a trim of motors or jets, or a leak, is a constant torque and '
    f"is not estimated; then {DIAGNOSE}"
)
_WHERE = {"body": "in the body", "inertial": "in inertial axes"}
_MOST_ATTENUATED = 0.5
"""Standard deviations by which noise of the actuators' telemetry may bias an inertia: a 95 % interval then covers
92 %."""
_UNDERSTATED = 1.1
"""The same ratio above which it is more than a stated noise may be off by, `gyro.noise_uncertainty`. What is missing in
a model and makes less is not white, which is tested by itself."""
_OVERSTATED = 0.7
"""Root mean square of a residual over the stated noise below which that is too large: three times the 10 % by which the
noise of a gyro may be off (gyro.noise_uncertainty)."""
_FAR = 1.0
"""Standard deviations between an estimate and the nearest body's inertia from which it is reported:
below it the difference is within what noise makes."""


def estimation_doubts(estimation: Estimation, records: int = 1) -> Iterator[str]:
    """Yield what puts the estimates of one record in doubt; nothing where all is as it should be.

    Args:
        estimation: of the record.
        records: that are tested alike: of each, chance has to be as many times rarer for all of them together to be
            called into doubt as rarely as one (Bonferroni).
    """
    checks = estimation.checks
    if checks is not None:
        trim, refused = any(each.frame == "body" for each in checks.neglected), REFUSED / records
        advice = _TRIM if trim else DIAGNOSE
        yield from _residual_doubts(checks.residual, estimator_name(checks.best), advice, refused)
        yield from _comparison_doubts(checks.compared, refused)
        yield from _attenuation_doubts(checks.attenuation, estimator_name(checks.best))
    yield from _body_doubts(estimation.by_name)


def _attenuation_doubts(found: Attenuation, estimator: str) -> Iterator[str]:
    if found.in_std > _MOST_ATTENUATED:
        axis = ", ".join(figures(each, 2) for each in found.axis_B)
        yield (
            f"Noise of the actuators' telemetry is {100.0 * found.share:.0f} % of the motion's variance about the axis "
            f"({axis}): {estimator} takes the inertia about it for larger, by about {figures(found.in_std, 2)} of its "
            "standard deviations, and its intervals do not hold there. Turn the platform more about that axis."
        )


def combination_doubts(combined: CombinedEstimation) -> Iterator[str]:
    """Yield notices on a combined estimate: records or estimators that disagree, an inertia that no body has."""
    for name, agreement in combined.runs_agreement.items():
        # Least squares are biased by the gyro's noise, in each record otherwise, where others are not.
        if agreement.refused and (name != BIASED or len(combined.runs_agreement) == 1):
            yield (
                f"The records differ from each other by more than their uncertainty ({estimator_name(name)}: "
                f"{_chi_square(agreement)}); their spread is in the stated uncertainty. Something is missing in the "
                f"model, or differs between the runs: {DIAGNOSE}."
            )
    if combined.runs > 1:
        yield from _comparison_doubts(combined.compared, REFUSED)
        yield from _body_doubts(combined.by_name)


def other_body_doubts(by_name: Mapping[str, CombinedEstimate], nominal: Theta) -> Iterator[str]:
    """Yield that an inertia is far from the nominal one, as `testbed diagnose` refuses it.

    Args:
        by_name: of all records together; the leading one is compared.
        nominal: θ of the nominal model, kg·m².
    """
    best = leading_estimator(by_name)
    ratios = [*ratios_apart(by_name[best].theta, by_name[best].total_covariance, nominal)]
    for side, factors in {
        "smaller": [1.0 / ratio for ratio in ratios if 0.0 < ratio < 1.0],
        "larger": [ratio for ratio in ratios if ratio > 1.0],
    }.items():
        if factors:
            yield (
                f"The inertia that {estimator_name(best)} estimates is {' to '.join(_ends(factors))} times {side} than "
                f"the nominal one about {_AXES[len(factors)]}: probably another body, or gyro, torques or actuators in "
                "other units; check the scenario's inertia and the units of the records."
            )


def _ends(values: Sequence[float]) -> list[str]:
    return [*dict.fromkeys((figures(min(values)), figures(max(values))))]


_AXES = {1: "one axis", 2: "two axes", 3: "every axis"}
_MICRO = 1e6


def neglected_words(neglected: NeglectedTorque) -> str:
    """Return what a constant torque that is not estimated would do."""
    where, size = _WHERE[neglected.frame], figures(neglected.size, 2)
    return (
        f"Neglected: a constant torque fixed {where}. {size} N·m of it would move {neglected.parameter} by one "
        "standard deviation; estimation.constant_torque estimates it jointly."
    )


def torque_words(estimate: Estimate) -> Iterator[str]:
    """Yield the constant torques that were estimated jointly, a sentence for each frame."""
    rows = zip(estimate.torque_names, estimate.constant_torque, estimate.constant_torque_std, strict=True)
    for frame, components in groupby(rows, key=lambda row: row[0].partition("_")[0]):
        listing = ", ".join(f"{figures(value, 2)} ± {figures(std, 2)}" for _, value, std in components)
        yield f"Constant torque fixed {_WHERE[frame]}, estimated jointly: {listing} N·m about x, y, z."


def offset_words(estimate: Answer, pivot: Pivoted | None) -> Iterator[str]:
    """Yield where on a pivot the centre of mass was found, with one standard deviation."""
    if pivot is None:
        return
    pairs = zip(pivot.offset_B + estimate.offset_error, estimate.offset_std, strict=True)
    listing = ", ".join(
        f"{figures_to(_MICRO * value, _MICRO * std)} ± {figures(_MICRO * std, 2)}" for value, std in pairs
    )
    yield f"Centre of mass, from the pivot, estimated jointly: {listing} µm along x, y, z."


def offset_interval_words(estimate: Answer, pivot: Pivoted) -> str:
    """Return the intervals that hold the centre of mass on a pivot with 95 %."""
    offset, stds = _MICRO * (pivot.offset_B + estimate.offset_error), _MICRO * estimate.offset_std
    triples = zip(offset - BAND * stds, offset + BAND * stds, stds, strict=True)
    listing = listed(f"{figures_to(low, std)} to {figures_to(high, std)}" for low, high, std in triples)
    return f"With 95 % it lies within {listing} µm."


def _residual_doubts(check: ResidualCheck, best: str, advice: str, refused: float) -> Iterator[str]:
    if check.size_p_value < refused and check.size > _UNDERSTATED:
        yield (
            f"The residual of {best} is {figures(check.size, 3)} times the gyro's noise "
            f"({chance_words(check.size_p_value)}): something is missing in the model, or the noise is larger than "
            f"stated; {advice}."
        )
    if check.size < _OVERSTATED:
        reason = (
            "that is stated too large, and with it all standard deviations; correct gyro.noise_rad_s, or "
            "gyro_noise_rad_s beside the record"
            if check.noise_is_stated
            else "the samples' differences show more than noise; state it, as gyro_noise_rad_s beside the record"
        )
        yield f"The residual of {best} is {figures(check.size, 2)} times the gyro's noise: {reason}."
    if check.whiteness_p_value < refused:
        yield (
            f"The residual of {best} is not white ({chance_words(check.whiteness_p_value)}): what is missing in the "
            f"model moves the platform, or the gyro's noise is correlated in time; {advice}."
        )


def _comparison_doubts(compared: Compared | None, refused: float) -> Iterator[str]:
    if compared is not None and compared.agreement.p_value < refused:
        efficient, robust = estimator_name(compared.efficient), estimator_name(compared.robust)
        yield (
            f"{capitalized(efficient)} and {robust} differ by more than noise makes them "
            f"({_chi_square(compared.agreement)}); their difference is in the stated uncertainty. What one of them "
            f"assumes does not hold: {DIAGNOSE}."
        )


def _body_doubts(by_name: Mapping[str, Estimate] | Mapping[str, CombinedEstimate]) -> Iterator[str]:
    for name, estimate in by_name.items():
        if is_body(estimate.theta):
            continue
        apart = np.abs(estimate.theta - estimate.body_theta) / estimate.std
        worst = int(np.argmax(apart))
        if apart[worst] > _FAR:
            yield (
                f"No body has the inertia that {estimator_name(name)} estimates; the nearest one that a body has is "
                f"{figures(apart[worst], 2)} standard deviations off in {PARAMETER_NAMES[worst]}. The motion "
                "identifies it poorly, or something is missing in the model."
            )


def _chi_square(agreement: Agreement) -> str:
    return f"chi-square {figures(agreement.chi_square, 3)} of {agreement.freedom}, {chance_words(agreement.p_value)}"
