"""The whole reproduction: claims that turn with the numbers, a page that shows them, one recording, whole folders."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from support.report_pages import ParsedPage
from support.reproductions import alignments, maneuver_statistics, reproduction, table1, table3
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError
from testbed.outputs.provenance import provenance_of_several
from testbed.outputs.reproduction_folder import write_reproduction
from testbed.report.reproduction.table1 import table1_section
from testbed.reproduction.alignment_claims import alignment_claims
from testbed.reproduction.box_plot import boxes_of
from testbed.reproduction.claims import table1_claims, table2_claims, whiteness_claim
from testbed.reproduction.gains import gains_of
from testbed.reproduction.judgement import claims_of
from testbed.reproduction.progress import silent
from testbed.reproduction.table2 import PAPER_STD
from testbed.reproduction.workers import Job, done_by_workers
from testbed.reproduction.zero_g_claims import zero_g_claims

FILES = {"reproduction.html", "reproduce.json", "recording.rrd", "provenance.json"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    rr.set_strict_mode(True)
    whole = reproduction()
    out = tmp_path_factory.mktemp("reproduction")
    origin = provenance_of_several("reproduction", [], "testbed reproduce", {"seed": "1"})
    write_reproduction(out, origin, whole, tuple(claims_of(whole)))
    rr.set_strict_mode(False)
    return out


@pytest.fixture(scope="module")
def page(folder):
    return ParsedPage((folder / "reproduction.html").read_text(encoding="utf-8"))


def verdicts(claims):
    return {claim.subject: claim.verdict for claim in claims}


def test_what_is_as_good_as_it_has_to_be_is_met():
    assert set(verdicts(claims_of(reproduction())).values()) == {"met"}


def test_every_claim_says_whether_it_was_fitted_or_could_fail():
    tests = {claim.subject: claim.test for claim in claims_of(reproduction())}
    assert all(text.startswith(("fitted", "could fail")) for text in tests.values())
    assert {subject for subject, text in tests.items() if text.startswith("fitted")} == {
        "Table 1, basic",
        "Table 2, basic",
        "Table 2, scaled",
        "Table 2, D-opt",
    }


@pytest.mark.parametrize(("factor", "verdict"), [(0.69, "missed"), (0.71, "met"), (1.29, "met"), (1.31, "missed")])
def test_scatter_is_held_within_30_percent_of_the_papers(factor, verdict):
    flown = maneuver_statistics("basic", factor * PAPER_STD["basic"])
    assert verdicts(table2_claims([flown]))["Table 2, basic"] == verdict


def test_few_runs_leave_a_miss_undecided():
    flown = maneuver_statistics("basic", 1.4 * PAPER_STD["basic"], runs=100)
    assert verdicts(table2_claims([flown]))["Table 2, basic"] == "undecided"


@pytest.mark.parametrize(("standard_errors", "verdict"), [(3.4, "met"), (3.6, "missed"), (-3.6, "missed")])
def test_bias_is_counted_in_standard_errors_from_what_theory_predicts(standard_errors, verdict):
    for predicted in (0.0, 3.0):
        mean_error = (standard_errors + predicted) / np.sqrt(1000)
        flown = maneuver_statistics("scaled", PAPER_STD["scaled"], mean_error=mean_error, predicted_bias=predicted)
        assert verdicts(table2_claims([flown]))["Table 2, bias"] == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.49, "met"), (0.51, "missed")])
def test_this_projects_maneuver_has_to_halve_every_deviation(share, verdict):
    shares = np.array([0.3, 0.3, 0.3, 0.3, 0.3, share])
    paper = maneuver_statistics("basic", PAPER_STD["basic"])
    own = maneuver_statistics("gimbal_weighted", shares * PAPER_STD["paper_d_optimal"])
    assert verdicts(table2_claims([paper, own]))["Better than the paper, own limits"] == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "met"), (1.01, "missed")])
def test_like_for_like_every_deviation_has_to_be_smaller_than_the_papers(share, verdict):
    shares = np.array([0.7, 0.7, 0.7, 0.7, 0.7, share])
    paper = maneuver_statistics("basic", PAPER_STD["basic"])
    own = maneuver_statistics("gimbal_slow", shares * PAPER_STD["paper_d_optimal"])
    assert verdicts(table2_claims([paper, own]))["Better than the paper, like for like"] == verdict


def test_a_basic_row_off_by_4_percent_is_missed():
    table = table1()
    off = replace(table.rows[0], trace_inverse=1.04 * table.rows[0].trace_inverse)
    assert verdicts(table1_claims(replace(table, rows=(off, *table.rows[1:]))))["Table 1, basic"] == "missed"


@pytest.mark.parametrize(("way", "subject"), [("paper", "Table 1, optimised"), ("hard", "Table 1, this project")])
def test_a_determinant_ten_times_too_small_is_missed(way, subject):
    table = table1()
    rows = [
        replace(row, determinant=row.determinant / 10.0) if (row.name, row.way) == ("D", way) else row
        for row in table.rows
    ]
    assert verdicts(table1_claims(replace(table, rows=tuple(rows))))[subject] == "missed"


def test_a_residual_of_a_colour_that_the_prefilter_does_not_make_is_missed():
    found = reproduction().whiteness
    coloured = replace(found, predicted_chi_square=np.full_like(found.predicted_chi_square, 30.0))
    assert whiteness_claim(coloured).verdict == "missed"
    assert "it is not white" in whiteness_claim(found).measured


@pytest.mark.parametrize(("usable", "verdict"), [(2.4, "met"), (4.4, "met"), (5.0, "missed")])
def test_flights_that_no_wall_ends_are_not_the_papers(usable, verdict):
    campaign = table3()
    time = np.array([0.0, usable])
    longest = replace(campaign.flights[0], telemetry=SimpleNamespace(gyro_time=time))
    flown = replace(campaign, flights=(*campaign.flights[1:], longest))
    assert verdicts(zero_g_claims(flown))["Table 3, flights"] == verdict


def test_an_estimate_four_deviations_off_is_missed():
    campaign = table3()
    combined = campaign.combined["iv"]
    off = replace(combined, theta=campaign.true_theta + 4.0 * combined.std)
    assert verdicts(zero_g_claims(replace(campaign, combined={"iv": off})))["Table 3"] == "missed"


def test_null_motion_has_to_halve_the_scatter():
    assert verdicts(alignment_claims(alignments(gain=1.9)))["Alignments, scatter"] == "missed"


def test_boxes_are_numpys_quartiles():
    errors = np.random.default_rng(2).standard_normal((201, 6))
    boxes = boxes_of(errors)
    np.testing.assert_allclose([box.lower_quartile for box in boxes], np.percentile(errors, 25, axis=0))
    np.testing.assert_allclose([box.median for box in boxes], np.median(errors, axis=0))
    assert all(box.highest <= box.upper_quartile + 1.5 * (box.upper_quartile - box.lower_quartile) for box in boxes)


def test_the_folder_holds_four_files(folder):
    assert {path.name for path in folder.iterdir()} == FILES
    content = json.loads((folder / "reproduce.json").read_text(encoding="utf-8"))
    assert content["table2"]["basic"]["steady_gyro"]["runs"] == 1000
    assert {claim["verdict"] for claim in content["claims"]} == {"met"}
    assert all(claim["test"] for claim in content["claims"])


def test_the_page_shows_the_papers_numbers_beside_ours(page):
    assert page.row("D-opt, st.d., paper") == ["0.38", "0.33", "0.35", "0.23", "0.24", "0.28"]
    assert page.row("D-opt, st.d., here")[0] == "0.38 ± 0.01"
    assert page.row("Estimate, paper") == ["20.04", "21.26", "25.75", "0.09", "0.04", "1.08"]
    assert page.row("D-opt, paper")[:4] == ["1.683", "2.434", "331.3", "1.568"]


def test_the_page_has_every_figure_and_fetches_nothing(page):
    titles = " ".join(text for _, text in page.tones)
    assert all(f"Figure {number}" in titles for number in range(1, 7))
    assert not [value for _, name, value in page.attributes if name in {"src", "href"} and "//" in value]


def test_the_recording_has_the_five_figures(folder):
    paths = RrdReader(folder / "recording.rrd").store().schema().entity_paths()
    assert {f"figure_{number}" for number in (1, 2, 3, 5, 6)} <= {path.split("/")[1] for path in paths}


def test_a_taken_folder_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "kept.txt").write_text("mine", encoding="utf-8")
    assert exit_code_of(lambda: app(["reproduce", "--out", str(tmp_path)])) == 2
    assert "not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["kept.txt"]


@pytest.mark.parametrize("runs", ["0", "1", "-3", "many"])
def test_fewer_than_two_runs_are_refused(tmp_path, runs):
    assert exit_code_of(lambda: app(["reproduce", "--runs", runs, "--out", str(tmp_path / "out")])) == 2
    assert not (tmp_path / "out").exists()


def test_workers_give_answers_in_the_order_of_their_jobs():
    started = []
    jobs = [Job(name=None, part="Squares", items=1, call=pow, arguments=(value, 2)) for value in range(4)]
    assert done_by_workers(jobs, 2, lambda part, items: started.append((part, items)) or (lambda _: None)) == [
        0,
        1,
        4,
        9,
    ]
    assert started == [("Squares", 4)]


def test_a_worker_that_dies_is_a_message():
    with pytest.raises(InputError, match="worker process died"):
        done_by_workers([Job(name=None, part="Death", items=1, call=os._exit, arguments=(1,))], 1, silent)


def test_the_gains_of_estimator_maneuver_and_rate_multiply_to_the_whole():
    slow, own = 0.8 * PAPER_STD["paper_d_optimal"], 0.4 * PAPER_STD["paper_d_optimal"]
    gains = gains_of(
        maneuver_statistics("paper_d_optimal", 1.1 * PAPER_STD["paper_d_optimal"]),
        maneuver_statistics("gimbal_slow", slow),
        maneuver_statistics("gimbal_weighted", own),
    )
    np.testing.assert_allclose(gains.maneuver, 0.8 / 1.1)
    np.testing.assert_allclose(gains.rate, 0.5)
    np.testing.assert_allclose(gains.total, own / PAPER_STD["paper_d_optimal"])


def test_the_page_separates_the_gains_and_marks_what_is_not_the_papers(page):
    assert page.row("the maneuver: gimbal space, slow over D-opt") == ["0.80"] * 6
    assert page.row("the rate: gimbal space over gimbal space, slow") == ["0.50"] * 6
    assert page.row("basic, bias in theory") == ["0.00"] * 6


def test_a_design_that_is_not_the_papers_row_is_marked():
    rows = table1().rows
    off = tuple(replace(row, determinant=27 * row.determinant) if row.way == "paper" else row for row in rows)
    marked = [
        cell.tone
        for section_row in table1_section(replace(table1(), rows=off), ()).blocks[1].rows
        for cell in section_row
        if cell.tone == "warn"
    ]
    assert len(marked) == 4  # the determinants of four designs
