"""What is known to make torques of a form, and the flight that would separate a formula from those like it.

A guess for people: data of one maneuver show a torque's form, and not what makes it.
"""

from __future__ import annotations

from collections.abc import Mapping

from testbed.formulas.law import Law
from testbed.formulas.motion import ATTITUDES, GIMBAL_RATES, GIMBALS, RATES, TIME, TORQUES
from testbed.formulas.pattern import Pattern

KNOWN_CAUSES: Mapping[str, str] = {
    "lag": "heat, a fluid or an eddy current that takes time to follow",
    "delay": "a transport delay, in a line or in a digital loop",
    "hysteresis": "dry friction with presliding, in a bearing or a cable",
    "actuator torque": "a motor, propeller or jet that gives another torque than in proportion, or along another axis",
    "gimbal rate": "a gyroscopic torque of a gimbal whose momentum or axis is not as drawn",
    "gimbal angle": "an unbalanced or misaligned gimbal, whose mass moves with its angle",
    "attitude": "gravity on a centre of mass beside the pivot, a cable to the surroundings, or a field outside",
    "size of the rate": "drag of air or of a fluid",
    "product of rates": "an inertia or alignment error of a moving part, or an inertia that grows with the rate",
    "rate": "drag, or a gyroscopic torque of a momentum that telemetry does not show",
    "wave": "an unbalanced rotor, a pump or a limit cycle",
    "pulse in one run": "a gust, a jet that fires, or a hand",
    "pulse": "a touch, a valve or a relay",
    "time": "a leak that grows or runs dry, or warming",
    "constant": "a leak, a jet or a field outside",
}
"""What is known to have a form; of several that a formula has, the first counts."""


def cause_of(pattern: Pattern) -> str:
    """Return a sentence on what is known to have such a form."""
    forms = _forms(pattern.laws[0])
    return f"Known to have this form: {next(made for form, made in KNOWN_CAUSES.items() if form in forms)}."


def _forms(law: Law) -> set[str]:
    arguments, functions = [factor.argument for factor in law.factors], {factor.function for factor in law.factors}
    rates = sum(each in (*RATES, "w") for each in arguments)
    timed = [factor.function for factor in law.factors if factor.argument == TIME]
    has = {
        law.memory: bool(law.memory),
        "actuator torque": any(each in TORQUES for each in arguments),
        "gimbal rate": any(each in GIMBAL_RATES for each in arguments),
        "gimbal angle": any(each in GIMBALS for each in arguments),
        "attitude": any(each in ATTITUDES for each in arguments),
        "size of the rate": bool(functions & {"norm", "abs"}),
        "product of rates": rates > 1,
        "rate": rates == 1,
        "wave": bool({"sin", "cos"} & set(timed)),
        "pulse in one run": "once" in functions,
        "pulse": "pulse" in timed,
        "time": "" in timed,
        "constant": not law.factors,
    }
    return {form for form, present in has.items() if present}


def separating_flight(pattern: Pattern) -> str:
    """Return the experiment that would separate it from formulas that the same data show."""
    law = pattern.laws[0]
    read = set(law.quantities)
    others = " and ".join(sorted({*RATES} - read)) or "each of the rates in turn"
    flights = (
        (not law.recurs, "The same maneuver again, in which what happened once does not come back."),
        (
            law.memory,
            "The same maneuver at half and at twice the pace: what has a memory falls behind by the same time.",
        ),
        (
            read & {*TORQUES},
            "The same motion at half and at twice the torque, and one with torque about a single axis.",
        ),
        (
            read & {*GIMBALS, *GIMBAL_RATES},
            "The same body motion with that gimbal held, the others doing its part: the torque is gone.",
        ),
        (
            pattern.placement == "N" or read & {*ATTITUDES},
            "The same maneuver from an attitude turned by a right angle: what is fixed in space changes its axis.",
        ),
        (
            read & {*RATES},
            f"A maneuver about other axes, with {others} alone, and the same one at half and at twice the rate.",
        ),
        (True, "The same maneuver begun later, and a longer one: what follows the clock does not follow the motion."),
    )
    return next(flight for separates, flight in flights if separates)
