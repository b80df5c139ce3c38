"""One palette for pages and recordings: a colour means the same in both."""

from __future__ import annotations

import re

import pytest

from support.processes import ROOT
from testbed.palette import SHADES
from testbed.recording import palette as recording
from testbed.report.frame.blocks import Notice, Page
from testbed.report.frame.page import render_page

LEGIBLE = 3.0
"""Contrast that a line needs against its ground (WCAG 2.1, 1.4.11)."""
WHOSE = ("measured", "true", "reference", "nominal", "extended", "fitted", "held-out")


def luminance(color: str) -> float:
    """Return the relative luminance of `#rrggbb` (WCAG 2.1)."""
    channels = [channel / 255 for channel in bytes.fromhex(color[1:])]
    linear = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


def test_the_style_sheet_has_the_palette_in_light_and_in_dark():
    page = Page(title="t", subtitle="", verdict=Notice(text="", tone="good"), notices=(), sections=())
    light, dark = render_page(page).split("@media (prefers-color-scheme: dark)")[:2]
    for name, shade in SHADES.items():
        assert f"--{name}: {shade.on_white};" in light
        assert f"--{name}: {shade.on_dark};" in dark


def test_the_recording_has_the_pages_dark_colours():
    assert recording.AXIS_COLORS == ((255, 138, 76), (53, 199, 154), (108, 182, 255))
    assert recording.colors_of("xyz") == recording.AXIS_COLORS
    assert SHADES["measured"].dark_rgb == recording.MEASURED_COLOR
    assert SHADES["nominal"].dark_rgb == recording.NOMINAL_COLOR
    assert SHADES["extended"].dark_rgb == recording.EXTENDED_COLOR


@pytest.mark.parametrize("name", WHOSE)
def test_whose_value_it_is_can_be_seen_on_either_ground(name):
    assert contrast(SHADES[name].on_white, "#ffffff") >= LEGIBLE
    assert contrast(SHADES[name].on_dark, "#12151c") >= LEGIBLE


def test_the_colours_of_axes_stand_for_axes_alone():
    """A page that took them for fitted and held-out runs showed x and z where neither was meant."""
    pages = [
        path for path in (ROOT / "testbed" / "report").rglob("*.py") if re.search(r'"axis-[xyz]"', path.read_text())
    ]
    assert pages == []
