import mujoco
import numpy as np
import pytest

from support.platforms import shipped
from testbed.plant.build import build
from testbed.plant.properties import PlatformProperties
from testbed.plant.scene import HIDDEN_GROUP, scene_of


@pytest.fixture(scope="module")
def model():
    return shipped()


@pytest.fixture(scope="module")
def scene(model):
    return {body.name: body for body in scene_of(model)}


def test_bodies_of_the_platform_stand_parents_first(scene):
    names = list(scene)
    units = [f"cmg{unit}_{kind}" for unit in range(1, 7) for kind in ("gimbal", "rotor")]
    assert sorted(names) == sorted(["bus", *units])
    assert names[0] == "bus"
    for body in list(scene.values())[1:]:
        assert names.index(body.parent) < names.index(body.name)


def test_only_the_bus_floats(scene):
    assert [name for name, body in scene.items() if body.hinge_axis is None] == ["bus"]
    np.testing.assert_array_equal(scene["cmg4_gimbal"].hinge_axis, [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(scene["cmg4_rotor"].hinge_axis, [1.0, 0.0, 0.0])


def test_every_visible_geom_is_drawn_and_the_hull_is_not(model, scene):
    drawn = {shape.name for body in scene.values() for shape in body.shapes}
    visible = {model.geom(geom).name for geom in range(model.ngeom) if model.geom_group[geom] != HIDDEN_GROUP}
    assert drawn == visible
    assert "hull" not in drawn


def test_shapes_stand_where_mujoco_draws_them(model, scene):
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for name, body in scene.items():
        rotation = data.body(name).xmat.reshape(3, 3)
        for shape in body.shapes:
            place = data.body(name).xpos + rotation @ shape.position
            np.testing.assert_allclose(place, data.geom(shape.name).xpos, rtol=0, atol=1e-15)


def test_mesh_is_the_ring_that_the_unit_file_describes(scene):
    (ring,) = (shape for shape in scene["cmg2_gimbal"].shapes if shape.kind == "mesh")
    assert ring.faces.min() == 0
    assert ring.faces.max() == len(ring.vertices) - 1
    assert np.ptp(ring.vertices, axis=0).max() == pytest.approx(0.058, rel=0.2)  # 29 mm scale, twice


def test_a_material_gives_its_color_and_an_own_color_wins(scene):
    shapes = {shape.name: shape for body in scene.values() for shape in body.shapes}
    np.testing.assert_allclose(shapes["cmg1_mark"].color, (0.86, 0.22, 0.18, 1.0), atol=1e-6)
    np.testing.assert_allclose(shapes["electronics"].color, (0.16, 0.32, 0.26, 1.0), atol=1e-6)


def test_cabin_walls_stand_in_the_world_before_all_bodies():
    scene = scene_of(build(PlatformProperties(cabin_size=np.array([1.0, 1.2, 1.4]))))
    assert (scene[0].name, scene[0].parent, scene[0].hinge_axis) == ("world", "", None)
    assert {shape.kind for shape in scene[0].shapes} == {"box"}
    assert len(scene[0].shapes) == 6
