"""The misfit beyond noise: nothing where nothing is missing, and all of what is missing where something is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.misfit import Misfit, explained
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.search import gap_of
from testbed.diagnosis.state import Gap
from testbed.dynamics.inertia import theta_of
from testbed.effects.gyro_latency import GyroLatency
from testbed.report.diagnosis.misfit import gimbals_words, misfit_change_words, misfit_words, shows_in_gyro

SETS = 24
DELAY = 0.01
LATE = Hypothesis(effect=GyroLatency(), component="gyro")


def data_of(**options):
    scenario, platform = nominal()
    return data_set_of(records(3, seconds=2.0, **options), scenario, platform)


def gap_with(data, placed=(), starts=()):
    fit = fitted(data.runs, placed, theta_of(nominal_platform(nominal()[0]).inertia), starts)
    return fit, gap_of(data.runs, fit, data.heldout)


@pytest.fixture(scope="module")
def null():
    """Gaps of data sets in which nothing is missing."""
    return [gap_with(data_of(seed=100 + number))[1] for number in range(SETS)]


@pytest.mark.parametrize("role", ["misfit", "heldout_misfit"])
def test_without_an_effect_the_excess_has_the_mean_and_the_scatter_that_are_stated(null, role):
    misfits = [getattr(gap, role) for gap in null]
    standing = [(each.chi_square - each.expected) / np.sqrt(each.variance) for each in misfits]
    assert abs(np.mean(standing)) < 3.0 / np.sqrt(SETS)  # by chance in 1 of 370 sets of seeds
    assert 0.6 < np.std(standing) < 1.5  # about 3 standard errors either way
    assert sum(each.beyond_noise for each in misfits) <= 2  # at 1 % each, more in 1 of 500
    assert all(each.beyond_noise == (each.sigma > each.noise_limit) for each in misfits)


def test_a_late_gyro_is_all_of_the_misfit_and_as_large_as_what_its_model_takes_off_chi_square():
    data = data_of(hooks=[LATE.hooks], values=[np.array([DELAY])])
    without, before = gap_with(data)
    with_it, after = gap_with(data, [LATE], [np.array([0.5 * DELAY])])
    gain = without.chi_square - with_it.chi_square
    assert before.misfit.excess == pytest.approx(gain, rel=0.05)
    assert before.misfit.sigma > 3.0 * before.misfit.noise_limit
    for share in (explained(before.misfit, after.misfit), explained(before.heldout_misfit, after.heldout_misfit)):
        assert share.share > 1.0 - 4.0 * share.std
        assert share.std < 0.1
    assert "% explained) on those held out" in misfit_change_words(before, after)


def test_where_the_misfit_is_no_more_than_noise_no_share_of_it_is_reported(null):
    quiet = next(gap for gap in null if not shows_in_gyro(gap))
    assert explained(quiet.misfit, quiet.misfit) is None
    assert "explained" not in misfit_change_words(quiet, quiet)
    assert "as much as noise alone makes" in misfit_words(quiet)


def test_a_noise_that_is_only_estimated_makes_a_larger_misfit_by_chance():
    known = Misfit(chi_square=150.0, expected=100.0, variance=200.0, noise_freedom=np.inf, gimbals=0.0)
    assert known.p_value < 0.001
    assert replace(known, noise_freedom=20.0).p_value > 0.05


def test_what_only_the_gimbals_show_is_reported_of_their_channels(null):
    quiet = next(gap for gap in null if not shows_in_gyro(gap))
    before, after = (replace(quiet, misfit=replace(quiet.misfit, gimbals=chi_square)) for chi_square in (900.0, 400.0))
    assert gimbals_words(before, after) == "χ² of the actuators' own channels: 900 -> 400"
    assert gimbals_words(quiet, quiet) == ""


def test_a_model_whose_motion_runs_away_has_no_misfit():
    away = Gap(fit=np.inf, heldout=np.nan, misfit=None, heldout_misfit=None)
    assert explained(away.misfit, away.misfit) is None
    assert not shows_in_gyro(away)
