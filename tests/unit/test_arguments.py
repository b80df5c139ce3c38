"""Arguments of the public functions: what does not fit is refused with words, before anything is flown or written."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import testbed as tb
from support.processes import ROOT

MODEL = ROOT / "models" / "smallsat.xml"
LARGEST = 2**63 - 1


@pytest.fixture(scope="module")
def scenario():
    return tb.read_scenario("basic")


@pytest.fixture(scope="module")
def run(scenario):
    return tb.fly(scenario, seed=1)


@pytest.fixture(scope="module")
def records(run):
    return tb.Records((run.record,))


@pytest.fixture(scope="module")
def table(run):
    return tb.frame_of(run.record)


def changed(table, **columns):
    return {**{name: table[name].to_numpy() for name in table}, **columns}


@pytest.mark.parametrize("seed", [-1, 1.5, "a", True, [1, 2], 2**63, 2**80, np.bool_(True), np.float64(1.0)])
def test_no_seed_but_one_of_the_command_lines_is_taken(scenario, records, seed, tmp_path):
    estimate = tb.estimate(scenario, records)
    for use in (
        lambda: tb.fly(scenario, seed=seed),
        lambda: tb.design(scenario, seed=seed),
        lambda: tb.plan(scenario, seed=seed, folder=tmp_path / "plan"),
        lambda: tb.monte_carlo(scenario, runs=2, seed=seed, workers=1, folder=tmp_path / "campaign"),
        lambda: estimate.to_arviz(seed=seed),
    ):
        with pytest.raises(tb.InputError, match=r"^seed = .*: give a whole number from 0 to 2\*\*63 - 1$"):
            use()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seed", [0, LARGEST, np.int64(7), np.uint8(7)])
def test_seeds_of_the_command_line_and_of_numpy_are_taken(scenario, seed):
    maneuver = tb.design(scenario)
    flown = tb.fly(scenario, maneuver, seed=seed)
    assert flown.experiment.seed == int(seed)
    assert type(flown.experiment.seed) is int


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"workers": 0}, r"^workers = 0: give a whole number from 1 to 1,024$"),
        ({"workers": -1}, "^workers = -1: "),
        ({"workers": "a"}, "^workers = 'a': "),
        ({"runs": "4"}, "^runs = '4': give a whole number from 2, as one run has no scatter, to 1,000,000$"),
        ({"runs": 2.5}, r"^runs = 2\.5: "),
        ({"runs": 1}, "^runs = 1: "),
        ({"check": "a"}, "^check = 'a': give a whole number from 1 to 1,000,000, or 0 for none$"),
        ({"check": 1.5}, r"^check = 1\.5: "),
        ({"check": -1}, "^check = -1: "),
        ({"resume": "yes"}, "^resume = 'yes': give True or False$"),
        ({"maneuver": "x"}, "^maneuver = 'x': give a maneuver: "),
    ],
)
def test_a_campaign_is_refused_before_it_writes_anything(scenario, given, message, tmp_path):
    with pytest.raises(tb.InputError, match=message):
        tb.monte_carlo(scenario, **{"runs": 2, "folder": tmp_path / "campaign", **given})
    assert not list(tmp_path.iterdir())


def test_a_text_is_no_scenario(records):
    for use in (
        lambda: tb.fly("basic"),
        lambda: tb.design("basic"),
        lambda: tb.plan("basic"),
        lambda: tb.monte_carlo("basic", runs=2),
        lambda: tb.estimate("basic", records),
        lambda: tb.diagnose("basic", records),
    ):
        with pytest.raises(tb.InputError, match=r"^scenario = 'basic': give a scenario, .* tb\.read_scenario"):
            use()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"maneuvers": "zzz"}, "^maneuvers = 'zzz': give 'chosen' or 'own'$"),
        ({"flights": 1.5}, r"^flights = 1\.5: give a whole number$"),
        ({"flights": 0}, "^flights = 0: give 1 or more$"),
        ({"alpha": "x"}, "^alpha = 'x': give a number$"),
        ({"effect": 3}, "^effect = 3: give 'any', an effect's id"),
        ({"records": "x"}, r"^records = 'x': give records: tb\.read_records"),
        ({"inertia_std": "x"}, "^inertia_std = 'x': give a standard deviation"),
        ({"inertia_std": {"J11": "x"}}, "^inertia_std = {'J11': 'x'}: give a standard deviation"),
        ({"effect": "gimbal_zero:cmg9"}, "basic has no cmg9; it has cmg1, cmg2, cmg3, cmg4, cmg5, cmg6$"),
        ({"effect": "wheel_inertia"}, "basic has no part that wheel_inertia could sit in$"),
    ],
)
def test_a_plan_is_refused_before_its_first_flight(scenario, given, message, tmp_path):
    with pytest.raises(tb.InputError, match=message):
        tb.plan(scenario, **{"folder": tmp_path / "plan", **given})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda: tb.read_scenario(None), "^source = None: give a path"),
        (lambda: tb.read_scenario("basic", ["seed"]), r"^overrides = \['seed'\]: give values by dotted key"),
        (lambda: tb.read_scenario("basic", {1: 2}), r"^overrides = \{1: 2\}: give values by dotted key"),
        (lambda: tb.read_records(None), "^folder = None: give a path"),
        (lambda: tb.import_log("b.csv", None), r"^map = None: give the path of MAP\.toml, or its keys"),
        (lambda: tb.guess_map(3), "^log = 3: give a path"),
        (lambda: tb.compare(None), "^folders = None: give folders"),
        (lambda: tb.compare(["a", 3]), r"^folders = \['a', 3\]: give folders"),
        (lambda: tb.compare("/tmp/x"), "^a comparison takes two folders or more$"),
        (lambda: tb.adopt(3), "^model = 3: give a path"),
        (lambda: tb.adopt(MODEL, ignore=[3]), r"^ignore = \[3\]: give texts"),
        (lambda: tb.export(None, mjcf="a.xml"), "^folder = None: give a path"),
        (lambda: tb.frame_of(3), "^record = 3: give a run"),
        (lambda: tb.Records((1, 2)), r"^runs = \(1, 2\): give runs of one platform"),
    ],
)
def test_another_type_is_refused_with_what_to_give(use, message):
    with pytest.raises(tb.InputError, match=message):
        use()


def test_a_method_refuses_as_a_function_does(scenario, run, records):
    with pytest.raises(tb.InputError, match=r"^draws = -1: give a whole number, 1 or more$"):
        tb.estimate(scenario, records).to_arviz(draws=-1)
    with pytest.raises(tb.InputError, match=r"^folder = None: give a path"):
        run.save(None)
    with pytest.raises(tb.InputError, match=r"^format = 'csv': give 'parquet' or 'mcap'$"):
        records.save("nowhere", format="csv")
    with pytest.raises(tb.InputError, match=r"^keep = 'folder': give a store with the methods get and put"):
        tb.diagnose(scenario, records, keep="folder")
    with pytest.raises(tb.InputError, match=r"^progress = 3: should be callable$"):
        tb.fly(scenario, progress=3)


def test_a_large_value_is_named_by_its_type(scenario, table):
    with pytest.raises(tb.InputError, match=r"^records = <DataFrame>: give records"):
        tb.diagnose(scenario, table)
    with pytest.raises(tb.InputError, match=r"^seed = an integer of thousands of digits: give"):
        tb.fly(scenario, seed=10**5000)
    with pytest.raises(tb.InputError, match=r"^seed = 'a{59}\.\.\.: give"):
        tb.fly(scenario, seed="a" * 1000)


def test_a_single_text_is_one_item():
    one, listed = (tb.adopt(MODEL, ignore=ignore) for ignore in ("panel_drive", ["panel_drive"]))
    assert one.text == listed.text
    assert ("panel_drive", "locked", "as ignore says") in one.parts


def test_a_list_of_runs_is_taken_and_kept_from_change(run):
    runs = [run.record]
    records = tb.Records(runs)
    runs.clear()
    assert records.runs == (run.record,)


def test_every_public_function_is_checked():
    functions = [getattr(tb, name) for name in tb.__all__ if inspect.isfunction(getattr(tb, name))]
    unchecked = {each.__name__ for each in functions if not hasattr(each, "__wrapped__")}
    assert unchecked == {"register_effect", "shipped_scenarios"}  # which look at their argument, or have none


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"source": "nonsense"}, "^source = 'nonsense': should be 'measured' or 'simulated'$"),
        ({"gyro_noise_rad_s": -1}, r"gyro_noise_rad_s = -1\.0: input should be greater than or equal to 0"),
        ({"gyro_noise_rad_s": np.nan}, "gyro_noise_rad_s = nan: input should be"),
        ({"gyro_noise_rad_s": np.inf}, "gyro_noise_rad_s = inf: input should be"),
        ({"gyro_noise_rad_s": 1e-15}, "gyro_noise_rad_s = 1e-15: .* less than anything has"),
        ({"gyro_noise_rad_s": "a"}, "^gyro_noise_rad_s = 'a': give a number$"),
    ],
)
def test_what_is_said_of_records_is_checked_as_their_toml_is(table, given, message):
    with pytest.raises(tb.InputError, match=message):
        tb.records_from({"flight 1": table}, **given)


@pytest.mark.parametrize("form", [float, np.float32, np.float64, int])
def test_a_noise_is_any_real_number(table, form):
    assert tb.records_from(table, gyro_noise_rad_s=form(1)).runs[0].details.gyro_noise == 1.0


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"time_s": 1.0}, r"^flight 1: column time_s has the shape \(\): give a list of one value for each row$"),
        ({"time_s": np.zeros((5, 2))}, r"^flight 1: column time_s has the shape \(5, 2\)"),
        ({"body_rate_x_rad_s": np.zeros(401) * 1j}, "^flight 1: column body_rate_x_rad_s holds complex numbers"),
        ({"body_rate_x_rad_s": np.zeros(401, dtype=bool)}, "^flight 1: column body_rate_x_rad_s holds true and false"),
        ({"body_rate_x_rad_s": ["a"] * 401}, "^flight 1: column body_rate_x_rad_s holds what is no number"),
        ({"remark": 3.0}, r"^flight 1: column remark has the shape \(\)"),
        ({"remark": [[1], [1, 2]]}, "^flight 1: column remark holds"),
    ],
)
def test_a_column_that_is_no_list_of_numbers_is_named(table, columns, message):
    with pytest.raises(tb.InputError, match=message):
        tb.records_from({"flight 1": changed(table, **columns)})


def test_columns_need_names_of_their_own(table):
    twice = pd.concat([table, table[["gimbal_angle_1_rad"]]], axis=1)
    with pytest.raises(tb.InputError, match=r"^flight 1: column gimbal_angle_1_rad appears 2 times"):
        tb.records_from({"flight 1": twice})
    with pytest.raises(tb.InputError, match=r"^flight 1: column 3: a column's name is a text"):
        tb.records_from({"flight 1": {**changed(table), 3: np.zeros(401)}})


def test_records_without_a_run_are_refused_wherever_one_is_needed(scenario, records, tmp_path):
    none = tb.Records(())
    for name, use in (
        ("records", lambda: tb.estimate(scenario, none)),
        ("records", lambda: tb.diagnose(scenario, none)),
        ("reference", lambda: tb.diagnose(scenario, records, reference=none)),
        ("records", lambda: none.save(tmp_path / "data")),
        ("records", none.to_pandas),
    ):
        with pytest.raises(tb.InputError, match=rf"^{name}: there are no records in it"):
            use()
    assert not list(tmp_path.iterdir())


def test_a_plan_before_its_first_flight_is_an_empty_table(scenario):
    found = tb.plan(scenario, effect="any")
    frame = found.to_pandas()
    assert found.result.flights == []
    assert len(frame) == 0
    assert frame.index.name == "number"
    assert {"record", "log_e_value", "leading", "verdict"} <= set(frame.columns)


def test_imported_records_are_saved_in_no_other_format(tmp_path):
    log = tmp_path / "bench.csv"
    rows = [f"{5 * row},{row % 7},0,1,0,0,0.1" for row in range(200)]
    log.write_text("\n".join(["t,gx,gy,gz,mx,my,mz", *rows]), encoding="utf-8")
    channels = {
        "body_rate": {"fields": ["gx", "gy", "gz"], "unit": "rad/s"},
        "applied_torque": {"fields": ["mx", "my", "mz"], "unit": "N*m"},
    }
    records = tb.import_log(log, {"schema": 1, "clock": {"field": "t", "unit": "ms"}, "channels": channels})
    with pytest.raises(tb.InputError, match=r"^format = 'csv': give 'parquet' or 'mcap'$"):
        records.save(tmp_path / "data", format="csv")
    assert not (tmp_path / "data").exists()
    assert records.save(tmp_path / "data") == Path(tmp_path / "data")


def test_a_refusal_in_python_names_no_option_of_the_command_line(run, tmp_path):
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    for place in (tmp_path, tmp_path / "mine"):
        with pytest.raises(tb.InputError, match="give a new or empty folder") as refused:
            run.save(place)
        assert "--" not in str(refused.value)


def test_a_campaign_goes_on_in_a_folder_only():
    with pytest.raises(tb.InputError, match="give the folder of the campaign"):
        tb.monte_carlo(tb.read_scenario("basic"), runs=2, resume=True)
