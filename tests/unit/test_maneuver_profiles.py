"""The basic profile, and profiles from tables, good and bad."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.errors import InputError
from testbed.maneuver.profiles import basic_profile, read_profile

HEAD = "time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s"
UNITS, NO_WHEELS = 6, np.zeros(0)
GIMBALS = ",".join(f"gimbal_angle_{unit}_rad" for unit in range(1, UNITS + 1))
ROWS = ["2.0,0,0,0", "2.5,0.1,0,0.2", "3.0,0.1,-0.1,0.2", "3.5,0,0,0.1", "4.0,0,0,0"]


def table(tmp_path, *lines):
    path = tmp_path / "profile.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_basic_profile_excites_all_axes_from_rest_to_rest():
    body_rate = basic_profile().reference(np.linspace(0.0, 5.0, 501)).body_rate
    np.testing.assert_array_equal(body_rate[[0, -1]], 0.0)
    assert np.abs(body_rate).max() == pytest.approx(0.2, rel=0.05)  # the paper's figure is read off a plot
    assert np.abs(body_rate).max(axis=0).min() > 0.15
    correlation = np.abs(np.corrcoef(body_rate.T)[np.triu_indices(3, 1)])
    assert correlation.max() < 0.9  # differently on each axis


def test_the_basic_profile_scales_and_stretches():
    time = np.linspace(0.0, 5.0, 50)
    scaled = basic_profile(duration=10.0, scale=1.5).reference(2.0 * time).body_rate
    np.testing.assert_allclose(scaled, 1.5 * basic_profile().reference(time).body_rate, atol=1e-15)


def test_a_table_is_met_at_its_rows(tmp_path):
    maneuver = read_profile(table(tmp_path, HEAD, *ROWS), UNITS, NO_WHEELS)
    assert maneuver.name == "profile"
    assert maneuver.duration == 2.0
    assert maneuver.gimbal_angle is None
    rows = np.array([[float(value) for value in row.split(",")] for row in ROWS])
    np.testing.assert_allclose(maneuver.reference(rows[:, 0] - 2.0).body_rate, rows[:, 1:], atol=1e-15)


def test_gimbal_angles_come_along_and_other_columns_do_not_matter(tmp_path):
    rows = [f"{row},{step},1,2,3,4,5,left" for step, row in enumerate(ROWS)]
    maneuver = read_profile(table(tmp_path, f"{HEAD},{GIMBALS},remark", *rows), UNITS, NO_WHEELS)
    reference = maneuver.reference(np.array([0.5]))
    np.testing.assert_allclose(reference.gimbal_angle, [[1, 1, 2, 3, 4, 5]], atol=1e-12)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (
            [f"{HEAD},{GIMBALS},gimbal_angle_7_rad", *(f"{row}{7 * ',0'}" for row in ROWS)],
            "has column gimbal_angle_7_rad, but the platform has 6 units; leave it out",
        ),
        ([HEAD.replace("_z_rad_s", "_z"), *ROWS], "has no column body_rate_z_rad_s; its columns are time_s, body"),
        (
            [f"{HEAD},gimbal_angle_1_rad,gimbal_angle_3_rad", *(f"{row},0,0" for row in ROWS)],
            "has no column gimbal_angle_2_rad, gimbal_angle_4",
        ),
        ([f"{HEAD},time_s", *(f"{row},1" for row in ROWS)], "has column time_s more than once"),
        ([HEAD, *ROWS[:2]], "has 2 rows; a cubic spline needs at least 4"),
        ([HEAD, *ROWS[:2], "3.0,0.1,,0.2", *ROWS[3:]], "body_rate_y_rad_s is not a finite number in row 3"),
        ([HEAD, *ROWS[:2], "3.0,0.1,nan,0.2", *ROWS[3:]], "body_rate_y_rad_s is not a finite number in row 3"),
        ([HEAD, *ROWS[:3], ROWS[2], *ROWS[3:]], "time_s does not increase from row 3 to row 4"),
        ([HEAD, *ROWS, "9000.0,0.1,0.1,0.1"], "lasts 8998 s, at most 3600 s are flown; if time_s is in ms"),
        ([HEAD, ROWS[0], "2.5,0.1,fast,0.2", *ROWS[2:]], "cannot be read as a table of numbers: .*'fast'"),
        ([HEAD, ROWS[0], "2.5,0.1", *ROWS[2:]], "cannot be read as a table of numbers"),
        ([], "cannot be read as a table of numbers"),
    ],
)
def test_a_bad_table_is_refused_with_its_place(tmp_path, lines, message):
    with pytest.raises(InputError, match=message) as caught:
        read_profile(table(tmp_path, *lines), UNITS, NO_WHEELS)
    assert str(tmp_path / "profile.csv") in str(caught.value)


def test_all_faults_of_a_table_are_named_at_once(tmp_path):
    with pytest.raises(InputError) as caught:
        read_profile(table(tmp_path, HEAD, "1,0,,0", "1,0,0,0"), UNITS, NO_WHEELS)
    assert len(str(caught.value).splitlines()) == 3


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.csv: cannot be read \(No such file"):
        read_profile(tmp_path / "nowhere.csv", UNITS, NO_WHEELS)
