import subprocess
import sys
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from support.flights import STEP_NS, STEPS_PER_SAMPLE, content, flown
from support.processes import PATIENCE
from testbed.plant.scene import scene_of
from testbed.recording import writer
from testbed.recording.stream import BLOCK_ROWS, durations
from testbed.recording.writer import write_recording

SAMPLES = 41
TABS = ("Flight", "Actuators", "Estimates", "Provenance")


@pytest.fixture(autouse=True)
def strict():
    """Make rerun raise where it would otherwise warn and write less."""
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture(scope="module")
def flight():
    return flown(SAMPLES)


def write(path, flight, **changes):
    arguments = {
        "recording_id": "run-1",
        "time": flight.time,
        "channels": flight.channels,
        "scene": scene_of(flight.model),
        "content": content(SAMPLES),
    }
    write_recording(path, **(arguments | changes))


@pytest.fixture(scope="module")
def recording(flight, tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "recording.rrd"
    write(path, flight)
    return path


def tables(path, entity):
    """Return an entity's rows that move with time and those that do not, as Arrow tables."""
    chunks = [chunk for chunk in RrdReader(path).stream().to_chunks() if chunk.entity_path == entity]
    moving = [chunk.to_record_batch() for chunk in chunks if not chunk.is_static]
    still = [chunk.to_record_batch() for chunk in chunks if chunk.is_static]
    return (pa.Table.from_batches(batches) if batches else None for batches in (moving, still))


def rows(path, entity, column):
    """Return times in ns and the values of one column of an entity, one row per sample."""
    moving, _ = tables(path, entity)
    return moving["sim_time"].cast(pa.int64()).to_numpy(), np.array(moving[column].to_pylist())


def test_time_is_whole_nanoseconds_from_the_step_counter(recording):
    stamps, _ = rows(recording, "/body_rate/true_body_rate", "Scalars:scalars")
    np.testing.assert_array_equal(stamps, np.arange(SAMPLES) * STEPS_PER_SAMPLE * STEP_NS)


def test_a_long_run_loses_no_nanosecond():
    counts = np.arange(400_000)
    expected = (counts * STEP_NS).astype("timedelta64[ns]")
    np.testing.assert_array_equal(durations(counts * 1.25e-3), expected)


def test_no_clock_but_the_flights(recording):
    assert [str(column.name) for column in RrdReader(recording).store().schema().index_columns()] == ["sim_time"]


@pytest.mark.parametrize(
    ("entity", "channel"),
    [
        ("/body_rate/true_body_rate", "true_body_rate"),
        ("/gimbal_angle/true_gimbal_angle", "true_gimbal_angle"),
        ("/gimbal_torque/gimbal_torque", "gimbal_torque"),
        ("/singularity_measure/singularity_measure", "singularity_measure"),
    ],
)
def test_signals_come_back_bit_by_bit(flight, recording, entity, channel):
    _, values = rows(recording, entity, "Scalars:scalars")
    np.testing.assert_array_equal(values, flight.channels[channel])


def test_poses_come_back_in_single_precision(flight, recording):
    _, position = rows(recording, "/platform", "Transform3D:translation")
    _, quaternion = rows(recording, "/platform", "Transform3D:quaternion")
    np.testing.assert_allclose(position[:, 0], flight.channels["true_position"], rtol=1e-7, atol=1e-9)
    scalar_first = np.roll(quaternion[:, 0], 1, axis=1)
    np.testing.assert_allclose(scalar_first, flight.channels["true_attitude"], rtol=0, atol=1e-7)
    stamps, _ = rows(recording, "/platform/cmg6/gimbal/rotor", "Transform3D:quaternion")
    assert len(stamps) == SAMPLES


def test_every_view_of_the_issue_has_its_entities(recording):
    paths = set(RrdReader(recording).store().schema().entity_paths())
    plots = {path.split("/")[1] for path in paths}
    assert plots == {
        "platform",
        "body_rate",
        "tracking_error",
        "cluster_momentum",
        "cluster_torque",
        "envelope_fraction",
        "gimbal_angle",
        "gimbal_rate",
        "gimbal_torque",
        "rotor_speed",
        "singularity_measure",
        "saturation",
        "residual",
        "estimates",
        "result",
        "provenance",
        "events",
    }


def test_shapes_are_styled_once(recording):
    moving, still = tables(recording, "/platform/cmg2/gimbal/cmg2_ring")
    assert moving is None
    assert still.num_rows == 1
    _, legend = tables(recording, "/gimbal_rate/true_gimbal_rate")
    assert legend["SeriesLines:names"].to_pylist() == [["cmg1", "cmg2", "cmg3", "cmg4", "cmg5", "cmg6"]]


def test_saturation_changes_where_the_flags_do(recording):
    stamps, states = rows(recording, "/saturation/cmg3", "StateChange:state")
    assert states[:, 0].tolist() == ["free", "gimbal rate", "free"]
    np.testing.assert_array_equal(stamps, np.array([0, 2, 5]) * STEPS_PER_SAMPLE * STEP_NS)


def test_an_arrow_that_stays_nought_is_not_drawn(recording):
    paths = RrdReader(recording).store().schema().entity_paths()
    assert "/platform/cluster_momentum" in paths
    assert "/total_momentum" not in paths


def test_text_and_properties_travel_along(recording):
    _, result = tables(recording, "/result")
    assert result["TextDocument:text"].to_pylist() == [[content(SAMPLES).result]]
    (entry,) = RrdReader(recording).recordings()
    assert (entry.application_id, entry.recording_id) == ("testbed", "run-1")


def test_the_blueprint_is_inside_with_its_tabs(recording):
    assert len(RrdReader(recording).blueprints()) == 1
    printed = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", "-vvv", str(recording)],
        check=True,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    ).stdout
    assert [tab for tab in TABS if tab not in printed] == []


def test_blocks_join_without_a_seam(tmp_path, flight):
    count = BLOCK_ROWS + 10
    time, values = np.arange(count) * 1e-3, np.random.default_rng(3).normal(size=(count, 3))
    shown = replace(content(count), residuals=(), events=())
    write(tmp_path / "long.rrd", flight, time=time, channels={"true_body_rate": values}, scene=(), content=shown)
    stamps, read = rows(tmp_path / "long.rrd", "/body_rate/true_body_rate", "Scalars:scalars")
    order = np.argsort(stamps)
    np.testing.assert_array_equal(stamps[order], np.arange(count) * 1_000_000)
    np.testing.assert_array_equal(read[order], values)


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path, flight, monkeypatch):
    path = tmp_path / "recording.rrd"
    write(path, flight)
    before = path.read_bytes()

    def fail(*_arguments):
        raise RuntimeError("disk full")

    monkeypatch.setattr(writer, "log_estimates", fail)
    with pytest.raises(RuntimeError, match="disk full"):
        write(path, flight)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["recording.rrd"]
