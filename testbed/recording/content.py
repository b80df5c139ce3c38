"""What a recording shows besides the flight's own channels: limits, estimates, residuals, events, text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from testbed.arrays import Array, Series, Theta, Vectors3

ShownLimits: TypeAlias = Mapping[str, Array]
"""Levels that are drawn in plots, by the plots' names: upper and lower limit, one, or those of all body axes, first the
upper ones; in the plots' units."""


@dataclass(frozen=True, kw_only=True)
class ShownEstimate:
    """One estimator's result.

    Attributes:
        name: of the estimator.
        theta: θ̂, kg·m².
        std: its standard deviations, shape (6,), kg·m².
    """

    name: str
    theta: Theta
    std: Theta


@dataclass(frozen=True, kw_only=True)
class ShownResidual:
    """What an estimator could not explain, measured minus predicted, per body axis.

    Attributes:
        name: of the estimator.
        unit: of the residual, as printed.
        time: shape (M,), s.
        values: shape (M, 3).
    """

    name: str
    unit: str
    time: Series
    values: Vectors3


@dataclass(frozen=True, kw_only=True)
class ShownEvent:
    """Something that happened once.

    Attributes:
        time: s.
        text: one line.
    """

    time: float
    text: str


@dataclass(frozen=True, kw_only=True)
class RecordingContent:
    """All that a recording shows besides the flight's channels; what a run does not have stays empty.

    Attributes:
        limits: drawn beside their signals.
        nominal_theta: the model's θ before the flight, kg·m².
        true_theta: of the simulated platform, kg·m²; None for a measured flight.
        estimates: one per estimator.
        bound_std: square roots of the Cramér-Rao bound's diagonal, shape (6,), kg·m².
        residuals: one per estimator.
        envelope_fraction: share of the cluster's momentum envelope in use, shape (N,); 1 on its surface.
        events: in order of time.
        result: the result table, markdown.
        provenance: what made the run, markdown.
        properties: what a catalog lists of the run, such as its seed.
    """

    limits: ShownLimits
    nominal_theta: Theta
    true_theta: Theta | None = None
    estimates: tuple[ShownEstimate, ...] = ()
    bound_std: Theta | None = None
    residuals: tuple[ShownResidual, ...] = ()
    envelope_fraction: Series | None = None
    events: tuple[ShownEvent, ...] = ()
    result: str = ""
    provenance: str = ""
    properties: Mapping[str, str | float | int] = field(default_factory=dict)
