"""Gaps in time, and the samples between them."""

import numpy as np
import pytest

from testbed.estimation.gaps import between_gaps, covered_by, gaps, stretches


def test_stretches_without_a_gap_and_of_four_samples_at_least():
    time = np.array([0, 1, 2, 3, 4, 10, 11, 12, 20, 21, 22, 23], dtype=float)
    assert stretches(time) == [slice(0, 5), slice(8, 12)]


@pytest.mark.parametrize(("periods", "lost"), [(1.5, {1, 2, 4}), (2.5, {2, 4})])
def test_a_gap_is_longer_than_so_many_usual_intervals(periods, lost):
    after = np.cumsum([1, 1, 2, 1, 3, 1, 1, 5, 1, 1, 1])  # one, two and four samples lost
    found = np.diff(after)[gaps(after.astype(float), periods)] - 1
    assert set(found.tolist()) == lost


def test_three_periods_of_a_tenth_of_a_second_are_three_tenths_whatever_their_rounding():
    """Of such gaps half were above 0.3 s in floating point, and cut a record."""
    time = np.delete(
        np.round(0.1 * np.arange(400), 6), [each for first in range(5, 390, 10) for each in (first, first + 1)]
    )
    assert not gaps(time, shortest=0.3).any()
    assert gaps(time).sum() == 39


def test_no_interval_within_the_shortest_gap_is_one():
    time = np.array([0.0, 0.01, 0.02, 0.06, 0.07, 0.20, 0.21])
    np.testing.assert_array_equal(np.flatnonzero(gaps(time, shortest=0.08)), [4])


def test_the_samples_between_gaps_are_all_samples_once():
    gap = np.array([False, True, True, False, False])
    assert between_gaps(gap) == [slice(0, 2), slice(2, 3), slice(3, 6)]
    assert between_gaps(gaps(np.zeros(1))) == [slice(0, 1)]


def test_instants_within_a_gap_are_not_covered_but_its_ends_are():
    samples = np.array([0.0, 1.0, 2.0, 6.0, 7.0, 8.0])
    np.testing.assert_array_equal(
        covered_by(np.array([-0.1, 0.5, 2.0, 4.0, 6.0, 7.9, 8.1]), samples), [0, 1, 1, 0, 1, 1, 0]
    )
