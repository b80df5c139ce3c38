"""An effect of the healthy flights that is another size in the suspect ones is what is new."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from testbed.assembly.extension import extended
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.diagnosis import changed as changed_module
from testbed.diagnosis.changed import changed_notices, without_changed
from testbed.diagnosis.findings import additions, changed_inertia
from testbed.diagnosis.fitting import fitted, starts_of
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.diagnosis.reference import Reference, reference_of
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.next_experiment.competing_hypotheses import hypothesis_pairs_of
from testbed.records.selection import telemetry_only
from testbed.report.diagnosis.verdict import diagnosis_verdict
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

LIBRARY = {name: EFFECTS[name] for name in ("wheel_torque_scale", "wheel_lag", "wheel_inertia", "gyro_scale")}
HEALTHY = {"wheel_torque_scale": 0.02}
HEALTHY_SEEDS, SUSPECT_SEEDS = (90351, 90352, 90353, 90354), (90361, 90362, 90363)


def scenario() -> Scenario:
    shipped = read_scenario(shipped_scenario("cubesat_wheels"))
    return shipped.model_copy(update={"simulation": shipped.simulation.model_copy(update={"duration_s": 12.0})})


def data_of(seeds: tuple[int, ...], **sizes: float) -> DataSet:
    """Fly with effects of these sizes in the third wheel."""
    nominal, hidden = nominal_platform(scenario()), scenario()
    for effect, size in sizes.items():
        hidden = extended(hidden, EFFECTS[effect].extension("wheel3", np.array([size]), hidden))
    maneuver = plan_maneuver(scenario(), nominal).maneuver
    flown = [fly_maneuver(hidden, nominal, true_platform(hidden), maneuver, seed).record for seed in seeds]
    named = [replace(each, details=replace(each.details, name=f"run {at}")) for at, each in enumerate(flown)]
    return data_set_of([telemetry_only(each) for each in named], scenario(), nominal)


def theta():
    return theta_of(nominal_platform(scenario()).inertia)


@cache
def healthy() -> Reference:
    data = data_of(HEALTHY_SEEDS, **HEALTHY)
    *_, final = diagnosed(data.runs, data.heldout, LIBRARY, theta())
    return reference_of(final)


def test_the_reference_has_what_the_healthy_flights_show():
    assert [each.key for each in healthy().given] == ["wheel_torque_scale:wheel3"]


def test_an_effect_that_has_grown_is_named_again_with_its_whole_size():
    data = data_of(SUSPECT_SEEDS, wheel_torque_scale=0.04)
    kept, changed = without_changed(healthy(), data.against(healthy()).runs, LIBRARY, theta())
    assert [each.key for each in changed] == ["wheel_torque_scale:wheel3"]
    assert kept.given == ()
    assert kept.belief.effects == ()
    (notice,) = changed_notices(healthy(), changed)
    assert "wheel_torque_scale (wheel3)" in notice
    known = data.against(kept)
    *_, final = diagnosed(known.runs, known.heldout, LIBRARY, theta(), given=known.given)
    (named,) = additions(final)
    assert (named.effect.id, named.component) == ("wheel_torque_scale", "wheel3")
    (size,) = named.quantities
    assert size.value == pytest.approx(0.04, abs=4.0 * size.std)


def test_an_effect_that_is_as_it_was_stays_in_the_nominal_model_beside_another():
    data = data_of(SUSPECT_SEEDS, wheel_lag=0.05, **HEALTHY)
    kept, changed = without_changed(healthy(), data.against(healthy()).runs, LIBRARY, theta())
    assert changed == ()
    assert kept is healthy()
    known = data.against(kept)
    *_, final = diagnosed(known.runs, known.heldout, LIBRARY, theta(), given=known.given)
    assert [each.effect.id for each in additions(final)] == ["wheel_lag"]


def test_look_alikes_are_compared_with_all_that_the_reference_has_in_the_model():
    """A model refitted without the effects of the reference has fewer rows: a diagnosis ended with exit code 70."""
    data = data_of(SUSPECT_SEEDS, wheel_lag=0.05, **HEALTHY).against(healthy())
    *_, final = diagnosed(data.runs, data.heldout, LIBRARY, theta(), given=data.given)
    step = final.steps[0]
    other = next(each for each in step.screening.candidates if each.placed.key != step.placed.key)
    alike = replace(
        step,
        screening=replace(
            step.screening,
            candidates=(step.candidate, replace(other, log_bayes_factor=step.candidate.log_bayes_factor)),
        ),
    )
    pairs = hypothesis_pairs_of(replace(final, steps=(alike, *final.steps[1:])))
    assert pairs is not None
    assert pairs.pairs


@pytest.mark.parametrize(("more", "is_new"), [(3.0, True), (30.0, False)])
def test_what_looks_like_the_change_does_not_hold_an_effect_to_the_reference(monkeypatch, more, is_new):
    """A torque about z that had grown was named as another one, which explained 480 where the change explained 479."""
    data = data_of(SUSPECT_SEEDS, wheel_torque_scale=0.04)
    runs = replace(data.against(healthy()).runs, belief=healthy().belief)
    fit = fitted(runs, healthy().given, theta(), starts_of(runs, healthy().given))
    gained = changed_module._freed(fit, healthy(), healthy().given[0])
    monkeypatch.setattr(changed_module, "signatures", lambda *_: [SimpleNamespace(score=gained + more)])
    _, changed = without_changed(healthy(), data.against(healthy()).runs, LIBRARY, theta())
    assert bool(changed) == is_new


def test_the_healthy_platform_may_have_more_effects_than_are_named_in_a_suspect_one():
    assert SETTINGS.most_effects_of_reference > SETTINGS.most_effects
    data = data_of(SUSPECT_SEEDS, wheel_lag=0.05, **HEALTHY)
    for most in (1, 2):
        *_, final = diagnosed(data.runs, data.heldout, LIBRARY, theta(), most=most)
        assert len(final.steps) == most


@pytest.mark.parametrize(("grown", "said"), [(0.0, False), (0.04, True)])
def test_an_inertia_that_is_not_that_of_the_healthy_records_is_said(grown, said):
    """J11 of a satellite was 4 % more than in its healthy flights, at 100 sigma: nothing was missing."""
    belief = healthy().belief
    smaller = belief.log_ratio - np.array([grown, 0.0, 0.0, 0.0, 0.0, 0.0])
    reference = replace(healthy(), belief=replace(belief, log_ratio=smaller))
    data = data_of(SUSPECT_SEEDS, **HEALTHY).against(reference)
    *_, final = diagnosed(data.runs, data.heldout, LIBRARY, theta(), given=data.given)
    change = changed_inertia(final)
    assert change.sure == said
    assert change.difference[0] == pytest.approx(grown * theta()[0], abs=4.0 * change.std[0])
    verdict = diagnosis_verdict(final)
    assert ("inertia is not that of the healthy records" in verdict.text) == said
    assert verdict.tone == ("warn" if said else "good")


def test_where_records_show_a_controllers_answer_no_effect_has_changed():
    """Healthy flights of data/crazypad had another gain of the actuators than those fitted, with P = 1.000."""
    of_loop = replace(healthy(), belief=replace(healthy().belief, of_loop=True))
    data = data_of(SUSPECT_SEEDS, wheel_torque_scale=0.04)
    assert without_changed(of_loop, data.runs, LIBRARY, theta()) == (of_loop, ())
