"""Flying until sure: wishes, when a name may be given, the loop in MuJoCo, going on with a user's records."""

from __future__ import annotations

import json
import shutil
from math import log

import numpy as np
import pytest

import testbed as tb
import testbed.library.plan_flights
import testbed.library.prepared_records
from support.diagnosed_records import nominal
from support.processes import ROOT
from testbed.cli.app import app
from testbed.cli.failures import BAD_INPUT, DIVERGED, exit_code_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.splines import clamped_spline
from testbed.report.plan import next_words
from testbed.sequential.choosing import flights_to_choose_among
from testbed.sequential.expected_gain import left_of
from testbed.sequential.robust import Case, robust_space
from testbed.sequential.wanted import EffectWanted, Named, effect_wanted, inertia_wanted, verified
from tests.unit.test_formats import require_valid

FEW = ("gimbal_zero", "gyro_bias", "gyro_scale")
QUICK = {"gyro.noise_rad_s": 0.0017, "encoder.noise_rad": 1e-4, "tachometer.noise_rad_s": 0.05} | {
    "torque_sensor.noise_N_m": 1e-4,
    "estimation.estimators": ["ls", "output_error"],
}
OFF = {"encoder.zero_rad": [0.0, 0.0, 0.04, 0.0, 0.0, 0.0], "truth.mass_kg": 4.0}
"""What flies: the encoder of one unit is off by 40 mrad."""


@pytest.fixture
def few(monkeypatch):
    """A library of three effects, of which a diagnosis takes two seconds."""
    known = {name: EFFECTS[name] for name in FEW}
    monkeypatch.setattr(testbed.library.plan_flights, "EFFECTS", known)
    monkeypatch.setattr(testbed.library.prepared_records, "EFFECTS", known)


def flown(overrides=OFF):
    return tb.read_scenario("basic", QUICK | overrides)


def believed():
    """The scenario of somebody who does not know what flies."""
    return tb.read_scenario("basic", QUICK)


@pytest.fixture(scope="module")
def records():
    """Two flights of what flies, as a user has them."""
    scenario = flown()
    return [tb.fly(scenario, seed=seed).record for seed in (11, 12)]


@pytest.mark.parametrize(
    ("text", "effect", "component"),
    [("any", None, None), ("gimbal_zero", "gimbal_zero", None), ("gimbal_zero:cmg3", "gimbal_zero", "cmg3")],
)
def test_a_wish_for_a_name(text, effect, component):
    wish = effect_wanted(text)
    assert (wish.effect, wish.component, wish.text) == (effect, component, text)
    assert wish.allows("gimbal_zero:cmg3")
    assert wish.allows("gyro_bias:gyro") == (effect is None)


def test_a_wish_for_an_inertia():
    assert inertia_wanted("1e-5").std == dict.fromkeys(("J11", "J22", "J33", "J23", "J13", "J12"), 1e-5)
    wish = inertia_wanted("J11=1e-5, J33=2e-5")
    assert wish.std == {"J11": 1e-5, "J33": 2e-5}
    assert wish.reached(np.full(6, 1.5e-5)).tolist() == [False, True, True, True, True, True]


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        (effect_wanted, ("no_such", "there is no effect 'no_such'; there are ")),
        (effect_wanted, ("gimbal_zer", "there is no effect 'gimbal_zer'; did you mean gimbal_zero")),
        (effect_wanted, ("gimbal_zero:wheel1", "has no component 'wheel1'")),
        (effect_wanted, ("contact:run", "acts in one flight only")),
        (effect_wanted, ("gyro_noise", "changes the noise")),
        (effect_wanted, ("inertia", "--inertia-std")),
        (effect_wanted, ("gimbal_coulomb_friction", "shows in gimbal_torque")),
        (effect_wanted, ("wheel_lag", "shows in wheel_torque_command")),
        (inertia_wanted, ("J14=1", "'J14' is no inertia parameter")),
        (inertia_wanted, ("J11=1e-5,J11=2e-5", "J11 is given twice")),
        (inertia_wanted, ("J11=-1", "above zero")),
        (inertia_wanted, ("small", "above zero")),
    ],
)
def test_a_wish_that_cannot_be_met_is_refused(wish, said):
    text, message = said
    with pytest.raises(InputError, match=message):
        wish(text)


def test_a_name_takes_the_verdict_and_the_e_value():
    alpha, among = 0.05, 10
    enough = {"a:x": log(among / alpha) + 0.01, "b:x": 0.0}
    named = Named(verdict="named", classes=[["a:x"]], undecided=[False])
    assert verified(EffectWanted(), named, enough, among, alpha) == ["a:x"]
    assert not verified(EffectWanted(), named, enough | {"a:x": log(among / alpha) - 0.01}, among, alpha)
    assert not verified(EffectWanted(effect="b"), named, enough, among, alpha)
    assert not verified(
        EffectWanted(), Named(verdict="unexplained", classes=[["a:x"]], undecided=[False]), enough, among, alpha
    )


def test_a_class_is_named_only_where_no_flight_distinguishes_its_members():
    values, both = {"a:x": log(200.0), "b:x": log(190.0)}, [["a:x", "b:x"]]
    apart = Named(verdict="ambiguous", classes=both, undecided=[True])
    together = Named(verdict="ambiguous", classes=both, undecided=[False])
    assert not verified(EffectWanted(), apart, values, 10, 0.05)
    assert verified(EffectWanted(), together, values, 10, 0.05) == ["a:x", "b:x"]
    assert not verified(EffectWanted(effect="a"), together, {"a:x": log(199.0), "b:x": log(900.0)}, 10, 0.05)


def test_the_information_with_others_unknown_is_the_inverse_of_the_marginal_covariance():
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(3, 30, 5))
    information = np.swapaxes(columns, 1, 2) @ columns
    expected = np.linalg.inv(np.linalg.inv(information[:, :4, :4])[:, 2:4, 2:4])
    assert left_of(information, [2, 3], [0, 1]) == pytest.approx(expected, rel=1e-9)


def test_flights_to_choose_among_keep_the_limits_with_another_inertia_and_a_failed_unit():
    scenario, platform = nominal()
    space = robust_space(scenario)
    assert {case.text for case in space.cases} >= {"inertia times 0.8", "inertia times 1.2", "unit 6 failed"}
    path = np.pad(np.random.default_rng(1).uniform(-0.5, 0.5, (8, 6)), ((2, 0), (0, 0))).cumsum(axis=0)
    own = Maneuver(
        name="own",
        duration=5.0,
        body_rate=clamped_spline(5.0, np.zeros((10, 3))),
        gimbal_angle=clamped_spline(5.0, np.concatenate([path, path[-1:]])),
    )
    flights = flights_to_choose_among(space, own)
    chosen = [flights[0], flights[-1]]
    for case in space.cases:
        for flight in chosen:
            release, points = case.released(flight.release), case.points(flight.control_points)[None]
            assert space.of(case).shares(release, points).max() <= 1.0 + 1e-9
    assert Case(failed=2).platform(platform).cluster.rotor_momentum[2] == 0.0


@pytest.mark.usefixtures("few")
def test_a_plan_flies_until_the_effect_is_named(tmp_path):
    plan = tb.plan(flown(), effect="gimbal_zero", flights=4, folder=tmp_path / "plan")
    assert plan.outcome == "named"
    assert plan.names == ("gimbal_zero:cmg3",)
    content = require_valid(tmp_path / "plan", "plan")
    assert content["simulated"] is True
    assert 2 <= len(content["flights"]) <= 4
    assert content["flights"][0]["scenario"] == "scenario.toml"
    assert content["flights"][1]["scenario"] == "flights/02/scenario.toml"
    assert "truth" not in (tmp_path / "plan" / "flights" / "02" / "scenario.toml").read_text(encoding="utf-8")
    assert not any("true_" in name for name in tb.read_records(tmp_path / "plan" / "records")["flight_01"].channels)
    assert "gimbal_zero:cmg3" in (tmp_path / "plan" / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("few")
def test_an_interrupted_plan_goes_on_to_the_same_end(tmp_path):
    whole = tb.plan(flown(), effect="gimbal_zero", flights=3, folder=tmp_path / "whole", maneuvers="own")

    def interrupt(state):
        if state.flights:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tb.plan(flown(), effect="gimbal_zero", flights=3, folder=tmp_path / "part", maneuvers="own", after=interrupt)
    assert len(json.loads((tmp_path / "part" / "plan.json").read_text(encoding="utf-8"))["flights"]) == 1
    rest = tb.plan(flown(), effect="gimbal_zero", flights=3, folder=tmp_path / "part", maneuvers="own", resume=True)
    assert rest.result == whole.result


@pytest.mark.usefixtures("few")
def test_a_plan_that_has_all_its_flights_flies_another_only_where_more_are_allowed(tmp_path):
    healthy = flown({"truth.mass_kg": 4.0})
    how = {"effect": "gimbal_zero", "folder": tmp_path / "plan", "maneuvers": "own"}
    first = tb.plan(healthy, flights=2, **how)
    assert (first.outcome, len(first.result.flights)) == ("used_up", 2)
    assert tb.plan(healthy, flights=2, resume=True, **how).result == first.result
    assert len(tb.plan(healthy, flights=3, resume=True, **how).result.flights) == 3


@pytest.mark.usefixtures("few")
def test_without_a_truth_the_user_flies_and_the_plan_goes_on_with_the_records(records, tmp_path):
    folder = tmp_path / "plan"
    first = tb.plan(believed(), effect="gimbal_zero", folder=folder)
    assert first.outcome is None
    assert first.next_scenario == folder / "scenario.toml"
    mine = tb.Records(tuple(records))
    second = tb.plan(believed(), tb.Records(mine.runs[:1]), effect="gimbal_zero", folder=folder, resume=True)
    assert [flight.record for flight in second.result.flights] == ["basic"]
    proposed = tb.read_scenario(second.next_scenario)
    assert proposed.maneuver.kind == "control_points"
    surer = second.result.next.model_copy(update={"gain": 13000.0})  # e^13000 is beyond all numbers
    assert "by a factor of 1e5646" in next_words(second.result.model_copy(update={"next": surer}))
    waiting = tb.plan(believed(), effect="gimbal_zero", folder=folder, resume=True)
    assert waiting.result == second.result
    fewer = tb.plan(believed(), effect="gimbal_zero", folder=folder, resume=True, flights=1)
    assert (fewer.outcome, fewer.next_scenario) == ("used_up", None)
    third = tb.plan(
        believed(), tb.records_from({"mine": _table(mine.runs[1])}), effect="gimbal_zero", folder=folder, resume=True
    )
    assert [flight.record for flight in third.result.flights] == ["basic", "mine"]
    assert third.result.flights[-1].log_e_value > log(1.0 / 0.05)
    assert third.result.flights[-1].verdict is not None
    require_valid(folder, "plan")


def _table(record):
    frame = tb.frame_of(record)
    return {name: frame[name].to_numpy() for name in frame if not name.startswith("true_")}


@pytest.mark.usefixtures("few")
def test_an_inertia_is_known_well_enough_after_enough_flights():
    plan = tb.plan(flown({"truth.mass_kg": 4.0}), inertia_std={"J33": 6e-5}, maneuvers="own", flights=6)
    reached = [flight.std_kg_m2[2] <= 6e-5 for flight in plan.result.flights]
    assert plan.outcome == "inertia"
    assert reached == [False] * (len(reached) - 1) + [True]
    assert plan.records.runs[0].details.name == "flight_01"
    assert plan.to_pandas().shape[0] == len(reached)


@pytest.mark.usefixtures("few")
def test_going_on_as_another_plan_is_refused(records, tmp_path):
    mine = tb.Records((records[0],))
    tb.plan(believed(), mine, effect="gimbal_zero", folder=tmp_path / "plan", maneuvers="own")
    again = {"folder": tmp_path / "plan", "resume": True, "maneuvers": "own"}
    with pytest.raises(InputError, match="another wanted"):
        tb.plan(believed(), effect="gyro_bias", **again)
    with pytest.raises(InputError, match="another alpha"):
        tb.plan(believed(), effect="gimbal_zero", alpha=0.01, **again)
    with pytest.raises(InputError, match="another scenario"):
        tb.plan(flown(), effect="gimbal_zero", **again)
    other = tb.read_records(tb.Records((records[1],)).save(tmp_path / "other"))
    with pytest.raises(InputError, match="another flight of this name"):
        tb.plan(believed(), other, effect="gimbal_zero", **again)
    folder = tb.Records((records[1],)).save(tmp_path / "copies")
    shutil.copy(next(folder.glob("*.parquet")), folder / "second.parquet")
    with pytest.raises(InputError, match=r"second: holds the samples of .*: a copy is no further flight"):
        tb.plan(believed(), tb.read_records(folder), effect="gimbal_zero", maneuvers="own", folder=tmp_path / "new")
    (tmp_path / "plan" / "plan.json").write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="not as testbed wrote it"):
        tb.plan(believed(), effect="gimbal_zero", **again)
    shutil.rmtree(tmp_path / "plan")
    (tmp_path / "plan").mkdir()
    with pytest.raises(InputError, match="nothing to go on with"):
        tb.plan(believed(), effect="gimbal_zero", **again)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["basic", "--effect", "no_such"], "there is no effect"),
        (["basic", "--effect", "gimbal_zero:cmg8"], "basic has no cmg8; it has cmg1, cmg2, cmg3, cmg4, cmg5, cmg6"),
        (["basic", "--effect", "any", "--inertia-std", "1e-5"], "plan one after the other"),
        (["basic", "--alpha", "1.5"], "above 0 and below 1"),
        (["basic", "--maneuvers", "mine"], "give chosen or own"),
        (["basic", "--resume"], "name its folder with --out"),
        (["crazyflie"], "is not flown"),
    ],
)
def test_what_cannot_be_planned_ends_with_a_message(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    source, *options = arguments
    path = str(ROOT / "scenarios" / f"{source}.toml")
    assert exit_code_of(lambda: app(["campaign-plan", path, *options])) == BAD_INPUT
    printed = capsys.readouterr()
    assert said in printed.err
    assert printed.out == ""
    assert not list(tmp_path.iterdir())


def test_a_simulated_flight_that_diverges_ends_the_plan_as_it_ends_a_run(tmp_path, capsys):
    # No step of 1.25 ms follows a body that turns by 3 rad in each.
    keys = (
        "initial.body_rate_rad_s=[2000.0, 1300.0, 600.0]",
        "estimation.initial_momentum=estimated",
        "truth.mass_kg=4.0",
    )
    spin = [part for key in keys for part in ("--set", key)]
    path = str(ROOT / "scenarios" / "basic.toml")
    assert exit_code_of(lambda: app(["campaign-plan", path, *spin, "--out", str(tmp_path / "plan")])) == DIVERGED
    assert "flight 1 came to no end: " in capsys.readouterr().err


def test_records_that_cannot_be_used_leave_nothing_behind(records, tmp_path):
    still = {
        name: np.zeros_like(column) if "body_rate" in name else column for name, column in _table(records[0]).items()
    }
    with pytest.raises(InputError):
        tb.plan(believed(), tb.records_from({"still": still}), folder=tmp_path / "plan")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("few")
def test_the_command_says_what_to_fly_next_and_how_to_go_on(tmp_path, capsys):
    out = tmp_path / "plan"
    path = str(ROOT / "scenarios" / "basic.toml")
    assert exit_code_of(lambda: app(["campaign-plan", path, "--effect", "gimbal_zero", "--out", str(out)])) == 0
    printed = capsys.readouterr().out
    assert "flight 1 is to be flown" in printed
    assert f"--data FOLDER --out {out} --resume" in printed
