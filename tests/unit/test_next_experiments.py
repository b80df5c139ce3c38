"""What a diagnosis advises where no flight can be designed."""

from __future__ import annotations

from types import SimpleNamespace

from testbed.diagnosis.model import Hypothesis
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.next import no_design_words


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
