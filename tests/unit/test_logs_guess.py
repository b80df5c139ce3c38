"""A map proposed from names and units: a beginning that imports where names say enough, and says where they do not."""

from __future__ import annotations

import struct
import sys
import tomllib

import numpy as np
import pytest

import testbed as tb
from support import logs
from testbed.logs import units
from tests.unit.test_logs_reading import WRITERS

TORQUE = ["torque_x_mNm", "torque_y_mNm", "torque_z_mNm"]


def test_without_the_units_library_the_message_names_what_installs_it(tmp_path, monkeypatch):
    path = tmp_path / "log.csv"
    path.write_text("t_us,gyro_x_dps,gyro_y_dps,gyro_z_dps\n0,1,2,3\n10,1,2,3\n", encoding="utf-8")
    units._registry.cache_clear()
    monkeypatch.setitem(sys.modules, "pint", None)
    with pytest.raises(tb.InputError, match=r"needs the package pint.*pip install 'testbed\[logs\]'"):
        tb.guess_map(path)


def guessed(path) -> dict:
    return tomllib.loads(tb.guess_map(path))


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_proposed_imports_as_the_map_that_a_person_wrote(tmp_path, name):
    write, keys = WRITERS[name]
    path = write(tmp_path / name)
    text = tb.guess_map(path)
    tree = tomllib.loads(text)
    clocks = {"time_field" in channel for channel in tree["channels"].values()}
    marked = name != "a.ulg" and len(clocks) > 1  # two clocks are nothing to pass over
    assert ("# CHECK: no time_field" in text) == marked
    if name == "json.mcap":  # whose clock of torques no name says
        assert marked
        tree["channels"]["applied_torque"] |= {"time_field": "us", "time_unit": "us"}
    proposed, written = tb.import_log(path, tree).runs[0], tb.import_log(path, keys).runs[0]
    for channel in ("body_rate", "applied_torque"):
        np.testing.assert_array_equal(
            proposed.channels[channel][np.isfinite(proposed.channels[channel][:, 0])],
            written.channels[channel][np.isfinite(written.channels[channel][:, 0])],
        )


@pytest.mark.parametrize(("clock", "why"), [("stamp_us", "from its name"), ("stamp", "a time since 1970 in us")])
def test_a_clock_in_messages_is_proposed_by_its_name_and_marked(tmp_path, clock, why):
    """It was passed over, and the log's own time taken: that at which messages came in."""
    path = logs.write_json_mcap(tmp_path / "json.mcap", clock=clock)
    text = tb.guess_map(path)
    torque = tomllib.loads(text)["channels"]["applied_torque"]
    assert (torque["time_field"], torque["time_unit"]) == (clock, "us")
    assert f'time_field = "{clock}"  # CHECK: by its name' in text
    assert why in text
    assert "# CHECK: no time_field" not in text


@pytest.mark.parametrize(
    ("columns", "fields", "unit", "clock"),
    [
        (["t_ms", "gyro_x_dps", "gyro_y_dps", "gyro_z_dps"], None, "deg/s", ("t_ms", "ms")),
        (["time", "gx", "gy", "gz"], None, "rad/s", ("time", "s")),
        (["Time since boot (ms)", "gx", "gy", "gz"], None, "rad/s", ("Time since boot (ms)", "ms")),
        (["t", "gyro_x_mdps", "gyro_y_mdps", "gyro_z_mdps"], None, "mdeg/s", ("t", "s")),
        (["Date/Time", "gx", "gy", "gz"], None, "rad/s", ("Date/Time", "s")),
        (["Time [s]", "omega_x[deg/s]", "omega_y[deg/s]", "omega_z[deg/s]"], None, "deg/s", ("Time [s]", "s")),
        (["timestamp", "angular_velocity.x", "angular_velocity.y", "angular_velocity.z"], None, "rad/s", None),
        (["t", "x_gyro", "y_gyro", "z_gyro"], None, "rad/s", ("t", "s")),
        (["t_us", "gyro_rad_s[0]", "gyro_rad_s[1]", "gyro_rad_s[2]"], None, "rad/s", ("t_us", "us")),
        (["t", "p", "q", "r"], None, "rad/s", ("t", "s")),
        (["t", "roll_rate", "pitch_rate", "yaw_rate"], None, "rad/s", ("t", "s")),
        (["t", "rollrate_dps", "pitchrate_dps", "yawrate_dps"], None, "deg/s", ("t", "s")),
        (["t", "wx (rad/s)", "wy (rad/s)", "wz (rad/s)"], None, "rad/s", ("t", "s")),
        (["time_s", *(f"body_rate_{axis}_rad_s" for axis in "xyz")], None, "rad/s", ("time_s", "s")),
        (["t", "acc_x", "acc_y", "acc_z", "gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "GyroX", "GyroY", "GyroZ"],
         ["GyroX", "GyroY", "GyroZ"], "rad/s", ("t", "s")),
    ],
)  # fmt: skip
def test_common_names_of_columns(tmp_path, columns, fields, unit, clock):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([",".join(columns), *(",".join([str(n)] * len(columns)) for n in range(20))]))
    tree = guessed(path)
    assert tree["channels"]["body_rate"]["fields"] == (fields or columns[1:])
    assert tree["channels"]["body_rate"]["unit"] == unit
    if clock is not None:
        assert (tree["clock"]["field"], tree["clock"]["unit"]) == clock


def test_what_no_channel_takes_and_what_a_map_still_needs_is_said(tmp_path):
    path = tmp_path / "a.csv"
    columns = ["time s", "gx dps", "gy dps", "gz dps", "panel", "mode"]
    path.write_text("\n".join([",".join(columns), *(",".join([str(n)] * len(columns)) for n in range(20))]))
    text = tb.guess_map(path)
    assert '# Columns without a channel: "panel", "mode"' in text
    assert "# CHECK: no channel here says what turned the platform" in text
    assert tomllib.loads(text)["channels"]["body_rate"]["unit"] == "deg/s"


@pytest.mark.parametrize(
    ("names", "channel", "unit"),
    [
        ([f"gimbal_{unit}_angle_deg" for unit in range(1, 7)], "gimbal_angle", "deg"),
        ([f"gimbal_angle_{unit}_rad" for unit in range(1, 7)], "gimbal_angle", "rad"),
        ([f"rotor_speed_{unit}_rpm" for unit in range(6)], "rotor_speed", "rpm"),
        ([f"wheel_speed_{unit}_rpm" for unit in range(4)], "wheel_speed", "rpm"),
        ([f"RW{unit} rpm" for unit in (1, 2, 3)], "wheel_speed", "rpm"),
        ([f"wheel_torque_cmd_{unit} [mNm]" for unit in (1, 2, 3)], "wheel_torque_command", "mN*m"),
        ([f"rw{unit}_mNm" for unit in (1, 2, 3)], "wheel_torque", "mN*m"),
        ([f"rw{unit}_cmd_mNm" for unit in (1, 2, 3)], "wheel_torque_command", "mN*m"),
        ([f"whlcmd{unit}_mNm" for unit in (1, 2, 3)], "wheel_torque_command", "mN*m"),
        ([f"whl{unit}_rpm" for unit in (1, 2, 3)], "wheel_speed", "rpm"),
        ([f"gim{unit}_deg" for unit in (1, 2, 3, 4)], "gimbal_angle", "deg"),
        ([f"gimcmd{unit}_dps" for unit in (1, 2, 3, 4)], "gimbal_rate_command", "deg/s"),
        ([f"cmg_momentum_{axis}_Nms" for axis in "xyz"], "cluster_momentum", "N*m*s"),
        (TORQUE, "applied_torque", "mN*m"),
        ([f"M{axis} [uNm]" for axis in "xyz"], "applied_torque", "uN*m"),
        (["q_w", "q_x", "q_y", "q_z"], "attitude", None),
        ([f"accel_{axis} [g]" for axis in "xyz"], "acceleration", "g_0"),
    ],
)
def test_other_channels(tmp_path, names, channel, unit):
    path = tmp_path / "a.csv"
    columns = ["t_s", "gx", "gy", "gz", *names]
    path.write_text("\n".join([",".join(columns), *(",".join([str(n)] * len(columns)) for n in range(20))]))
    found = guessed(path)["channels"][channel]
    assert found["fields"] == names
    assert found.get("unit") == unit


@pytest.mark.parametrize(
    ("first", "unit"), [(1_760_000_000, "s"), (1_760_000_000_000, "ms"), (1_760_000_000_000_000, "us"), (10**18, "ns")]
)
def test_a_clock_since_1970_says_its_unit_by_its_size(tmp_path, first, unit):
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["timestamp,gx,gy,gz", *(f"{first + n},1,2,3" for n in range(20))]))
    assert guessed(path)["clock"] == {"field": "timestamp", "unit": unit}


def test_what_is_not_stated_is_marked_to_be_checked(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["t,gx,gy,gz", *(f"{n},1,2,3" for n in range(20))]))
    text = tb.guess_map(path)
    assert 'unit = "s"  # CHECK: the log does not state it' in text
    assert 'unit = "rad/s"  # CHECK: the log does not state it' in text


@pytest.mark.parametrize(
    ("columns", "axes", "doubt", "channels"),
    [
        ("Yaw rate [deg/s],mz", ["z"], False, {"body_rate": ["Yaw rate [deg/s]"], "applied_torque": ["mz"]}),
        ("gyro_z_dps,rw_rpm", ["z"], False, {"body_rate": ["gyro_z_dps"], "wheel_speed": ["rw_rpm"]}),
        ("heading_rate_dps,wheel_rpm", ["z"], True, {"body_rate": ["heading_rate_dps"], "wheel_speed": ["wheel_rpm"]}),
        ("wx,wz,wheel1_rpm,wheel2_rpm", ["x", "z"], False, {"body_rate": ["wx", "wz"]}),
        ("pitch_rate,torque,tau_x,tau_y,tau_z", ["y"], False, {"applied_torque": ["tau_x", "tau_y", "tau_z"]}),
    ],
)
def test_the_few_axes_of_a_rig_are_proposed_with_their_fields(tmp_path, columns, axes, doubt, channels):
    path = tmp_path / "rig.csv"
    rows = [",".join(str(row + column) for column in range(columns.count(",") + 2)) for row in range(20)]
    path.write_text("\n".join([f"t,{columns}", *rows]) + "\n", encoding="utf-8")
    text = tb.guess_map(path)
    tree = tomllib.loads(text)
    assert tree["axes"] == axes
    assert ("# CHECK: one field, and no name says about which axis" in text) == doubt
    assert {name: tree["channels"][name]["fields"] for name in channels} == channels
    assert tb.import_log(path, tree).runs[0].details.axes == tuple(axes)


def test_a_normalized_torque_is_proposed_as_a_comment(tmp_path):
    fields = {
        "vehicle_torque_setpoint": "uint64_t timestamp;float[3] xyz",
        "sensor_gyro": "uint64_t timestamp;float x;float y;float z",
    }
    log = logs.ULogWriter(tmp_path / "a.ulg", fields)
    for number, name in enumerate(fields):
        log.add(number, name)
        log.data(number, struct.pack("<Q3f", 5000, 0.1, 0.2, 0.3))
    log.close()
    text = tb.guess_map(tmp_path / "a.ulg")
    assert list(tomllib.loads(text)["channels"]) == ["body_rate"]
    assert "# scale = [1.0, 1.0, 1.0]  # PX4 normalizes it to -1 ... 1: give the torque at 1, N*m" in text


def test_a_topic_and_its_field_together_name_a_channel(tmp_path):
    """Topic `wheels` with fields `speed` and `torque`: neither name alone says what it is."""
    fields = {
        "wheels": "uint64_t timestamp;float[4] speed;float[4] torque",
        "sensor_gyro": "uint64_t timestamp;float x;float y;float z",
    }
    log = logs.ULogWriter(tmp_path / "a.ulg", fields)
    for number, (name, count) in enumerate(zip(fields, (8, 3), strict=True)):
        log.add(number, name)
        log.data(number, struct.pack(f"<Q{count}f", 5000, *(0.1,) * count))
    log.close()
    channels = tomllib.loads(tb.guess_map(tmp_path / "a.ulg"))["channels"]
    assert channels["wheel_speed"]["fields"] == [f"speed[{wheel}]" for wheel in range(4)]
    assert channels["wheel_torque"]["fields"] == [f"torque[{wheel}]" for wheel in range(4)]
    assert "applied_torque" not in channels


def test_a_flag_is_proposed_for_cutting(tmp_path):
    text = tb.guess_map(logs.write_ulog(tmp_path / "a.ulg"))
    assert '# kind = "flag"\n# topic = "thrusters"\n# field = "armed"\n' in text


def test_a_log_without_a_gyro_is_refused_with_what_it_holds(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,temperature\n1,2\n2,3\n")
    with pytest.raises(
        tb.InputError, match=r"is called a gyro or a body rate; write a map .*; the log holds\n  t, temperature"
    ):
        tb.guess_map(path)


def test_what_names_do_not_say_is_taken_from_units_and_marked(tmp_path):
    path = tmp_path / "log.csv"
    rows = [f"{0.1 * tick:.1f},1,2,3,500,600,700" for tick in range(9)]
    units = "s,deg/s,deg/s,deg/s,rpm,rpm,rpm"
    path.write_text("\n".join(["time,Spin X,Spin Y,Spin Z,Rad 1,Rad 2,Rad 3", units, *rows]) + "\n", encoding="utf-8")
    text = tb.guess_map(path)
    assert text.count("# CHECK: no name says so") == 2
    channels = tomllib.loads(text)["channels"]
    assert channels["body_rate"] == {"fields": ["Spin X", "Spin Y", "Spin Z"], "unit": "deg/s"}
    assert channels["wheel_speed"] == {"fields": ["Rad 1", "Rad 2", "Rad 3"], "unit": "rpm"}


@pytest.mark.parametrize(
    ("columns", "clock"),
    [
        (["時刻(us)", *(f"角速度{axis}(deg/s)" for axis in "XYZ"), *(f"ホイール{n}回転数(rpm)" for n in (1, 2, 3))], 0),
        (["jour", *(f"vitesse {axis} (deg/s)" for axis in "xyz"), *(f"roue {n} (tr/min)" for n in (1, 2, 3))], 0),
        ([*(f"Kreisel {axis} [deg/s]" for axis in "xyz"), *(f"Rad {n} [1/min]" for n in (1, 2, 3)), "Uhr [ms]"], 6),
    ],
)
def test_logs_in_other_languages_are_read_by_their_units(tmp_path, columns, clock):
    path, torques = tmp_path / "log.csv", [f"couple {n} (mN.m)" for n in (1, 2, 3)]
    header, rows = [*columns, *torques], [["5"] * (len(columns) + 3) for _ in range(9)]
    if columns[clock] == "jour":  # a clock that shows dates states its unit
        for tick, row in enumerate(rows):
            row[clock] = f"2026-05-03T10:22:{tick:02d}Z"
    path.write_text("\n".join(map(",".join, [header, *rows])) + "\n", encoding="utf-8")
    text = tb.guess_map(path)
    found = tomllib.loads(text)
    assert found["clock"]["field"] == columns[clock]
    turning = [name for name in columns if name != columns[clock]]
    assert found["channels"]["body_rate"] == {"fields": turning[:3], "unit": "deg/s"}
    assert found["channels"]["wheel_speed"] == {"fields": turning[3:], "unit": "rpm"}
    assert found["channels"]["wheel_torque_command"] == {"fields": torques, "unit": "mN*m"}
    assert text.count("# CHECK: no name says so") == 4
    assert "Columns without a channel" not in text


def test_a_file_without_numbers_is_said_to_hold_none(tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text('name = "orbit"\n[platform]\n', encoding="utf-8")
    with pytest.raises(tb.InputError, match=r"the log holds\n  no column of numbers"):
        tb.guess_map(path)


@pytest.mark.parametrize("text", ["time,gx,gy,gz\n", "time,g", "time,gx,gy,gz\n\n\n"])
def test_names_of_columns_without_rows_are_said_to_be_all(tmp_path, text):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(tb.InputError, match=r"holds names of columns, time, g.* and no row of numbers behind them"):
        tb.guess_map(path)


STAMPS = ["2026-11-25T10:00:00.0Z", "2026-11-25T10:00:00.1Z"]


@pytest.mark.parametrize(
    ("columns", "clock", "channels"),
    [
        (
            ["t_ms", "gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s", "thrust_1_N", "thrust_2_N"],
            ["0", "5"],
            {"body_rate": "rad/s", "motor_thrust": "N"},
        ),
        (
            ["t_ms", "gx_deg_s", "gy_deg_s", "gz_deg_s", "wheel_1_rpm", "motor_torque_cmd_1_Nm"],
            ["0", "5"],
            {"body_rate": "deg/s", "wheel_speed": "rpm", "wheel_torque_command": "N*m"},
        ),
        (
            [
                "Time [UTC]",
                "AngularRate_X [deg/s]",
                "AngularRate_Y [deg/s]",
                "AngularRate_Z [deg/s]",
                "wheel1_rpm",
                "wheel2_rpm",
                "wheel3_rpm",
            ],
            STAMPS,
            {"body_rate": "deg/s", "wheel_speed": "rpm"},
        ),
        (
            ["UTC", "wx [rad/s]", "wy [rad/s]", "wz [rad/s]", "RW1 [U/min]", "RW2 [U/min]", "RW3 [U/min]"],
            ["2026-11-25 10:00:00.0+01:00", "2026-11-25 10:00:00.1+01:00"],
            {"body_rate": "rad/s", "wheel_speed": "rpm"},
        ),
        (
            ["unix_time", "body_rate_x", "body_rate_y", "body_rate_z", "rw_speed_0", "rw_speed_1", "rw_speed_2"],
            ["1700000000.0", "1700000000.1"],
            {"body_rate": "rad/s", "wheel_speed": "rad/s"},
        ),
        (
            [
                "time",
                "gyro_x",
                "gyro_y",
                "gyro_z",
                "cmg1_gimbal_deg",
                "cmg2_gimbal_deg",
                "cmg1_rotor_rpm",
                "cmg2_rotor_rpm",
            ],
            ["0.0", "0.1"],
            {"body_rate": "rad/s", "gimbal_angle": "deg", "rotor_speed": "rpm"},
        ),
        (
            [
                "time",
                "gyro_x",
                "gyro_y",
                "gyro_z",
                "gimbal_1(rad)",
                "gimbal_2(rad)",
                "wheel_speed_1(rpm)",
                "wheel_speed_2(rpm)",
            ],
            ["0.0", "0.1"],
            {"body_rate": "rad/s", "gimbal_angle": "rad", "wheel_speed": "rpm"},
        ),
        (
            ["time_s", "gyro_x", "gyro_y", "gyro_z", "rw_speed_x", "rw_speed_y", "rw_speed_z"],
            ["0.0", "0.1"],
            {"body_rate": "rad/s", "wheel_speed": "rad/s"},
        ),
        (
            ["MET_ms", "gx", "gy", "gz", "rw_a_rpm", "rw_b_rpm", "rw_c_rpm"],
            ["0.0", "100.0"],
            {"body_rate": "rad/s", "wheel_speed": "rpm"},
        ),
        (
            ["time", "gx", "gy", "gz", "rw_a_rpm", "rw_b_rpm", "rw_c_rpm", "rw_d_rpm"],
            ["0.0", "0.1"],
            {"body_rate": "rad/s", "wheel_speed": "rpm"},
        ),
    ],
)
def test_names_of_clocks_wheels_and_gimbals_as_vehicles_write_them(tmp_path, columns, clock, channels):
    """Each channel once: a speed of wheels is no torque of them."""
    path = tmp_path / "log.csv"
    numbers = ",".join("5" for _ in columns[1:])
    path.write_text("\n".join([",".join(columns), *(f"{stamp},{numbers}" for stamp in clock)]) + "\n", encoding="utf-8")
    tree = guessed(path)
    assert tree["clock"]["field"] == columns[0]
    assert {name: channel["unit"] for name, channel in tree["channels"].items()} == channels
    named = [field for channel in tree["channels"].values() for field in channel["fields"]]
    assert sorted(named) == sorted(columns[1:])


def test_text_times_with_an_offset_are_read(tmp_path):
    path = tmp_path / "log.csv"
    rows = [f"2026-11-25T10:00:{tick // 10:02d}.{tick % 10}Z,{0.01 * tick},0.1,0.2,0,0,0" for tick in range(40)]
    path.write_text(
        "\n".join(["UTC,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,torque_x_Nm,torque_y_Nm,torque_z_Nm", *rows]) + "\n",
        encoding="utf-8",
    )
    (run,) = tb.import_log(path, guessed(path)).runs
    np.testing.assert_allclose(run.time - run.time[0], 0.1 * np.arange(40), atol=1e-6)


def test_times_of_day_go_on_past_midnight(tmp_path):
    path = tmp_path / "log.csv"
    clock = [
        f"{(23 + (59 * 60 + 58 + tick // 10) // 3600) % 24}:{(59 + (58 + tick // 10) // 60) % 60:02d}"
        for tick in range(40)
    ]
    rows = [
        f"{time}:{(58 + tick // 10) % 60:02d},{tick % 10};{0.01 * tick};0,1;0,2;0;0;0"
        for tick, time in enumerate(clock)
    ]
    header = "Zeit;gyro_x_rad_s;gyro_y_rad_s;gyro_z_rad_s;torque_x_Nm;torque_y_Nm;torque_z_Nm"
    path.write_text("\n".join([header, *(row.replace(".", ",") for row in rows)]) + "\n", encoding="utf-8")
    (run,) = tb.import_log(path, guessed(path)).runs
    assert rows[0].startswith("23:59:58,0")
    assert rows[20].startswith("0:00:00,0")
    np.testing.assert_allclose(run.time - run.time[0], 0.1 * np.arange(40), atol=1e-6)


def test_what_nobody_has_confirmed_of_a_proposed_map_is_said(tmp_path):
    path, proposed = tmp_path / "log.csv", tmp_path / "map.toml"
    rows = [f"{0.1 * tick:.1f},{0.01 * tick},0.1,0.2,0,0,0" for tick in range(40)]
    path.write_text("\n".join(["time_s,gx,gy,gz,torque_x_Nm,torque_y_Nm,torque_z_Nm", *rows]) + "\n", encoding="utf-8")
    proposed.write_text(tb.guess_map(path), encoding="utf-8")
    records = tb.import_log(path, proposed)
    (open_line,) = records.unchecked
    assert 'unit = "rad/s"  # CHECK' in open_line
    assert f"unchecked: {open_line}" in str(records)
    proposed.write_text(tb.guess_map(path).replace("# CHECK", "# seen"), encoding="utf-8")
    assert tb.import_log(path, proposed).unchecked == ()


@pytest.mark.parametrize(
    ("columns", "channel", "doubt"),
    [
        ([f"rpm[{unit}]" for unit in range(4)], "wheel_speed", "# CHECK: no name says so"),
        (["rpm1", "rpm2", "rpm3"], "wheel_speed", "# CHECK: no name says so"),
        ([f"rpm{unit}" for unit in range(1, 13)], "wheel_speed", "# CHECK: no name says so"),
        (["wheel1", "wheel2", "wheel3"], "wheel_speed", "# CHECK: the log does not state it"),
        (["rw1_torque", "rw2_torque", "rw3_torque"], "wheel_torque", "# CHECK: the log does not state it"),
        (["rw_1_tq", "rw_2_tq", "rw_3_tq"], "wheel_torque", "# CHECK: the log does not state it"),
        (["rw_tq_cmd_1", "rw_tq_cmd_2", "rw_tq_cmd_3"], "wheel_torque_command", "# CHECK: the log does not"),
        (["rw_current_1", "rw_current_2", "rw_current_3"], None, "# Columns without a channel: "),
    ],
)
def test_columns_of_wheels_are_one_channel_each(tmp_path, columns, channel, doubt):
    """Torques of wheels were offered as speeds or torques on the body too; bare speeds in rpm as nothing."""
    path = tmp_path / "a.csv"
    header = ["t", "gx", "gy", "gz", *columns]
    path.write_text("\n".join([",".join(header), *(",".join([str(n)] * len(header)) for n in range(20))]))
    text = tb.guess_map(path)
    channels = tomllib.loads(text)["channels"]
    assert set(channels) == {"body_rate"} | ({channel} if channel else set())
    if channel:
        assert channels[channel]["fields"] == columns
    assert doubt in text


def test_topics_without_a_channel_are_listed_where_one_is_missing(tmp_path):
    path = logs.write_json_mcap(tmp_path / "json.mcap", torque_topic="/command_93")
    text = tb.guess_map(path)
    assert "no channel here says what turned the platform" in text
    assert '# Topics without a channel:\n#   "/command_93": ' in text


def test_a_gyro_axis_that_holds_text_is_pointed_at(tmp_path):
    path = tmp_path / "text.csv"
    rows = "\n".join(f"{n},bad,2,3" for n in range(20))
    path.write_text(f"t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps\n{rows}\n", encoding="utf-8")
    text = tb.guess_map(path)
    assert 'axes = ["y", "z"]  # CHECK: gyro_x_dps holds no number' in text
    assert '# Columns without a number: "gyro_x_dps"' in text


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"t": 1, "gyro_x": 2}\n', "is JSON, which is not read; write a table of it, such as CSV"),
        (b"[\n{}]", "is JSON, which is not read"),
        (
            "t\tgyro_x\n".encode("utf-16"),
            "is UTF-16 text, as of a spreadsheet's Unicode export; save it as CSV in UTF-8",
        ),
    ],
)
def test_logs_in_other_formats_are_named(tmp_path, content, words):
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    with pytest.raises(tb.InputError, match=words):
        tb.guess_map(path)


def test_a_topic_whose_first_messages_have_no_values_is_proposed_all_the_same(tmp_path):
    late, usual = (guessed(logs.write_json_mcap(tmp_path / f"{count}.mcap", late_values=count)) for count in (5, 0))
    assert late["channels"] == usual["channels"]
