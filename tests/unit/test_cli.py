"""The command line: exit codes, messages for people, no half-written folders."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from support.processes import outcome, started, until
from testbed.cli.app import app
from testbed.cli.console import further_command
from testbed.cli.failures import exit_code_of
from testbed.records.reading import read_record

ROOT = Path(__file__).resolve().parents[2]
BASIC = (ROOT / "scenarios" / "basic.toml").read_text(encoding="utf-8")


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scenario(folder: Path, *changes: tuple[str, str], name: str = "changed.toml") -> Path:
    text = BASIC
    for old, new in changes:
        assert old in text, f"{old} is not in basic.toml"
        text = text.replace(old, new)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def refused(capsys, *fragments: str) -> None:
    printed = capsys.readouterr()
    assert printed.err.startswith("error: ")
    assert "Traceback" not in printed.err
    for fragment in fragments:
        assert fragment in printed.err


def test_a_missing_scenario(here, capsys):
    assert run("run", "nowhere.toml") == 2
    refused(capsys, "nowhere.toml", "scenario file")
    assert list(here.iterdir()) == []


def test_a_changed_key_is_named_without_a_line_that_the_file_does_not_have(capsys):
    assert run("check", "basic", "--set", "gyro.nois=0.01") == 2
    message = capsys.readouterr().err
    assert "basic.toml with gyro.nois = 0.01: 1 problem" in message
    assert "gyro.nois: unknown key" in message
    assert "line" not in message


def test_a_copied_scenario_is_valid_and_names_no_schema_that_is_not_there(here):
    assert run("new", "mine", "--from", "zero_g") == 0
    assert "#:schema" not in (here / "mine.toml").read_text(encoding="utf-8")
    assert run("check", "mine.toml") == 0


def test_an_unknown_key_names_the_nearest(here, capsys):
    path = scenario(here, ("mass_kg", "mas_kg"))
    assert run("check", path) == 2
    refused(capsys, "changed.toml", "line ", "mas_kg", "mass_kg")


def test_a_wrong_shape(here, capsys):
    path = scenario(here, ("cluster_torque_N_m = [0.040, 0.040, 0.047]", "cluster_torque_N_m = [0.040, 0.047]"))
    assert run("run", path, "--out", "out") == 2
    refused(capsys, "cluster_torque_N_m", "2 entries instead of 3")
    assert not (here / "out").exists()


def test_an_inertia_that_no_bus_has(here, capsys):
    inertia = "[[0.022, 0.0, 0.0], [0.0, 0.022, 0.0], [0.0, 0.0, 0.027]]"
    path = scenario(here, (inertia, "[[0.0005, 0.0, 0.0], [0.0, 0.0005, 0.0], [0.0, 0.0, 0.0005]]"))
    assert run("check", path) == 2
    refused(capsys, "inertia_kg_m2", "no body has")


def test_a_folder_that_is_not_empty_is_left_alone(here, capsys):
    kept = here / "out" / "mine.txt"
    kept.parent.mkdir()
    kept.write_text("mine", encoding="utf-8")
    assert run("run", scenario(here), "--out", "out") == 2
    refused(capsys, "out", "not empty")
    assert [path.name for path in kept.parent.iterdir()] == ["mine.txt"]


def test_a_folder_that_cannot_be_made(here, capsys):
    (here / "file").write_text("", encoding="utf-8")
    assert run("run", scenario(here), "--out", "file/out") == 2
    refused(capsys, "file/out")


def test_a_design_whose_limits_cannot_be_met(here, capsys):
    design = (
        'kind = "design"\nparametrization = "gimbal"\ncriterion = "D"\nduration_s = 5.0\ncontrol_points = 6\n'
        "starts = 1\nseed = 1\nsample_rate_hz = 16.0\nprefilter_time_constant_s = 0.8\nenvelope_fraction = 0.9\n"
        "gimbal_rate_fraction = 0.9\nmin_singularity_measure = 0.95\n"
    )
    path = scenario(here, ('kind = "basic"\nduration_s = 5.0\nscale = 1.0\n', design))
    assert run("design", path, "--out", "out") == 2
    refused(capsys, "singularity")
    assert {entry.name for entry in here.iterdir()} == {"changed.toml"}


def test_there_is_nothing_to_design_in_a_given_maneuver(here, capsys):
    assert run("design", scenario(here)) == 2
    refused(capsys, 'maneuver.kind is "basic"')


def test_a_diverged_flight_keeps_what_was_recorded_and_says_so(here, capsys):
    # No step of 1.25 ms follows a body that turns by 3 rad in each.
    spin = ("body_rate_rad_s = [0.0, 0.0, 0.0]", "body_rate_rad_s = [2000.0, 1300.0, 600.0]")
    path = scenario(here, spin, ('initial_momentum = "zero"', 'initial_momentum = "estimated"'))
    assert run("run", path, "--out", "out") == 3
    assert "iverged" in capsys.readouterr().out
    result = json.loads((here / "out" / "result.json").read_text(encoding="utf-8"))
    assert result["outcome"] == "diverged"
    assert "diverged between t = " in result["message"]
    assert result["estimates"] == {}
    table = pq.read_table(here / "out" / "record.parquet")
    assert 0 < table.num_rows < 401
    assert (here / "out" / "report.html").is_file()
    assert (here / "out" / "recording.rrd").is_file()
    assert {entry.name for entry in here.iterdir()} == {"changed.toml", "out"}


def test_without_out_runs_are_numbered_under_runs(here, capsys):
    path = scenario(here)
    assert run("run", path) == 0
    assert run("run", path, "--seed", 7) == 0
    capsys.readouterr()
    assert {entry.name for entry in (here / "runs").iterdir()} == {"basic", "basic-2"}
    seeds = [json.loads((here / "runs" / name / "result.json").read_text())["seed"] for name in ("basic", "basic-2")]
    assert seeds == [1, 7]
    gyros = [
        read_record(here / "runs" / name / "record.parquet").channels["body_rate"] for name in ("basic", "basic-2")
    ]
    assert (gyros[0] != gyros[1]).any()


def test_a_run_without_a_recording_cannot_be_viewed(here, capsys):
    assert run("view", here) == 2
    refused(capsys, "no recording there")


def test_an_empty_data_folder(here, capsys):
    path = scenario(here)
    (here / "data").mkdir()
    assert run("estimate", path, "--data", "data") == 2
    refused(capsys, "data", "no run in this folder")


def test_a_record_that_does_not_excite_every_axis_is_refused_with_the_directions(here, capsys):
    rows = [
        "time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s,"
        "cluster_momentum_x_N_m_s,cluster_momentum_y_N_m_s,cluster_momentum_z_N_m_s"
    ]
    for index in range(80):
        rate = 0.2 * (index % 16) / 16
        rows.append(f"{index / 16},{rate},0,0,{-0.022 * rate},0,0")
    (here / "data").mkdir()
    (here / "data" / "one_axis.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert run("estimate", scenario(here), "--data", "data") == 2
    refused(capsys, "one_axis", "J22")


def test_a_mistyped_option_is_named(here, capsys):
    assert run("run", scenario(here), "--sede", 3) == 2
    assert "--sede" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("called", "on_the_path", "printed"),
    [
        (".venv/bin/testbed", False, ".venv/bin/testbed view 'runs/my run'"),
        (".venv/bin/testbed", True, "testbed view 'runs/my run'"),
        ("server.py", False, "testbed view 'runs/my run'"),
    ],
)
def test_a_command_to_go_on_with_can_be_pasted(monkeypatch, called, on_the_path, printed):
    monkeypatch.setattr("sys.argv", [called])
    monkeypatch.setattr("shutil.which", lambda name: name if on_the_path else None)
    assert further_command("view", Path("runs/my run")) == printed


def test_help_lists_the_commands():
    command = [sys.executable, "-c", "from testbed.cli import main; main()", "--help"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    shown = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
    for name in ("run", "design", "estimate", "check", "view"):
        assert name in shown


@pytest.mark.parametrize("size", ["0", "00"])
def test_a_terminal_of_no_width_is_one_of_unknown_width(size):
    command = [sys.executable, "-c", "from testbed.cli import main; main()", "list"]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": size, "LINES": size}
    shown = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
    assert "zero_g" in shown


def test_help_imports_no_engine():
    """What keeps `testbed --help` fast."""
    code = (
        "import sys; sys.argv = ['testbed', '--help']\n"
        "from testbed.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "loaded = {'mujoco', 'casadi', 'rerun', 'scipy', 'numpy', 'pydantic'} & set(sys.modules)\n"
        "assert not loaded, loaded\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=environment)


def test_names_that_look_like_markup_are_printed_as_they_are(here, capsys):
    path = scenario(here, ('description = "', 'description = "[/x] [bold]'))
    assert run("check", path) == 0
    assert "[/x] [bold]" in capsys.readouterr().out
    assert run("run", path, "--out", "a[/b]") == 0
    assert "a[/b]" in capsys.readouterr().out


def test_the_scenario_is_copied_byte_for_byte(here, capsys):
    path = scenario(here)
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert run("run", path, "--out", "out") == 0
    capsys.readouterr()
    assert (here / "out" / "scenario.toml").read_bytes() == path.read_bytes()


def test_an_empty_folder_is_filled_even_if_one_stands_in_it(here, capsys):
    path = scenario(here)
    place = here / "empty"
    place.mkdir()
    os.chdir(place)
    assert run("run", path, "--out", ".") == 0
    capsys.readouterr()
    assert (place / "result.json").is_file()
    assert {entry.name for entry in here.iterdir()} == {"changed.toml", "empty"}


def test_an_overspeeding_rotor_is_clamped_and_said_so(here, capsys):
    momenta = "[0.004714, 0.004714, 0.0056, 0.004714, 0.004714, 0.004714]"
    truth = ("[gyro]", f"[truth]\nrotor_momentum_N_m_s = {momenta}\n\n[gyro]")
    path = scenario(here, truth, ('initial_momentum = "zero"', 'initial_momentum = "estimated"'))
    assert run("run", path, "--out", "out") == 0
    assert "with a rotor or wheel at its momentum limit" in capsys.readouterr().out
    record = read_record(here / "out" / "record.parquet")
    clamped = record.channels["rotor_momentum_clamped"].any(axis=0)
    assert clamped.tolist() == [False, False, True, False, False, False]
    assert abs(record.channels["true_rotor_speed"][-1, 2]) * 1e-5 <= 0.0052 * (1.0 + 1e-6)


def test_a_contact_with_the_cabin_ends_the_usable_record(here, capsys):
    drift = ("velocity_m_s = [0.0, 0.0, 0.0]", "velocity_m_s = [0.12, 0.0, 0.0]\n\n[cabin]\nsize_m = [1.0, 1.0, 1.0]")
    assert run("run", scenario(here, drift), "--out", "out") == 0
    assert "with the cabin at 3." in capsys.readouterr().out  # (0.5 - 0.09) m / 0.12 m/s, less what the cube has turned
    record = read_record(here / "out" / "record.parquet")
    end = record.details.usable_to
    assert end is not None
    free = record.time <= end
    momentum_N = record.channels["true_total_momentum"]
    drift_free = abs(momentum_N[free] - momentum_N[0]).max()
    assert drift_free < 1e-8
    assert abs(momentum_N - momentum_N[0]).max() > 1e-4, "the wall did push"


def test_a_profile_in_degrees_per_second_is_refused(here, capsys):
    rows = ["time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s"]
    rows += [f"{index / 10},{30 * (index % 5)},0,0" for index in range(20)]
    (here / "profile.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    path = scenario(here, ('kind = "basic"\nduration_s = 5.0\nscale = 1.0\n', 'kind = "csv"\nfile = "profile.csv"\n'))
    assert run("run", path, "--out", "out") == 2
    refused(capsys, "profile.csv", "deg/s")


def test_an_interrupted_design_leaves_nothing_behind(here):
    """The optimiser catches Ctrl-C for itself; the command must end all the same."""
    solving = """
import pathlib
import testbed.maneuver.multistart as multistart
solved = multistart._solved
def noted(*arguments):
    pathlib.Path("here").touch()
    return solved(*arguments)
multistart._solved = noted
"""
    shipped = (ROOT / "scenarios" / "gimbal_d_optimal.toml").read_text(encoding="utf-8")
    path = here / "long.toml"
    path.write_text(re.sub(r"(?m)^starts = \d+", "starts = 500", shipped), encoding="utf-8")
    with started("design", path, "--out", "out", cwd=here, before=solving, signals_ignored=True) as process:
        until((here / "here").exists, process)
        process.send_signal(signal.SIGINT)
        code, output, complaints = outcome(process)
    assert (code, output, complaints) == (130, "", "Interrupted; nothing was written.\n")
    assert {entry.name for entry in here.iterdir()} == {"long.toml", "here"}
