"""Copies of flights: found by the gyro's samples, also where they were rounded or cut; other flights are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import records
from testbed.diagnosis.copies import Flights, is_copy
from testbed.errors import InputError

NOISE = 1e-3


def motion(count=400, seed=0, noise=NOISE):
    """Return a gyro's samples of one maneuver, with noise of their own."""
    time = 0.0625 * np.arange(count)
    true = np.stack([0.2 * np.sin(0.4 * time), 0.1 * np.sin(0.9 * time), 0.05 * time * np.exp(-0.1 * time)], axis=1)
    return true + noise * np.random.default_rng(seed).standard_normal(true.shape)


@pytest.mark.parametrize(
    "changed",
    [
        lambda rate: rate,
        lambda rate: rate.round(4),
        lambda rate: rate[21:],
        lambda rate: rate[:-150],
        lambda rate: rate[100:200].round(5),
        lambda rate: np.concatenate([rate[250:], motion(200, seed=9)]),
    ],
)
def test_a_copy_is_found_rounded_or_cut(changed):
    rate = motion()
    assert is_copy(changed(rate), rate)
    assert is_copy(rate, changed(rate))


@pytest.mark.parametrize("seed", range(1, 6))
def test_the_same_maneuver_flown_again_is_none(seed):
    assert not is_copy(motion(seed=seed), motion())
    assert not is_copy(motion(seed=seed, noise=3e-5), motion(noise=3e-5))


def test_a_coarse_gyro_at_rest_makes_no_copies():
    """Before and after two flights it reads zero, and steps of its resolution on them."""
    rest = np.zeros((150, 3))
    one, other = (np.concatenate([rest, motion(seed=seed).round(3), rest]) for seed in (1, 2))
    assert not is_copy(one, other)
    assert not is_copy(rest, np.zeros((300, 3)))


def test_an_axis_that_was_not_read_does_not_count():
    rate = motion()
    rate[:, 1] = np.nan
    assert is_copy(rate, motion())
    assert not is_copy(np.full_like(rate, np.nan), rate)


def test_flights_that_are_copies_are_refused_by_name():
    first, second = records(2)
    flights = Flights()
    flights.add(first)
    flights.add(second)
    rounded = {name: values.round(6) for name, values in first.channels.items()}
    again = replace(first, channels=rounded, details=replace(first.details, name="again"))
    with pytest.raises(InputError, match="again: holds the samples of run1: a copy is no further flight"):
        flights.add(again)
