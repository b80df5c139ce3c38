"""What a campaign is to end with: the name of an effect, or the inertia to a standard deviation."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, log

import numpy as np

from testbed.arrays import Flags, Theta
from testbed.diagnosis.testable import INNER_CHANNELS
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.effects.contract import components_flown
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError
from testbed.scenario.scenario import Scenario

ANY = "any"
"""Wish for the name of whichever effect is there."""


@dataclass(frozen=True, kw_only=True)
class EffectWanted:
    """The name of an effect.

    Attributes:
        effect: id; None for any.
        component: where; None for anywhere.
    """

    effect: str | None = None
    component: str | None = None

    @property
    def text(self) -> str:
        """As it is given: `any`, `rotor_speed`, `rotor_speed:cmg3`."""
        if self.effect is None:
            return ANY
        return self.effect if self.component is None else f"{self.effect}:{self.component}"

    def allows(self, key: str) -> bool:
        """Return whether a hypothesis is one of those."""
        effect, _, component = key.partition(":")
        return self.effect in (None, effect) and self.component in (None, component)


@dataclass(frozen=True, kw_only=True)
class InertiaWanted:
    """The inertia to a standard deviation.

    Attributes:
        std: of each parameter, kg·m², by its name, `J11` to `J12`; parameters without one may have any.
    """

    std: Mapping[str, float]

    @property
    def text(self) -> str:
        """As it is given: `J11=1e-05,J22=1e-05`."""
        return ",".join(f"{name}={value:g}" for name, value in self.std.items())

    @property
    def limits(self) -> Theta:
        """Of all parameters, shape (6,), kg·m²; infinite where none is wanted."""
        return np.array([self.std.get(name, np.inf) for name in PARAMETER_NAMES])

    def reached(self, std: Theta) -> Flags:
        """Return which parameters are known as well as wanted, shape (6,)."""
        return np.asarray(std <= self.limits)


Wanted = EffectWanted | InertiaWanted


def effect_wanted(text: str) -> EffectWanted:
    """Return the wish for a name.

    Args:
        text: `any`, an effect's id, or ID:COMPONENT.

    Raises:
        InputError: there is no such effect or component, or no further flight brings evidence of it: it happens once,
            is estimated anyway, or does not show in the gyro's samples.
    """
    if text == ANY:
        return EffectWanted()
    effect, colon, component = text.partition(":")
    if effect in NOISE_EFFECTS:
        raise InputError(f"{text}: changes the noise, of which no e-value tells; diagnose the flights")
    if effect not in EFFECTS:
        near = difflib.get_close_matches(effect, EFFECTS, n=3)
        named = f"did you mean {', '.join(near)}?" if near else f"there are {', '.join(EFFECTS)};"
        raise InputError(f"{text}: there is no effect {effect!r}; {named} `{ANY}` stands for all of them")
    found = EFFECTS[effect]
    if not found.recurs:
        raise InputError(f"{text}: acts in one flight only, so that no further one can verify it; diagnose that flight")
    if effect == "inertia":
        raise InputError(f"{text}: is estimated beside whatever is tested, and asked for as --inertia-std, not by name")
    if uncounted := [channel for channel in found.needs if channel in INNER_CHANNELS]:
        raise InputError(
            f"{text}: shows in {' and '.join(uncounted)}, and a plan counts the gyro's alone; diagnose the flights"
        )
    if colon and component not in found.components:
        raise InputError(f"{text}: {effect} has no component {component!r}; it has {', '.join(found.components)}")
    return EffectWanted(effect=effect, component=component or None)


def require_component(wish: EffectWanted, scenario: Scenario) -> None:
    """Refuse a wish for the name of what a platform does not have: no flight of it could bring evidence.

    Args:
        wish: for a name.
        scenario: of the platform.

    Raises:
        InputError: the effect, or its component, is not there; the message names those that are.
    """
    if wish.effect is None:
        return
    present = components_flown(EFFECTS[wish.effect], scenario)
    if not present:
        raise InputError(f"{wish.text}: {scenario.name} has no part that {wish.effect} could sit in")
    if wish.component not in (None, *present):
        raise InputError(f"{wish.text}: {scenario.name} has no {wish.component}; it has {', '.join(present)}")


def inertia_wanted(text: str) -> InertiaWanted:
    """Return the wish for an inertia.

    Args:
        text: a standard deviation of all six parameters, kg·m², or NAME=STD of some, commas between them.

    Raises:
        InputError: a parameter is none, or a standard deviation no positive number.
    """
    parts = [part.strip() for part in text.split(",")]
    if len(parts) == 1 and "=" not in text:
        value = _std(text, text)
        return InertiaWanted(std=dict.fromkeys(PARAMETER_NAMES, value))
    std: dict[str, float] = {}
    for part in parts:
        name, _, given = (each.strip() for each in part.partition("="))
        if name not in PARAMETER_NAMES:
            raise InputError(f"{part}: {name!r} is no inertia parameter; they are {', '.join(PARAMETER_NAMES)}")
        if name in std:
            raise InputError(f"{text}: {name} is given twice; once is enough")
        std[name] = _std(given, part)
    return InertiaWanted(std=std)


def _std(text: str, part: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not (isfinite(value) and value > 0.0):
        raise InputError(f"{part}: give a standard deviation in kg·m² above zero, such as 1e-5 or J11=1e-5,J22=2e-5")
    return value


@dataclass(frozen=True, kw_only=True)
class Named:
    """What a diagnosis of all flights so far says.

    Attributes:
        verdict: of the diagnosis.
        classes: of each effect in its model, the keys of the effects that these data cannot distinguish from it, the
            named one first.
        undecided: of each class, whether a flight of this platform would distinguish its members; all of them where
            something unknown is more probable.
    """

    verdict: str
    classes: Sequence[Sequence[str]]
    undecided: Sequence[bool]


def verified(wanted: EffectWanted, named: Named, log_e: Mapping[str, float], among: int, alpha: float) -> list[str]:
    """Return the class that may be named: the wanted one, in the diagnosis's verdict, its e-value at least 1/α.

    The e-value of a class is the sum of those of its members over the number of hypotheses that share the prior, one
    part of their mean. That the mean ever passes 1/α has at most the probability α without an effect, and so has that
    any class of all does: naming chooses among them at no further cost.

    Args:
        wanted: what may be named.
        named: what the diagnosis says.
        log_e: natural logarithm of every hypothesis's e-value.
        among: number of hypotheses that share the prior.
        alpha: probability of a false name.

    Returns:
        Keys, the named one first; none where nothing may be named, or a flight is left that would distinguish them.
    """
    if named.verdict not in {"named", "ambiguous"}:
        return []
    for members, undecided in zip(named.classes, named.undecided, strict=True):
        if undecided:
            continue
        values = [log_e[key] for key in members if key in log_e and wanted.allows(key)]
        if values and wanted.allows(members[0]) and _log_sum(values) - log(among) >= -log(alpha):
            return list(members)
    return []


def _log_sum(values: Sequence[float]) -> float:
    return float(np.logaddexp.reduce(values))
