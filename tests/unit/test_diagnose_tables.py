"""What a diagnosis shows in a terminal of 80 columns: no name is broken, each size once with its unit."""

from __future__ import annotations

import re

import pytest
from rich.console import Console

import testbed.cli.console
from support.diagnosed_records import nominal, records
from testbed.cli.console import entry, line
from testbed.cli.diagnose_tables import detectable_table
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.sizes import lacking

TESTED = ("viscous_drag", "quadratic_drag", "gyro_misalignment", "slosh", "actuator_lag", "gimbal_viscous_friction")
TESTED += ("flexible_appendage", "rotor_speed")


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    """Of three runs without effects."""
    scenario, platform = nominal()
    data = data_set_of(records(3), scenario, platform)
    effects = {name: EFFECTS[name] for name in TESTED}
    *_, diagnosis = diagnosed(data.runs, data.heldout, effects, theta_of(platform.inertia))
    return diagnosis


@pytest.fixture(scope="module")
def shown(diagnosis) -> list[str]:
    """Lines of the table of detectable sizes."""
    terminal = Console(width=80)
    with terminal.capture() as captured:
        terminal.print(detectable_table(diagnosis))
    return captured.get().splitlines()


def test_no_name_is_broken_and_no_line_is_too_long(shown):
    assert max(map(len, shown)) <= 80
    words = {word.strip(",") for line in shown for word in line.split()}
    assert {"viscous_drag", "quadratic_drag", "gyro_misalignment"} <= words


def test_a_size_that_all_axes_share_is_shown_once(shown):
    (drag,) = [" ".join(line.split()) for line in shown if line.startswith("viscous_drag")]
    assert re.search(r"\d N·m·s/rad", drag)
    following = shown[[line.startswith("viscous_drag") for line in shown].index(True) + 1]
    assert "N·m·s/rad" not in following
    assert "each" in f"{drag} {following}"


def test_what_scales_with_an_effect_is_its_size(shown):
    (slosh,) = [line for line in shown if line.startswith("slosh")]
    assert "kg" in slosh
    assert "Hz" not in slosh


def test_what_cannot_be_tested_stands_by_what_it_needs(diagnosis, shown):
    assert lacking(diagnosis) == {
        "applied_torque or cluster_momentum": ["actuator_lag"],
        "gimbal_torque": ["gimbal_viscous_friction"],
    }
    assert not any(line.startswith(("actuator_lag", "gimbal_viscous_friction")) for line in shown)


def test_every_size_has_the_name_of_its_parameter(shown):
    """The three numbers of a flexible appendage's axis stood there without one; 0.00268 of what, for a rotor?"""
    for effect, words in (
        ("viscous_drag", "coefficient"),
        ("gyro_misalignment", "yz, xz, xy"),
        ("slosh", "mass"),
        ("flexible_appendage", "inertia"),
        ("rotor_speed", "relative error"),
    ):
        (line,) = [line for line in shown if line.startswith(effect)]
        assert line.removeprefix(effect).strip().startswith(words)
    (appendage,) = [line for line in shown if line.startswith("flexible_appendage")]
    assert "," not in appendage


def test_a_row_takes_one_line(shown):
    assert len([line for line in shown if line.startswith(TESTED)]) == len(shown) - 3  # title, heads, rule


def test_a_text_breaks_between_words_on_a_terminal_only(monkeypatch, capsys):
    for terminal, lines in ((True, ["Verdict    one two", "           three"]), (False, ["Verdict    one two three"])):
        console = Console(width=20, force_terminal=terminal, no_color=True, highlight=False, soft_wrap=True)
        monkeypatch.setattr(testbed.cli.console, "console", console)
        entry("Verdict", "one two three")
        line("Verdict    one two three")
        assert capsys.readouterr().out.splitlines() == 2 * lines
