"""The page of a run: its numbers are the run's, and it shows what the run has and nothing else."""

import re
from dataclasses import fields, replace

import numpy as np
import pytest

from support.report_pages import ParsedPage
from support.report_runs import PROVENANCE, designed, diverged_flight, flight
from testbed.assembly.estimators import UNCERTAINTY_KEYS
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.estimation.uncertainty import Uncertainty
from testbed.experiment.result import result_of
from testbed.report.frame.page import render_page
from testbed.report.run import run_page, write_run_report
from testbed.report.sections.inertias import Inertias
from testbed.report.verdict import ALL_BUT_CONSIDERED, MOSTLY_CONSIDERED, flight_verdict
from testbed.report.wording import ESTIMATOR_NAMES, capitalized
from testbed.scenario.uncertainty import Uncertainty as ScenarioUncertainty

FLIGHT = ["maneuver", "tracking", "actuators"]


def page_of(experiment, folder):
    path = folder / "report.html"
    write_run_report(path, experiment, PROVENANCE, result_of(experiment))
    return ParsedPage(path.read_text(encoding="utf-8"))


def inertias_of(experiment, by_name=None):
    return Inertias(
        by_name=experiment.estimation.by_name if by_name is None else by_name,
        bound_std=experiment.estimation.bound_std,
        nominal=theta_of(experiment.nominal.inertia),
        truth=theta_of(experiment.truth.inertia),
    )


def off_by(estimate, truth, stds):
    """The estimate moved so that it is off by given numbers of its standard deviations."""
    return replace(estimate, theta=truth + np.asarray(stds) * estimate.std)


def titles(experiment):
    return [section.title for section in run_page(experiment, PROVENANCE, result_of(experiment)).sections]


def assert_shows(cells, values):
    """Each cell is the value in 1e-3 kg·m², rounded to the digits that it shows."""
    for cell, value in zip(cells, values, strict=True):
        digits = len(cell.partition(".")[2])
        assert float(cell) == pytest.approx(1e3 * value, abs=0.5001 * 10.0**-digits)


def test_the_table_shows_the_runs_numbers(tmp_path):
    experiment = flight()
    page, estimation = page_of(experiment, tmp_path), experiment.estimation
    truth = theta_of(experiment.truth.inertia)
    assert_shows(page.row("True"), truth)
    assert_shows(page.row("Nominal"), theta_of(experiment.nominal.inertia))
    assert_shows(page.row("Cramér-Rao bound, std"), estimation.bound_std)
    ratios = [row[1:] for row in page.tables[0] if row[0] == "error / std"]
    for estimate, name, ratio in zip(estimation.by_name.values(), estimation.by_name, ratios, strict=True):
        cells = [cell.split(" ± ") for cell in page.row(f"{capitalized(ESTIMATOR_NAMES[name])}, ± std")]
        assert_shows([cell[0] for cell in cells], estimate.theta)
        assert_shows([cell[1] for cell in cells], estimate.std)
        np.testing.assert_allclose(np.array(ratio, dtype=float), (estimate.theta - truth) / estimate.std, atol=0.0051)


def test_units_stand_in_the_headers(tmp_path):
    header = page_of(flight(), tmp_path).tables[0][0]
    assert header == ["Inertia", *(f"{name}1e-3 kg·m²" for name in PARAMETER_NAMES)]


def test_the_chart_of_the_estimates_shows_the_runs_numbers():
    experiment = flight()
    chart = run_page(experiment, PROVENANCE, {}).sections[0].blocks[1].chart
    drawn = {trace.name: trace for trace in chart.data}
    truth = theta_of(experiment.truth.inertia)
    for name, estimate in experiment.estimation.by_name.items():
        trace = drawn[ESTIMATOR_NAMES[name]]
        np.testing.assert_allclose(trace.y, 1e3 * (estimate.theta - truth), rtol=1e-12)
        np.testing.assert_allclose(trace.error_y.array, 1.96e3 * estimate.std, rtol=1e-12)
    band = drawn["bound"]
    base = np.array(band.base, dtype=float)
    np.testing.assert_allclose(base, -1.96e3 * experiment.estimation.bound_std, rtol=1e-9)
    np.testing.assert_allclose(base + band.y, 1.96e3 * experiment.estimation.bound_std, rtol=1e-9)
    np.testing.assert_allclose(drawn["nominal"].y, 1e3 * (theta_of(experiment.nominal.inertia) - truth), rtol=1e-12)


def test_a_completed_run_has_all_its_sections_in_order(tmp_path):
    page = page_of(designed(flight()), tmp_path)
    expected = ["estimates", *FLIGHT, "residuals", "conservation-of-momentum", "design", "provenance"]
    assert page.ids == expected
    assert page.said_with("notice warn") == page.said_with("notice bad") == []
    assert len(page.said_with("verdict good")) == 1


def test_the_design_lists_every_start(tmp_path):
    experiment = designed(flight())
    page = page_of(experiment, tmp_path)
    assert page.row("1")[:2] == ["-1.25", "1.00"]
    assert page.row("2")[0] == "broke a limit"
    assert page.row("3, flown") == ["-2.5", "3.00", "solve succeeded"]
    determinant = float(page.row("Determinant of ΨᵀΨ")[0])
    assert determinant == pytest.approx(experiment.plan.design.information.determinant, rel=1e-3)


def test_a_maneuver_that_was_given_has_no_design_section():
    assert "Design" not in titles(flight())


def test_the_scenario_stands_there_verbatim(tmp_path):
    page = page_of(flight(), tmp_path)
    assert PROVENANCE["scenario.toml"] in page.texts["provenance"]
    assert page.row("command") == [PROVENANCE["command"]]
    assert '"outcome": "completed"' in page.texts["provenance"]


def test_saturation_is_stated_and_shaded(tmp_path):
    experiment = flight(1.2)
    page = page_of(experiment, tmp_path)
    seconds = experiment.flown.record.channels["gimbal_rate_saturated"].any(axis=1).sum() * experiment.flown.period
    notice = next(text for text in page.said_with("notice warn") if "gimbal-rate limit" in text)
    assert float(re.search(r"([\d.]+) s at", notice)[1]) == pytest.approx(seconds, rel=5e-3)
    shaded = [shape for chart in page.charts for shape in chart["layout"].get("shapes", [])]
    assert sum(shape["x1"] - shape["x0"] for shape in shaded) == pytest.approx(seconds)
    assert "Shaded" in page.texts["actuators"]


def test_without_saturation_nothing_is_shaded(tmp_path):
    page = page_of(flight(), tmp_path)
    assert not [chart for chart in page.charts if chart["layout"].get("shapes")]


@pytest.mark.parametrize(("spin", "rows"), [(0.36, 4), (1.0, 1)])
def test_a_diverged_run_shows_what_there_is_and_says_so_in_red(tmp_path, spin, rows):
    experiment = diverged_flight(spin)
    assert len(experiment.flown.record.time) == rows
    page = page_of(experiment, tmp_path)
    assert page.ids == [*FLIGHT, "conservation-of-momentum", "provenance"]
    assert "diverged" in page.said_with("verdict bad")[0]
    assert any("shorten" in text or "simulation.step_s" in text for text in page.said_with("notice bad"))


def test_a_failed_estimator_is_reported_first_and_explained_last(tmp_path):
    experiment = flight()
    by_name = {name: estimate for name, estimate in experiment.estimation.by_name.items() if name != "iv"}
    estimation = replace(experiment.estimation, by_name=by_name, failures={"iv": "J12 cannot be determined"})
    page = page_of(replace(experiment, estimation=estimation), tmp_path)
    assert page.said_with("notice warn") == ["Instrumental variable gave no estimate: J12 cannot be determined"]
    assert page.ids[-2:] == ["estimators-that-failed", "provenance"]
    assert page.row("Instrumental variable") == ["J12 cannot be determined"]


def test_without_any_estimate_the_flight_is_still_shown(tmp_path):
    experiment = flight()
    failures = dict.fromkeys(experiment.estimation.by_name, "no motion")
    estimation = replace(experiment.estimation, by_name={}, failures=failures)
    page = page_of(replace(experiment, estimation=estimation), tmp_path)
    assert "no estimator gave an estimate" in page.said_with("verdict bad")[0]
    assert page.ids == [*FLIGHT, "conservation-of-momentum", "estimators-that-failed", "provenance"]


def test_the_verdict_counts_the_bands_that_miss():
    experiment = flight()
    truth, some = theta_of(experiment.truth.inertia), experiment.estimation.by_name
    exact = off_by(some["iv"], truth, [0.1, -0.3, 0.0, 0.0, 0.0, 0.2])
    wrong = off_by(some["ls"], truth, [9.0, 0.0, -9.0, 0.0, 0.0, 0.0])
    alone = flight_verdict(inertias_of(experiment, {"iv": exact})).text
    assert "all 6 of the estimators' 95 % bands cover the truth, as chance has it" in alone
    both = flight_verdict(inertias_of(experiment, {"output_error": wrong, "iv": exact}))
    assert "10 of the estimators' 12 95 % bands cover the truth (output error misses J11 and J33)" in both.text
    assert "output error is off by more than chance" in both.text
    assert both.tone == "warn"


def test_least_squares_is_the_biased_baseline_and_does_not_spoil_a_verdict():
    experiment = flight()
    truth, some = theta_of(experiment.truth.inertia), experiment.estimation.by_name
    exact = off_by(some["iv"], truth, [0.1, -0.3, 0.0, 0.0, 0.0, 0.2])
    biased = off_by(some["ls"], truth, [9.0, 0.0, -9.0, 0.0, 0.0, 0.0])
    assert flight_verdict(inertias_of(experiment, {"ls": biased, "iv": exact})).tone == "good"


def test_the_verdict_names_what_makes_the_uncertainty_larger_than_noise():
    experiment = flight()
    estimate = experiment.estimation.by_name["output_error"]
    noise = estimate.noise_std[:, None]

    def verdict(considered, kinds):
        uncertain = replace(estimate, considered=considered * noise, considered_kinds=kinds)
        return flight_verdict(inertias_of(experiment, {"output_error": uncertain})).text

    kinds = ("gyro_bias", "gimbal_misalignment", "gimbal_misalignment", "gyro_scale")
    text = verdict(np.array([6.0, 4.0, 3.0, 1.0]), kinds)  # variances 1 of noise, 36, 16 + 9 and 1
    assert "up to 7.94 times what the gyro's noise makes" in text
    assert "57 % from estimation.uncertainty.gyro_bias_rad_s and 40 % from" in text
    assert "estimation.uncertainty.gimbal_axis_misalignment_rad; state" in text
    assert "gyro_scale" not in text
    just_below = np.sqrt(0.99 * (MOSTLY_CONSIDERED**2 - 1.0)) * np.array([1.0, 0.0, 0.0, 0.0])
    assert "estimation.uncertainty" not in verdict(just_below, kinds)
    assert "estimation.uncertainty" in verdict(just_below * 1.02, kinds)


@pytest.mark.parametrize(("ratio", "tone"), [(0.99 * ALL_BUT_CONSIDERED, "good"), (1.01 * ALL_BUT_CONSIDERED, "warn")])
def test_an_interval_that_is_all_assumed_is_in_doubt(ratio, tone):
    """A flight that stated 1,000 times what its gyro's noise makes, by the default of the gyro's bias, was good."""
    experiment = flight()
    estimate = experiment.estimation.by_name["output_error"]
    considered = np.sqrt(ratio**2 - 1.0) * estimate.noise_std[:, None]
    uncertain = replace(estimate, considered=considered, considered_kinds=("gyro_bias",))
    verdict = flight_verdict(inertias_of(experiment, {"output_error": uncertain}))
    assert verdict.tone == tone
    assert ("what was assumed" in verdict.text) == (tone == "warn")


def test_every_considered_quantity_has_its_key():
    assert [*UNCERTAINTY_KEYS] == [each.name for each in fields(Uncertainty)]
    assert {*UNCERTAINTY_KEYS.values()} == {*ScenarioUncertainty.model_fields}


def test_a_flight_whose_estimates_are_in_doubt_is_not_green():
    experiment = flight()
    inertias = inertias_of(experiment, experiment.estimation.by_name)
    assert flight_verdict(inertias).tone == "good"
    doubtful = flight_verdict(inertias, ["The residual is not white."])
    assert doubtful.tone == "warn"
    assert "1 finding below" in doubtful.text


def test_an_error_beyond_noise_is_a_warning(tmp_path):
    experiment = flight()
    truth = theta_of(experiment.truth.inertia)
    wrong = off_by(experiment.estimation.by_name["ls"], truth, [0.0, 0.0, 6.3, 0.0, 0.0, 0.0])
    estimation = replace(experiment.estimation, by_name={"ls": wrong})
    page = page_of(replace(experiment, estimation=estimation), tmp_path)
    assert "off by 6.3 of its standard deviations in J33" in page.said_with("notice warn")[0]
    assert page.said_with("warn") == ["+6.30"]  # the cell of the table


def test_every_colour_of_a_chart_is_defined_for_light_and_dark():
    html = render_page(run_page(designed(flight(1.2)), PROVENANCE, {}))
    light, dark = html.split("@media (prefers-color-scheme: dark)")[:2]
    dark = dark.split("@media print")[0]
    used = set(re.findall(r'"var\((--[\w-]+)\)"', html))
    assert {"--axis-x", "--unit-6", "--estimator-4", "--limit", "--bound", "--shade"} <= used
    for colors in (light, dark):
        assert used <= set(re.findall(r"(--[\w-]+):", colors))


def test_a_long_flight_stays_below_6_megabytes(tmp_path):
    experiment = designed(flight(0.4, 40.0))
    assert len(experiment.flown.record.time) == 3201
    path = tmp_path / "report.html"
    write_run_report(path, experiment, PROVENANCE, result_of(experiment))
    assert path.stat().st_size < 6e6
