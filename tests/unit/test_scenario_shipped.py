"""The shipped scenarios: they read, spell out the nominal platform, and say which question they answer."""

import tomllib
from pathlib import Path

import pytest

from testbed.errors import InputError
from testbed.scenario.reader import read_body_scenario, read_scenario

FOLDER = Path(__file__).parents[2] / "scenarios"
SHIPPED = sorted(FOLDER.glob("*.toml"))

# The nominal platform, paper eqs. (30) and (31) and the README's table; no scenario may drift from it.
NOMINAL_CLUSTER = {
    "units": 6,
    "skew_deg": 63.9,
    "mounting_radius_m": 0.06,
    "rotor_momentum_N_m_s": 0.004714,
    "rotor_momentum_limit_N_m_s": 0.0052,
    "rotor_spin_inertia_kg_m2": 1.0e-5,
    "rotor_transverse_inertia_kg_m2": 5.3e-6,
    "rotor_mass_kg": 0.040,
    "gimbal_inertia_kg_m2": 3.0e-6,
    "gimbal_mass_kg": 0.020,
    "gimbal_rate_limit_rad_s": 2.0,
    "gimbal_torque_limit_N_m": 0.015,
    "gimbal_servo_bandwidth_rad_s": 50.0,
    "gimbal_servo_damping_ratio": 0.7,
}
NOMINAL_LIMITS = {"cluster_torque_N_m": [0.040, 0.040, 0.047], "cluster_momentum_N_m_s": [0.0210, 0.0210, 0.0254]}
REQUIRED = {
    "zero_g",
    "paper_d_optimal",
    "scaled",
    "gimbal_d_optimal",
    "gimbal_slow",
    "gimbal_weighted",
    "diagnose",
    "basic",
    "failed_cmg",
    "momentum_bias",
    "orbit",
    "crazyflie",
    "crazypad",
}
OTHER_PLATFORMS = {
    "orbit",
    "crazyflie",
    "crazypad",
    "pyramid4",
    "box_roof",
    "cubesat_wheels",
    "mixed",
    "adopted",
    "air_bearing",
    "orbit_wheels",
}
"""Satellites, two quadcopters, a table on a bearing and other arrays of units, with gyros of their own."""


def test_the_promised_scenarios_are_shipped():
    assert {path.stem for path in SHIPPED} >= REQUIRED


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
class TestShipped:
    def test_reads_and_is_named_like_its_file(self, path):
        assert read_body_scenario(path).name == path.stem

    def test_first_comment_is_a_question_and_the_schema_follows(self, path):
        lines = path.read_text(encoding="utf-8").splitlines()
        question = lines[: lines.index("#:schema ../docs/scenario.schema.json")]
        assert all(line.startswith("# ") for line in question)
        assert question[-1].endswith("?")

    def test_spells_out_the_nominal_platform(self, path):
        if path.stem in OTHER_PLATFORMS:
            pytest.skip("a platform of its own")
        tree = tomllib.loads(path.read_text(encoding="utf-8"))
        assert {key: tree["cluster"].get(key) for key in NOMINAL_CLUSTER} == NOMINAL_CLUSTER
        assert tree["limits"] == NOMINAL_LIMITS
        assert tree["platform"].keys() == {"inertia_kg_m2", "mass_kg", "edge_m"}

    def test_gyro_is_the_papers(self, path):
        if path.stem in OTHER_PLATFORMS:
            pytest.skip("a gyro of its own")
        gyro = read_scenario(path).gyro
        assert gyro.sample_rate_hz == 16.0
        assert gyro.noise_rad_s in (0.025, 0.001658)


def test_zero_g_believes_the_cad_model_and_flies_the_papers_estimate():
    scenario = read_scenario(FOLDER / "zero_g.toml")
    assert scenario.platform.inertia_kg_m2 == ((0.0208, 0.0, 0.0), (0.0, 0.0208, 0.0), (0.0, 0.0, 0.0260))
    assert scenario.truth.inertia_kg_m2 == (
        (0.02004, 0.00108, 0.00004),
        (0.00108, 0.02126, 0.00009),
        (0.00004, 0.00009, 0.02575),
    )


def test_gimbal_design_has_no_dispersions():
    scenario = read_scenario(FOLDER / "gimbal_d_optimal.toml")
    assert scenario.truth.model_fields_set == set()
    assert scenario.encoder.noise_rad == 0.0


def test_the_basic_profile_is_one_start(tmp_path):
    text = (FOLDER / "paper_d_optimal.toml").read_text(encoding="utf-8")
    path = tmp_path / "paper_d_optimal.toml"
    path.write_text(text.replace("starts = 1", "starts = 2"), encoding="utf-8")
    with pytest.raises(
        InputError, match=r"maneuver\.starts: is 2, but the basic profile is one start; use 1, or start"
    ):
        read_scenario(path)
