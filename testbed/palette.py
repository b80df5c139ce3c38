"""The colours of pages and recordings: one meaning each, the same everywhere.

Where a chart shows several body axes, CMG units or estimators, the hue says which, and the stroke says whose value it
is: samples as points, a reference pale or dashed. Where it shows one axis, the hue says whose: measured, true,
reference, or predicted by the nominal or the extended model.

On white, the lightness of units, axes and estimators was chosen so that protanopes, deuteranopes and tritanopes tell
any two apart, by 17 units of CIE Lab or more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

Color: TypeAlias = tuple[int, int, int]
"""Red, green, blue, 0 to 255."""


@dataclass(frozen=True)
class Shade:
    """One colour of the palette, as `#rrggbb`.

    Attributes:
        on_white: on paper and in bright rooms.
        on_dark: in dark ones, and in recordings, whose viewer is dark.
    """

    on_white: str
    on_dark: str

    @property
    def dark_rgb(self) -> Color:
        """The colour on dark ground as a recording takes it."""
        red, green, blue = bytes.fromhex(self.on_dark.removeprefix("#"))
        return red, green, blue


SHADES: Mapping[str, Shade] = {
    "axis-x": Shade("#d55e00", "#ff8a4c"),
    "axis-y": Shade("#009e73", "#35c79a"),
    "axis-z": Shade("#0072b2", "#6cb6ff"),
    "unit-1": Shade("#62aac4", "#56b4e9"),
    "unit-2": Shade("#75540d", "#e69f00"),
    "unit-3": Shade("#1b7459", "#00be8c"),
    "unit-4": Shade("#99a61a", "#f0e442"),
    "unit-5": Shade("#4e150e", "#d56e3c"),
    "unit-6": Shade("#841775", "#cc79be"),
    "estimator-1": Shade("#d97706", "#ef8c3c"),
    "estimator-2": Shade("#2f9be0", "#56b4e9"),
    "estimator-3": Shade("#007a58", "#66bb6a"),
    "estimator-4": Shade("#a3468a", "#cc79be"),
    # Whose value it is.
    "measured": Shade("#75808f", "#aab3c2"),
    "true": Shade("#1d2430", "#f0f2f6"),
    "reference": Shade("#00818f", "#4dd0e1"),
    "nominal": Shade("#b26a00", "#ffc247"),
    "extended": Shade("#6f42c1", "#b79cff"),
    # Whether a run was fitted.
    "fitted": Shade("#2f5d8a", "#8fb8e8"),
    "held-out": Shade("#b3327a", "#f48fc0"),
    # A number that is of no axis and no unit, and what it must not exceed.
    "single": Shade("#4f5b6e", "#a3aec2"),
    "limit": Shade("#a8324a", "#e57a90"),
    # Two effects that the data confound, or distinguish.
    "alike": Shade("#b3327a", "#f48fc0"),
    "apart": Shade("#2f5d8a", "#8fb8e8"),
    # The paper's red, yellow and blue, and this project's cyan and green.
    "maneuver-basic": Shade("#c8372d", "#ef5350"),
    "maneuver-scaled": Shade("#a88a00", "#f0c842"),
    "maneuver-paper_d_optimal": Shade("#2b5fc9", "#4f91ff"),
    "maneuver-gimbal_slow": Shade("#00818f", "#4dd0e1"),
    "maneuver-gimbal_weighted": Shade("#2f8f3a", "#66bb6a"),
}
"""Every colour by name; a page has it as the custom property `--name`."""

AXIS_SHADES = ("axis-x", "axis-y", "axis-z")
UNIT_SHADES = ("unit-1", "unit-2", "unit-3", "unit-4", "unit-5", "unit-6")
ESTIMATOR_SHADES = ("estimator-1", "estimator-2", "estimator-3", "estimator-4")
SINGLE_SHADES = ("single",)


def component_shades(components: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the colours of a signal's components: body axes, numbered units, or a single number.

    Of more than six units, the colours come again.
    """
    if len(components) == len(AXIS_SHADES) and components[0] != "1":
        return AXIS_SHADES
    if len(components) == 1 and components[0] != "1":
        return SINGLE_SHADES
    return tuple(UNIT_SHADES[index % len(UNIT_SHADES)] for index in range(len(components)))
