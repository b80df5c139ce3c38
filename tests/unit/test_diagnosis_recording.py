"""What the recording of a diagnosis draws over each other can be distinguished, and the platform turns as measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rerun.chunk import RrdReader

from support.diagnosed_records import nominal, records
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.run_residuals import RunResiduals, residuals_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.outputs.diagnosis_recording import diagnosis_content, platform_scene, shown_run
from testbed.outputs.lean_scene import box_scene, frame_of
from testbed.recording.diagnosis import write_diagnosis_recording
from testbed.recording.reproduction_content import traces_of
from testbed.recording.shapes import SEE_THROUGH

RATE = np.array([0.3, -0.2, 0.1])
TIME = np.arange(0.0, 2.0, 0.01)


@pytest.fixture(scope="module")
def run() -> RunResiduals:
    still = np.tile(RATE, (len(TIME), 1))
    return RunResiduals(
        name="run",
        held_out=True,
        time=TIME,
        measured=still,
        nominal=still + np.array([0.01, 0.0, 0.0]),
        extended=still,
        before=np.ones_like(still),
        after=np.zeros_like(still),
        gimbal_angle=np.tile(np.linspace(0.0, 1.0, len(TIME))[:, None], (1, 6)),
    )


@pytest.fixture(scope="module")
def shown(run):
    return shown_run("run_1", run, platform_scene(nominal()[0]))


def test_every_curve_of_a_panel_has_its_own_colour_or_is_drawn_otherwise(shown):
    assert shown.tab.name == "run, held out"
    for panel in (panel for column in shown.tab.columns for panel in column):
        looks = [(trace.colors[0], trace.style) for trace in panel.traces]
        assert len(set(looks)) == len(looks)


def test_predictions_lie_wider_below_thinner_and_samples_are_small_dots(shown):
    """The viewer draws lines in the order of their paths, and points over all lines."""
    _, rates, _ = shown.tab.columns
    for panel in rates:
        by_path = sorted(panel.traces, key=lambda trace: trace.path)
        assert [trace.path.rpartition("/")[2] for trace in by_path] == ["extended", "measured", "nominal"]
        assert [trace.style for trace in by_path] == ["wide", "dots", "reference"]


def test_the_platform_turns_as_measured_and_the_predictions_beside_it(shown):
    measured, before, after = shown.motions
    assert [each.name for each in shown.motions] == ["measured", "nominal", "extended"]
    places = np.array([each.channels["true_position"][0] for each in shown.motions])
    assert len(np.unique(places[:, 1])) == 3
    turned = 2.0 * np.arccos(measured.channels["true_attitude"][-1, 0])
    assert turned == pytest.approx(np.linalg.norm(RATE) * measured.time[-1], rel=1e-6)
    np.testing.assert_allclose(after.channels["true_attitude"], measured.channels["true_attitude"], atol=1e-12)
    assert np.abs(before.channels["true_attitude"] - measured.channels["true_attitude"]).max() > 1e-3
    assert len(measured.time) == len(np.unique(np.floor(30.0 * TIME)))  # a screen shows no more than 30 a second


def test_where_nothing_was_added_one_prediction_stands_beside_the_measured_platform(run):
    alike = replace(run, extended=run.nominal, after=run.before)
    names = [each.name for each in shown_run("run_1", alike, platform_scene(nominal()[0])).motions]
    assert names == ["measured", "nominal"]


def test_the_angle_between_attitudes_grows_with_the_rates_difference(shown):
    ((panel,), _, _) = shown.tab.columns
    by_name = {trace.names[0]: trace.values[:, 0] for trace in panel.traces}
    np.testing.assert_allclose(by_name["extended"], 0.0, atol=1e-7)
    assert by_name["nominal"][-1] == pytest.approx(0.01 * TIME[-1], rel=0.05)  # while they have turned little


def test_rings_in_pieces_stand_where_the_mesh_is():
    gimbal = next(body for body in platform_scene(nominal()[0]) if body.name == "cmg1_gimbal")
    pieces = [shape for shape in gimbal.shapes if shape.name == "cmg1_ring"]
    assert {shape.kind for shape in pieces} == {"capsule"}
    radii = [np.linalg.norm(shape.position) for shape in pieces]
    np.testing.assert_allclose(radii, 0.029, rtol=0.1)  # of the model's ring
    assert sum(2.0 * shape.size[1] for shape in pieces) == pytest.approx(2.0 * np.pi * np.mean(radii), rel=0.02)
    assert "cmg1_rotor" not in {body.name for body in platform_scene(nominal()[0])}
    assert "cylinder" in {shape.kind for shape in gimbal.shapes}  # the rotor's disk, at rest in the gimbal


def test_a_body_without_a_model_is_the_box_of_its_inertia():
    half = np.array([0.01, 0.02, 0.04])
    inertia = np.diag(half @ half - half**2)
    (body,) = box_scene(inertia)
    box, *axes = body.shapes
    np.testing.assert_allclose(box.size / box.size[2], [0.25, 0.5, 1.0])
    assert [axis.name for axis in axes] == ["axis_x", "axis_y", "axis_z"]
    edges, *_ = frame_of(body, (10, 20, 30)).shapes
    assert edges.color[3] < SEE_THROUGH


def test_the_file_has_the_verdict_and_what_was_added(tmp_path):
    scenario, platform = nominal()
    late = EFFECTS["gyro_latency"]
    made = records(3, hooks=[late.hooks("gyro")], values=[np.array([12e-3])])
    data = data_set_of(made, scenario, platform)
    *_, diagnosis = diagnosed(data.runs, data.heldout, {"gyro_latency": late}, theta_of(platform.inertia))
    content = diagnosis_content(scenario, diagnosis, residuals_of(diagnosis), {"seed": "1"})
    assert content.verdict.startswith("## Named")
    assert "**gyro_latency (gyro)**" in content.verdict
    assert "delay_s = " in content.verdict
    path = tmp_path / "recording.rrd"
    write_diagnosis_recording(path, "diagnosis", content)
    entities = set(RrdReader(path).store().schema().entity_paths())
    assert {"/verdict", "/provenance", "/run_1/attitude/nominal"} <= entities
    for name in ("measured", "nominal", "extended"):
        assert f"/run_1/motion/{name}/platform" in entities
    assert "/run_1/motion/measured/platform/cmg3/gimbal" in entities
    expected = {trace.path for run in content.runs for trace in traces_of(run.tab)}
    assert {f"/{path}" for path in expected} <= entities
