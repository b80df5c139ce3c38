"""NAME.toml: what it may say, and what is refused."""

import pytest

from testbed.errors import InputError
from testbed.records.details import details_text, read_details
from testbed.records.record import RunDetails

FULL = """
name = "parabola 14"
source = "measured"            # measured | simulated
gyro_noise_rad_s = 0.001658    # per sample; estimated from the data where absent
usable_from_s = 0              # e.g. release
usable_to_s = 3.2              # e.g. first contact with the cabin wall
role = "fit"
"""
PARABOLA = RunDetails(name="parabola 14", gyro_noise=0.001658, usable_from=0.0, usable_to=3.2, role="fit")


@pytest.fixture
def toml(tmp_path):
    def write(text):
        path = tmp_path / "run.toml"
        path.write_text(text)
        return path

    return write


def refusal(path):
    with pytest.raises(InputError) as caught:
        read_details(path)
    assert str(path) in str(caught.value)
    return str(caught.value)


def test_every_key_is_read(toml):
    assert read_details(toml(FULL)) == PARABOLA


def test_a_run_without_details_has_its_files_name(tmp_path, toml):
    assert read_details(tmp_path / "yaw 1.toml") == RunDetails(name="yaw 1")
    assert read_details(toml("")) == RunDetails(name="run")


def test_all_errors_are_named_at_once(toml):
    message = refusal(toml('usable_form_s = 1.0\ngyro_noise_rad_s = "small"\nsource = "simulation"\nusable_to_s = nan'))
    assert "usable_form_s: unknown key; known are name, source, gyro_noise_rad_s, usable_from_s, usable_to_s" in message
    assert "gyro_noise_rad_s = 'small': input should be a valid number" in message
    assert "source = 'simulation': input should be 'measured' or 'simulated'" in message
    assert "usable_to_s = nan: input should be a finite number" in message
    assert "gyro_noise_rad_s = nan: input should be a finite number" in refusal(toml("gyro_noise_rad_s = nan"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gyro_noise = 0.1", "gyro_noise: unknown key; known are"),
        ("gyro_noise_deg_s = 0.095", "gyro_noise_deg_s: unknown key; known are"),
        ("gyro_noise_rad_s = -0.1", "gyro_noise_rad_s = -0.1: input should be greater than or equal to 0"),
        ("gyro_noise_rad_s = true", "gyro_noise_rad_s = True: input should be a valid number"),
        ("name = 14", "name = 14: input should be a valid string"),
        ('name = ""', "name = '': string should have at least 1 character"),
        ('role = "test"', "role = 'test': input should be 'fit' or 'heldout'"),
        ("usable_from_s = 3.2\nusable_to_s = 1.0", "usable_from_s has to be smaller than usable_to_s"),
        ("name = parabola", "is not TOML: Invalid value (at line 1, column 8)"),
    ],
)
def test_wrong_details_are_refused(toml, text, message):
    assert message in refusal(toml(text))


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "run.toml").write_bytes(b'name = "\xff"')
    assert "is not UTF-8 text (byte 8)" in refusal(tmp_path / "run.toml")


def test_only_what_a_reader_would_not_assume_is_written():
    assert details_text(RunDetails(name="run"), "run") == ""
    assert details_text(RunDetails(name="run", source="simulated"), "run") == 'source = "simulated"\n'
    assert details_text(RunDetails(name="run"), "record") == 'name = "run"\n'
