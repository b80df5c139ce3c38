"""What a diagnosis advises where no flight can be designed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.findings import noise_notices
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.reference import reference_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.next import no_design_words, same_inertia_words


def added(effect, component, *others):
    alike = tuple(Hypothesis(effect=EFFECTS[name], component=place) for name, place in others)
    return SimpleNamespace(effect=EFFECTS[effect], component=component, look_alikes=alike)


def test_the_experiments_are_those_of_the_effects_that_look_alike():
    """Late telemetry beside a late gyro: advice against a low-pass, which nobody had suspected, was all."""
    (words,) = no_design_words(SimpleNamespace(added=[added("gyro_latency", "gyro", ("telemetry_skew", "actuators"))]))
    assert f"gyro_latency: {EFFECTS['gyro_latency'].confirm}" in words
    assert f"telemetry_skew: {EFFECTS['telemetry_skew'].confirm}" in words


def test_of_what_has_no_look_alike_there_is_no_advice():
    assert not list(no_design_words(SimpleNamespace(added=[added("body_torque", "platform")])))


def state_of(nominal_factor):
    """A diagnosis of two runs at zero momentum against a nominal inertia that is off by a factor."""
    scenario, platform = nominal()
    data = data_set_of(records(2), scenario, platform)
    effects = {name: EFFECTS[name] for name in ("gyro_scale", "viscous_drag")}
    *_, last = diagnosed(data.runs, data.heldout, effects, nominal_factor * theta_of(platform.inertia))
    return last


def test_where_the_inertia_changed_what_passes_for_that_is_said():
    """A gyro's scale of 1.5 % moved J by 65 standard deviations, and nothing said that their interval leaves it out."""
    (words,) = same_inertia_words(state_of(0.95))
    assert "gyro_scale (x, y, z)" in words
    assert "viscous_drag" not in words


def test_where_the_inertia_is_the_nominal_one_nothing_is_said_of_it():
    assert not list(same_inertia_words(state_of(1.0)))


def test_where_the_inertia_changed_beside_a_reference_that_is_said_as_well():
    scenario, platform = nominal()
    healthy, theta = data_set_of(records(3), scenario, platform), 0.95 * theta_of(platform.inertia)
    effects = {"gyro_scale": EFFECTS["gyro_scale"]}
    *_, reference = diagnosed(healthy.runs, healthy.heldout, effects, theta)
    suspect = data_set_of(records(2), scenario, platform).against(reference_of(reference))
    *_, last = diagnosed(suspect.runs, suspect.heldout, effects, theta, given=suspect.given)
    assert "gyro_scale (x, y, z)" in "".join(same_inertia_words(last))


@pytest.mark.parametrize(("stated", "words"), [(True, "is stated too large"), (False, "which no record states")])
def test_noise_that_is_taken_for_too_large_is_called_stated_where_it_is(stated, words):
    noise = SimpleNamespace(overstated=True, ratio=np.array([0.64, 0.64, np.nan]))
    (notice,) = noise_notices(SimpleNamespace(noise=noise, runs=SimpleNamespace(noise_stated=stated)))
    assert words in notice
    assert "0.64 times" in notice
