"""Colours of the recording, RGB: those of `testbed.palette` on dark ground, and those that no page has."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.palette import AXIS_SHADES, ESTIMATOR_SHADES, SHADES, UNIT_SHADES, Color, component_shades

AXIS_COLORS: tuple[Color, ...] = tuple(SHADES[name].dark_rgb for name in AXIS_SHADES)
UNIT_COLORS: tuple[Color, ...] = tuple(SHADES[name].dark_rgb for name in UNIT_SHADES)
ESTIMATOR_COLORS: tuple[Color, ...] = tuple(SHADES[name].dark_rgb for name in ESTIMATOR_SHADES)
LIMIT_COLOR: Color = SHADES["limit"].dark_rgb
MEASURED_COLOR: Color = SHADES["measured"].dark_rgb
TRUTH_COLOR: Color = SHADES["true"].dark_rgb
NOMINAL_COLOR: Color = SHADES["nominal"].dark_rgb
EXTENDED_COLOR: Color = SHADES["extended"].dark_rgb

CLUSTER_MOMENTUM_COLOR: Color = (205, 220, 57)
TOTAL_MOMENTUM_COLOR: Color = (186, 104, 200)
BODY_RATE_COLOR: Color = (77, 208, 225)

BOUND_COLOR: Color = (70, 78, 96)
GRID_COLOR: Color = (120, 125, 135)

FREE_COLOR: Color = (45, 60, 55)
SATURATED_COLORS: tuple[Color, ...] = ((230, 159, 0), (213, 70, 60), (186, 104, 200))
"""No limit reached; then gimbal rate, gimbal torque, rotor momentum."""


def colors_of(components: Sequence[str]) -> tuple[Color, ...]:
    """Return the colours of a signal's components, by their names."""
    return tuple(SHADES[name].dark_rgb for name in component_shades(components))


def pale(color: Color) -> Color:
    """Return a colour mixed half and half with the dark background, for what stays behind."""
    red, green, blue = ((channel + 40) // 2 for channel in color)
    return red, green, blue
