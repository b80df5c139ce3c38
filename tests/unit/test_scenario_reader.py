"""What the reader says about files that cannot be used: every problem, its line and place, and the remedy."""

import re
from pathlib import Path

import pytest

from testbed.errors import InputError
from testbed.scenario.reader import read_body_scenario, read_scenario

SHIPPED = Path(__file__).parents[2] / "scenarios"


def edited(tmp_path, pattern, replacement, name="diagnose"):
    """A shipped scenario with the first line that matches replaced; the file and the line's number."""
    text = (SHIPPED / f"{name}.toml").read_text(encoding="utf-8")
    match = re.search(rf"^{pattern}.*$", text, re.MULTILINE)
    assert match is not None, f"{pattern} is not in {name}.toml"
    path = tmp_path / "edited.toml"
    path.write_text(text[: match.start()] + replacement + text[match.end() :], encoding="utf-8")
    return path, text[: match.start()].count("\n") + 1


def flown_again(tmp_path, points):
    """The basic scenario with a gimbal-angle spline as its maneuver."""
    text = (SHIPPED / "basic.toml").read_text(encoding="utf-8")
    spline = f'kind = "control_points"\nparametrization = "gimbal"\nduration_s = 5.0\ngimbal_angle_rad = {points}'
    path = tmp_path / "flown_again.toml"
    path.write_text(text.replace('kind = "basic"\nduration_s = 5.0\nscale = 1.0', spline), encoding="utf-8")
    return path


def message_of(path):
    with pytest.raises(InputError) as caught:
        read_scenario(path)
    return str(caught.value)


REFUSED = {
    "unknown key": ("noise_rad_s = 0.001658", "noise_rad = 0.001658", "gyro.noise_rad", "did you mean noise_rad_s?"),
    "wrong unit": ("skew_deg", "skew_rad = 1.115", "cluster.skew_rad", "did you mean skew_deg?"),
    "key of nothing": ("mass_kg", "colour = 1", "platform.colour", "the keys here are model, inertia_kg_m2"),
    "text for a number": ("edge_m", 'edge_m = "0.18"', "platform.edge_m", "should be a valid number, not '0.18'"),
    "truth for a number": ("edge_m", "edge_m = true", "platform.edge_m", "should be a valid number, not True"),
    "number for truth": ("feedback", "feedback = 1", "controller.feedback", "should be a valid boolean, not 1"),
    "not finite": ("step_s", "step_s = nan", "simulation.step_s", "should be a finite number"),
    "negative noise": ("noise_rad =", "noise_rad = -1e-4", "encoder.noise_rad", "at least 0"),
    "zero limit": (
        "gimbal_rate_limit",
        "gimbal_rate_limit_rad_s = 0.0",
        "cluster.gimbal_rate_limit_rad_s",
        "at least 1e-06",
    ),
    "a single unit": ("units", "units = 1", "cluster.units", "should be at least 2, not 1"),
    "seven units": ("units", "units = 7", "initial.gimbal_angle_rad", "has 6 entries instead of 7, one for each unit"),
    "an array without torque about z": ("units", 'array = "line"', "cluster.array", "no torque about z can be given"),
    "a roof of three": ("units", 'array = "roof"\nunits = 3', "cluster.units", "a roof has two equal rows"),
    "a roof that loses torque": ("units", 'array = "roof"\nunits = 2', "cluster.units", "at any angle; use 4"),
    "a box with a skew": ("units", 'array = "box"', "cluster.skew_deg", "has no effect on a box"),
    "four units, place unknown": (
        "mounting_radius_m",
        'array = "roof"',
        "cluster.mounting_radius_m",
        "is missing; the shipped model has its own for six units in a pyramid only, not for 6 in a roof: add it",
    ),
    "seven angles": (
        "gimbal_angle_rad",
        "gimbal_angle_rad = [0, 0, 0, 0, 0, 0, 0]",
        "initial.gimbal_angle_rad",
        "has 7 entries instead of 6",
    ),
    "entry of a list": (
        "body_rate_rad_s",
        'body_rate_rad_s = [0.1, "0", 0.0]',
        "initial.body_rate_rad_s[2]",
        "should be a valid number, not '0'",
    ),
    "no list": ("position_m", "position_m = 0.0", "initial.position_m", "should be a list, not 0.0"),
    "asymmetric inertia": (
        "inertia_kg_m2",
        "inertia_kg_m2 = [[0.022, 1e-3, 0], [0, 0.022, 0], [0, 0, 0.027]]",
        "platform.inertia_kg_m2",
        "is not symmetric",
    ),
    "indefinite inertia": (
        "inertia_kg_m2",
        "inertia_kg_m2 = [[0.022, 0.03, 0], [0.03, 0.022, 0], [0, 0, 0.027]]",
        "platform.inertia_kg_m2",
        "is not positive definite",
    ),
    "inertia of no body": (
        "inertia_kg_m2",
        "inertia_kg_m2 = [[0.022, 0, 0], [0, 0.022, 0], [0, 0, 0.045]]",
        "platform.inertia_kg_m2",
        "belongs to no body",
    ),
    "attitude": (
        "attitude_quat_NB",
        "attitude_quat_NB = [1.0, 0.1, 0.0, 0.0]",
        "initial.attitude_quat_NB",
        "has the norm 1.00499 instead of 1",
    ),
    "no such unit": ("failed", "failed = [7]", "cluster.failed", "names unit 7, but there are 6"),
    "a unit twice": ("failed", "failed = [2, 2]", "cluster.failed", "names an entry twice"),
    "too many failed": (
        "failed",
        "failed = [1, 2, 3, 4]",
        "cluster.failed",
        "names 4 of 6 units; at most half of them may have failed",
    ),
    "overspeed by design": (
        "rotor_momentum_N_m_s",
        "rotor_momentum_N_m_s = 0.006",
        "cluster.rotor_momentum_N_m_s",
        "exceeds rotor_momentum_limit_N_m_s = 0.0052",
    ),
    "rotor of no body": (
        "rotor_transverse",
        "rotor_transverse_inertia_kg_m2 = 4.9e-6",
        "cluster.rotor_transverse_inertia_kg_m2",
        "less than half",
    ),
    "saturated by noise": (
        "noise_rad_s = 0.001658",
        "noise_rad_s = 0.5\nsaturation_rad_s = 0.4",
        "gyro.saturation_rad_s",
        "leaves no signal",
    ),
    "correlation time of nothing": (
        "noise_rad_s = 0.001658",
        "noise_rad_s = 0.001658\nbias_correlation_time_s = 10.0",
        "gyro.bias_correlation_time_s",
        "no effect without a bias_instability_rad_s",
    ),
    "targets without effect": (
        "criterion",
        'criterion = "D"\ntarget_std_kg_m2 = [1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4]',
        "maneuver.target_std_kg_m2",
        "has no effect on criterion D",
    ),
    "unknown kind": ("kind", 'kind = "desing"', "maneuver.kind", "use one of 'design', 'basic', 'csv', 'control"),
    "no kind": ("kind", "", "maneuver.kind", "is missing; use one of 'design', 'basic', 'csv', 'control_points'"),
    "no parametrization": ("parametrization", "", "maneuver.parametrization", "use one of 'body_rate', 'gimbal'"),
    "key of another form": (
        "gimbal_rate_fraction",
        'gimbal_rate_fraction = 0.95\nconstraint = "hard"',
        "maneuver.constraint",
        "unknown key",
    ),
    "too few samples": ("duration_s", "duration_s = 0.5", "maneuver.duration_s", "gives 8 samples; at least 10"),
    "more points than samples": ("control_points", "control_points = 81", "maneuver.control_points", "use fewer"),
    "no such file": ("mass_kg", 'model = "none.xml"', "platform.model", "there is no file"),
    "unknown law": ("law", 'law = "sr"', "controller.steering.law", "is 'sr', which is unknown"),
    "unknown estimator": (
        "estimators",
        'estimators = ["lsq"]',
        "estimation.estimators[1]",
        "'ls', 'iv', 'iv_momentum'",
    ),
    "no estimator": (
        "estimators",
        "estimators = []",
        "estimation.estimators",
        "should have at least 1 entry, not 0",
    ),
    "stiff servo": (
        "gimbal_servo_bandwidth",
        "gimbal_servo_bandwidth_rad_s = 2500.0",
        "simulation.step_s",
        "stay below 0.00111 s",
    ),
    "indivisible step": ("step_s", "step_s = 0.001", "simulation.step_s", "use 0.00125 or 0.00078125"),
    "indivisible rates": (
        "sample_rate_hz",
        "sample_rate_hz = 25.0",
        "simulation.control_rate_hz",
        "80.0 is no whole multiple of gyro.sample_rate_hz = 25.0; use 75.0 or 100.0",
    ),
    "gyro faster than the loop": (
        "sample_rate_hz",
        "sample_rate_hz = 160.0",
        "simulation.control_rate_hz",
        "80.0 is slower than gyro.sample_rate_hz = 160.0; use 160.0 or more",
    ),
    "small cabin": (
        r"\[gyro\]",
        "[cabin]\nsize_m = [2.0, 0.17, 2.0]\n[gyro]",
        "cabin.size_m",
        "along y leaves no room for a platform of 0.18 m",
    ),
    "cabin in which the cube cannot turn": (  # its diagonal is 0.312 m
        r"\[gyro\]",
        "[cabin]\nsize_m = [2.0, 2.0, 0.31]\n[gyro]",
        "cabin.size_m",
        "along z leaves no room for a platform of 0.18 m, 0.312 m from corner to corner",
    ),
    "rotor at rest": (
        r"\[initial\]",
        "[truth]\nrotor_momentum_N_m_s = [0, 0.0047, 0.0047, 0.0047, 0.0047, 0.0047]\n[initial]",
        "truth.rotor_momentum_N_m_s[1]",
        "should be at least 1e-09, not 0; give: True rotor momentum of all units, or of each; servos "
        "clamp it at the limit; at rest: use cluster.failed",
    ),
    "rotor that turns backwards": (
        r"\[initial\]",
        "[truth]\nrotor_momentum_N_m_s = [0.0047, -0.0047, 0.0047, 0.0047, 0.0047, 0.0047]\n[initial]",
        "truth.rotor_momentum_N_m_s[2]",
        "should be at least 1e-09, not -0.0047",
    ),
    "day-long run": (
        "telemetry_rate",
        "telemetry_rate_hz = 16.0\nsettle_s = 86400.0",
        "simulation.settle_s",
        "at most 3600",
    ),
    "endless maneuver": ("duration_s", "duration_s = 1e9", "maneuver.duration_s", "at most 3600"),
    "step of nothing": ("step_s", "step_s = 1.25e-9", "simulation.step_s", "at least 1e-06, not"),
    "rate of a radio": ("sample_rate_hz = 16.0", "sample_rate_hz = 1e9", "gyro.sample_rate_hz", "at most 100000"),
    "prefilter of everything": (
        "prefilter_time_constant_s = 0.8 # paper",
        "prefilter_time_constant_s = 1e9",
        "estimation.prefilter_time_constant_s",
        "at most 1000",
    ),
    "prefilter of nothing": (
        "prefilter_time_constant_s = 0.8 # paper",
        "prefilter_time_constant_s = 1e-9",
        "estimation.prefilter_time_constant_s",
        "at least 0.001",
    ),
}


class TestRefused:
    @pytest.mark.parametrize("case", REFUSED)
    def test_names_file_place_and_remedy(self, case, tmp_path):
        pattern, replacement, place, words = REFUSED[case]
        path, _ = edited(tmp_path, pattern, replacement)
        message = message_of(path)
        assert message.startswith(f"{path}: ")
        assert any(f"{place}: " in line and words in line for line in message.splitlines()), message

    def test_names_the_line(self, tmp_path):
        path, line = edited(tmp_path, "skew_deg", "skew_deg = 0.0")
        assert f"line {line}, cluster.skew_deg: " in message_of(path)

    def test_missing_section_has_no_line(self, tmp_path):
        path, _ = edited(tmp_path, "schema", "schema = 2")
        assert "1 problem\n" in message_of(path)
        path.write_text("schema = 1\n", encoding="utf-8")
        assert "\n  gyro: is missing; add it: The rate gyro" in message_of(path)

    def test_a_typo_of_a_required_key_is_one_problem(self, tmp_path):
        path, line = edited(tmp_path, "criterion", 'critrion = "D"')
        assert message_of(path).splitlines()[1:] == [
            f"  line {line}, maneuver.critrion: unknown key; did you mean criterion? It gives: What is optimised: "
            "determinant, trace of the inverse, smallest eigenvalue or condition number of information"
        ]

    def test_all_problems_at_once_in_the_order_of_the_file(self, tmp_path):
        path, _ = edited(tmp_path, "mass_kg", "mass_kg = -4.0")
        text = path.read_text(encoding="utf-8").replace("step_s = 0.00125", "step_s = 0.001")
        path.write_text(text.replace("failed = []", "failed = [9]"), encoding="utf-8")
        lines = message_of(path).splitlines()
        assert lines[0] == f"{path}: 3 problems"
        places = [line.split(", ")[1].split(":")[0] for line in lines[1:]]
        assert places == ["platform.mass_kg", "cluster.failed", "simulation.step_s"]

    def test_preferring_the_gimbal_angles_of_a_maneuver_without_any(self, tmp_path):
        path, line = edited(tmp_path, "preferred", 'preferred_gimbal_angle_rad = "maneuver"', name="basic")
        expected = f"line {line}, controller.steering.preferred_gimbal_angle_rad: "
        assert expected in message_of(path)

    def test_duration_that_ends_inside_a_control_period(self, tmp_path):
        text = (SHIPPED / "basic.toml").read_text(encoding="utf-8")
        path = tmp_path / "edited.toml"
        path.write_text(text.replace("duration_s = 5.0\ncontrol", "duration_s = 5.01\ncontrol"), encoding="utf-8")
        assert "is no whole number of control periods of 1/80.0 s; use 5.0 or 5.0125" in message_of(path)

    @pytest.mark.parametrize(("rotors", "refused"), [("constant_speed", True), ("free", False)])
    def test_step_that_the_rotor_servo_does_not_bear(self, tmp_path, rotors, refused):
        """2.785 / 300 = 9.28 ms; a free rotor has no servo at work, and the gimbal servo bears 55.7 ms."""
        path, _ = edited(tmp_path, "rotors", f'rotors = "{rotors}"', name="basic")
        text = path.read_text(encoding="utf-8").replace("step_s = 0.00125", "step_s = 0.0125")
        path.write_text(text, encoding="utf-8")
        if refused:
            expected = "step_s: 0.0125 s is too long for the rotor servo of 300.0 rad/s; stay below 0.00928 s"
            assert expected in message_of(path)
        else:
            assert read_scenario(path).simulation.step_s == 0.0125

    @pytest.mark.parametrize(
        ("flown", "key"),
        [("duration_s = 0.5\n", "simulation.duration_s"), ("", "maneuver.duration_s")],
        ids=["given", "of the maneuver"],
    )
    def test_run_too_short_for_an_estimate(self, tmp_path, flown, key):
        text = (SHIPPED / "basic.toml").read_text(encoding="utf-8")
        text = text.replace("duration_s = 5.0\ncontrol", f"{flown}control")
        path = tmp_path / "edited.toml"
        path.write_text(text.replace("duration_s = 5.0", "duration_s = 0.5"), encoding="utf-8")
        expected = f"{key}: 0.5 s at gyro.sample_rate_hz = 16.0 gives 8 samples, an estimate needs 10; fly 0.625 s"
        assert expected in message_of(path)

    def test_gimbal_angle_spline_that_starts_elsewhere_than_the_gimbals(self, tmp_path):
        path = flown_again(tmp_path, [[0.1 * row] * 6 for row in (1, 1, 2, 2, 1, 1)])
        expected = "maneuver.gimbal_angle_rad: starts at [0.1, 0.1, 0.1, 0.1, 0.1, 0.1], the gimbals at [0.0, 0.0, "
        assert expected in message_of(path)

    def test_failed_unit_that_starts_off_its_lock(self, tmp_path):
        path, _ = edited(tmp_path, "failed", "failed = [3]", name="failed_cmg")
        expected = "initial.gimbal_angle_rad: has -0.781427 for unit 3, which has failed and is locked at zero"
        assert expected in message_of(path)


class TestUnreadable:
    def test_missing_file(self, tmp_path):
        assert message_of(tmp_path / "none.toml").startswith(f"{tmp_path / 'none.toml'}: cannot be read")

    def test_folder(self, tmp_path):
        assert "cannot be read" in message_of(tmp_path)

    def test_binary(self, tmp_path):
        path = tmp_path / "binary.toml"
        path.write_bytes(b"\xff\xfe\x00")
        assert "is not UTF-8 text (byte 0)" in message_of(path)

    def test_not_toml(self, tmp_path):
        path, line = edited(tmp_path, "skew_deg", "skew_deg 63.9")
        assert f"is not TOML: Expected '=' after a key in a key/value pair (at line {line}," in message_of(path)


class TestAccepted:
    def test_paths_are_relative_to_the_scenario(self, tmp_path):
        (tmp_path / "own.xml").write_text("<mujoco/>", encoding="utf-8")
        path, _ = edited(tmp_path, "mass_kg", 'model = "own.xml"')
        assert read_scenario(path).platform.model == tmp_path / "own.xml"

    def test_truth_may_overspeed_one_rotor_or_all(self, tmp_path):
        momenta = [0.0055, 0.004714, 0.004714, 0.004714, 0.004714, 0.004714]
        overspeed = f"[truth]\nrotor_momentum_N_m_s = {momenta}\n\n[initial]"
        path, _ = edited(tmp_path, r"\[initial\]", overspeed, name="momentum_bias")
        assert read_scenario(path).truth.rotor_momentum_N_m_s == tuple(momenta)
        path, _ = edited(tmp_path, r"\[initial\]", "[truth]\nrotor_momentum_N_m_s = 0.0055\n\n[initial]")
        assert read_scenario(path).truth.rotor_momentum_N_m_s == 0.0055
        path, _ = edited(tmp_path, r"\[initial\]", "[truth]\nrotor_momentum_N_m_s = []\n\n[initial]")
        assert read_scenario(path).truth.rotor_momentum_N_m_s is None  # all are as believed

    def test_control_points_of_an_earlier_design(self, tmp_path):
        points = [[0.1 * row] * 6 for row in (0, 0, 1, 2, 1, 0, 0)]
        path = flown_again(tmp_path, points)
        assert read_scenario(path).maneuver.gimbal_angle_rad == tuple(tuple(row) for row in points)

    def test_what_is_omitted_keeps_the_models_numbers(self, tmp_path):
        path, _ = edited(tmp_path, "skew_deg", "")
        assert read_scenario(path).cluster.skew_deg is None

    def test_a_byte_order_mark_is_no_problem(self, tmp_path):
        path = tmp_path / "saved_by_an_editor.toml"
        path.write_bytes(b"\xef\xbb\xbf" + (SHIPPED / "basic.toml").read_bytes())
        assert read_scenario(path) == read_scenario(SHIPPED / "basic.toml")

    def test_is_frozen(self):
        scenario = read_scenario(SHIPPED / "basic.toml")
        with pytest.raises(ValueError, match="frozen"):
            scenario.gyro.noise_rad_s = 0.0


class TestPlatformsWithoutCluster:
    def test_read_without_the_sections_of_a_flight(self):
        scenario = read_body_scenario(SHIPPED / "crazyflie.toml")
        assert scenario.diagnosis.horizon_s == 0.2
        assert not scenario.stores_momentum

    def test_one_that_can_be_flown_is_read_whole(self):
        assert read_body_scenario(SHIPPED / "diagnose.toml") == read_scenario(SHIPPED / "diagnose.toml")

    def test_half_a_flight_lists_what_is_missing(self, tmp_path):
        path, _ = edited(tmp_path, r"\[estimation\]", "[initial]\n[encoder]\n[estimation]", name="crazyflie")
        text = path.read_text(encoding="utf-8")
        limits = "cluster_torque_N_m = [1.0, 1.0, 1.0]\ncluster_momentum_N_m_s = [1.0, 1.0, 1.0]"
        path.write_text(f"{text}\n[limits]\n{limits}\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"cluster: is missing"):
            read_body_scenario(path)

    def test_a_section_that_means_nothing_without_a_cluster_is_unknown(self, tmp_path):
        path, _ = edited(tmp_path, r"\[estimation\]", "[encoder]\n[estimation]", name="crazyflie")
        with pytest.raises(InputError, match=r"encoder: unknown key; it is part of a flight"):
            read_body_scenario(path)

    def test_windows_of_too_few_samples(self, tmp_path):
        path, _ = edited(tmp_path, "horizon_s", "horizon_s = 0.05", name="crazyflie")
        with pytest.raises(InputError, match=r"diagnosis\.horizon_s: 0\.05 s at .* holds 5 samples; at least 10"):
            read_body_scenario(path)
