"""Rigs that turn about some body axes only: what they determine is estimated, what they do not is left out."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import testbed as tb
from concealing.rig import Rig
from support.diagnosed_records import nominal
from support.diagnosed_records import records as free_records
from support.few_effects import know_only
from support.rigs import rig_records, rig_scenario
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.testable import components_on, hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.formats.diagnosis import DiagnosisFile
from testbed.identification.identify import identify
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted
from testbed.records.reading import record_of

HEAVY = 0.052
ABOUT_Z = [False, False, True, False, False, False]


def data_of(records, scenario=None):
    scenario = scenario or rig_scenario()
    return data_set_of(records, scenario, nominal_body(scenario))


@pytest.mark.parametrize("held", ["empty", "zero", "noise"])
def test_axes_that_a_bearing_holds_are_compared_with_nothing(held):
    records = rig_records([Rig(inertia=HEAVY, held=held)] * 3)
    data = data_of(records)
    assert data.runs.samples == sum(len(run.gyro_time) for run in data.runs.grid.runs)
    assert data.runs.inertia_shown.tolist() == ABOUT_Z
    fit = fitted(data.runs, [], theta_of(0.05 * np.eye(3)), [])
    assert fit.shown[:6].tolist() == ABOUT_Z
    assert fit.theta[2] == pytest.approx(HEAVY, abs=5.0 * np.sqrt(fit.covariance[2, 2]))
    assert 0.8 < fit.root_mean_square < 1.2
    assert any("J11, J22, J23, J13, J12 of the inertia are not determined" in notice for notice in data.notices)


@pytest.mark.parametrize(("held", "said"), [("empty", "no value in any row"), ("zero", "dead")])
def test_without_the_key_the_gate_says_which_axes_do_not_turn_and_names_it(held, said):
    records = rig_records([Rig(held=held)] * 3)
    with pytest.raises(InputError, match=said) as refused:
        data_of(records, rig_scenario(axes=""))
    assert "[platform] of the scenario" in str(refused.value)
    assert "axes = [" in str(refused.value)


def test_a_record_without_any_gyro_channel_is_refused():
    (record,) = rig_records([Rig()])

    def columns(about_z):
        rates = {f"body_rate_{axis}_rad_s": np.full(len(record.time), np.nan) for axis in "xyz"}
        names = (f"cluster_momentum_{axis}_N_m_s" for axis in "xyz")
        momenta = dict(zip(names, record.channels["cluster_momentum"].T, strict=True))
        return {"time_s": record.time} | rates | momenta | about_z

    with pytest.raises(InputError, match="no value in any row"):
        record_of(columns({}), record.details, {})
    read = record_of(columns({"body_rate_z_rad_s": record.channels["body_rate"][:, 2]}), record.details, {})
    assert np.isnan(read.channels["body_rate"][:, :2]).all()


def test_an_axis_that_the_rig_names_and_no_run_turns_about_is_refused():
    with pytest.raises(InputError, match="shows no motion about x"):
        data_of(rig_records([Rig()] * 2), rig_scenario('axes = ["x"]'))


def test_runs_about_different_axes_are_pooled():
    rigs = [Rig(axis=axis, inertia=inertia) for axis, inertia in (("z", HEAVY), ("x", 0.047)) * 3]
    data = data_of(rig_records(rigs), rig_scenario('axes = ["x", "z"]'))
    fit = fitted(data.runs, [], theta_of(0.05 * np.eye(3)), [])
    assert fit.shown[:6].tolist() == [True, False, True, False, False, False]
    assert fit.theta[[0, 2]] == pytest.approx([0.047, HEAVY], rel=2e-3)
    assert data.heldout is not None
    assert not (data.heldout.live.any(axis=0) & ~data.runs.live.any(axis=0)).any()


def test_a_run_says_by_itself_about_which_of_the_axes_it_turns():
    """A gyro that works shows noise about the axes that a bearing holds: only the run can say that it is held there."""
    rigs = [Rig(axis=axis, held="noise") for axis in ("z", "x", "z", "x")]
    records = rig_records(rigs)
    axes = [("z",), ("x",), ("z",), ("x",)]
    said = [
        replace(record, details=replace(record.details, axes=own)) for record, own in zip(records, axes, strict=True)
    ]
    data = data_of(said, rig_scenario('axes = ["x", "z"]'))
    assert all(live.sum() == 1 for live in data.runs.live)


def test_effects_on_axes_that_no_run_turns_about_are_no_hypotheses():
    testable, _ = hypotheses(data_of(rig_records([Rig()] * 3)).runs, EFFECTS)
    keys = {each.key for each in testable}
    assert "gyro_scale:z" in keys
    assert not keys & {"gyro_scale:x", "gyro_scale:y"}


def test_noise_of_the_whole_gyro_is_no_second_hypothesis_where_one_axis_is_all_of_it():
    noise = NOISE_EFFECTS["gyro_noise"]
    assert components_on(data_of(rig_records([Rig(inertia=HEAVY)] * 3)).runs, noise) == ["z"]
    assert components_on(data_set_of(free_records(1), *nominal()).runs, noise) == ["gyro", "x", "y", "z"]


@pytest.mark.parametrize(("effect", "size"), [("flexible_appendage", "inertia_kg_m2"), ("slosh", "mass_kg")])
def test_the_size_of_what_moves_inside_a_rig_is_known_by_the_axis_that_turns(effect, size):
    """It was 0.004 ± nan, and its direction between -inf and inf."""
    values, std = np.array([1.0, 0.02, 0.0, 0.0, 0.004]), np.array([0.1, 0.01, np.inf, np.inf, 1e-4])
    found = {each.name: each for each in EFFECTS[effect].quantities(values, std)}
    assert (found[size].value, found[size].std) == (0.004, 1e-4)
    assert all(np.isfinite([each.value, each.std]).all() for each in found.values())


def test_about_two_axes_the_held_one_turns_the_momentum():
    """ω_z = 0: J_x ω̇_x = -h_z ω_y - ḣ_x and J_y ω̇_y = h_z ω_x - ḣ_y, with h_z at rest a turning of ω by h_z/J t."""
    time, spin, inertia = np.arange(0.0, 4.0, 0.05), 0.02, 0.05
    run = Telemetry(
        gyro_time=time,
        body_rate=np.zeros((len(time), 3)),
        gyro_noise=1e-3,
        actuator_time=time,
        gimbals=None,
        cluster_momentum=np.tile([0.0, 0.0, spin], (len(time), 1)),
        live=(True, True, False),
    )
    values = Values(theta=theta_of(inertia * np.eye(3))[None], initial_rate=np.array([[[0.3, 0.0, 0.0]]]), effects=())
    (rates,) = predicted(grid_of([run]), [], values)
    turned = spin / inertia * time
    expected = 0.3 * np.stack([np.cos(turned), np.sin(turned), 0.0 * turned], axis=1)
    np.testing.assert_allclose(rates[0], expected, atol=1e-7)


def test_a_rig_is_diagnosed_and_what_it_leaves_open_is_left_out(monkeypatch, tmp_path):
    know_only(monkeypatch, "viscous_drag", "gyro_scale")
    records = tb.Records(tuple(rig_records([Rig(inertia=HEAVY, viscous=3e-3)] * 3)))
    tb.diagnose(rig_scenario(), records).save(tmp_path / "out")
    result = json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    DiagnosisFile.model_validate(result)
    inertia, drag = result["steps"]
    assert list(inertia["parameters"]) == ["dJ33_kg_m2"]
    assert list(drag["parameters"]) == ["coefficient_z_N_m_s_rad"]
    assert drag["parameters"]["coefficient_z_N_m_s_rad"]["value"] == pytest.approx(3e-3, rel=0.02)
    for part in ("theta_kg_m2", "std_kg_m2"):
        assert [value is not None for value in result["inertia"]["after"][part]] == ABOUT_Z
    for part in ("ratio_to_stated", "level", "correlation"):
        assert [value is not None for value in result["noise"][part]] == [False, False, True]
    assert "not determined" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_the_colour_of_the_noise_is_estimated_about_the_axis_that_turns():
    data = data_of(rig_records([Rig(inertia=HEAVY, correlation=0.5, held="noise")] * 3, seconds=20.0))
    effects = {"viscous_drag": EFFECTS["viscous_drag"]}
    color = {"gyro_noise_color": NOISE_EFFECTS["gyro_noise_color"]}
    *_, last = diagnosed(data.runs, data.heldout, effects, theta_of(0.05 * np.eye(3)), noise_effects=color)
    assert [each.key for each in last.scatter] == ["gyro_noise_color:gyro"]
    assert not last.steps
    assert last.runs.color.correlation[2] == pytest.approx(0.5, abs=0.1)
    left = np.concatenate([part[:, 2] for part in last.runs.by_run(last.model.residual)])
    assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.1
    assert np.mean(left**2) == pytest.approx(1.0, abs=0.15)


def test_an_estimate_says_what_such_runs_determine():
    scenario, platform = nominal()
    on_bearing = scenario.model_copy(update={"platform": scenario.platform.model_copy(update={"axes": ("z",)})})
    with pytest.raises(InputError, match="which shows J33 of the inertia"):
        identify(on_bearing, platform, rig_records([Rig(inertia=platform.inertia[2, 2])] * 2))


def test_a_rig_that_turns_about_some_axes_is_not_flown():
    with pytest.raises(tb.InputError, match="take axes out to fly it"):
        tb.fly(tb.read_scenario("basic", {"platform.axes": ["z"]}))
