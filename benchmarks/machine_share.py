"""Operations in a step of the compiled equations of motion, and what share of the machine they keep busy.

Run with `python -m benchmarks.machine_share`. Operations are counted by running the very equations on numbers that
count; sines, cosines and roots are counted apart. The machine's peak is that of a product of large matrices on one
core.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from types import FunctionType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.flight import SCENARIOS
from benchmarks.paired import processor_seconds
from testbed.assembly.platform import nominal_platform, true_plant
from testbed.dynamics import gyrostat_kernel
from testbed.plant.gyrostat import gyrostats_of
from testbed.plant.plant import Model
from testbed.scenario.reader import read_scenario

PLATFORMS = ("gimbal_d_optimal", "pyramid4", "mixed", "cubesat_wheels", "air_bearing")
SIDE_BY_SIDE, STEPS, TIMES = 25, 2_000, 5
"""Platforms, steps of each, and how often they are timed; the least time counts, as other work only adds to it."""
SIZE, PRODUCTS = 1_000, 5
"""Rows of the matrices, and how often they are multiplied."""


@dataclass(frozen=True, kw_only=True)
class Share:
    """What a platform's step keeps busy.

    Attributes:
        platform: scenario that it is from.
        operations: additions, multiplications and divisions in a step.
        functions: sines, cosines and roots in it.
        seconds: that it takes.
    """

    platform: str
    operations: int
    functions: int
    seconds: float

    @property
    def rate(self) -> float:
        """Operations a second."""
        return self.operations / self.seconds


class Number:
    """A number that counts what is done to it."""

    counted: ClassVar[Counter[str]] = Counter()

    def __init__(self, value: float) -> None:
        """Take its value."""
        self.value = float(value)

    def _done(self, kind: str, value: float) -> Number:
        Number.counted[kind] += 1
        return Number(value)

    def __add__(self, other: Any) -> Number:
        return self._done("operations", self.value + float(other))

    def __sub__(self, other: Any) -> Number:
        return self._done("operations", self.value - float(other))

    def __rsub__(self, other: Any) -> Number:
        return self._done("operations", float(other) - self.value)

    def __mul__(self, other: Any) -> Number:
        return self._done("operations", self.value * float(other))

    def __truediv__(self, other: Any) -> Number:
        return self._done("operations", self.value / float(other))

    def __rtruediv__(self, other: Any) -> Number:
        return self._done("operations", float(other) / self.value)

    def __pow__(self, power: int) -> Number:
        return self._done("operations", self.value**power)

    def __neg__(self) -> Number:  # a change of sign costs nothing beside what it goes into
        return Number(-self.value)

    def __abs__(self) -> Number:
        return Number(abs(self.value))

    def __float__(self) -> float:
        return self.value

    def __lt__(self, other: Any) -> bool:
        return self.value < float(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > float(other)

    def sin(self) -> Number:
        """What NumPy calls for a sine."""
        return self._done("functions", np.sin(self.value))

    def cos(self) -> Number:
        """Likewise."""
        return self._done("functions", np.cos(self.value))

    def sqrt(self) -> Number:
        """Likewise."""
        return self._done("functions", np.sqrt(self.value))

    __radd__, __rmul__ = __add__, __mul__


def main() -> None:
    """Print the table."""
    with threadpool_limits(1):
        peak = _peak()
        print(f"peak of one core: {peak / 1e9:.1f} thousand million operations a second")
        print(f"{'platform':18} {'operations':>10} {'functions':>9} {'µs a step':>9} {'1e9/s':>6} {'of the peak':>11}")
        for name in PLATFORMS:
            share = _share(name)
            print(
                f"{share.platform:18} {share.operations:10} {share.functions:9} {1e6 * share.seconds:9.2f} "
                f"{share.rate / 1e9:6.2f} {share.rate / peak:11.1%}"
            )


def _share(name: str) -> Share:
    scenario = read_scenario(SCENARIOS / f"{name}.toml")
    plant = true_plant([(scenario, nominal_platform(scenario))] * SIDE_BY_SIDE, engine="compiled")
    still = np.zeros(plant.gimbal_rate.shape)
    took = min(processor_seconds(lambda: plant.advance(still, STEPS)) for _ in range(TIMES))
    one, two = (_counted(plant.models[0], steps) for steps in (1, 2))
    per_step = two - one  # what is done once, before and after the steps, falls out
    return Share(
        platform=name,
        operations=per_step["operations"],
        functions=per_step["functions"],
        seconds=took / (STEPS * SIDE_BY_SIDE),
    )


def _counted(model: Model, steps: int) -> Counter[str]:
    """Return what the equations do in so many steps of a platform that begins to turn."""
    gyrostats = gyrostats_of([model])
    row = np.concatenate([model.qpos0, np.full(model.nv, 0.1), np.zeros(model.na + model.nv + 1)])
    functions = SimpleNamespace(empty=lambda size: np.empty(size, dtype=object), sqrt=np.sqrt)
    loop = FunctionType(gyrostat_kernel._advance.__code__, vars(gyrostat_kernel) | {"np": functions})
    places = gyrostats.places
    given = (gyrostats.body, gyrostats.units, gyrostats.wheels, np.zeros((1, model.nu)), row[None])
    numbers = [np.frompyfunc(Number, 1, 1)(each) for each in given]
    Number.counted.clear()
    loop(places.body, places.units, places.wheels, [steps], [0], *numbers)
    return Counter(Number.counted)


def _peak() -> float:
    """Return operations a second of a product of matrices."""
    left = np.random.default_rng(1).standard_normal((SIZE, SIZE))
    took = min(processor_seconds(lambda: left @ left) for _ in range(PRODUCTS))
    return 2.0 * SIZE**3 / took


if __name__ == "__main__":
    main()
