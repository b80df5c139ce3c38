"""What the paper does not say, and how it was settled."""

from __future__ import annotations

from testbed.report.frame.blocks import Column, Section, Table
from testbed.report.reproduction.rows import text_rows

_SETTLED = (
    (
        "Which condition number Table 1 lists",
        "That of Ψ_f, not of Ψ_fᵀΨ_f: only so it agrees with the trace and the smallest eigenvalue beside it.",
    ),
    (
        "Sample rate of the designs and simulations",
        "16 Hz, as in section 5.2: with it the columns of Table 1 and the deviations of Table 2 come out together.",
    ),
    (
        "The basic profile (figure 1 is a picture)",
        "Reconstructed by a search for a smooth profile, rest to rest over 5 s, with Table 1's row; shipped as control "
        "points. Its x and y axes may be exchanged, as J11 = J22.",
    ),
    (
        "Which maneuver the D-opt flights follow",
        "The D-optimal design within eq. (31); the cluster's gimbals cannot give all the torque that the box of eq. "
        "(31) allows, so it is flown saturated. The estimators use the motion as flown.",
    ),
    (
        "Geometry, rotors and servos of the cluster",
        "Six units on a pyramid of 63.9°, rotors of 4.7e-3 N·m·s, gimbals of at most 2 rad/s: a cluster that has the "
        "paper's limits.",
    ),
    (
        "The momentum that enters the equations",
        "h = Σ (Js Ω s + (Jg + Jt) ḋ g), and J as a function of the gimbal angles: without them 3e-5 kg·m² are "
        "missing.",
    ),
    (
        "The start of a truncated record",
        "The momentum at the first sample is estimated with the inertia; Table 3 shows what the other treatments do.",
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
