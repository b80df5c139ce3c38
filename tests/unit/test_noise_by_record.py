"""A gyro that is noisier in some records than in others: said by record, and no noise that all of them share."""

from __future__ import annotations

from dataclasses import replace

import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.noise_by_record import noise_by_record
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import result_of
from testbed.dynamics.inertia import theta_of

NOISE = 4e-4


def diagnosis_of(levels, seed):
    """Runs that all state the same noise, which have so many times of it."""
    flights = {level: records(len(levels), noise=level * NOISE, seed=seed) for level in set(levels)}
    used = [flights[level][run] for run, level in enumerate(levels)]
    scenario, platform = nominal()
    stated = [replace(each, details=replace(each.details, gyro_noise=NOISE)) for each in used]
    data = data_set_of(stated, scenario, platform)
    *_, last = diagnosed(data.runs, data.heldout, {}, theta_of(platform.inertia))
    return last


def test_records_of_twice_the_noise_are_said_by_name():
    levels = [1.0, 2.0, 1.0, 2.0, 1.5]
    found = diagnosis_of(levels, 31)
    of_each = {f"run{number}": level for number, level in enumerate(levels, start=1)}
    assert noise_by_record(found).ratio == pytest.approx(of_each, rel=0.2)  # of 240 numbers they scatter by 8 %
    (notice,) = (each for each in model_notices(found) if "not as noisy in every record" in each)
    assert all(f"{name} " in notice for name in of_each)
    assert result_of(found, [], [])["noise"]["by_record"] == pytest.approx(of_each, rel=0.2)


@pytest.mark.parametrize("level", [1.0, 1.5])
def test_noise_that_all_records_share_is_not_said_to_differ(level):
    found = diagnosis_of([level] * 5, 32)
    assert not noise_by_record(found).differs
    assert not any("as noisy" in each for each in model_notices(found))
