"""Flights to a verified name: chosen by expected gain, against the same maneuver again; false names without an effect.

python -m benchmarks.fly_until_sure --campaigns N --null M --seed S: each campaign flies in MuJoCo (zero_g.toml, one
start of its design) and hides one effect, of twice the smallest size that twenty flights of the scenario's own maneuver
would show; the same effect and noise are flown with chosen flights and with the own maneuver every time. A campaign
without an effect flies until something is named, or twenty flights.

Each campaign has a file of its own in --out (runs/fly-until-sure-S): what is there is kept, and an interrupted command
goes on where it was. --jobs fly side by side; the counts are of all that the folder has. --write keeps them in
docs/fly-until-sure.json, from where the command goes on as well.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from math import inf, log, sqrt
from pathlib import Path
from typing import Any, get_args

import numpy as np
from scipy.stats import beta

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.data import joined
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.signatures import required_shift
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.files import write_json
from testbed.library.plan_flights import Maneuvers
from testbed.library.plans import ALPHA, MOST_FLIGHTS
from testbed.sequential.evidence import Evidence, evidence_of

SIZES = 2.0
"""Times the smallest detectable size of `MOST_FLIGHTS` flights of the own maneuver, which is that of five flights."""
QUICK = {"maneuver.starts": 1, "estimation.initial_momentum": "estimated"}
KEPT = Path(__file__).resolve().parents[1] / "docs" / "fly-until-sure.json"
NULL_SEEDS = 10_000
"""By which seeds of campaigns without an effect lie above those of campaigns with one."""
HIDDEN = (
    *((f"gimbal_zero:cmg{unit}", "encoder.zero_rad", unit - 1, 6) for unit in range(1, 7)),
    *(("gyro_bias:gyro", "gyro.bias_rad_s", axis, 3) for axis in range(3)),
    *(("gyro_misalignment:gyro", "gyro.misalignment_rad", axis, 3) for axis in range(3)),
)
"""What can be hidden: hypothesis, key of the scenario, index and length of its list."""


@dataclass(frozen=True, kw_only=True)
class Order:
    """A campaign to fly.

    Attributes:
        name: of its file.
        key: of what is hidden; empty for nothing.
        size: of its parameter, SI.
        changes: of the scenario that hide it.
        maneuvers: chosen, or the own one.
        seed: of the noise.
    """

    name: str
    key: str
    size: float
    changes: dict[str, Any]
    maneuvers: Maneuvers
    seed: int


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """One campaign.

    Attributes:
        key: of what is hidden; empty for nothing.
        size: of its parameter, SI.
        maneuvers: chosen, or the own one.
        outcome: as plan.json states it.
        names: given at the end.
        flights: flown.
        largest: natural logarithm of the largest e-value after any flight.
        seconds: of processor time.
    """

    key: str
    size: float
    maneuvers: Maneuvers
    outcome: str
    names: list[str]
    flights: int
    largest: float
    seconds: float

    @property
    def until_right(self) -> float:
        """Flights to a name that holds what is hidden; infinite where none did."""
        return self.flights if self.key in self.names else inf

    @property
    def words(self) -> str:
        """What was hidden, and how it ended."""
        hidden = f"{self.key} {self.size:.2g}" if self.key else "nothing"
        names = " or ".join(self.names) or "-"
        return f"{hidden}, {self.maneuvers}: {self.outcome} {names} after {self.flights} flights, {self.seconds:.0f} s"


def own_flight() -> Evidence:
    """Return what one flight of the own maneuver without an effect shows."""
    scenario = tb.read_scenario("zero_g", QUICK)
    nominal = nominal_platform(scenario)
    data = data_set_of([tb.fly(scenario, seed=1).record], scenario, nominal)
    return evidence_of(joined(data.runs, data.heldout), EFFECTS, theta_of(nominal.inertia))


def hidden_size(evidence: Evidence, key: str, index: int) -> float:
    """Return `SIZES` smallest detectable sizes of one parameter of an effect, SI."""
    information = evidence.signatures[key].here.information
    own = index if len(information) > 1 else 0
    shift = required_shift(evidence.signatures[key].rank, len(evidence.by_key))
    return SIZES * shift / sqrt(MOST_FLIGHTS * information[own, own])


def orders(count: int, null: int, seed: int) -> Iterator[Order]:
    """Yield campaigns with an effect, each to be flown both ways, and those without.

    Those without have the same noise whatever `count` is.

    Args:
        count: of effects that are hidden.
        null: of campaigns without one.
        seed: of effects and noise.
    """
    evidence, rng = own_flight(), np.random.default_rng(seed)
    for number in range(count):
        key, name, index, length = HIDDEN[rng.integers(len(HIDDEN))]
        size = hidden_size(evidence, key, index)
        values = [size * (-1.0) ** number if each == index else 0.0 for each in range(length)]
        for maneuvers in get_args(Maneuvers):
            yield Order(
                name=f"effect_{number:04d}_{maneuvers}",
                key=key,
                size=size,
                changes={name: values},
                maneuvers=maneuvers,
                seed=seed + number,
            )
    for number in range(null):
        yield Order(
            name=f"null_{number:04d}", key="", size=0.0, changes={}, maneuvers="chosen", seed=seed + NULL_SEEDS + number
        )


def fly(order: Order, folder: Path) -> None:
    """Fly one campaign until something is named, or all flights are used up; keep how it ended."""
    file = folder / f"{order.name}.json"
    if file.exists():
        return
    began = time.process_time()
    scenario = tb.read_scenario("zero_g", QUICK | order.changes)
    plan = tb.plan(scenario, effect="any", maneuvers=order.maneuvers, seed=order.seed)
    flights = plan.result.flights
    campaign = Campaign(
        key=order.key,
        size=order.size,
        maneuvers=order.maneuvers,
        outcome=str(plan.outcome),
        names=list(plan.names),
        flights=len(flights),
        largest=max(flight.log_e_value for flight in flights),
        seconds=time.process_time() - began,
    )
    write_json(file, asdict(campaign))
    print(f"{order.name}: {campaign.words}", flush=True)


def rate(names: int, count: int) -> str:
    """Return a share with its exact 95 % interval (Clopper and Pearson)."""
    if not count:
        return "none flown"
    low = 0.0 if names == 0 else float(beta.ppf(0.025, names, count - names + 1))
    high = 1.0 if names == count else float(beta.ppf(0.975, names + 1, count - names))
    return f"{names} of {count} ({100 * low:.0f} to {100 * high:.0f} %)"


def counts(done: Sequence[Campaign]) -> Iterator[str]:
    """Yield what was counted, line by line."""
    hidden = [each for each in done if each.key]
    for maneuvers in get_args(Maneuvers):
        own = [each for each in hidden if each.maneuvers == maneuvers]
        wrong = [each for each in own if each.names and each.key not in each.names]
        if own:
            median = np.median([each.until_right for each in own])
            yield f"{maneuvers}: median {median:g} flights to the right name of {len(own)}, {len(wrong)} wrong names"
    null = [each for each in done if not each.key]
    passed = sum(each.largest >= -log(ALPHA) for each in null)
    yield f"names without an effect: {rate(sum(bool(each.names) for each in null), len(null))}"
    yield f"e-values above {1 / ALPHA:g} after any flight without an effect: {rate(passed, len(null))}"


def kept() -> dict[str, dict[str, Any]]:
    """Return the campaigns that are kept, by seed and name."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def restore(folder: Path, seed: int) -> None:
    """Write the files of campaigns of a seed that are kept and not in the folder."""
    for name, campaign in kept().get(str(seed), {}).items():
        if not (folder / f"{name}.json").exists():
            write_json(folder / f"{name}.json", campaign)


def keep(folder: Path, seed: int) -> None:
    """Keep the campaigns of a seed that are in the folder."""
    campaigns = {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))}
    write_json(KEPT, kept() | {str(seed): campaigns})


def main() -> None:
    parser = argparse.ArgumentParser(description="Count flights to a verified name.")
    parser.add_argument("--campaigns", type=int, default=200, help="with an effect, each flown both ways")
    parser.add_argument("--null", type=int, default=200, help="without an effect")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--jobs", type=int, default=2, help="campaigns side by side")
    parser.add_argument("--out", type=Path, help="folder of the campaigns")
    parser.add_argument("--write", action="store_true", help=f"keep them in docs/{KEPT.name}")
    wanted = parser.parse_args()
    folder = wanted.out or Path("runs") / f"fly-until-sure-{wanted.seed}"
    folder.mkdir(parents=True, exist_ok=True)
    restore(folder, wanted.seed)
    with ProcessPoolExecutor(wanted.jobs) as pool:
        for future in [pool.submit(fly, each, folder) for each in orders(wanted.campaigns, wanted.null, wanted.seed)]:
            future.result()
    if wanted.write:
        keep(folder, wanted.seed)
    done = [Campaign(**json.loads(file.read_text(encoding="utf-8"))) for file in sorted(folder.glob("*.json"))]
    print("\n".join(counts(done)))


if __name__ == "__main__":
    main()
