"""`testbed import`: a data set that the other commands read, with how it came about; honest messages otherwise."""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import replace

import numpy as np
import pytest
import tomli_w

import testbed as tb
from support import logs
from support.few_effects import know_only
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.logs.export import map_keys, write_mcap
from testbed.records.reading import read_data_set


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture
def log(tmp_path):
    (tmp_path / "map.toml").write_text(tomli_w.dumps(logs.ULOG_MAP))
    return logs.write_ulog(tmp_path / "bench.ulg")


def test_a_log_becomes_a_data_set_with_its_provenance(log, tmp_path, capsys):
    assert run("import", log, "--map", tmp_path / "map.toml", "--out", tmp_path / "data") == 0
    printed = capsys.readouterr().out
    assert "timestamp_sample in us" in printed
    assert "Not used   sensor_gyro" in printed
    (record,) = read_data_set(tmp_path / "data")
    assert record.details.name == "bench"
    made = json.loads((tmp_path / "data" / "provenance.json").read_text(encoding="utf-8"))
    hashes = {stamp["path"]: stamp["sha256"] for stamp in made["inputs"]}
    assert hashes[str(log)] == hashlib.sha256(log.read_bytes()).hexdigest()
    assert hashes[str(tmp_path / "map.toml")] == hashlib.sha256((tmp_path / "map.toml").read_bytes()).hexdigest()
    assert made["map"] == (tmp_path / "map.toml").read_text()
    assert made["channels"]["body_rate"]["clock"] == "timestamp_sample in us"
    assert made["unused"] == ["sensor_gyro"]
    assert made["version_pyulog"]
    assert {path.name for path in (tmp_path / "data").iterdir()} == {"bench.parquet", "provenance.json"}


def test_json_is_the_provenance_and_quiet_is_nothing(log, tmp_path, capsys):
    arguments = ("import", log, "--map", tmp_path / "map.toml", "--out")
    assert run(*arguments, tmp_path / "one", "--json") == 0
    assert json.loads(capsys.readouterr().out)["runs"]["bench"]["rows"] == 500
    assert run(*arguments, tmp_path / "other", "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_guess_prints_a_map_that_can_be_saved(log, tmp_path, capsys):
    assert run("import", log, "--guess") == 0
    (tmp_path / "guessed.toml").write_text(capsys.readouterr().out)
    assert run("import", log, "--map", tmp_path / "guessed.toml", "--out", tmp_path / "data") == 0


def test_a_clock_in_another_unit_is_refused(tmp_path, capsys):
    """500 samples in ten seconds are 500 in ten microseconds, where milliseconds are taken for nanoseconds."""
    time = np.arange(500) * 20
    lines = [f"{each},0.1,0.0,-0.1" for each in time]
    (tmp_path / "log.csv").write_text("\n".join(["t,x,y,z", *lines]) + "\n")
    fields = ["x", "y", "z"]
    channels = {"body_rate": {"fields": fields, "unit": "rad/s"}, "applied_torque": {"fields": fields, "unit": "N*m"}}
    for unit, code in (("ms", 0), ("ns", 2)):
        keys = {"schema": 1, "source": "measured", "clock": {"field": "t", "unit": unit}, "channels": channels}
        (tmp_path / "map.toml").write_text(tomli_w.dumps(keys))
        assert run("import", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "--out", tmp_path / unit) == code
    assert "500 samples within 9.98e-06 s by the clock (t in ns): no sensor is that fast" in capsys.readouterr().err
    assert not (tmp_path / "ns").exists()


def test_rows_of_other_channels_are_no_lost_samples_of_a_gyro_with_a_gap(tmp_path, capsys):
    """A table with a row for each message: the torques' rows are none of the gyro's, whose gap nobody left out."""
    rows = [(0.005 * k, f"{0.1 * np.sin(k)},0.0,-0.1,,,") for k in range(600) if not 300 < k < 316]
    rows += [(0.01 * k + 0.002, f",,,{0.1 * np.cos(k)},0.0,0.1") for k in range(300)]
    lines = [f"{time:.4f},{values}" for time, values in sorted(rows)]
    (tmp_path / "log.csv").write_text("\n".join(["t,x,y,z,u,v,w", *lines]) + "\n")
    channels = {
        "body_rate": {"fields": ["x", "y", "z"], "unit": "rad/s"},
        "applied_torque": {"fields": ["u", "v", "w"], "unit": "N*m"},
    }
    keys = {"schema": 1, "clock": {"field": "t", "unit": "s"}, "channels": channels}
    (tmp_path / "map.toml").write_text(tomli_w.dumps(keys))
    assert run("import", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "--out", tmp_path / "data") == 0
    assert "dropped" not in capsys.readouterr().out


def test_what_is_wrong_leaves_nothing_behind(log, tmp_path, capsys):
    keys = json.loads(json.dumps(logs.ULOG_MAP))
    keys["channels"]["body_rate"]["topic"] = "gyro"
    (tmp_path / "map.toml").write_text(tomli_w.dumps(keys))
    assert run("import", log, "--map", tmp_path / "map.toml", "--out", tmp_path / "data") == 2
    assert "topic gyro: is not there; did you mean sensor_gyro" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()
    assert run("import", log) == 2
    assert "--map: is missing; give MAP.toml, or --guess" in capsys.readouterr().err
    assert run("import", log, "--map", tmp_path / "map.toml", "--guess") == 2
    assert "--guess: proposes a map; leave --map out" in capsys.readouterr().err
    assert run("import", log, "--guess", "--out", tmp_path / "data") == 2
    assert "--guess: prints a map and writes nothing; leave --out out" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["a.ulg", "json.mcap", "ros2.mcap", "protobuf.mcap", "ros1.bag"])
def test_a_missing_extra_is_said_with_what_installs_it(tmp_path, monkeypatch, capsys, name):
    from tests.unit.test_logs_reading import WRITERS

    write, keys = WRITERS[name]
    path = write(tmp_path / name)
    (tmp_path / "map.toml").write_text(tomli_w.dumps(keys))
    package = {"a.ulg": "pyulog", "json.mcap": "mcap", "protobuf.mcap": "mcap_protobuf"}.get(name, "rosbags")
    for module in [module for module in sys.modules if module.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, package, None)
    assert run("import", path, "--map", tmp_path / "map.toml") == 2
    assert f"needs the package {package}, which is not installed: pip install" in capsys.readouterr().err


def test_without_the_units_library_nothing_is_converted(log, tmp_path, monkeypatch, capsys):
    from testbed.logs import units

    units._registry.cache_clear()
    monkeypatch.setitem(sys.modules, "pint", None)
    assert run("import", log, "--map", tmp_path / "map.toml") == 2
    assert "converting units needs the package pint" in capsys.readouterr().err


@pytest.fixture(scope="module")
def flights():
    scenario = tb.read_scenario("diagnose")
    flown = [tb.fly(scenario, seed=seed).record for seed in (1, 2)]
    names = ("first", "second")
    return scenario, [
        replace(record, details=replace(record.details, name=name), extra_columns={})
        for record, name in zip(flown, names, strict=True)
    ]


def test_imported_flights_are_estimated_and_diagnosed_as_the_flights(flights, tmp_path, monkeypatch):
    """Written as MCAP, imported, read from the folder: the same numbers; sums over them differ in their last bits."""
    know_only(monkeypatch, "gyro_latency", "viscous_drag", "gimbal_zero")
    scenario, records = flights
    for record in records:
        name = record.details.name
        path = write_mcap(record, tmp_path / f"{name}.mcap")
        tb.import_log(path, map_keys(record), tmp_path / name)
        (tmp_path / name / f"{name}.parquet").rename(tmp_path / f"{name}.parquet")
    imported = tb.read_records(tmp_path)
    for record in records:
        for channel, values in record.channels.items():
            np.testing.assert_array_equal(imported[record.details.name].channels[channel], values)
    one, other = tb.estimate(scenario, imported), tb.estimate(scenario, tb.Records(tuple(records)))
    for estimator, combined in other.combined.items():
        assert np.abs((one.combined[estimator].theta - combined.theta) / combined.std).max() < 1e-9
    assert tb.diagnose(scenario, imported, propose=False).verdict == "none"


def test_what_is_known_of_a_run_goes_with_it(flights, tmp_path):
    _, (record, _) = flights
    details = replace(record.details, usable_from=0.5, usable_to=4.0, role="fit", axes=("x", "z"))
    known = replace(record, details=details)
    imported = tb.import_log(write_mcap(known, tmp_path / "first.mcap"), map_keys(known), tmp_path / "out")
    assert imported.runs[0].details == details
    assert tb.read_records(tmp_path / "out")["first"].details == details


def test_channels_that_share_no_time_are_refused(flights, tmp_path):
    _, (record, _) = flights
    keys = map_keys(record)
    keys["channels"] = {name: keys["channels"][name] for name in ("body_rate", "gimbal_angle")}
    keys["channels"]["gimbal_angle"]["offset_s"] = 1000.0
    with pytest.raises(tb.InputError, match=r"gimbal_angle has samples from 10.* their clocks differ"):
        tb.import_log(write_mcap(record, tmp_path / "run.mcap"), keys)


def test_topics_at_their_own_times_are_estimated(flights, tmp_path):
    """Gyro and encoders that never share a row: the estimate is that of simultaneous ones, within its noise."""
    scenario, (record, _) = flights
    keys = map_keys(record)
    keys["channels"] = {name: keys["channels"][name] for name in ("body_rate", "gimbal_angle")}
    together = tb.import_log(write_mcap(record, tmp_path / "run.mcap"), keys)
    gyro = replace(record, channels={"body_rate": record.channels["body_rate"]})
    encoders = replace(record, time=record.time + 1e-4, channels={"gimbal_angle": record.channels["gimbal_angle"]})
    files = [write_mcap(part, tmp_path / f"{name}.mcap") for name, part in (("gyro", gyro), ("encoders", encoders))]
    apart = tb.import_log(_merged(files, tmp_path / "apart.mcap"), keys)
    known = [np.isfinite(values).all(axis=1) for values in apart.runs[0].channels.values()]
    assert not (known[0] & known[1]).any()
    one, other = (tb.estimate(scenario, each).combined["output_error"] for each in (apart, together))
    assert np.abs((one.theta - other.theta) / other.std).max() < 0.5


def _merged(files, path):
    """Write the messages of several MCAP files into one."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        for each in files:
            with each.open("rb") as part:
                channels: dict[str, int] = {}
                for schema, channel, message in make_reader(part).iter_messages():
                    if channel.topic not in channels:
                        identity = writer.register_schema(schema.name, schema.encoding, schema.data)
                        channels[channel.topic] = writer.register_channel(channel.topic, "json", identity)
                    writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
        writer.finish()
    return path


def test_several_logs_become_one_data_set(log, tmp_path, capsys):
    other, again = tmp_path / "later.ulg", tmp_path / "second" / "bench.ulg"
    again.parent.mkdir()
    logs.write_ulog(other, 600)
    logs.write_ulog(again, 700)
    assert run("import", log, other, again, "--map", tmp_path / "map.toml", "--out", tmp_path / "data") == 0
    assert "1,700 samples at 200 Hz" in capsys.readouterr().out
    records = {record.details.name: record for record in read_data_set(tmp_path / "data")}
    alone = tb.import_log(other, tmp_path / "map.toml").runs[0]
    assert set(records) == {"bench", "later", "bench_2"}
    np.testing.assert_array_equal(records["later"].channels["body_rate"], alone.channels["body_rate"])
    made = json.loads((tmp_path / "data" / "provenance.json").read_text(encoding="utf-8"))
    assert [stamp["path"] for stamp in made["inputs"]] == [str(p) for p in (log, other, again, tmp_path / "map.toml")]
    assert set(made["runs"]) == set(records)


def test_the_maps_name_stands_before_those_of_several_logs(log, tmp_path):
    other = logs.write_ulog(tmp_path / "later.ulg", 600)
    records = tb.import_log([log, other], logs.ULOG_MAP | {"name": "day1"})
    assert [record.details.name for record in records] == ["day1_bench", "day1_later"]
    assert [stamp.path for stamp in records.runs[1].files] == [str(other), "map.toml"]


def test_every_log_that_cannot_be_imported_is_named_and_nothing_is_left(log, tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t,x\n0,1\n")
    arguments = ("--map", tmp_path / "map.toml", "--out", tmp_path / "data")
    (tmp_path / "empty.csv").write_text("")
    assert run("import", log, tmp_path / "a.csv", tmp_path / "b.ulg", tmp_path / "empty.csv", *arguments) == 2
    said = capsys.readouterr().err
    assert "b.ulg: cannot be read" in said
    assert "empty.csv: is empty" in said
    (tmp_path / "b.csv").write_text("t,y\n0,1\n")
    assert run("import", tmp_path / "a.csv", log, tmp_path / "b.csv", *arguments) == 2
    said = capsys.readouterr().err
    assert "a.csv: does not hold" in said
    assert "b.csv: does not hold" in said
    (tmp_path / "copy.ulg").write_bytes(log.read_bytes())
    assert run("import", log, tmp_path / "copy.ulg", *arguments) == 2
    assert "is the same log as" in capsys.readouterr().err
    assert run("import", log, log, "--guess") == 2
    assert "proposes a map for one log" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()
    with pytest.raises(tb.InputError, match="there is no log in it"):
        tb.import_log([], tmp_path / "map.toml")
