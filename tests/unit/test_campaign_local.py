"""Worker processes: one that is killed loses nothing, one that always dies is given up, all end with the campaign."""

from __future__ import annotations

import multiprocessing
import os
import signal
from dataclasses import dataclass, replace

import pytest

from support.campaigns import plan_of, small_scenario
from testbed.campaign.local import LocalExecutor
from testbed.campaign.plan import Block, blocks_of
from testbed.campaign.rows import block_rows
from testbed.errors import InputError


@dataclass(frozen=True)
class Deadly:
    """A plan that ends the process which looks at its scenario."""

    @property
    def scenario(self):
        os._exit(9)


@dataclass(frozen=True)
class Broken:
    """A plan that no worker can fly."""

    @property
    def scenario(self):
        raise InputError("nothing to fly")


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    return plan_of(small_scenario(tmp_path_factory.mktemp("scenario")), 12)


def pairs(plan):
    (whole,) = blocks_of(plan)
    return [Block(index=first // 2, first=first, seeds=whole.seeds[first : first + 2]) for first in range(0, 12, 2)]


def test_a_killed_worker_loses_nothing_and_counts_nothing_twice(plan):
    notices: list[str] = []
    done = []
    finished = LocalExecutor(workers=2).finished(plan, pairs(plan), notices.append)
    for block in finished:
        done.append(block)
        if len(done) == 1:
            os.kill(multiprocessing.active_children()[0].pid, signal.SIGKILL)
    assert sorted(block.block.index for block in done) == [0, 1, 2, 3, 4, 5]
    assert len(notices) == 1
    assert "killed by SIGKILL" in notices[0]
    flown_again = int(notices[0].split("runs ")[1].split()[0]) // 2
    (again,) = [block for block in done if block.block.index == flown_again]
    assert again.rows == block_rows(plan, again.block)
    assert multiprocessing.active_children() == []


def test_a_block_that_kills_every_worker_is_given_up():
    notices: list[str] = []
    with pytest.raises(InputError, match=r"3 worker processes in a row died on runs 0 to 1 .*exit code 9"):
        list(LocalExecutor(workers=1).finished(Deadly(), [Block(index=0, first=0, seeds=(1, 2))], notices.append))
    assert len(notices) == 2
    assert multiprocessing.active_children() == []


def test_what_a_worker_raises_reaches_the_campaign():
    with pytest.raises(InputError, match="nothing to fly"):
        list(LocalExecutor(workers=1).finished(Broken(), [Block(index=0, first=0, seeds=(1, 2))], pytest.fail))


def test_giving_up_early_ends_the_workers(plan):
    finished = LocalExecutor(workers=2).finished(replace(plan, runs=12), pairs(plan), pytest.fail)
    next(finished)
    assert multiprocessing.active_children()
    finished.close()
    assert multiprocessing.active_children() == []
