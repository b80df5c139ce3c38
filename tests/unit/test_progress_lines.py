"""How far a work is, where standard error is no terminal: a line now and then, and none with --quiet."""

from __future__ import annotations

import pytest

from support.campaigns import small_scenario
from testbed.cli import console
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.mark.parametrize(
    ("period", "options", "lines"), [(0.0, (), True), (0.0, ("--quiet",), False), (1e9, (), False)]
)
def test_a_campaign_says_how_far_it_is(tmp_path, monkeypatch, capsys, period, options, lines):
    monkeypatch.setattr(console, "LINE_PERIOD", period)
    folder = tmp_path / "out"
    assert run("montecarlo", small_scenario(tmp_path), "--runs", 2, "--workers", 1, "--out", folder, *options) == 0
    printed = capsys.readouterr()
    assert ("Flying: 2 of 2\n" in printed.err) == lines
    assert bool(printed.out) == (not options)
