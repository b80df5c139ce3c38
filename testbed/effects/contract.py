"""Every named effect: its description, how it enters the prediction, and how it is built into a flying model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np

from testbed.arrays import Array
from testbed.plant.additions import Addition
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.signals import KINDS, MOST_UNITS

Channel: TypeAlias = Literal[
    "gimbal_angle",
    "gimbal_rate_command",
    "gimbal_torque",
    "rotor_speed",
    "wheel_speed",
    "wheel_torque",
    "wheel_torque_command",
    "applied_torque",
    "applied_torque_or_cluster_momentum",
    "cluster_momentum",
    "thrust",
    "attitude",
    "any_actuator",
]
"""What a record has to carry beside the body rate for an effect to be tested for."""

UNITS = tuple(f"{KINDS['unit'].prefix}{number}" for number in range(1, MOST_UNITS + 1))
"""Components of effects that sit in one CMG unit; of a platform with fewer, `components_in` has those that it has."""
THRUSTERS = tuple(str(number) for number in range(1, MOST_UNITS + 1))
"""Components of effects that sit in one thruster or motor of many, by its number."""
WHEELS = tuple(f"{KINDS['wheel'].prefix}{number}" for number in range(1, MOST_UNITS + 1))
"""Components of effects that sit in one reaction wheel, likewise."""
ALL_WHEELS = "wheels"
"""Component of effects that all reaction wheels of a platform have alike."""
NUMBERED = (UNITS, WHEELS, THRUSTERS)
"""Components of each kind of actuator, as documents list them."""
HOLDING_MOMENTUM: tuple[Channel, ...] = ("gimbal_angle", "wheel_speed", "cluster_momentum")
"""Channels of platforms that turn by momentum that they hold: there an effect of thrusters is no hypothesis at all."""
SHOWING_UNITS: tuple[Channel, ...] = ("gimbal_angle", "wheel_speed")
"""Channels that show which units a platform has, and what each of them holds."""
AXES = ("x", "y", "z")
"""Components of effects that sit on one gyro axis."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of an effect, SI.

    Attributes:
        name: as in files, with its unit suffix, e.g. `delay_s`.
        unit: e.g. `s`.
        typical: a size that hardware of this class shows. The report states whether the data would have shown it, and
            gives the detectable size of several parameters in its direction; tests use it. Source: chosen, a round
            figure for each kind of error: 1 % of a scale or a momentum, 0.01 rad of an angle, 10 to 30 ms of a delay
            or a lag, torques and impulses of 0.1 to 1 % of what the cluster can give.
        lower: smallest value that is searched. Source: convention, 0 where a negative value would supply energy or
            precede its cause, -1 of a gain, which is then gone; else as `upper`.
        upper: largest value that is searched; infinite where the fit needs no bound. Source: chosen, 16 times
            `typical` or more, by which the motion would be another one; 1 of a share, 0.9 of a correlation. A frequency
            stays within what a run of 5 s and a gyro at 16 Hz show: one period in the run, and less than 8 Hz.
        absent: value at which the effect does nothing.
        scanned: whether searches start from many values of it, such as a frequency or an instant; at those starts the
            effect is next to nothing, so that this parameter changes nothing.
        plausible: what hardware shows, from least to greatest; a name with a value beyond it carries a warning. Of
            forces and masses, which go with the size of the platform, `PLAUSIBLE_PER_INERTIA` says it.
        usual_at_bound: whether hardware is beyond what is searched and no sample tells by how much, such as a friction
            that changes its sign within less of a rate: it carries no warning.
    """

    name: str
    unit: str
    typical: float
    lower: float = -np.inf
    upper: float = np.inf
    absent: float = 0.0
    scanned: bool = False
    plausible: tuple[float, float] = (-np.inf, np.inf)
    usual_at_bound: bool = False

    def lies_at_bound(self, value: float) -> bool:
        """Return whether a value lies where a search ends, and not where the effect is absent or as it typically is."""
        if self.usual_at_bound or value in (self.absent, self.typical):
            return False
        return value in (self.lower, self.upper)

    def growth_on(self, moment: float) -> float:
        """Return how many times as far searches go on a platform of a mean moment of inertia, at least once.

        Args:
            moment: kg·m².
        """
        return max(1.0, moment / TYPICAL_INERTIA) if self.unit in _GROWING else 1.0

    def typical_on(self, moment: float) -> float:
        """Return the typical distance from where the effect is absent, on a platform of a mean moment of inertia.

        Args:
            moment: kg·m².
        """
        with_inertia = self.unit in PLAUSIBLE_PER_INERTIA and moment > 0.0
        return abs(self.typical - self.absent) * (moment / TYPICAL_INERTIA if with_inertia else 1.0)

    def is_plausible(self, value: float) -> bool:
        """Return whether hardware has such a value."""
        return self.plausible[0] <= value <= self.plausible[1]


_GROWING = frozenset({"kg", "kg·m²"})
"""Units of what is searched the farther the larger the platform is; forces have bounds far beyond any platform's."""
PLAUSIBLE_PER_INERTIA = {
    "N·m": 10.0,
    "N·m·s": 10.0,
    "N·m/rad": 1e3,
    "N·m·s/rad": 10.0,
    "N·m·s²/rad²": 10.0,
    "kg·m²": 0.5,
    "kg": 37.5,
}
"""Largest parameters, by their units, over the platform's mean moment of inertia: accelerations of 10 rad/s², jumps
of 10 rad/s, a pendulum of 5 Hz, motions that stop within a tenth of a second, half of the inertia, a quarter of it in a
mass at the arm of slosh, 0.08 m. A platform with more is held by more than what is looked for here; typical effects are
a hundredth of it. They decide warnings alone."""

TYPICAL_INERTIA = 0.024
"""kg·m², mean moment of inertia of the class of platforms whose typical sizes parameters state: that of the shipped
nominal platform (`scenarios/diagnose.toml`). Forces and inertias, by their units in `PLAUSIBLE_PER_INERTIA`, go with
it."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number as reports and files show it.

    Attributes:
        name: with its unit suffix, e.g. `bandwidth_hz`.
        unit: e.g. `Hz`.
        value: in that unit.
        std: its standard error.
    """

    name: str
    unit: str
    value: float
    std: float


@dataclass(frozen=True, kw_only=True)
class Extension:
    """What an effect adds to a flying model.

    Attributes:
        platform: parts and torques that are added to the MJCF.
        scenario: keys of the scenario that change, by section, e.g. `{"gyro": {"latency_s": 0.01}}`.
    """

    platform: Sequence[Addition] = ()
    scenario: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


_PLACES = {
    "gyro": "the gyro",
    "platform": "the platform",
    "cluster": "the cluster",
    "actuators": "the actuators",
    ALL_WHEELS: "the wheels",
}
_PLACES |= {number: f"actuator {number}" for number in THRUSTERS}
_PLACES |= {axis: f"the gyro's {axis} axis" for axis in AXES}


class NamedEffect(ABC):
    """A row of the table of effects, whatever way it is found.

    Attributes:
        id: as in diagnosis.json.
        components: where it can sit; the parameters of two components are different hypotheses.
        parameters: in the order of the values.
        needs: channels without which it cannot be tested for.
        sentence: what it is, for the report; `{component}` stands for the place.
        look_alikes: ids of effects that are confounded with it: their signatures are nearly the same.
        confirm: the experiment that would distinguish it from them.
        measured_by: channels that show what it does: with one of them it is no deviation from what is predicted.
        yields_to: ids of effects that are named before it where the data say as much for them: the more usual ones.
        includes: ids of effects that are cases of it, as a weak actuator is one of constant torques: they say more and
            go before it where they are indistinguishable.
        flies: whether a flying model can have it; the extension of one that cannot is empty.
        environment: `kind` of the one in which it acts; empty where it may act in any.
        recurs: whether it acts in every run; what happened once says nothing of the other runs.
    """

    id: str
    components: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    needs: tuple[Channel, ...] = ("any_actuator",)
    sentence: str
    look_alikes: tuple[str, ...] = ()
    confirm: str
    measured_by: ClassVar[tuple[Channel, ...]] = ()
    yields_to: ClassVar[tuple[str, ...]] = ()
    includes: tuple[str, ...] = ()
    flies: bool = True
    environment: ClassVar[Literal["", "air_bearing", "orbit"]] = ""
    recurs: bool = True

    def described(self, component: str) -> str:
        """Return a sentence that describes it at its component."""
        sentence = self.sentence.format(component=_PLACES.get(component, component))
        return sentence[0].upper() + sentence[1:]

    def measured(self, component: str, quantities: Sequence[Quantity]) -> str:  # noqa: ARG002 - for those that say more
        """Return what describes it with its parameters as they were found."""
        return self.described(component)

    @abstractmethod
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        """Return how a flying model with this effect differs from one without.

        Args:
            component: where it sits.
            values: of the parameters, shape (K,).
            scenario: without the effect.
        """

    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        """Return the parameters as they are reported: as they are, unless another number says more.

        Args:
            values: of the parameters, shape (K,).
            std: their standard errors, shape (K,).
        """
        return tuple(
            Quantity(name=parameter.name, unit=parameter.unit, value=float(value), std=float(error))
            for parameter, value, error in zip(self.parameters, values, std, strict=True)
        )


class Effect(NamedEffect):
    """An effect on what is predicted; a class derived from it adds one.

    Another package names its class under the entry point `testbed.effects`; one of the library has a line in
    `testbed/effects/registry.py`. docs/effects.md has an example of each.

    Attributes:
        confounds: ids of effects that it confounds in the same unit, by details of it that are not predicted.
        instant: name of the parameter that is an instant in the runs laid end to end; empty where none is.
    """

    confounds: ClassVar[tuple[str, ...]] = ()
    instant: ClassVar[str] = ""

    @abstractmethod
    def hooks(self, component: str) -> Hooks:
        """Return how it enters the prediction."""

    def starts(self, component: str, grid: Grid) -> Array:  # noqa: ARG002 - for those that scan
        """Return values from which to search, and at which its signature is taken, shape (S, K).

        One row, at which it is absent, unless a frequency or an instant has to be scanned.
        """
        return np.array([[parameter.absent for parameter in self.parameters]])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest values of the parameters, each of shape (K,)."""
        return np.array([each.lower for each in self.parameters]), np.array([each.upper for each in self.parameters])

    @property
    def scans_frequencies(self) -> bool:
        """Whether it starts from one frequency after the other, its first parameter."""
        return self.parameters[0].scanned and self.parameters[0].unit == "Hz"

    def reach(self, start: Array) -> tuple[Array, Array]:  # noqa: ARG002 - for those that start at a speck
        """Return the least and greatest values that a search from a start can come to, each of shape (K,).

        Args:
            start: one of `starts`, shape (K,).
        """
        return self.bounds

    def unresolved(self, grid: Grid) -> Array:  # noqa: ARG002 - for those that happen between samples
        """Return what runs cannot resolve of each parameter though the fit seems to, a standard deviation, shape (K,).

        What is no larger is no evidence of the effect, but for an instant, which is never absent.

        Args:
            grid: the runs.
        """
        return np.zeros(len(self.parameters))

    def scan_count(self, component: str, grid: Grid) -> int:
        """Return how many start values a scan from its starts amounts to, by which chance is multiplied."""
        return len(self.starts(component, grid))


CLUSTER = "cluster"
"""All units alike, where a component is asked for."""


def unit_index(component: str) -> int:
    """Return the index, from 0, of the CMG unit that a component such as `cmg3` names."""
    return UNITS.index(component)


def wheel_index(component: str) -> int:
    """Return the index, from 0, of the reaction wheel that a component such as `wheel3` names."""
    return WHEELS.index(component)


def wheels_named(component: str) -> int | slice:
    """Return the index, from 0, of the reaction wheel that a component names, or a slice of all of them."""
    return slice(None) if component == ALL_WHEELS else wheel_index(component)


def components_in(effect: NamedEffect, units: int, wheels: int = 0, thrusters: int = 0) -> tuple[str, ...]:
    """Return where an effect can sit on a platform with so many CMG units, wheels, and thrusters with commands."""
    all_is_one = wheels == 1 and WHEELS[0] in effect.components
    all_wheels = [ALL_WHEELS] if not wheels or all_is_one else []
    absent = (*UNITS[units:], *WHEELS[wheels:], *all_wheels, *THRUSTERS[thrusters:])
    return tuple(component for component in effect.components if component not in absent)


def components_flown(effect: NamedEffect, scenario: Scenario) -> tuple[str, ...]:
    """Return where an effect can sit on the platform of a scenario that flies."""
    return components_in(effect, scenario.gyros.units, wheel_count(scenario.actuators))


def thruster_index(component: str) -> int:
    """Return the index, from 0, of the thruster that a component such as `3` names."""
    return THRUSTERS.index(component)


def only_unit(component: str, value: Array, units: int) -> Array:
    """Return values for all M units of which only the component's is not zero, shape (..., M).

    Args:
        component: e.g. `cmg3`.
        value: shape (...,).
        units: M.
    """
    return np.asarray(value[..., None] * (np.arange(units) == unit_index(component)))


def only_wheel(component: str, value: Array, wheels: int) -> Array:
    """Return the first parameter for all W wheels, zero for those that the component does not name, shape (P, W).

    Args:
        component: e.g. `wheel3`, or `wheels`.
        value: shape (P, K).
        wheels: W.
    """
    named = component == ALL_WHEELS or np.arange(wheels) == wheel_index(component)
    return np.asarray(value[:, :1] * np.broadcast_to(named, wheels))
