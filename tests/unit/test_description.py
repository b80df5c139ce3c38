"""The estimated platform as MJCF and URDF: what other programs read has the estimate's mass and inertia."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import testbed as tb
from testbed.dynamics.inertia import inertia_of
from testbed.plant.geometry import cluster_of, composite_inertia, composite_mass

EXACT = 1e-9
"""kg m²; a millionth of the smallest standard deviation of any estimate here."""


@pytest.fixture(scope="module")
def estimate():
    scenario = tb.read_scenario("basic", {"gyro.noise_rad_s": 1e-3})
    return tb.estimate(scenario, tb.Records((tb.fly(scenario, seed=4).record,)))


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_mujoco_reads_the_estimated_mass_inertia_and_centre_of_mass(estimate, tmp_path, kind):
    path = getattr(estimate, f"to_{kind}")(tmp_path / f"platform.{kind}")
    model = mujoco.MjModel.from_xml_path(str(path))
    wanted = inertia_of(estimate.combined["output_error"].theta)
    assert not np.allclose(wanted, estimate.nominal.inertia, atol=1e3 * EXACT)
    np.testing.assert_allclose(composite_inertia(model), wanted, rtol=0.0, atol=EXACT)
    assert composite_mass(model) == pytest.approx(composite_mass(estimate.nominal.model), abs=1e-9)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    bus = model.body("bus").id
    np.testing.assert_allclose(data.subtree_com[bus], data.xpos[bus], atol=1e-6)


def test_the_estimate_of_another_estimator_is_written_if_wanted(estimate, tmp_path):
    model = mujoco.MjModel.from_xml_path(str(estimate.to_urdf(tmp_path / "a.urdf", estimator="iv")))
    wanted = inertia_of(estimate.combined["iv"].theta)
    np.testing.assert_allclose(composite_inertia(model), wanted, rtol=0.0, atol=EXACT)
    with pytest.raises(tb.InputError, match="there is no estimate by kalman; there are ls, iv"):
        estimate.to_urdf(tmp_path / "b.urdf", estimator="kalman")
    assert not (tmp_path / "b.urdf").exists()


def test_the_mjcf_flies_as_a_scenarios_platform(estimate, tmp_path):
    """Six digits of axes and speeds, as MuJoCo writes them."""
    model = mujoco.MjModel.from_xml_path(str(estimate.to_mjcf(tmp_path / "platform.xml")))
    written, nominal = cluster_of(model), estimate.nominal.cluster
    np.testing.assert_allclose(written.gimbal_axis_B, nominal.gimbal_axis_B, atol=1e-5)
    np.testing.assert_allclose(written.rotor_momentum, nominal.rotor_momentum, rtol=1e-5)


def test_the_urdf_has_a_link_for_every_gimbal_and_rotor(estimate, tmp_path):
    root = ElementTree.parse(estimate.to_urdf(tmp_path / "platform.urdf")).getroot()
    links = {link.get("name") for link in root.iter("link")}
    assert links == {"bus", *(f"cmg{unit}_{part}" for unit in range(1, 7) for part in ("gimbal", "rotor"))}
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "platform.urdf"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = np.array([data.xaxis[model.joint(f"cmg{unit}_gimbal_joint").id] for unit in range(1, 7)])
    np.testing.assert_allclose(axes, estimate.nominal.cluster.gimbal_axis_B, atol=1e-12)


def test_an_inertia_that_leaves_the_bus_none_is_refused(estimate, tmp_path):
    small = replace(estimate.combined["iv"], theta=estimate.combined["iv"].theta * 0.01)
    combined = replace(estimate.identification.combined, by_name={"iv": small})
    broken = replace(estimate, identification=replace(estimate.identification, combined=combined))
    with pytest.raises(tb.InputError, match="which no body has"):
        broken.to_urdf(tmp_path / "platform.urdf")
    assert not list(tmp_path.iterdir())


def test_the_extended_model_is_written_too(estimate, tmp_path):
    from testbed.library.diagnoses import ExtendedModel

    inertia = inertia_of(estimate.combined["iv"].theta)
    extended = ExtendedModel(scenario=estimate.scenario, extensions=(), inertia=inertia)
    for path in (extended.to_urdf(tmp_path / "a.urdf"), extended.to_mjcf(tmp_path / "a.xml")):
        model = mujoco.MjModel.from_xml_path(str(path))
        np.testing.assert_allclose(composite_inertia(model), inertia, rtol=0.0, atol=EXACT)
