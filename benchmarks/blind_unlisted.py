"""What can be known of the unlisted cases: python -m benchmarks.blind_unlisted OUT --seed N, beside `make blind`.

Every unlisted case of a blind set is flown again without any noise, and explained as well as one effect of the library
can explain it, inertia and initial rates re-estimated. What χ² is left, in the units of the noise that the case had, is
all by which the name could be seen to be wrong. An oracle that knows the very signature that is left, but for its
size, tests for it at 1 %, as the diagnosis tests the residual: its power is kept in OUT/unlisted.json, and
`make blind` shows it beside what the diagnosis said.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from math import sqrt
from pathlib import Path

import numpy as np
from scipy.stats import chi2, ncx2

from concealing.blind_set import Counts, case_of, orders
from concealing.case import Case
from concealing.files import record
from concealing.flown import fly_case, sensors_of
from concealing.order import Order, case_name
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.data import joined
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import screened
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.files import whole_file
from testbed.records.reading import read_data_set
from testbed.records.writing import write_record
from testbed.scenario.reader import read_scenario
from testbed.scoring.card import grouped
from testbed.scoring.case import Case as ScoredCase
from testbed.scoring.judging import recognised_as_unknown

SCENARIO = Path("scenarios/diagnose.toml")
BOUNDS = "unlisted.json"
_JOBS = 2


@dataclass(frozen=True, kw_only=True)
class Bound:
    """What of an unlisted case is left to be seen beside the best name.

    Attributes:
        case: its name.
        shown: norm of what the nominal model leaves, in sigma.
        best: the effect that takes most off it.
        left: norm of what it leaves, in sigma.
        power: of an oracle's test for that.
    """

    case: str
    shown: float
    best: str
    left: float
    power: float


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Unlisted cases of one kind and size together; norms and power are means.

    Attributes:
        effect: that is hidden.
        sigma: size that was wanted.
        of: cases.
        shown, left: norms of what the nominal model and the best name leave, in sigma.
        power: of the oracle's test.
        recognised: share of which the diagnosis said `unexplained`.
    """

    effect: str
    sigma: float
    of: int
    shown: float
    left: float
    power: float
    recognised: float


def kinds_of(cases: Sequence[ScoredCase], bounds: Mapping[str, Bound]) -> tuple[Kind, ...]:
    """Return what could be known of the unlisted cases, and what was said, by size and kind.

    Args:
        cases: with their diagnoses.
        bounds: by case; cases without one are left out.
    """
    known = [case for case in cases if case.name in bounds]
    return tuple(
        _kind(effect, sigma, [case for case in group if case.answer.effects[0].effect == effect], bounds)
        for sigma, group in grouped(known, "wanted_sigma")
        for effect in sorted({case.answer.effects[0].effect for case in group})
    )


def _kind(effect: str, sigma: float, cases: Sequence[ScoredCase], bounds: Mapping[str, Bound]) -> Kind:
    own = [bounds[case.name] for case in cases]
    return Kind(
        effect=effect,
        sigma=sigma,
        of=len(cases),
        shown=float(np.mean([each.shown for each in own])),
        left=float(np.mean([each.left for each in own])),
        power=float(np.mean([each.power for each in own])),
        recognised=float(np.mean([recognised_as_unknown(case) for case in cases])),
    )


def read_bounds(out: Path) -> dict[str, Bound]:
    """Return the bounds of a blind set's unlisted cases, by case; empty where they were not asked for."""
    path = out / BOUNDS
    found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    return {each["case"]: Bound(**each) for each in found}


def bound(order: Order, seed: int) -> Bound:
    """Return what an oracle could see of an unlisted case.

    Args:
        order: of the case.
        seed: of the set.
    """
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    with tempfile.TemporaryDirectory() as folder:
        _write_quiet(case_of(order, seed, SCENARIO), Path(folder))
        data = data_set_of(read_data_set(Path(folder)), scenario, nominal)
    runs = joined(data.runs, data.heldout)
    fit = fitted(runs, [], theta_of(nominal.inertia), [])
    screening = screened(runs, None, fit, hypotheses(runs, EFFECTS)[0])
    best = max(screening.candidates, key=lambda candidate: candidate.chi_square_reduction)
    left = best.fit.chi_square
    return Bound(
        case=case_name(order),
        shown=sqrt(fit.chi_square),
        best=best.placed.key,
        left=sqrt(left),
        power=float(ncx2.sf(chi2.isf(SETTINGS.unexplained_p_value, 1), 1, left)),
    )


def _write_quiet(case: Case, folder: Path) -> None:
    """Write the records of a case without noise, spikes or gaps, its noise stated as it would be."""
    whole = replace(case, telemetry=replace(case.telemetry, dropouts=0.0, outliers=0.0, stated_noise=1.0))
    flown = replace(fly_case(whole, quiet=True), sensors=sensors_of(whole))
    for index in range(len(whole.runs)):
        write_record(record(flown, index), folder / f"run_{index + 1}.csv")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, required=True, help="of the set")
    chosen = parser.parse_args()
    unlisted = [order for order in orders(Counts(), chosen.seed) if order.stratum == "unlisted"]
    with ProcessPoolExecutor(_JOBS) as pool:
        bounds = list(pool.map(bound, unlisted, [chosen.seed] * len(unlisted)))
    with whole_file(chosen.out / BOUNDS) as path:
        path.write_text(json.dumps([asdict(each) for each in bounds], indent=1) + "\n", encoding="utf-8")
    print(f"{len(bounds)} unlisted cases; an oracle would see {np.mean([each.power for each in bounds]):.0%} of them")


if __name__ == "__main__":
    main()
