"""What is detectable of an effect whose frequency is not known: at each frequency, and at the worst of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.detectable import _over_frequencies, detectable_sizes, first_screening
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import result_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.sizes import size_lines
from testbed.report.diagnosis.visibility import visibility_section


@cache
def state():
    scenario, platform = nominal()
    data = data_set_of(records(2), scenario, platform)
    effects = {name: EFFECTS[name] for name in ("flexible_appendage", "gyro_latency")}
    *_, last = diagnosed(data.runs, data.heldout, effects, theta_of(platform.inertia))
    return last


def appendage():
    return next(size for size in detectable_sizes(state()) if size.placed.effect.id == "flexible_appendage")


def test_the_headline_holds_at_every_frequency():
    size = appendage()
    multiples = np.array([each.multiple for each in size.by_frequency])
    frequencies = np.array([each.smallest[0].value for each in size.by_frequency])
    assert size.multiple == multiples.max()
    assert multiples.max() > 3.0 * multiples.min()  # one number would not do for all
    assert (np.diff(frequencies) > 0.0).all()
    for each in size.by_frequency:
        inertia = next(quantity for quantity in each.smallest if quantity.name == "inertia_kg_m2")
        typical = np.linalg.norm([4e-4, 2e-4, 3e-4])
        assert inertia.value == pytest.approx(each.multiple * typical, rel=1e-6)


def test_where_no_size_shows_at_a_frequency_none_is_said():
    """A gyro at 2 Hz shows nothing of a mode at 6 Hz: a warning of invalid values stood in the terminal."""
    known = next(each for each in first_screening(state()).signatures if each.reaches)
    unseen = replace(known.reaches[-1], absent=known.reaches[-1].absent + 1.0, length=0.0)
    size = _over_frequencies(replace(known, reaches=(*known.reaches, unseen)), tested=2)
    assert size.multiple == np.inf
    assert size.smallest == ()
    assert all(each.smallest for each in size.by_frequency[:-1])


def test_the_table_has_the_range_and_the_page_the_curve():
    line = next(line for line in size_lines(state()) if line.effect == "flexible_appendage")
    assert " to " in line.smallest
    assert " to " in line.multiple
    assert "axis x 0.743, axis y 0.371, axis z 0.557" in line.typical  # not three times "axis"
    (section, *_) = visibility_section(state())
    assert any("by frequency" in getattr(block, "title", "") for block in section.blocks)


def test_the_file_has_every_frequency():
    shown = {each["effect"]: each for each in result_of(state(), (), ())["detectable"]}
    assert len(shown["flexible_appendage"]["by_frequency"]) == len(appendage().by_frequency)
    assert shown["gyro_latency"]["by_frequency"] == []
