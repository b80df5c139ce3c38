"""The page of measured records: no truth, no flight internals, one record or several."""

from dataclasses import replace

import numpy as np

from support.report_pages import ParsedPage
from support.report_runs import PROVENANCE, flight
from testbed.dynamics.inertia import theta_of
from testbed.experiment.combining import combine_estimations
from testbed.experiment.measured import estimate_record
from testbed.identification.identify import Identification
from testbed.records.selection import telemetry_only
from testbed.report.measured import write_estimates_report


def record(name, *channels, **details):
    """A flight's record as another platform would have sent it: some channels only."""
    sent = telemetry_only(flight().flown.record)
    kept = {channel: sent.channels[channel] for channel in channels or ("body_rate", "gimbal_angle")}
    return replace(sent, channels=kept, details=replace(sent.details, name=name, source="measured", **details))


def page_of(folder, *records, failures=None):
    scenario, nominal = flight().scenario, flight().nominal
    estimations = {each.details.name: estimate_record(scenario, nominal, each) for each in records}
    if failures is not None:
        first = records[0].details.name
        estimations[first] = replace(estimations[first], failures=failures)
    path = folder / "report.html"
    write_estimates_report(
        path,
        scenario=scenario,
        nominal=nominal,
        identification=Identification(
            torque_drawn=False,
            records=records,
            estimations=estimations,
            combined=combine_estimations(estimations),
            notices=(),
            refused=(),
            nominal_theta=None,
            records_used=len(records),
        ),
        provenance=PROVENANCE,
        result={"schema": 1},
    )
    return ParsedPage(path.read_text(encoding="utf-8")), estimations


def test_one_record_with_two_channels(tmp_path):
    page, estimations = page_of(tmp_path, record("parabola 3"))
    assert page.ids == ["record-parabola-3", "provenance"]
    assert "one record" in page.said_with("verdict good")[0]
    assert [row[0] for row in page.tables[0]].count("True") == 0
    estimate = estimations["parabola 3"].by_name["output_error"]
    shown = np.array([cell.split(" ± ")[0] for cell in page.row("Output error, ± std")], dtype=float)
    np.testing.assert_allclose(shown, 1e3 * estimate.theta, atol=0.0051)
    change = np.array(page.row("change from nominal / std"), dtype=float)
    nominal = theta_of(flight().nominal.inertia)
    first = next(iter(estimations["parabola 3"].by_name.values()))
    np.testing.assert_allclose(change, (first.theta - nominal) / first.std, atol=0.0051)
    # estimates, gyro, encoder, and two for each of four estimators
    assert len(page.charts) == 11


def test_the_bound_lies_around_the_most_certain_estimate(tmp_path):
    page, estimations = page_of(tmp_path, record("p"))
    best = min(estimations["p"].by_name.values(), key=lambda estimate: np.trace(estimate.covariance))
    band = page.charts[0]["data"][0]
    assert band["name"] == "bound"
    reach = 1.96 * estimations["p"].bound_std
    expected = 1e3 * (best.theta - theta_of(flight().nominal.inertia) - reach)
    np.testing.assert_allclose(band["base"], expected, rtol=1e-9)


def test_several_records_are_shown_combined_first(tmp_path):
    page, _ = page_of(tmp_path, record("a"), record("b", usable_to=2.0))
    assert page.ids == ["all-records-combined", "record-a", "record-b", "provenance"]
    assert "2 records" in page.said_with("verdict good")[0]


def test_the_unusable_part_is_shaded(tmp_path):
    page, _ = page_of(tmp_path, record("a", usable_from=0.25, usable_to=2.0))
    spans = [[(shape["x0"], shape["x1"]) for shape in chart["layout"].get("shapes", [])] for chart in page.charts]
    assert spans[1] == spans[2] == [(0.0, 0.25), (2.0, 2.5)]
    assert spans[0] == spans[3] == []


def test_a_failure_names_its_record(tmp_path):
    page, _ = page_of(tmp_path, record("a"), failures={"iv": "J12 cannot be determined"})
    assert page.said_with("notice warn") == ["a: Instrumental variable gave no estimate: J12 cannot be determined"]
