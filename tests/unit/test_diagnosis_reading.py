"""Records that a diagnosis can use, and those that it refuses: what is wrong with them, and the remedy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from concealing.rig import Rig
from concealing.wheel_case import WheelCase, WheelRun
from concealing.wheel_flight import fly_wheels
from concealing.wheel_set import wheel_record
from support.diagnosed_records import NOISE, nominal, records
from support.rigs import rig_records, rig_scenario
from testbed.assembly.platform import nominal_body
from testbed.diagnosis import roles
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.gate import Gate, require_explicable
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.settings import PriorOdds
from testbed.dynamics.inertia import theta_of
from testbed.effects.gyro_latency import GyroLatency
from testbed.errors import InputError
from testbed.records.record import Record, RunDetails
from testbed.scenario.diagnosis import Diagnosis
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

WHEELS = shipped_scenario("cubesat_wheels")


@pytest.fixture(scope="module")
def good():
    return records(4)


def read(used):
    return data_set_of(used, *nominal())


def with_channels(record, **channels):
    return replace(record, channels={**record.channels, **channels})


def with_details(record, **details):
    return replace(record, details=replace(record.details, **details))


def scaled(record, factor):
    return with_channels(record, body_rate=factor * record.channels["body_rate"])


def delayed(record, seconds):
    """A gyro whose clock is late: what it shows at the start is not known."""
    rate = [np.interp(record.time - seconds, record.time, axis, left=np.nan) for axis in record.channels["body_rate"].T]
    return with_channels(record, body_rate=np.column_stack(rate))


def test_a_gyro_that_falls_silent_is_said_with_how_much_is_used(good):
    """Of 39 s of a log 0.7 were used, with a name, and nobody said so."""
    rate = good[0].channels["body_rate"].copy()
    rate[len(rate) // 2 :] = np.nan
    half = with_channels(good[0], body_rate=rate)
    (notice,) = [each for each in read([half, *good[1:]]).notices if "only these are used" in each]
    assert notice.startswith(f"{good[0].details.name}: gyro and actuators both have samples in ")
    assert not any("only these are used" in each for each in read(good).notices)


def test_every_third_run_is_held_out_at_least_one_and_none_of_a_single_one(good):
    assert read(records(3)).heldout.names == ("run3",)
    assert read(good[:2]).heldout.names == ("run2",)
    assert read(good[:1]).heldout is None
    assert read(good).runs.names == ("run1", "run2", "run4")


@pytest.mark.parametrize(("times", "held_out"), [(1.0, 2), (3.0, 1)])
def test_a_run_that_turns_far_faster_than_all_others_is_fitted(times, held_out, good, monkeypatch):
    """A drag that goes with the square of the rate showed in the run that was held out, and was unexplained."""
    monkeypatch.setattr(roles, "log_chance_of_jump", lambda _: 0.0)  # a scaled rate has no momentum to conserve
    parts = [[part] for part in read([with_details(record, role="fit") for record in good[:3]]).runs.grid.runs]
    parts[2] = [replace(parts[2][0], body_rate=times * parts[0][0].body_rate)]
    fit, heldout = roles.by_role(list(zip(good[:3], parts, strict=True)))
    assert heldout == [held_out]
    assert fit == sorted({0, 1, 2} - {held_out})


def test_stated_roles_are_kept(good):
    stated = [with_details(good[0], role="heldout"), with_details(good[1], role="fit"), good[2]]
    data = read(stated)
    assert data.heldout.names == ("run1",)
    assert data.runs.names == ("run2", "run3")


def test_a_run_that_is_to_be_fitted_leaves_the_others_to_be_dealt():
    """One with the role "fit" left none held out."""
    stated = [*records(3)[:2], with_details(records(3)[2], role="fit")]
    data = read(stated)
    assert data.heldout.names == ("run2",)
    assert data.runs.names == ("run1", "run3")


def test_held_out_runs_alone_cannot_be_fitted(good):
    with pytest.raises(InputError, match="every run has role"):
        read([with_details(record, role="heldout") for record in good])


@pytest.mark.parametrize(
    ("factor", "unit"), [(180 / np.pi, "in deg/s: multiply it by 0.01745"), (30 / np.pi, "rpm"), (-1.0, "other sign")]
)
def test_a_gyro_in_another_unit_is_recognised_by_what_the_actuators_predict(good, factor, unit):
    with pytest.raises(InputError, match=unit):
        read([scaled(record, factor) for record in good[:2]])


@pytest.mark.parametrize(
    ("order", "signs", "said"),
    [
        ([1, 0, 2], [1, 1, 1], "the body's x, y, z were the gyro's y, x, z"),
        ([1, 2, 0], [1, 1, 1], "the body's x, y, z were the gyro's z, x, y"),
        ([0, 1, 2], [1, -1, 1], "the body's x, y, z were the gyro's x, -y, z"),
    ],
)
def test_a_gyro_with_its_axes_in_other_places_is_refused_with_where_they_are(good, order, signs, said):
    mounted = [with_channels(each, body_rate=each.channels["body_rate"][:, order] * signs) for each in good[:2]]
    with pytest.raises(InputError, match=said):
        read(mounted)


def test_a_gimbal_that_turns_the_other_way_is_refused_with_its_number(good):
    signs = np.array([1, 1, -1, 1, 1, 1])
    turned = [with_channels(each, gimbal_angle=signs * each.channels["gimbal_angle"]) for each in good[:2]]
    with pytest.raises(InputError, match=r"misses 7\d\.\d% of the motion.*0\.0% if gimbal 3 turned the other way"):
        read(turned)


def test_only_the_run_whose_gimbal_turns_the_other_way_is_named(good):
    turned = with_channels(good[1], gimbal_angle=[1, 1, -1, 1, 1, 1] * good[1].channels["gimbal_angle"])
    with pytest.raises(InputError, match=r"^run2: the balance of angular.*if gimbal 3 turned the other way"):
        read([good[0], turned, good[2]])


def test_gimbals_in_degrees_are_refused_with_their_unit(good):
    degrees = [with_channels(each, gimbal_angle=np.degrees(each.channels["gimbal_angle"])) for each in good[:2]]
    with pytest.raises(InputError, match="the gimbals' angles were in deg"):
        read(degrees)


def test_gimbals_that_changed_places_are_refused_with_the_word_that_accepts_them(good):
    order = [0, 4, 2, 3, 1, 5]
    exchanged = [with_channels(each, gimbal_angle=each.channels["gimbal_angle"][:, order]) for each in good[:2]]
    with pytest.raises(InputError, match=r"gimbals 2 and 5 changed places.*add \"telemetry\" to accept"):
        read(exchanged)


def test_wheels_are_in_their_places_or_said_not_to_be():
    case = WheelCase(scenario=WHEELS, seed=4, runs=(WheelRun(duration=12.0, motion=8, at_rest=False),) * 2)
    flown, scenario = fly_wheels(case), read_body_scenario(WHEELS)
    records = [wheel_record(flown, number) for number in range(2)]
    assert data_set_of(records, scenario, nominal_body(scenario)).runs.names
    signs = np.array([1, 1, -1, 1])
    turned = [with_channels(each, wheel_speed=signs * each.channels["wheel_speed"]) for each in records]
    with pytest.raises(InputError, match="wheel 3 turned the other way"):
        data_set_of(turned, scenario, nominal_body(scenario))
    in_rpm = [with_channels(each, wheel_speed=each.channels["wheel_speed"] * 30.0 / np.pi) for each in records]
    with pytest.raises(InputError, match=r"the wheels' speeds were in rpm \(multiply them by 0\.1047"):
        data_set_of(in_rpm, scenario, nominal_body(scenario))


def test_only_the_run_in_the_wrong_unit_is_blamed(good):
    with pytest.raises(InputError, match=r"^run2: the gyro reads 57\.3 times"):
        read([good[0], scaled(good[1], 180 / np.pi)])


def test_another_inertia_by_a_factor_is_another_platform(good):
    scenario, platform = nominal()
    with pytest.raises(InputError, match="another platform"):
        data_set_of(good, scenario, replace(platform, inertia=3.0 * platform.inertia))


def test_clocks_that_differ_between_runs_are_refused(good):
    late = [delayed(record, 0.06 * index) for index, record in enumerate(good)]
    with pytest.raises(InputError, match=r"run4 \+1\d\d ms.*one clock"):
        read(late)


def test_a_delay_that_all_runs_share_is_left_to_the_diagnosis():
    hooks = GyroLatency().hooks("gyro")
    data = read(records(3, hooks=[hooks], values=[np.array([0.05])]))
    assert sorted(data.fit_records + data.heldout_records) == ["run1", "run2", "run3"]


def test_a_platform_at_rest_tells_nothing(good):
    rest = np.random.default_rng(2).normal(0.0, NOISE, good[0].channels["body_rate"].shape)
    still = with_channels(good[0], body_rate=rest, gimbal_angle=0.0 * good[0].channels["gimbal_angle"])
    with pytest.raises(InputError, match="and has to be 10"):
        read([still])


def test_a_saturated_gyro_is_left_out_and_said(good):
    clipped = with_channels(good[1], body_rate=np.sign(good[1].channels["body_rate"]) * 0.1)
    data = read([good[0], clipped, good[2]])
    assert data.runs.names == ("run1",)
    assert "run2: the gyro's x axis reads 0.1 rad/s in size in 65 of 65 samples" in data.notices[0]


def test_a_run_that_is_too_short_is_left_out_and_alone_refused(good):
    short = with_details(good[0], usable_to=0.3)
    assert "left out: run1" in read([short, *good[1:]]).notices[0]
    with pytest.raises(InputError, match="at least 10 are needed"):
        read([short])


@pytest.mark.parametrize("source", ["simulated", "measured"])
def test_a_noise_of_zero_is_replaced_by_what_the_samples_show_and_said(good, source):
    data = read([with_details(record, gyro_noise=0.0, source=source) for record in good])
    assert data.runs.sigma == pytest.approx(NOISE, rel=0.35)  # 61 differences on three axes: 10 %, so 3.5 sigma
    assert "noise of zero is stated" in data.notices[0]


def test_a_gap_of_the_actuators_splits_a_run(good):
    hole = (good[0].time > 1.5) & (good[0].time < 2.2)
    angle = np.where(hole[:, None], np.nan, good[0].channels["gimbal_angle"])
    data = read([with_channels(good[0], gimbal_angle=angle), good[1]])
    assert data.runs.names == ("run1 part 1", "run1 part 2")
    assert data.heldout.names == ("run2",)
    assert not data.alone


@pytest.mark.parametrize(("missing", "parts"), [(4, 1), (6, 2)])
def test_an_applied_torque_at_50_hz_is_bridged_for_as_long_as_between_samples_at_16_hz(missing, parts):
    """A tenth of a second; two lost samples at 50 Hz had split a run, and each part had initial rates of its own."""
    record = applied(seconds=3.0, rate=50.0)
    torque = record.channels["applied_torque"].copy()
    torque[70 : 70 + missing] = np.nan
    data = read([with_channels(record, applied_torque=torque), applied(seconds=3.0, rate=50.0)])
    assert len(data.runs.names) == parts


def applied(seconds, rate):
    time, inertia = np.arange(0.0, seconds, 1.0 / rate), nominal()[1].inertia
    swing, axis = 0.3 * np.sin(2.0 * time)[:, None], np.array([1.0, -1.0, 0.5])
    change = 0.6 * np.cos(2.0 * time)[:, None] * axis
    torque = change @ inertia + np.cross(swing * axis, (swing * axis) @ inertia)
    noise = np.random.default_rng(3).normal(0.0, NOISE, torque.shape)
    channels = {"applied_torque": torque, "body_rate": swing * axis + noise}
    return Record(time=time, channels=channels, details=RunDetails(name="run1", gyro_noise=NOISE))


def test_the_parts_of_a_single_record_verify_nothing(good):
    hole = (good[0].time > 1.5) & (good[0].time < 2.2)
    angle = np.where(hole[:, None], np.nan, good[0].channels["gimbal_angle"])
    data = read([with_channels(good[0], gimbal_angle=angle)])
    assert len(data.runs.names) == 2
    assert data.alone


def test_a_gap_of_the_gyro_costs_only_its_samples(good):
    hole = (good[0].time > 1.5) & (good[0].time < 2.2)
    rate = np.where(hole[:, None], np.nan, good[0].channels["body_rate"])
    data = read([with_channels(good[0], body_rate=rate)])
    assert data.runs.names == ("run1",)
    assert data.runs.samples == 3 * int((~hole).sum())


@pytest.fixture(scope="module")
def fit(good):
    """The nominal model fitted to good records."""
    return fitted(read(good).runs, [], theta_of(nominal()[1].inertia), [])


def with_gap(fit, gap):
    return replace(fit, residual=fit.residual * gap / fit.root_mean_square)


def test_a_gap_that_hardly_shrinks_gives_no_names(good, fit):
    runs = read(good).runs
    require_explicable(runs, before=12.0, after=with_gap(fit, 1.1), gate=Gate())
    require_explicable(runs, before=4.0, after=with_gap(fit, 3.9), gate=Gate())
    with pytest.raises(InputError, match=r"not of the scenario's platform.*add \"gap\" to accept"):
        require_explicable(runs, before=12.0, after=with_gap(fit, 8.0), gate=Gate())
    known = Gate(accepted=("gap",))
    require_explicable(runs, before=12.0, after=with_gap(fit, 8.0), gate=known)
    assert known.notices[0].startswith("accepted by the scenario: the gap is 12 times")


def test_a_gap_of_the_gimbal_channels_alone_is_not_put_down_to_the_platform(good, fit):
    runs = read(good).runs
    with_gimbals = replace(fit, residual=np.concatenate([fit.residual, np.full(runs.samples, 20.0)]))
    with pytest.raises(
        InputError, match=r"in the gyro's samples alone.*leave gimbal_torque and gimbal_rate_command out"
    ):
        require_explicable(runs, before=15.0, after=with_gimbals, gate=Gate())


@pytest.mark.parametrize(
    ("doubt", "spoil"),
    [
        ("unit", lambda good: [scaled(record, -1.0) for record in good]),
        ("inertia", lambda good: [scaled(record, 1.0 / 3.0) for record in good]),
        ("clocks", lambda good: [delayed(record, 0.06 * index) for index, record in enumerate(good)]),
        ("body_rate", lambda good: [scaled(record, 300.0) for record in good]),
    ],
)
def test_what_the_gate_refuses_passes_by_the_word_that_its_message_names(good, doubt, spoil):
    scenario, platform = nominal()
    records = spoil(good)
    with pytest.raises(InputError, match=f'add "{doubt}" to accept in'):
        data_set_of(records, scenario, platform)
    every = ("body_rate", "unit", "inertia", "telemetry", "clocks", "rest", "stuck")
    accepting = scenario.model_copy(update={"diagnosis": Diagnosis(accept=every)})
    notices = data_set_of(records, accepting, platform).notices
    assert any(notice.startswith("accepted by the scenario: ") for notice in notices)


def test_stated_prior_odds_go_with_fitted_and_held_out_runs(good):
    scenario, platform = nominal()
    stating = scenario.model_copy(update={"diagnosis": Diagnosis(null_prior_odds=19.0, unmodelled_prior_odds=0.5)})
    data = data_set_of(good, stating, platform)
    assert data.runs.prior_odds == data.heldout.prior_odds == PriorOdds(none=19.0, unmodelled=0.5)
    assert read(good).runs.prior_odds == PriorOdds()


def test_a_fast_rig_that_its_actuators_predict_is_in_rad_s():
    """22 rad/s looked like deg/s: where momentum and gyro agree in SI, the rate is what it is."""
    rig = Rig(inertia=0.001)
    scenario = rig_scenario()
    platform = replace(nominal_body(scenario), inertia=0.001 * np.eye(3))
    fast = rig_records([rig] * 3)
    assert max(np.nanmax(np.abs(record.channels["body_rate"])) for record in fast) > 22.0
    assert len(data_set_of(fast, scenario, platform).runs.names) == 2


def test_friction_that_passes_for_inertia_is_no_other_platform():
    """A bearing makes the inertia of the bare model twice the stated one: its gap says that something is missing."""
    scenario = rig_scenario()
    data = data_set_of(rig_records([Rig(viscous=0.15)] * 3), scenario, nominal_body(scenario))
    assert any("times the scenario's inertia" in notice for notice in data.notices)
