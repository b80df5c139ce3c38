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

from testbed.arrays import Array, Matrices3, Matrix3, Series, Theta, Vectors3
from testbed.diagnosis.settings import SETTINGS
from testbed.estimation.identifiability import explaining
from testbed.estimation.momentum_equation import momentum_equation
from testbed.estimation.regression import rows_of
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


class _Mounting(NamedTuple):
    """Another mounting of the gyro.

    Attributes:
        said: what would have to be so.
        matrix: takes the measured body rate to what it would be then.
    """

    said: str
    matrix: Matrix3


def mistaken_arrangement(runs: Sequence[Telemetry], theta: Theta) -> str | None:
    """Return what arrangement balances the momentum far better than the one given, the best first, in words.

    Args:
        runs: of one platform.
        theta: of its nominal inertia, kg·m².

    Returns:
        None where the channels are where they should be, or no other arrangement would make them so.
    """
    looked_at = sorted(runs, key=lambda run: -len(run.gyro_time))[:_MOST_RUNS]
    powers = np.array([_powers(run, theta, run.body_rate) for run in looked_at])
    given = float(_share(powers))
    if given < SETTINGS.unbalanced_share:
        return None
    most = int(np.argmax(powers[:, 1]))  # the run that moves the most weighs the most
    first, there = looked_at[most : most + 1], float(_share(powers[most : most + 1]))
    tried = sorted([*_mounted(looked_at, first, theta, there), *_arranged(looked_at, first, theta, there)])
    if not tried or not _far_better(best := tried[0][0], given):
        return None
    instead = ", or ".join(
        f"{share:.1%} if {said}" for share, said in tried[:_MOST_NAMED] if share <= best * SETTINGS.better_balanced
    )
    return f"the balance of angular momentum misses {given:.1%} of the motion as the records are, {instead}"


def _far_better(share: float, given: float) -> bool:
    return share <= min(given / SETTINGS.better_balanced, SETTINGS.unit_rate_share)


def _arranged(
    runs: Sequence[Telemetry], first: Sequence[Telemetry], theta: Theta, given: float
) -> Iterator[tuple[float, str]]:
    """Yield what actuators in other places miss in all runs, and their words, where the first run is far better so."""
    for other in _others(first[0]):
        if _far_better(_missed(first, other, theta), given):
            yield _missed(runs, other, theta), other.said


def _missed(runs: Sequence[Telemetry], other: _Arrangement, theta: Theta) -> float:
    read = map(other.read, runs)
    return float(_share(np.array([_powers(run, theta, run.body_rate) for run in read])))


def _mounted(
    runs: Sequence[Telemetry], first: Sequence[Telemetry], theta: Theta, given: float
) -> Iterator[tuple[float, str]]:
    """Yield the same of other mountings of the gyro."""
    every = list(_gyro_mountings(first[0]))
    shares = _missed_by_mounting(first, every, theta)
    better = [each for each, share in zip(every, shares, strict=True) if _far_better(float(share), given)]
    yield from zip(_missed_by_mounting(runs, better, theta).tolist(), (each.said for each in better), strict=True)


def _missed_by_mounting(runs: Sequence[Telemetry], mountings: Sequence[_Mounting], theta: Theta) -> Series:
    """Return the share that each mounting misses, shape (M,); all of them side by side."""
    if not mountings:
        return np.zeros(0)
    matrices = np.stack([each.matrix for each in mountings])
    return _share(np.array([_mounted_powers(run, matrices, theta) for run in runs]))


def _mounted_powers(run: Telemetry, matrices: Matrices3, theta: Theta) -> Array:
    rates = run.body_rate @ np.swapaxes(matrices, -1, -2)
    if run.surroundings is None:
        return _powers(run, theta, rates)
    # The torque from outside is that of the attitude which the gyro has.
    return np.array([_powers(replace(run, body_rate=rate), theta, rate) for rate in rates])


def _share(powers: Array) -> Array:
    """Return the share of the power of J ω, of all runs, that the balance of momentum misses, shape (...).

    Args:
        powers: of each run, as `_powers` returns them, shape (R, ..., 2).
    """
    missed, whole = np.moveaxis(powers.sum(axis=0), -1, 0)
    return np.asarray(np.where(whole > 0.0, missed / np.where(whole > 0.0, whole, 1.0), 0.0))


def _powers(run: Telemetry, theta: Theta, body_rate: Vectors3) -> Array:
    """Return the sums of squares of the balance's residual and of J ω, (N·m·s)², less what the unknowns explain.

    Args:
        run: what the actuators do.
        theta: of the nominal inertia, kg·m².
        body_rate: shape (..., N, 3), rad/s.

    Returns:
        Shape (..., 2).
    """
    if run.applied_torque is not None:
        run = replace(run, constant_torque="body")  # thrust has a trim
    equation = momentum_equation(run, body_rate)
    live = np.array(run.live)
    unknowns = rows_of(equation.regressor[..., live, 6:])
    own = np.matvec(equation.regressor[..., live, :6], theta)
    both = np.stack([equation.response[..., live] - own, own], axis=-1)
    both = both.reshape(*both.shape[:-3], -1, 2)
    return np.asarray(np.square(both - unknowns @ explaining(unknowns, both)).sum(axis=-2))


def _others(run: Telemetry) -> Iterator[_Arrangement]:
    """Yield all arrangements of the actuators with one mistake.

    The unit of all of a kind, the sign of one of them, two that changed places.
    """
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


def _gyro_mountings(run: Telemetry) -> Iterator[_Mounting]:
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
            yield _Mounting(said, matrix)


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


def _with_wheels(run: Telemetry, order: Array, factors: Array) -> Telemetry:
    assert run.wheels is not None
    momentum = factors * run.wheels.best_momentum[:, order]
    return replace(run, wheels=replace(run.wheels, momentum=momentum, smoothed=None))


def _with_gimbals(run: Telemetry, order: Array, factors: Array) -> Telemetry:
    assert run.gimbals is not None
    return replace(run, gimbals=replace(run.gimbals, angle=factors * run.gimbals.angle[:, order]))
