import mujoco
import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from support.flights import flown
from testbed.plant.scene import scene_of
from testbed.recording.platform import body_pose, entity_paths, log_platform
from testbed.rotation.quaternion import matrix_of, quaternion_product, turned
from testbed.scene import shade_of


@pytest.fixture(scope="module")
def flight():
    return flown(samples=9)


@pytest.fixture(scope="module")
def scene(flight):
    return scene_of(flight.model)


def test_entities_hang_as_the_bodies_do(scene):
    paths = entity_paths(scene)
    assert paths["bus"] == "platform"
    assert paths["cmg3_gimbal"] == "platform/cmg3/gimbal"
    assert paths["cmg3_rotor"] == "platform/cmg3/gimbal/rotor"


def poses_in_inertial_frame(scene, channels):
    """Compose the poses down the tree, as a viewer does."""
    poses = {}
    for body in scene:
        position, quaternion = body_pose(body, channels)
        if body.parent:
            parent_position, parent_quaternion = poses[body.parent]
            position = parent_position + turned(parent_quaternion, position)
            quaternion = quaternion_product(parent_quaternion, quaternion)
        poses[body.name] = position, quaternion
    return poses


def test_the_tree_puts_every_body_where_mujoco_has_it(flight, scene):
    poses = poses_in_inertial_frame(scene, flight.channels)
    data = mujoco.MjData(flight.model)
    for row, qpos in enumerate(flight.qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(flight.model, data)
        for name, (position, quaternion) in poses.items():
            # Rounding alone: three products of unit quaternions, rotors some hundred radians from their start.
            np.testing.assert_allclose(position[row], data.body(name).xpos, rtol=0, atol=1e-12)
            expected = data.body(name).xmat.reshape(3, 3)
            np.testing.assert_allclose(matrix_of(quaternion[row]), expected, rtol=0, atol=1e-12)
    assert np.ptp(flight.channels["true_rotor_angle"], axis=0).min() > 1.0  # they did turn


def test_units_and_axes_are_named_in_three_dimensions(scene, tmp_path):
    stream = rr.RecordingStream("testbed", recording_id="names", send_properties=False)
    stream.save(tmp_path / "names.rrd")
    log_platform(stream, scene, np.zeros(1), {})
    stream.disconnect()
    chunks = {chunk.entity_path: chunk for chunk in RrdReader(tmp_path / "names.rrd").stream().to_chunks()}
    for path, names in (("/platform/cmg4/gimbal/names", ["4"]), ("/platform/names", ["z", "y", "x"])):
        batch = chunks[path].to_record_batch()
        assert sorted(batch.column("Points3D:labels")[0].as_py()) == sorted(names)


def test_rings_and_axes_have_the_colours_of_their_curves(scene):
    shades = {shape.name: shade_of(shape) for body in scene for shape in body.shapes}
    assert shades["cmg3_ring"] == "unit-3"
    assert shades["axis_y"] == "axis-y"
    assert shades["base_plate"] is None


def test_a_joint_without_an_angle_stays_at_zero(scene):
    rotor = next(body for body in scene if body.name == "cmg5_rotor")
    position, quaternion = body_pose(rotor, {})
    np.testing.assert_array_equal(position, [rotor.position])
    np.testing.assert_array_equal(quaternion, [rotor.quaternion])
