"""A real Dask cluster on loopback: a worker is killed midway, and nothing is lost or counted twice."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest

from support.campaigns import ROOT, plan_of, small_scenario
from testbed.campaign.dask_executor import DaskExecutor
from testbed.campaign.manifest import deciding_versions
from testbed.campaign.plan import Block, blocks_of
from testbed.campaign.rows import block_rows
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError

ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
PATIENCE = 60.0


def started(module, *arguments):
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    return subprocess.Popen(command, env=ONE_THREAD, stderr=subprocess.PIPE, text=True)


def first_match(process, pattern):
    for line in process.stderr:
        if found := re.search(pattern, line):
            return found
    raise AssertionError(f"the process ended without saying {pattern}")


@pytest.fixture(scope="module")
def scheduler():
    process = started("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-jupyter")
    try:
        yield first_match(process, r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)")[1]
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def workers(scheduler):
    options = ["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    processes = [started("dask_worker", scheduler, *options) for _ in range(2)]
    try:
        for process in processes:
            first_match(process, "Registered to")
        yield processes
    finally:
        for process in processes:
            process.kill()
            process.communicate()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return small_scenario(tmp_path_factory.mktemp("scenario"))


def test_a_scheduler_without_workers(scheduler, path, tmp_path, capsys):
    assert montecarlo(path, tmp_path, scheduler) == 2
    assert "no workers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_killed_worker_loses_nothing_and_counts_nothing_twice(scheduler, workers, path):
    plan = plan_of(path, 12)
    (whole,) = blocks_of(plan)
    blocks = [Block(index=first // 2, first=first, seeds=whole.seeds[first : first + 2]) for first in range(0, 12, 2)]
    done = []
    for block in DaskExecutor(address=scheduler).finished(plan, blocks, pytest.fail):
        done.append(block)
        if len(done) == 2:
            workers[0].send_signal(signal.SIGKILL)
            assert workers[0].wait(PATIENCE) == -signal.SIGKILL
    assert sorted(block.block.index for block in done) == list(range(6))
    here = {row["run"]: row for row in block_rows(plan, whole)}
    assert all(row == here[row["run"]] for block in done for row in block.rows)


@pytest.mark.usefixtures("workers")
def test_a_worker_with_other_versions_is_refused(scheduler, path, monkeypatch):
    plan = plan_of(path, 2)
    versions = deciding_versions() | {"mujoco": "3.0.0"}
    monkeypatch.setattr("testbed.campaign.dask_executor.deciding_versions", lambda _: versions)
    with pytest.raises(InputError, match=r"the worker on .* has mujoco 4.* instead of 3.0.0; install"):
        list(DaskExecutor(address=scheduler).finished(plan, list(blocks_of(plan)), pytest.fail))


def montecarlo(path, folder, address):
    arguments = ["montecarlo", path, "--runs", 2, "--out", folder / "out", "--scheduler", address]
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


def test_a_dead_address_is_reported_within_ten_seconds(path, tmp_path, capsys):
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    began = time.monotonic()
    assert montecarlo(path, tmp_path, address) == 2
    assert time.monotonic() - began < 10.0
    assert f"{address}: no Dask scheduler answers there" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_silent_server_is_no_scheduler(path, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("testbed.campaign.dask_executor._PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        assert montecarlo(path, tmp_path, f"tcp://127.0.0.1:{server.getsockname()[1]}") == 2
    assert "no Dask scheduler answers there" in capsys.readouterr().err


def test_no_address_at_all(path, tmp_path, capsys):
    assert montecarlo(path, tmp_path, "nonsense") == 2
    assert "tcp://" in capsys.readouterr().err
