"""What the paper does not state, and what is assumed."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.report.frame.blocks import Column, Section, Table
from testbed.report.reproduction.rows import text_rows
from testbed.reproduction.table2 import PAPER_MEAN, ManeuverStatistics
from testbed.reproduction.whiteness import Whiteness

_SETTLED = (
    (
        "Which condition number Table 1 lists",
        "That of Ψ_f. Were it that of Ψ_fᵀΨ_f, a smallest eigenvalue of 0.099 and 3.271 leave a determinant of at "
        "most 3.5e-4, a tenth of the table's.",
    ),
    (
        "The sample rate of designs and simulations",
        "16 Hz, that of the experiment. With it a profile that peaks at 0.2 rad/s has Table 1's row; Ψ_fᵀΨ_f is "
        "proportional to the rate, so other pairs of rate and peak would do as well.",
    ),
    (
        "The basic profile (figure 1 is a picture)",
        "Searched for: smooth, rest to rest over 5 s, such that it has Table 1's row, a scatter near Table 2's basic "
        "and scaled rows, and a small finite-sample bias; shipped as control points. So these three are fitted, and "
        "show only that one profile can have them all. J11 = J22, so x and y may be exchanged.",
    ),
    (
        "How the D-opt maneuver was parametrised",
        "Penalties of eqs. (27) to (29), one start from the basic profile, |ω| up to 0.3 rad/s. The number of control "
        "points, which the paper does not give, was chosen on the outcome: Table 1's row asks for fewer than Table "
        "2's, 9 missed Table 2 in one parameter, and 10 are shipped. With them the design is better than the "
        "paper's row of Table 1 in every figure but the condition number.",
    ),
    (
        "Details of the instrumental variable",
        "The reference as instrument, rest at the start known, products filtered on a finer grid. Instrument and grid "
        "move no deviation; an estimated start enlarges them a little, the first noisy sample in its place a lot.",
    ),
    (
        "Geometry, rotors and servos of the cluster",
        "Six units on a pyramid of 63.9°, rotors of 4.7e-3 N·m·s, gimbals of at most 2 rad/s: a cluster that has the "
        "limits of eq. (31).",
    ),
    (
        "The momentum in the equations",
        "h = Σ (Js Ω s + (Jg + Jt) ḋ g), and J that follows the gimbal angles: without them part of the units' inertia "
        "is missing.",
    ),
    (
        "The start of a truncated record",
        "The momentum at the first sample is estimated with the inertia; the section on Table 3 shows what other "
        "treatments do.",
    ),
    ("Where a zero-g record ends", "At the first contact, found in the record itself."),
    ("Figure 4", "A photograph in the paper; here the platform as it is simulated."),
)


def interpretation_section(maneuvers: Sequence[ManeuverStatistics], whiteness: Whiteness) -> Section:
    """Return the choices that the paper leaves open.

    Args:
        maneuvers: of Table 2, with the bias that theory predicts.
        whiteness: of the residual.
    """
    columns = (Column(title="Not in the paper"), Column(title="assumed"))
    rows = text_rows((*_SETTLED, _bias(maneuvers), _colour(whiteness)))
    return Section(title="What the paper does not say", blocks=(Table(columns=columns, rows=rows, numeric=False),))


def _bias(maneuvers: Sequence[ManeuverStatistics]) -> tuple[str, str]:
    basic = next(maneuver for maneuver in maneuvers if maneuver.name == "basic")
    biases = (basic.predicted_iv_bias, PAPER_MEAN["basic"] - basic.true_theta)
    predicted, paper = (bias[:3] / basic.true_theta[:3] for bias in biases)
    return (
        "Why the paper's means are off",
        "Its estimator is consistent, not unbiased: over 81 samples the regressor's noise, which is the equation's "
        f"too, makes the moments of inertia {predicted.min():.1%} to {predicted.max():.1%} too large from the basic "
        "profile, to second order in the noise. With more flights that stands out by any number of standard errors; it "
        "is judged less this prediction. The paper's means err to the same side, by "
        f"{paper.min():.1%} to {paper.max():.1%}.",
    )


def _colour(whiteness: Whiteness) -> tuple[str, str]:
    row = whiteness.paper_row
    return (
        "How white the residual becomes",
        "Not entirely: the prefilter passes gyro noise less its low frequencies, and the fit takes out those of the "
        f"motion. Chi-square of {whiteness.autocorrelation.shape[1]} lags over {whiteness.flights} flights: "
        f"{whiteness.white_chi_square[row]:.0f} from a white residual, {whiteness.fit_chi_square[row]:.0f} from the "
        f"residual of a fit to a white error, {whiteness.predicted_chi_square[row]:.1f} from what prefilter and fit "
        "make of a white gyro. So at the paper's γ the error is nearly white, which is what matters, and most of the "
        "residual's correlation is the fit's.",
    )
