"""Is the misfit zero where nothing is missing, and is what goes with an effect gone? python -m benchmarks.misfit.

The concealing engine hides an effect, or none, in sets of five runs of several seconds. Each is fitted by the nominal
model, and by the one that has the hidden effect at its component: no search, and no screening, so that what is
measured is the misfit and not the diagnosis. Without an effect the excess χ² over its standard deviation has the mean 0
and the standard deviation 1, on fitted and on held-out runs.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from concealing.asked import asked_case
from concealing.files import conceal
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.misfit import Misfit, explained
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import screened
from testbed.diagnosis.search import gap_of
from testbed.diagnosis.state import Gap
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario
from testbed.scoring.case import ANSWER
from testbed.scoring.formats import AnswerFile

SCENARIO = Path("scenarios/diagnose.toml")
SEED, SEEDS, NULL_SEEDS, RUNS = 900, 4, 40, 5
HIDDEN = (
    ("rotor_speed", 2.0),
    ("rotor_speed", 6.0),
    ("gyro_latency", 6.0),
    ("viscous_drag", 6.0),
    ("body_torque", 6.0),
    ("gimbal_zero", 6.0),
    ("flexible_appendage", 6.0),
    ("contact", 6.0),
    ("gimbal_viscous_friction", 6.0),
    ("gimbal_lag", 6.0),
)
"""Effects, and their size in smallest detectable sizes; the last two show in the gimbals' own channels alone."""


@dataclass(frozen=True, kw_only=True)
class HiddenSet:
    """One data set.

    Attributes:
        before: what the nominal model leaves, its inertia fitted.
        after: what the model with the hidden effect leaves; the same where nothing is hidden.
        signature: length of what was hidden, as the concealing engine has it, in sigma; of all its runs.
    """

    before: Gap
    after: Gap
    signature: float


def with_hidden(effect: str | None, size: float | None, seed: int) -> HiddenSet:
    """Hide an effect, or none, and return what a model without it and one with it leave.

    Args:
        effect: its id; None for none.
        size: in smallest detectable sizes.
        seed: of everything.
    """
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    case = asked_case(np.random.default_rng(seed), SCENARIO, () if effect is None else (effect,), size, RUNS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        conceal(case, folder / "data", folder / "answer")
        answer = AnswerFile.model_validate_json((folder / "answer" / ANSWER).read_bytes())
        data = data_set_of(read_data_set(folder / "data"), scenario, nominal)
    baseline = fitted(data.runs, [], theta_of(nominal.inertia), [])
    before = after = gap_of(data.runs, baseline, data.heldout)
    for hidden in answer.effects:
        testable, _ = hypotheses(data.runs, {hidden.effect: EFFECTS[hidden.effect]})
        placed = [each for each in testable if each.component == hidden.component]
        (candidate,) = screened(data.runs, data.heldout, baseline, placed).candidates
        after = gap_of(data.runs, candidate.fit, data.heldout)
    return HiddenSet(before=before, after=after, signature=float(answer.notes.get("sigma", 0.0)))


def null_row(what: str, misfits: Sequence[Misfit]) -> str:
    """Return a row on sets in which nothing is hidden."""
    standing = np.array([(each.chi_square - each.expected) / np.sqrt(each.variance) for each in misfits])
    beyond = sum(each.beyond_noise for each in misfits)
    cells = (
        what,
        f"{len(misfits)}",
        f"{standing.mean():+.2f} ± {standing.std(ddof=1) / np.sqrt(len(standing)):.2f}",
        f"{standing.std(ddof=1):.2f}",
        f"{np.median([each.sigma for each in misfits]):.1f}",
        f"{np.median([each.noise_limit for each in misfits]):.1f}",
        f"{beyond}",
    )
    return _row(cells)


def effect_row(effect: str, size: float, sets: Sequence[HiddenSet]) -> str:
    """Return a row on sets in which an effect is hidden; medians over them."""
    fit = [(each.before.misfit, each.after.misfit) for each in sets]
    heldout = [(each.before.heldout_misfit, each.after.heldout_misfit) for each in sets]
    gimbals = [before.gimbals - after.gimbals for before, after in fit if before and after]
    cells = (
        f"`{effect}`, {size:g}",
        f"{np.median([each.signature for each in sets]):.1f}",
        *_both(fit),
        *_both(heldout),
        f"{np.median(gimbals):.0f}",
        f"{np.median([each.before.fit for each in sets]):.3f} -> {np.median([each.after.fit for each in sets]):.3f}",
    )
    return _row(cells)


def _both(pairs: Sequence[tuple[Misfit | None, Misfit | None]]) -> Iterator[str]:
    """Yield the misfit before and after, and what share is explained where it was more than noise."""
    sigma = [(before.sigma, after.sigma) for before, after in pairs if before and after]
    before, after = np.median(sigma, axis=0)
    yield f"{before:.1f} -> {after:.1f}"
    shares = [share.share for each in pairs if (share := explained(*each)) is not None]
    yield f"{np.median(shares):.0%} (of {len(shares)})" if shares else "no share"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the misfit on data sets with an effect and without one.")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="of each effect")
    parser.add_argument("--null-seeds", type=int, default=NULL_SEEDS, help="without an effect")
    chosen = parser.parse_args()
    null = [with_hidden(None, None, SEED + number) for number in range(chosen.null_seeds)]
    print(
        "| nothing hidden | sets | excess χ² / its std | scatter of that | median misfit, σ | noise limit, σ | beyond |"
    )
    print("|---|---|---|---|---|---|---|")
    print(null_row("fitted", [each.before.misfit for each in null if each.before.misfit]))
    print(null_row("held out", [each.before.heldout_misfit for each in null if each.before.heldout_misfit]), flush=True)
    print(
        "\n| hidden, detectable sizes | signature, σ | misfit fitted, σ | explained | held out, σ | explained | ",
        end="",
    )
    print("χ² of the gimbals falls by | gap |\n|---|---|---|---|---|---|---|---|", flush=True)
    for number, (effect, size) in enumerate(HIDDEN, start=1):
        sets = [with_hidden(effect, size, SEED + 100 * number + each) for each in range(chosen.seeds)]
        print(effect_row(effect, size, sets), flush=True)


if __name__ == "__main__":
    main()
