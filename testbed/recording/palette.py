"""Colours of the recording, RGB; one meaning each, the same in every view."""

from __future__ import annotations

from typing import TypeAlias

Color: TypeAlias = tuple[int, int, int]

AXIS_COLORS: tuple[Color, ...] = ((239, 83, 80), (102, 187, 106), (79, 145, 255))
"""Body axes x, y, z; those of the axes drawn on the platform."""

UNIT_COLORS: tuple[Color, ...] = (
    (86, 180, 233),
    (230, 159, 0),
    (0, 190, 140),
    (240, 228, 66),
    (213, 110, 60),
    (204, 121, 190),
)
"""CMG units, in order; distinguishable by colour-blind readers."""

SINGLE_COLORS: tuple[Color, ...] = ((140, 150, 172),)
LIMIT_COLOR: Color = (190, 70, 90)

CLUSTER_MOMENTUM_COLOR: Color = (255, 193, 7)
TOTAL_MOMENTUM_COLOR: Color = (186, 104, 200)
BODY_RATE_COLOR: Color = (77, 208, 225)

ESTIMATOR_COLORS: tuple[Color, ...] = ((239, 140, 60), (86, 180, 233), (102, 187, 106), (204, 121, 190))
TRUTH_COLOR: Color = (235, 235, 240)
NOMINAL_COLOR: Color = (190, 70, 90)
BOUND_COLOR: Color = (70, 78, 96)
GRID_COLOR: Color = (120, 125, 135)

FREE_COLOR: Color = (45, 60, 55)
SATURATED_COLORS: tuple[Color, ...] = ((230, 159, 0), (213, 70, 60), (186, 104, 200))
"""No limit reached; then gimbal rate, gimbal torque, rotor momentum."""


def colors_of(components: int) -> tuple[Color, ...]:
    """Return the colours of a single number, or of the components along three axes."""
    return {1: SINGLE_COLORS, 3: AXIS_COLORS}[components]


def unit_colors(units: int) -> tuple[Color, ...]:
    """Return a colour for each unit; of more than six, they come again."""
    return tuple(UNIT_COLORS[index % len(UNIT_COLORS)] for index in range(units))


def pale(color: Color) -> Color:
    """Return a colour mixed half and half with the dark background, for what stays behind."""
    red, green, blue = ((channel + 40) // 2 for channel in color)
    return red, green, blue
