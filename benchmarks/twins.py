"""What two implementations of one thing do that either alone does not: python -m benchmarks.twins.

Contacts: the search through the samples and the one over the whole record. Fits: the diagnosis' own Levenberg-Marquardt
and scipy's least squares. Motions: the compiled loop of one run and the arrays of many.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from benchmarks.table import here_and_now
from support.diagnosed_records import nominal, records
from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.arrays import Array
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis import model
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis, moved
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.estimation.contact import first_contact, likeliest_jumps, shows_a_jump
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values, node_rates

RECORDS = 100
SIZES = (2e-4, 1e-3)
"""N·m·s: about five and 25 standard deviations of the gyro on 0.022 kg·m²."""
HIDDEN = (
    ("rotor_speed", "cmg3", [0.02]),
    ("gyro_latency", "gyro", [0.0125]),
    ("viscous_drag", "platform", [2e-4] * 3),
    ("gimbal_misalignment", "cmg2", [0.02, -0.01]),
    ("flexible_appendage", "platform", [1.5, 0.05, 2.4e-3, -1.6e-3, 8e-4]),
)


def main() -> None:
    print(here_and_now())
    contacts()
    fits()
    motions()


def contacts() -> None:
    """Print what each search finds in records with no, one and three contacts."""
    print("\ncontacts | found by the search through samples | by the one over the record")
    rng = np.random.default_rng(8)
    for size, count in ((0.0, 0), *((size, count) for count in (1, 3) for size in SIZES)):
        first, largest = [], []
        for seed in range(RECORDS):
            touches = _touches(rng, count, size)
            run = _run(seed, touches)
            instant = touches[0, 0] if count else np.nan
            found = first_contact(run, _theta())
            first.append(found and _beside(instant, found.last_free, found.first_seen))
            jumps = likeliest_jumps(run, 1) if shows_a_jump(run) else []
            largest.append(jumps[0] and _beside(instant, jumps[0][1], jumps[0][1]) if jumps else None)
        print(f"{count} of {size:g} N·m·s", *(_counted(each) for each in (first, largest)), sep=" | ")
    run = _run(0, _touches(rng, 0, 0.0))
    print(f"ms a record | {_ms(lambda: first_contact(run, _theta())):.1f} | {_ms(lambda: likeliest_jumps(run, 1)):.1f}")


def _touches(rng: np.random.Generator, count: int, size: float) -> Array:
    """Return instants and impulses, in order, a second apart, shape (count, 4)."""
    instants = 0.7 + 1.0 * np.arange(count) + rng.uniform(0.0, 0.3, count)
    directions = rng.normal(size=(count, 3))
    return np.column_stack([instants, size * directions / np.linalg.norm(directions, axis=1, keepdims=True)])


def _run(seed: int, touches: Array) -> Telemetry:
    scenario, platform = nominal()
    hooks = [EFFECTS["contact"].hooks("platform")] * len(touches)
    (record,) = records(1, hooks=hooks, values=list(touches), seed=seed)
    return telemetry_of(record, scenario, platform)


def _theta() -> Array:
    return theta_of(nominal()[1].inertia)


def _beside(instant: float, first: float, last: float) -> bool:
    """Whether an instant lies within two samples of where a contact was found."""
    return first - 0.125 <= instant <= last + 0.125


def _counted(found: Sequence[bool | None]) -> str:
    named = [each for each in found if each is not None]
    return f"{len(named)} of {len(found)}, the first one {sum(named)}"


def fits() -> None:
    """Print evaluations, seconds and the χ² above the lower one of both searches."""
    print("\nfit | evaluations, own | scipy | s, own | scipy | χ² above the lower one, own | scipy")
    for effect, component, size in HIDDEN:
        runs, placed = _hidden(effect, component, np.array(size))
        start = 0.3 * np.array(size)
        if "flexible" in effect:
            start[0] = 0.8 * size[0]
        sides = [_measured(partial(search, runs, placed, start)) for search in (_own, _scipy)]
        lower = min(side[2] for side in sides)
        cells = [f"{side[0]}" for side in sides] + [f"{side[1]:.2f}" for side in sides]
        print(f"{effect}:{component}", *cells, *(f"{side[2] - lower:.2g}" for side in sides), sep=" | ")


def _hidden(effect: str, component: str, size: Array) -> tuple[Runs, Hypothesis]:
    scenario, platform = nominal()
    hidden = records(3, hooks=[EFFECTS[effect].hooks(component)], values=[size], seed=5)
    runs = runs_of(["a", "b", "c"], [telemetry_of(each, scenario, platform) for each in hidden])
    return runs, Hypothesis(effect=EFFECTS[effect], component=component)


def _measured(search: Callable[[], float]) -> tuple[int, float, float]:
    """Return the evaluations, s and χ² of a search."""
    count, evaluated = 0, model.evaluated

    def counted(*arguments: Any) -> Fit:
        nonlocal count
        count += 1
        return evaluated(*arguments)

    model.evaluated = counted
    try:
        started = time.process_time()
        chi_square = search()
        return count, time.process_time() - started, chi_square
    finally:
        model.evaluated = evaluated


def _own(runs: Runs, placed: Hypothesis, start: Array) -> float:
    return fitted(runs, [placed], _theta(), [start]).chi_square


def _scipy(runs: Runs, placed: Hypothesis, start: Array) -> float:
    """The same problem by scipy's trust region with bounds, each point evaluated once."""
    first = np.stack([rates[0] for rates in runs.measured])[:, None]
    origin = model.evaluated(runs, (placed,), Values(theta=_theta()[None], initial_rate=first, effects=(start[None],)))
    at: dict[bytes, Fit] = {np.zeros(origin.jacobian.shape[1]).tobytes(): origin}

    def fit(step: Array) -> Fit:
        if step.tobytes() not in at:
            at[step.tobytes()] = model.evaluated(runs, (placed,), moved(origin, step))
        return at[step.tobytes()]

    def residual(step: Array) -> Array:
        try:
            return fit(step).residual
        except InputError:  # the motion runs away
            return np.full_like(origin.residual, 1e6)

    low, high = (np.full(origin.jacobian.shape[1], sign * np.inf) for sign in (-1.0, 1.0))
    own = slice(6, 6 + placed.size)
    low[own], high[own] = placed.bounds[0] - start, placed.bounds[1] - start
    ends = 1e-3 / max(origin.chi_square, 1.0)  # the same gain in χ² ends both
    found = least_squares(
        residual, np.zeros(len(low)), lambda step: -fit(step).jacobian, bounds=(low, high), x_scale="jac", ftol=ends
    )
    return float(2.0 * found.cost)


def motions() -> None:
    """Print what a prediction of one run, and of 64 parameter sets, takes by either implementation."""
    run = exact_telemetry(nominal_flight(np.array([0.003, -0.004, 0.006])), *[sample_times(16.0)] * 2)
    drive, grid, momentum_B = drive_of(run), grid_of([run], 1.0 / 32.0), np.array([0.003, -0.004, 0.006])
    print("\nms for | the compiled loop | the arrays")
    for sets in (1, 64):
        thetas = TRUE_THETA * (1.0 + 1e-3 * np.arange(sets))[:, None]
        loop = _ms(lambda thetas=thetas: [simulate(drive, theta, momentum_B) for theta in thetas])
        values = Values(theta=thetas, initial_rate=run.body_rate[:1][None], effects=())
        print(f"{sets} sets | {loop:.2f} | {_ms(lambda values=values: node_rates(grid, [], values)):.2f}")


def _ms(work: Callable[[], object]) -> float:
    """Return the median time of a few calls after one to warm up."""
    work()
    return 1e3 * float(np.median(list(_seconds(work))))


def _seconds(work: Callable[[], object]) -> Iterator[float]:
    for _ in range(15):
        started = time.process_time()
        work()
        yield time.process_time() - started


if __name__ == "__main__":
    main()
