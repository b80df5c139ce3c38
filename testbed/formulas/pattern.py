"""A torque by formulas whose sizes, and some of whose constants, are to be estimated: a hypothesis of the grammar."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.formulas.law import Law
from testbed.formulas.motion import Moment
from testbed.formulas.parser import parsed
from testbed.formulas.torque import Frame, Torque, along, follows_motion, reads_attitude

Placement: TypeAlias = Literal["x", "y", "z", "B", "N"]
"""Where a torque points: along a body axis, or in a direction that is estimated and fixed in B or in N."""
PLACEMENTS: tuple[Placement, ...] = ("x", "y", "z", "B", "N")
_TEXT = re.compile(r"(?P<laws>.+) (?:about (?P<axis>[xyz])|in (?P<frame>[BN]))")


def axes_of(placement: Placement) -> Array:
    """Return the directions of the coefficients of a law, shape (D, 3)."""
    return np.eye(3)["xyz".index(placement)][None] if placement in "xyz" else np.eye(3)


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Laws with common constants, each with coefficients of its own along the same axes.

    Attributes:
        laws: one, or the sine and cosine of one frequency.
        placement: where the torque points.
    """

    laws: tuple[Law, ...]
    placement: Placement

    def __str__(self) -> str:
        place = f"about {self.placement}" if self.placement in "xyz" else f"in {self.placement}"
        return f"{' + '.join(map(str, self.laws))} {place}"

    @property
    def frame(self) -> Frame:
        """Whose axes the coefficients are along."""
        return "N" if self.placement == "N" else "B"

    @property
    def axes(self) -> Array:
        """Directions of the coefficients, shape (D, 3)."""
        return axes_of(self.placement)

    @property
    def names(self) -> tuple[str, ...]:
        """Constants that are estimated, in order."""
        return tuple(dict.fromkeys(name for law in self.laws for name in law.names))

    @property
    def length(self) -> int:
        """By which its prior falls; a direction that is estimated is one constant more."""
        return max(law.length for law in self.laws) + (self.placement in "BN")

    @property
    def states(self) -> int:
        """Number of states that its memories integrate."""
        return sum(law.states for law in self.laws)

    @property
    def reads_attitude(self) -> bool:
        """Whether the torque depends on the attitude."""
        return any(reads_attitude(law, self.frame) for law in self.laws)

    @property
    def follows_motion(self) -> bool:
        """Whether the body's own motion changes the torque."""
        return any(follows_motion(law, self.frame) for law in self.laws)

    def constants(self, value: Array) -> Mapping[str, Array]:
        """Return the named constants of parameter sets of shape (P, K), each (P,)."""
        return {name: value[..., index] for index, name in enumerate(self.names)}

    def coefficients(self, value: Array) -> Array:
        """Return the coefficients of each law, shape (P, laws, 3), of parameter sets of shape (P, K)."""
        sizes = value[..., len(self.names) :].reshape(*value.shape[:-1], len(self.laws), len(self.axes))
        return np.asarray(sizes @ self.axes)

    def torque(self, value: Array, at: Moment, state: Array) -> Array:
        """Return the torque, shape (..., P, 3), N·m, body axes.

        Args:
            value: parameters, constants before coefficients, shape (P, K).
            at: the instant; its arrays broadcast against (..., P).
            state: of the memories, shape (..., P, `states`).
        """
        constants, sizes = self.constants(value), self.coefficients(value)
        parts = [
            law.value(at, own, constants)[..., None] * sizes[:, index]
            for index, (law, own) in enumerate(self._own(state))
        ]
        return along(self.frame, np.asarray(sum(parts[1:], parts[0])), at)

    def first_state(self, value: Array, at: Moment) -> Array:
        """Return the memories' states at the first sample, shape (..., P, `states`)."""
        return _joined([law.first_state(at, self.constants(value)) for law in self.laws])

    def state_rate(self, value: Array, at: Moment, state: Array) -> Array:
        """Return the rates of change of the memories' states."""
        return _joined([law.state_rate(at, own, self.constants(value)) for law, own in self._own(state)])

    def torques(self, value: Array) -> tuple[Torque, ...]:
        """Return what is flown with parameters of shape (K,): laws with numbers for their constants."""
        named = {name: float(number) for name, number in zip(self.names, value, strict=False)}
        sizes = self.coefficients(value)
        return tuple(
            Torque(law=law.with_numbers(named), coefficient=sizes[index], frame=self.frame)
            for index, law in enumerate(self.laws)
        )

    def _own(self, state: Array) -> Iterator[tuple[Law, Array]]:
        edges = list(accumulate((law.states for law in self.laws), initial=0))
        return ((law, state[..., edges[index] : edges[index + 1]]) for index, law in enumerate(self.laws))


def contains(wider: Pattern, narrower: Pattern) -> bool:
    """Return whether one formula becomes another where parameters vanish: parts of a direction, a lag or a delay."""
    same = wider.placement == narrower.placement or (wider.placement == "B" and narrower.placement in "xyz")
    laws = all(
        law == other or (law.memory in ("lag", "delay") and Law.of(*law.factors) == other)
        for law, other in zip(wider.laws, narrower.laws, strict=False)
    )
    return same and laws and len(wider.laws) == len(narrower.laws) and wider != narrower


def pattern_of(text: str) -> Pattern:
    """Return the pattern that a text says, such as `w_x*w_y about z` or `lag(w_x, tau) in B`.

    Raises:
        InputError: the text is none.
    """
    match = _TEXT.fullmatch(text)
    if match is None:
        raise InputError(f"{text!r} says no axis; end it with about x, about y, about z, in B or in N")
    laws = tuple(parsed(each, named_constants=True) for each in match["laws"].split(" + "))
    placement: Placement = next(each for each in PLACEMENTS if each in (match["axis"], match["frame"]))
    return Pattern(laws=laws, placement=placement)


def _joined(parts: Sequence[Array]) -> Array:
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)
