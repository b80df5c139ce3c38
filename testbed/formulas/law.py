"""A torque law: a product of at most three factors, with a memory; text, units and value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce
from math import sqrt
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array
from testbed.formulas.motion import ELAPSED, GIMBAL_RATES, GIMBALS, QUANTITIES, RATES, TIME, TORQUES, Moment, unit_of
from testbed.formulas.units import Unit

Constant: TypeAlias = float | str
"""A number, or the name of one that is estimated."""
Function: TypeAlias = Literal["", "abs", "norm", "sin", "cos", "pulse", "once"]
Memory: TypeAlias = Literal["", "lag", "delay", "hysteresis"]

MOST_FACTORS = 3
"""Of a product: third order in the body rate, as the grammar is defined."""
ORDER: tuple[Function, ...] = ("once", "pulse", "sin", "cos", "norm", "abs", "")
BELLS: tuple[Function, ...] = ("pulse", "once")
"""Bells about an instant: of every run, and of the runs laid end to end."""
STATES: Mapping[Memory, int] = {"": 0, "lag": 1, "delay": 2, "hysteresis": 1}
"""States that a memory integrates."""


@dataclass(frozen=True, kw_only=True)
class Factor:
    """One factor of a product.

    Attributes:
        function: applied to the argument; empty for the argument itself.
        argument: a name of `QUANTITIES`; `w` of `norm`; `t` of a sine with a frequency, and of a pulse;
            `elapsed` of a pulse in a single run.
        constants: frequency in Hz of a sine of time; instant and width in s of a pulse.
    """

    function: Function = ""
    argument: str
    constants: tuple[Constant, ...] = ()

    def __str__(self) -> str:
        if self.function in BELLS:
            return f"{self.function}({', '.join(map(shown, self.constants))})"
        if self.constants:
            return f"{self.function}(2*pi*{shown(self.constants[0])}*t)"
        return f"{self.function}({self.argument})" if self.function else self.argument

    @property
    def unit(self) -> Unit:
        """Of its value."""
        if self.function in ("sin", "cos", *BELLS):
            return Unit()
        if self.argument in (*RATES, *GIMBAL_RATES, "w"):
            return Unit(rad=1, s=-1)
        if self.argument in GIMBALS:
            return Unit(rad=1)
        if self.argument in TORQUES:
            return Unit(N_m=1)
        return Unit(s=1) if self.argument == TIME else Unit()

    @property
    def rank(self) -> tuple[int, int, str]:
        """Place in the order in which factors are written."""
        quantity = QUANTITIES.index(self.argument) if self.argument in QUANTITIES else -1
        return ORDER.index(self.function), quantity, str(self)

    def value(self, at: Moment, constants: Mapping[str, Array]) -> Array:
        """Return its value; analytic, as derivatives are taken by complex steps.

        Args:
            at: the instant.
            constants: values of the named ones.
        """
        if self.function == "norm":
            return np.asarray(np.sqrt((at.body_rate**2).sum(axis=-1)))
        value = at.value(self.argument)
        if self.function == "abs":
            return np.asarray(value * np.sign(value.real))
        if self.function in BELLS:
            instant, width = (number(each, constants) for each in self.constants)
            return np.asarray(np.exp(-0.5 * ((value - instant) / width) ** 2))
        if self.constants:
            value = 2.0 * np.pi * number(self.constants[0], constants) * value
        waves = {"sin": np.sin, "cos": np.cos}
        return np.asarray(waves[self.function](value) if self.function else value)


def shown(constant: Constant) -> str:
    """Return a constant as a formula has it: the shortest text that is read as this number."""
    return constant if isinstance(constant, str) else repr(float(constant)).removesuffix(".0")


def number(constant: Constant, constants: Mapping[str, Array]) -> Array:
    """Return the value of a constant, stated or named."""
    return constants[constant] if isinstance(constant, str) else np.asarray(constant)


@dataclass(frozen=True, kw_only=True)
class Law:
    """A product of factors with a memory; two that say the same are equal, however they were written.

    Attributes:
        factors: in order; none stands for 1.
        memory: of the product.
        memory_constant: time constant of a lag and time of a delay, s; of a hysteresis the stretch of the product's
            integral over which its sign follows, in the product's unit times s. None without a memory.
    """

    factors: tuple[Factor, ...] = ()
    memory: Memory = ""
    memory_constant: Constant | None = None

    @staticmethod
    def of(*factors: Factor, memory: Memory = "", memory_constant: Constant | None = None) -> Law:
        """Return the law with its factors in order."""
        ordered = tuple(sorted(factors, key=lambda each: each.rank))
        return Law(factors=ordered, memory=memory, memory_constant=memory_constant)

    def __str__(self) -> str:
        product = "*".join(map(str, self.factors)) or "1"
        if self.memory_constant is None:
            return product
        return f"{self.memory}({product}, {shown(self.memory_constant)})"

    @property
    def quantities(self) -> tuple[str, ...]:
        """What it reads; the norm of the body rate reads its three components."""
        read = [(factor.argument,) if factor.function != "norm" else RATES for factor in self.factors]
        return tuple(dict.fromkeys(name for names in read for name in names))

    @property
    def units_needed(self) -> int:
        """Greatest number of a gimbal that it reads; 0 for none."""
        return max(map(unit_of, self.quantities), default=0)

    @property
    def recurs(self) -> bool:
        """Whether it acts in every run."""
        return all(factor.argument != ELAPSED for factor in self.factors)

    @property
    def reads_torque(self) -> bool:
        """Whether it reads the torque of actuators."""
        return not set(TORQUES).isdisjoint(self.quantities)

    @property
    def names(self) -> tuple[str, ...]:
        """Named constants, in order."""
        stated = [each for factor in self.factors for each in factor.constants]
        every = [*stated, *([] if self.memory_constant is None else [self.memory_constant])]
        return tuple(dict.fromkeys(each for each in every if isinstance(each, str)))

    @property
    def length(self) -> int:
        """Number of factors, constants and memories, by which its prior falls."""
        stated = sum(len(factor.constants) for factor in self.factors)
        return len(self.factors) + stated + 2 * bool(self.memory)

    @property
    def product_unit(self) -> Unit:
        """Of the product of the factors."""
        return reduce(Unit.__mul__, (factor.unit for factor in self.factors), Unit())

    @property
    def coefficient_unit(self) -> Unit:
        """Of what it is multiplied by to be a torque."""
        return Unit(N_m=1) if self.memory == "hysteresis" else Unit(N_m=1) / self.product_unit

    @property
    def states(self) -> int:
        """Number of states that its memory integrates."""
        return STATES[self.memory]

    @property
    def fastest_rate(self) -> float:
        """How fast its memory forgets what is no longer, 1/s, of numbers for its constants; 0 without such a memory.

        A lag's pole is 1/τ, those of the delay's Padé approximation are √12/T in size; a hysteresis has none.
        """
        rates = {"lag": 1.0, "delay": sqrt(12.0)}
        if not isinstance(self.memory_constant, float) or self.memory not in rates:
            return 0.0
        return rates[self.memory] / self.memory_constant

    def with_numbers(self, numbers: Mapping[str, float]) -> Law:
        """Return the law with numbers for its named constants."""

        def stated(constant: Constant) -> Constant:
            return numbers[constant] if isinstance(constant, str) else constant

        factors = (replace(each, constants=tuple(map(stated, each.constants))) for each in self.factors)
        constant = None if self.memory_constant is None else stated(self.memory_constant)
        return Law.of(*factors, memory=self.memory, memory_constant=constant)

    def product(self, at: Moment, constants: Mapping[str, Array]) -> Array:
        """Return the product of the factors."""
        every = (factor.value(at, constants) for factor in self.factors)
        return reduce(np.multiply, every, np.ones_like(at.time))

    def value(self, at: Moment, state: Array, constants: Mapping[str, Array]) -> Array:
        """Return the law's value.

        Args:
            at: the instant.
            state: of its memory, shape (..., `states`).
            constants: values of the named ones.
        """
        return value_of(self.memory, self.product(at, constants), state)

    def first_state(self, at: Moment, constants: Mapping[str, Array]) -> Array:
        """Return the state with which a run begins, shape (..., `states`)."""
        return first_state_of(self.memory, self.product(at, constants))

    def state_rate(self, at: Moment, state: Array, constants: Mapping[str, Array]) -> Array:
        """Return the rate of change of the state, shape (..., `states`)."""
        if self.memory_constant is None:
            return np.zeros_like(state)
        return rate_of(self.memory, self.product(at, constants), state, number(self.memory_constant, constants))


def value_of(memory: Memory, product: Array, state: Array) -> Array:
    """Return what a memory makes of a product, shape (...), in a state of shape (..., states)."""
    if memory in ("lag", "hysteresis"):
        return np.asarray(state[..., 0])
    return np.asarray(product - state[..., 1]) if memory == "delay" else product


def first_state_of(memory: Memory, product: Array) -> Array:
    """Return the state of a memory with which a run begins: settled, and of a hysteresis none."""
    states = {"": [], "lag": [product], "delay": [product, 0.0 * product], "hysteresis": [0.0 * product]}
    every = states[memory]
    return np.stack(every, axis=-1) if every else np.zeros((*np.shape(product), 0))


def rate_of(memory: Memory, product: Array, state: Array, constant: Array) -> Array:
    """Return the rate of change of the state of a memory.

    A lag is of first order, a delay its second-order Padé approximation, and a hysteresis the solid friction of Dahl:
    ż = (x - |x| z)/c comes to the sign of x while the integral of x grows by a few c.

    Source: Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal (1976).
    """
    if memory == "lag":
        return np.asarray(((product - state[..., 0]) / constant)[..., None])
    if memory == "hysteresis":
        size = product * np.sign(product.real)
        return np.asarray(((product - size * state[..., 0]) / constant)[..., None])
    late, rate = state[..., 0], state[..., 1]
    return np.stack([rate / constant, (12.0 * (product - late) - 6.0 * rate) / constant], axis=-1)
