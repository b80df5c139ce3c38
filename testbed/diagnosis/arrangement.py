"""Are channels where the scenario has them: the gyro's axes in order and sign, each actuator's in its own place?

The balance of angular momentum along the measured motion shows it, without an integration of the equations of motion:
the platform's momentum and what its actuators hold, turned into inertial axes, change by torques alone. Another
arrangement that balances far better than the one given is a mistake in the records or in the scenario. A fit would hide
it: inertia takes up what two exchanged axes do to a balance, and effects the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations, product
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Matrix3, Theta
from testbed.diagnosis.settings import SETTINGS
from testbed.estimation.momentum_equation import momentum_equation
from testbed.estimation.telemetry import Telemetry
from testbed.signals import AXES

_MOST_NAMED = 3
"""Arrangements that are named, the best first, of those that balance about alike."""
_MOST_RUNS = 8
"""Runs that are looked at, the longest: a mistake is in all of them, and of hundreds of windows each costs as much."""


class _Arrangement(NamedTuple):
    """Another reading of the same channels.

    Attributes:
        said: what would have to be so.
        read: takes a run to what it would be then.
    """

    said: str
    read: Callable[[Telemetry], Telemetry]


def mistaken_arrangement(runs: Sequence[Telemetry], theta: Theta) -> str | None:
    """Return what arrangement balances the momentum far better than the one given, the best first, in words.

    Args:
        runs: of one platform.
        theta: of its nominal inertia, kg·m².

    Returns:
        None where the channels are where they should be, or no other arrangement would make them so.
    """
    looked_at = sorted(runs, key=lambda run: -len(run.gyro_time))[:_MOST_RUNS]
    powers = np.array([_powers(run, theta) for run in looked_at])
    given = _share(powers)
    if given < SETTINGS.unbalanced_share:
        return None
    most = int(np.argmax(powers[:, 1]))  # the run that moves the most weighs the most
    first, there = looked_at[most : most + 1], _share(powers[most : most + 1])
    worth_trying = [other for other in _others(first[0]) if _far_better(_missed(first, other, theta), there)]
    tried = sorted((_missed(looked_at, other, theta), other.said) for other in worth_trying)
    if not tried or not _far_better(best := tried[0][0], given):
        return None
    instead = ", or ".join(
        f"{share:.1%} if {said}" for share, said in tried[:_MOST_NAMED] if share <= best * SETTINGS.better_balanced
    )
    return f"the balance of angular momentum misses {given:.1%} of the motion as the records are, {instead}"


def _far_better(share: float, given: float) -> bool:
    return share <= min(given / SETTINGS.better_balanced, SETTINGS.unit_rate_share)


def _missed(runs: Sequence[Telemetry], other: _Arrangement, theta: Theta) -> float:
    return _share(np.array([_powers(other.read(run), theta) for run in runs]))


def _share(powers: Array) -> float:
    """Return the share of the power of J ω, of all runs, that the balance of momentum misses.

    Args:
        powers: of each run, as `_powers` returns them, shape (R, 2).
    """
    missed, whole = powers.sum(axis=0)
    return float(missed / whole) if whole > 0.0 else 0.0


def _powers(run: Telemetry, theta: Theta) -> tuple[float, float]:
    """Return the sums of squares of the balance's residual and of J ω, (N·m·s)², less what the unknowns explain."""
    if run.applied_torque is not None:
        run = replace(run, constant_torque="body")  # thrust has a trim
    equation = momentum_equation(run, run.body_rate)
    live = np.array(run.live)
    unknowns = equation.regressor[..., live, 6:]
    unknowns = unknowns.reshape(-1, unknowns.shape[-1])
    own = np.matvec(equation.regressor[..., live, :6], theta)
    both = np.stack([(equation.response[..., live] - own).ravel(), own.ravel()], axis=1)
    left = both - unknowns @ np.linalg.lstsq(unknowns, both, rcond=None)[0]
    missed, whole = np.square(left).sum(axis=0)
    return float(missed), float(whole)


def _others(run: Telemetry) -> Iterator[_Arrangement]:
    """Yield all arrangements with one mistake.

    The gyro's mounting, the unit of all of a kind of actuators, the sign of one of them, two that changed places.
    """
    yield from _gyro_mountings(run)
    if run.wheels is not None:
        wheels = run.wheels.momentum.shape[1]
        yield from _in_another_unit(
            "the wheels' speeds", {"rpm": np.pi / 30, "deg/s": np.pi / 180}, wheels, _with_wheels
        )
        yield from _misplaced("wheel", wheels, _with_wheels)
    if run.gimbals is not None:
        gimbals = run.gimbals.angle.shape[1]
        yield from _in_another_unit("the gimbals' angles", {"deg": np.pi / 180}, gimbals, _with_gimbals)
        yield from _misplaced("gimbal", gimbals, _with_gimbals)


def _gyro_mountings(run: Telemetry) -> Iterator[_Arrangement]:
    """Yield the gyro's axes in any other order and signs, left-handed ones too; axes that are not live stay.

    Not all three turned: that is a sign of the whole channel, which the gate asks for run by run.
    """
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[range(3), order] = signs
        if abs(matrix.trace()) < len(matrix) and _keeps_still_axes(matrix, run):
            named = ", ".join(
                f"{'-' if sign < 0.0 else ''}{AXES[axis]}" for axis, sign in zip(order, signs, strict=True)
            )
            said = f"the body's x, y, z were the gyro's {named} (reorder its columns or turn their signs)"
            yield _Arrangement(said, partial(_with_gyro, matrix=matrix))


def _keeps_still_axes(matrix: Matrix3, run: Telemetry) -> bool:
    still = ~np.array(run.live)
    return bool(np.array_equal(matrix[still], np.eye(3)[still]))


def _in_another_unit(
    channel: str, units: Mapping[str, float], count: int, changed: Callable[..., Telemetry]
) -> Iterator[_Arrangement]:
    """Yield all columns of a channel in other units, each with its factor to SI."""
    for unit, factor in units.items():
        said = f"{channel} were in {unit} (multiply them by {factor:.10g})"
        yield _Arrangement(said, partial(changed, order=np.arange(count), factors=np.full(count, factor)))


def _misplaced(unit: str, count: int, changed: Callable[..., Telemetry]) -> Iterator[_Arrangement]:
    """Yield one unit with the other sign, and any two that changed places."""
    places = np.arange(count)
    for one in places:
        signs = np.where(places == one, -1.0, 1.0)
        said = f"{unit} {one + 1} turned the other way (turn the sign of its columns, or its axis in the scenario)"
        yield _Arrangement(said, partial(changed, order=places, factors=signs))
    for one, other in combinations(places, 2):
        order = places.copy()
        order[[one, other]] = other, one
        said = f"{unit}s {one + 1} and {other + 1} changed places (exchange their columns)"
        yield _Arrangement(said, partial(changed, order=order, factors=np.ones(count)))


def _with_gyro(run: Telemetry, matrix: Matrix3) -> Telemetry:
    return replace(run, body_rate=run.body_rate @ matrix.T)


def _with_wheels(run: Telemetry, order: Array, factors: Array) -> Telemetry:
    assert run.wheels is not None
    momentum = factors * run.wheels.best_momentum[:, order]
    return replace(run, wheels=replace(run.wheels, momentum=momentum, smoothed=None))


def _with_gimbals(run: Telemetry, order: Array, factors: Array) -> Telemetry:
    assert run.gimbals is not None
    return replace(run, gimbals=replace(run.gimbals, angle=factors * run.gimbals.angle[:, order]))
