"""Blind data sets: read as measured, sealed, the same twice, and telling nothing beside the measurements."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from concealing.case import Case, Run, Telemetry
from concealing.effect import HiddenEffect
from concealing.files import conceal
from concealing.flown import theta
from concealing.guidance import software_of
from concealing.sealing import is_sealed
from testbed.experiment.measured import estimate_record
from testbed.records.reading import read_data_set
from tests.agreement.test_concealing import SCENARIO

LATE = HiddenEffect(effect="gyro_latency", component="gyro", parameters={"delay": 0.012})
RUNS = (Run(duration=1.0, maneuver=1), Run(duration=0.8, maneuver=2, release_error=(0.01, 0.0, -0.01)))


def case(**changes):
    return replace(Case(scenario=SCENARIO, seed=11, runs=RUNS, theta_error=(5e-4, 0, 0, 0, 0, 1e-4)), **changes)


@pytest.fixture(scope="module")
def hidden(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind")
    conceal(case(effects=(LATE,)), folder / "data", folder / "answer")
    return folder


def test_the_records_read_as_measured(hidden):
    records = read_data_set(hidden / "data")
    assert [record.details.name for record in records] == ["run_1", "run_2"]
    assert [len(record.time) for record in records] == [17, 13]
    for record in records:
        assert record.details.source == "measured"
        assert record.details.role is None
        assert record.details.gyro_noise == pytest.approx(0.001658)
        assert set(record.channels) == {
            "body_rate",
            "gimbal_angle",
            "gimbal_rate_command",
            "gimbal_torque",
            "rotor_speed",
        }
        assert not record.extra_columns


def test_the_answer_is_sealed(hidden):
    assert is_sealed(hidden / "data", hidden / "answer")
    answer = json.loads((hidden / "answer" / "answer.json").read_text())
    assert answer["effects"] == [
        {"effect": "gyro_latency", "component": "gyro", "parameters": {"delay_s": {"value": 0.012, "unit": "s"}}}
    ]
    assert answer["true_theta_kg_m2"] == pytest.approx([0.0225, 0.022, 0.027, 0.0, 0.0, 1e-4])
    assert answer["initial_rates_rad_s"][1] == pytest.approx([0.01, 0.0, -0.01])
    (hidden / "answer" / "answer.json").write_text(json.dumps(answer))
    assert not is_sealed(hidden / "data", hidden / "answer")


def test_nothing_beside_the_measurements_depends_on_the_effect(hidden, tmp_path):
    conceal(case(), tmp_path / "data", tmp_path / "answer")
    names = sorted(path.name for path in (tmp_path / "data").iterdir())
    assert names == ["run_1.csv", "run_1.toml", "run_2.csv", "run_2.toml", "sealed.sha256"]
    assert names == sorted(path.name for path in (hidden / "data").iterdir())
    for name in ("run_1.toml", "run_2.toml"):
        assert (tmp_path / "data" / name).read_text() == (hidden / "data" / name).read_text()
    without, with_it = read_data_set(tmp_path / "data"), read_data_set(hidden / "data")
    for plain, late in zip(without, with_it, strict=True):
        np.testing.assert_array_equal(plain.time, late.time)
        difference = np.abs(plain.channels["body_rate"] - late.channels["body_rate"]).max()
        assert 1e-4 < difference < 0.05  # the delay shows; the noise is the same, and cancels


def test_the_same_case_twice_is_the_same_to_the_byte(tmp_path):
    for folder in ("once", "again"):
        conceal(case(effects=(LATE,)), tmp_path / folder, tmp_path / f"{folder}_answer")
    for name in ("run_1.csv", "run_2.csv", "sealed.sha256"):
        assert (tmp_path / "once" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_noise_has_the_stated_size_and_telemetry_its_defects(tmp_path):
    still = tuple(Run(duration=2.0, maneuver=0) for _ in range(3))
    telemetry = Telemetry(
        gyro_rate=100.0, dropouts=0.1, outliers=0.02, encoder_step=1e-3, tachometers=False, stated_noise=0.8
    )
    flown = conceal(case(runs=still, telemetry=telemetry), tmp_path / "data", tmp_path / "answer")
    records = read_data_set(tmp_path / "data")
    whole = 3 * 201
    kept = sum(len(record.time) for record in records)
    assert 0.8 * whole < kept < 0.98 * whole
    spikes = 0
    for index, record in enumerate(records):
        assert record.details.gyro_noise == pytest.approx(0.8 * 0.001658)
        assert "rotor_speed" not in record.channels
        angle = record.channels["gimbal_angle"]
        np.testing.assert_allclose(angle, 1e-3 * np.rint(angle / 1e-3), atol=1e-12)
        ticks = np.rint(record.time * 100.0).astype(int)
        error = record.channels["body_rate"] - flown.log.body_rate[ticks, index]
        outside = np.abs(error) > 6 * 0.001658
        spikes += outside.any(axis=1).sum()
        # 600 numbers: the standard deviation is within 12 % at four of its own.
        assert np.std(error[~outside]) == pytest.approx(0.001658, rel=0.12)
    assert 3 <= spikes <= 30  # of about 540 samples, 2 %


def test_cluster_momentum_in_place_of_gimbal_angles(tmp_path):
    flown = conceal(case(telemetry=Telemetry(momentum="cluster_momentum")), tmp_path / "data", tmp_path / "answer")
    record = read_data_set(tmp_path / "data")[0]
    assert set(record.channels) == {"body_rate", "cluster_momentum"}
    # Zero total momentum: h = -J ω but for the gimbals' small change of J, and encoder noise of 1e-4 rad.
    expected = -flown.log.body_rate[::5, 0] @ flown.craft.inertia
    np.testing.assert_allclose(record.channels["cluster_momentum"], expected, atol=2e-5)


def test_a_platform_under_applied_torque(tmp_path):
    lag = HiddenEffect(effect="actuator_lag", component="actuators", parameters={"time_constant": 0.05})
    conceal(
        case(actuation="applied_torque", effects=(lag,), telemetry=Telemetry(gyro_rate=100.0)),
        tmp_path / "data",
        tmp_path / "answer",
    )
    record = read_data_set(tmp_path / "data")[0]
    assert set(record.channels) == {"body_rate", "applied_torque"}
    assert np.abs(record.channels["body_rate"]).max() > 0.05


def test_the_testbed_estimates_the_true_inertia_from_an_undisturbed_set(tmp_path):
    runs = tuple(Run(duration=2.0, maneuver=index, planned_spin=(0.1, -0.1, 0.1)) for index in (4, 5))
    flown = conceal(case(runs=runs), tmp_path / "data", tmp_path / "answer")
    known = software_of(SCENARIO)
    estimation = known.scenario.estimation.model_copy(
        update={"estimators": ("output_error",), "initial_momentum": "estimated"}
    )
    scenario = known.scenario.model_copy(update={"estimation": estimation})
    for record in read_data_set(tmp_path / "data"):
        estimate = estimate_record(scenario, known.nominal, record).by_name["output_error"]
        error = np.linalg.solve(np.linalg.cholesky(estimate.covariance), estimate.theta - theta(flown.craft))
        assert error @ error < chi2.isf(1e-4, 6)
