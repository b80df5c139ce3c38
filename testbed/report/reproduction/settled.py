"""What the paper does not say, and how it was settled."""

from __future__ import annotations

from testbed.report.frame.blocks import Column, Section, Table
from testbed.report.reproduction.rows import text_rows

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
        "Searched for: smooth, rest to rest over 5 s, with Table 1's row and a scatter near Table 2's; shipped as "
        "control points. J11 = J22, so x and y may be exchanged.",
    ),
    (
        "How the D-opt maneuver was parametrised",
        "Penalties of eqs. (27) to (29), one start from the basic profile, |ω| up to 0.3 rad/s. Table 1's row asks for "
        "fewer control points an axis than Table 2's; the fewest that meet Table 2 are shipped.",
    ),
    (
        "Details of the instrumental variable",
        "The reference as instrument, rest at the start known, products filtered on a finer grid. Instrument and grid "
        "move no deviation; an estimated start makes them 1.1 times, the first noisy sample 1.6 times as large.",
    ),
    (
        "Why the paper's means are off",
        "Its estimator is consistent, not unbiased: over 81 samples the regressor's noise, squared, makes the moments "
        "of inertia 0.3 to 0.8 % too large from the basic profile. The paper's means err to the same side.",
    ),
    (
        "Geometry, rotors and servos of the cluster",
        "Six units on a pyramid of 63.9°, rotors of 4.7e-3 N·m·s, gimbals of at most 2 rad/s: a cluster that has the "
        "limits of eq. (31).",
    ),
    (
        "The momentum in the equations",
        "h = Σ (Js Ω s + (Jg + Jt) ḋ g), and J that follows the gimbal angles: without them 3e-5 kg·m² are missing.",
    ),
    (
        "The start of a truncated record",
        "The momentum at the first sample is estimated with the inertia; the section on Table 3 shows what other "
        "treatments do.",
    ),
    ("Where a zero-g record ends", "At the first contact, found in the record itself."),
    ("Figure 4", "A photograph in the paper; here the platform as it is simulated."),
)


def settled_section() -> Section:
    """Return the choices that the paper leaves open."""
    columns = (Column(title="Not in the paper"), Column(title="settled"))
    return Section(
        title="What the paper does not say", blocks=(Table(columns=columns, rows=text_rows(_SETTLED), numeric=False),)
    )
