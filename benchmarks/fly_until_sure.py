"""Flights to a verified name: chosen by expected gain, against the same maneuver again; false names without an effect.

python -m benchmarks.fly_until_sure --campaigns N --null M --seed S: each campaign flies in MuJoCo (zero_g.toml, one
start of its design) and hides one effect, of twice the smallest size that twenty flights of the scenario's own maneuver
would show; the same effect and noise are flown with chosen flights and with the own maneuver every time. A campaign
without an effect flies until something is named, or twenty flights.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from scipy.stats import beta

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.data import joined
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.signatures import required_shift
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.library.plan_flights import Maneuvers
from testbed.library.plans import MOST_FLIGHTS, FlightPlan
from testbed.sequential.evidence import Evidence, evidence_of

SIZES = 2.0
"""Times the smallest detectable size of `MOST_FLIGHTS` flights of the own maneuver, which is that of five flights."""
QUICK = {"maneuver.starts": 1, "estimation.initial_momentum": "estimated"}
HIDDEN = (
    *((f"gimbal_zero:cmg{unit}", "encoder.zero_rad", unit - 1, 6) for unit in range(1, 7)),
    *(("gyro_bias:gyro", "gyro.bias_rad_s", axis, 3) for axis in range(3)),
    *(("gyro_misalignment:gyro", "gyro.misalignment_rad", axis, 3) for axis in range(3)),
)
"""What can be hidden: hypothesis, key of the scenario, index and length of its list."""


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """One campaign.

    Attributes:
        key: of what is hidden; empty for nothing.
        size: of its parameter, SI.
        maneuvers: chosen, or the own one.
        plan: how it ended.
        seconds: of processor time.
    """

    key: str
    size: float
    maneuvers: Maneuvers
    plan: FlightPlan
    seconds: float

    @property
    def flights(self) -> float:
        """Flights to a name that holds what is hidden; infinite where none did."""
        return len(self.plan.result.flights) if self.key in self.plan.names else inf


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


def campaigns(count: int, null: int, seed: int) -> Iterator[Campaign]:
    """Yield campaigns with an effect, each flown both ways, and those without.

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
        for maneuvers in ("chosen", "own"):
            yield flown({name: values}, key, size, maneuvers, seed + number)
    for number in range(null):
        yield flown({}, "", 0.0, "chosen", seed + count + number)


def flown(hidden: dict[str, object], key: str, size: float, maneuvers: Maneuvers, seed: int) -> Campaign:
    """Fly one campaign until something is named, or all flights are used up."""
    began = time.process_time()
    scenario = tb.read_scenario("zero_g", QUICK | hidden)
    plan = tb.plan(scenario, effect="any", maneuvers=maneuvers, seed=seed)
    return Campaign(key=key, size=size, maneuvers=maneuvers, plan=plan, seconds=time.process_time() - began)


def false_rate(names: int, count: int) -> str:
    """Return a share with its exact 95 % interval (Clopper and Pearson)."""
    if not count:
        return "none flown"
    low = 0.0 if names == 0 else float(beta.ppf(0.025, names, count - names + 1))
    high = 1.0 if names == count else float(beta.ppf(0.975, names + 1, count - names))
    return f"{names} of {count} ({100 * low:.0f} to {100 * high:.0f} %)"


def main() -> None:
    parser = argparse.ArgumentParser(description="Count flights to a verified name.")
    parser.add_argument("--campaigns", type=int, default=200, help="with an effect, each flown both ways")
    parser.add_argument("--null", type=int, default=200, help="without an effect")
    parser.add_argument("--seed", type=int, required=True)
    chosen = parser.parse_args()
    done: list[Campaign] = []
    for each in campaigns(chosen.campaigns, chosen.null, chosen.seed):
        done.append(each)
        hidden = f"{each.key} {each.size:.2g}" if each.key else "nothing"
        print(
            f"{hidden}, {each.maneuvers}: {each.plan.outcome} {' or '.join(each.plan.names) or '-'} after "
            f"{len(each.plan.result.flights)} flights, {each.seconds:.0f} s of processor time",
            flush=True,
        )
    for maneuvers in ("chosen", "own"):
        counts = [each.flights for each in done if each.key and each.maneuvers == maneuvers]
        wrong = [each for each in done if each.key and each.maneuvers == maneuvers and each.plan.names]
        wrong = [each for each in wrong if each.key not in each.plan.names]
        if counts:
            print(f"{maneuvers}: median {np.median(counts):g} flights to the right name, {len(wrong)} wrong names")
    null = [each for each in done if not each.key]
    print(f"names without an effect: {false_rate(sum(bool(each.plan.names) for each in null), len(null))}")


if __name__ == "__main__":
    main()
