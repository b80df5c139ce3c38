"""Torques by random formulas, hidden by the concealing engine: python -m benchmarks.formulas --sets N --seed S.

Each set has five runs of 5 s at 16 Hz of the shipped platform, whose torque follows a random law at 8 or 16 sigma, in
turns; with --null, sets without any effect. Every set is diagnosed with the whole library, and the formula that it
names is compared with the one that was hidden:

- class: the hidden formula, or the same law along a free direction, is named or indistinguishable from what is named;
- driver: the formula that is named is driven by the same quantities;
- exact: the formula that is named is the hidden one;
- covered: the 95 % interval of the coefficient along the hidden axis has the truth in it, of exact ones;
- held out: normalized residual of the held-out run after naming; noise alone is 1.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from concealing.case import Case, Run
from concealing.effect import HiddenEffect, Parameters, vector
from concealing.files import record
from concealing.flown import fly_case
from concealing.formula_effects import drawn_law
from concealing.guidance import pool
from concealing.power import UnreachableError
from concealing.sizing import sized
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.state import Diagnosis, Step
from testbed.dynamics.inertia import theta_of
from testbed.effects.formula import Formula
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.formulas.grammar import classes
from testbed.formulas.motion import ATTITUDES
from testbed.formulas.pattern import Pattern, pattern_of
from testbed.records.reading import read_data_set
from testbed.records.writing import write_record
from testbed.scenario.reader import read_scenario

SCENARIO = Path("scenarios/diagnose.toml")
SIGMAS = (8.0, 16.0)
_RUNS, _DURATION = 5, 5.0
_INTERVAL = 1.96
"""Standard errors to either side of a 95 % interval."""


@dataclass(frozen=True, kw_only=True)
class Scored:
    """What was said of a set.

    Attributes:
        sigma: of the signature that was wanted; 0 of a set without an effect.
        shown: that it has.
        hidden: formula; empty without an effect.
        verdict: of the diagnosis.
        named: all that was added.
        alike: what cannot be distinguished from the first formula.
        in_class, driver, exact: as the module says.
        covered: None where the formula is not exact.
        heldout: normalized residual of the held-out run, before and after.
        seconds: that the diagnosis took.
    """

    sigma: float
    shown: float
    hidden: str
    verdict: str
    named: tuple[str, ...]
    alike: tuple[str, ...] = ()
    in_class: bool = False
    driver: bool = False
    exact: bool = False
    covered: bool | None = None
    heldout: tuple[float, float]
    seconds: float


def text_of(law: Parameters) -> str:
    """Return a hidden law as the grammar writes it."""
    factors = ["t"] * int(law["clock"]) + ["norm(w)"] * int(law["length"])
    factors += [f"w_{axis}" for axis in "xyz" for _ in range(int(law[f"power_{axis}"]))]
    factors += [ATTITUDES[int(law["entry"]) - 1]] if law["entry"] else []
    product = "*".join(factors)
    if law["frequency"]:
        product = "sin(2*pi*f*t) + cos(2*pi*f*t)"
    along = vector(law, "coefficient")
    axes = np.flatnonzero(along)
    place = "in N" if law["in_space"] else "in B"
    if len(axes) == 1 and not law["in_space"]:
        place = f"about {'xyz'[axes[0]]}"
    return str(pattern_of(f"{product} {place}"))


def case_of(seed: int, index: int, sigma: float) -> tuple[Case, Parameters | None, float]:
    """Return a set with a formula hidden at a size, which is a function of seed and index; 0 hides nothing."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    while True:
        runs = tuple(
            Run(
                duration=_DURATION,
                maneuver=int(rng.integers(len(pool()))),
                planned_spin=tuple(np.round(0.15 * rng.standard_normal(3), 3).tolist()),
                release_error=tuple((0.01 * rng.standard_normal(3)).tolist()),
            )
            for _ in range(_RUNS)
        )
        errors = (*(6.6e-4 * rng.standard_normal(3)), *(2e-4 * rng.standard_normal(3)))
        case = Case(scenario=SCENARIO, seed=int(rng.integers(2**62)), runs=runs, theta_error=tuple(map(float, errors)))
        if sigma == 0.0:
            return case, None, 0.0
        typical = HiddenEffect(effect="formula_torque", component="platform", parameters=drawn_law(rng))
        try:
            hidden, shown = sized(case, typical, sigma)
        except UnreachableError:
            continue
        return replace(case, effects=(hidden,)), hidden.parameters, shown


def diagnosis_of(case: Case) -> Diagnosis:
    """Return the diagnosis of a set's records, of which it sees nothing else."""
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    with tempfile.TemporaryDirectory() as folder:
        flown = fly_case(case)
        for index in range(len(case.runs)):
            write_record(record(flown, index), Path(folder) / f"run_{index + 1}.csv")
        data = data_set_of(read_data_set(Path(folder)), scenario, nominal)
    found = diagnosed(data.runs, data.heldout, EFFECTS, theta_of(nominal.inertia), noise_effects=NOISE_EFFECTS)
    return list(found)[-1]


def scored(case: Case, law: Parameters | None, sigma: float, shown: float) -> Scored:
    """Return what a diagnosis says of a set, against what is hidden."""
    begun = time.perf_counter()
    state = diagnosis_of(case)
    facts: dict[str, Any] = {
        "sigma": sigma,
        "shown": shown,
        "hidden": "" if law is None else text_of(law),
        "verdict": state.verdict or "",
        "named": tuple(each.key for each in state.added),
        "heldout": (state.gap_before.heldout, state.gap.heldout),
        "seconds": time.perf_counter() - begun,
    }
    formulas = [step for step in state.steps if isinstance(step.effect, Formula)]
    if law is None or not formulas:
        return Scored(**facts)
    hidden = pattern_of(facts["hidden"])
    alike = [each.component for each in formulas[0].look_alikes]
    named = [step.component for step in formulas]
    meant = (
        {str(replace(hidden, placement=place)) for place in {hidden.placement, "B"}}
        if hidden.placement in "xyz"
        else {str(hidden)}
    )
    exact = next((step for step in formulas if step.component == str(hidden)), None)
    return Scored(
        **facts,
        alike=tuple(alike),
        in_class=bool(meant & {*named, *alike}),
        driver=any(_driver(pattern_of(each)) == _driver(hidden) for each in named),
        exact=exact is not None,
        covered=None if exact is None or law["frequency"] else _covered(exact, law),
    )


def _driver(pattern: Pattern) -> str:
    """Return the class of a formula whatever its memory and place."""
    bare = tuple(replace(law, memory="", memory_constant=None) for law in pattern.laws)
    return next((name for name, every in classes(6).items() if bare in every), "")


def _covered(step: Step, law: Parameters) -> bool:
    """Return whether the intervals of the coefficients have the truth in them, along the axis that is largest."""
    true = vector(law, "coefficient")
    values = step.candidate.fit.effect_values[step.candidate.fit.own(step.placed)]
    variance = np.diag(step.candidate.fit.covariance)[6:][step.candidate.fit.own(step.placed)]
    axis = int(np.abs(true).argmax())
    which = 0 if len(values) == 1 else axis
    return bool(abs(values[which] - true[axis]) <= _INTERVAL * np.sqrt(variance[which]))


def table(every: Sequence[Scored]) -> str:
    """Return the figures by size."""
    rows = ["| sigma | sets | in class | same driver | exact | covered | held out before | after | median s |"]
    rows.append("|---|---|---|---|---|---|---|---|---|")
    for sigma in sorted({each.sigma for each in every}):
        own = [each for each in every if each.sigma == sigma]
        covered = [each.covered for each in own if each.covered is not None]
        before, after = np.median([each.heldout for each in own], axis=0)
        counts = (sum(each.in_class for each in own), sum(each.driver for each in own), sum(each.exact for each in own))
        shown = " | ".join(str(count) for count in counts)
        rows.append(
            f"| {sigma:g} | {len(own)} | {shown} | {sum(covered)} of {len(covered)} | {before:.3f} | {after:.3f} "
            f"| {np.median([each.seconds for each in own]):.0f} |"
        )
    return "\n".join(rows)


def main() -> None:
    """Read the command line, diagnose the sets one after the other, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=10, help="with a formula, 8 and 16 sigma in turns")
    parser.add_argument("--null", type=int, default=0, help="without any effect")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, help="file for what was said of every set")
    options = parser.parse_args()
    every: list[Scored] = []
    wanted = [SIGMAS[index % len(SIGMAS)] for index in range(options.sets)] + [0.0] * options.null
    for index, sigma in enumerate(wanted):
        case, law, shown = case_of(options.seed, index, sigma)
        every.append(scored(case, law, sigma, shown))
        print(f"{index + 1} of {len(wanted)}: {every[-1]}", flush=True)
        if options.out is not None:
            options.out.write_text(json.dumps([asdict(each) for each in every], indent=1) + "\n", encoding="utf-8")
    print(table(every))


if __name__ == "__main__":
    main()
