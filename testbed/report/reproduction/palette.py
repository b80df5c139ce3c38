"""Colours of the maneuvers, one meaning each, the same in every figure; custom properties of the style sheet."""

from __future__ import annotations

from collections.abc import Mapping

MANEUVER_COLORS: Mapping[str, str] = {
    "basic": "axis-x",
    "scaled": "unit-4",
    "paper_d_optimal": "axis-z",
    "gimbal_slow": "unit-5",
    "gimbal_weighted": "axis-y",
}
"""The paper's red, yellow and blue, and this project's green."""
