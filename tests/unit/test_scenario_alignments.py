"""What does not go together with alignments in a scenario, and how they look in the terminal."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.cli.alignments import print_alignments
from testbed.errors import InputError
from testbed.estimation.alignment import AlignmentEstimate
from testbed.estimation.alignment_observability import COMMON_SCALE, Observability, OpenDirection, parameter_names
from testbed.experiment.aligning import Aligning
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario

TEXT = shipped_scenario("alignments").read_text(encoding="utf-8")


def complaint(tmp_path, old, new):
    assert old in TEXT
    path = tmp_path / "edited.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_scenario(path)
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ('metric = "momentum"', 'metric = "torque"', "maneuver.metric", 'use "momentum"'),
        ('criterion = "D"', 'criterion = "A"', "maneuver.criterion", 'use "D"'),
        (
            'initial_momentum = "estimated"',
            'initial_momentum = "zero"',
            "estimation.initial_momentum",
            "out of alignment",
        ),
        ("[-0.01, 0.003]", "[-0.01]", "truth.gimbal_axis_misalignment_rad[1]", "has 1 entries instead of 2"),
    ],
)
def test_what_does_not_go_together_is_refused(tmp_path, old, new, place, words):
    message = complaint(tmp_path, old, new)
    assert any(f"{place}: " in line and words in line for line in message.splitlines()), message


def test_misaligned_units_carry_momentum_at_rest(tmp_path):
    """Without the alignments' own rule the flight's momentum speaks for itself."""
    message = complaint(
        tmp_path,
        'initial_momentum = "estimated" # units out of alignment carry momentum at rest\nalignments = true',
        'initial_momentum = "zero"',
    )
    assert "the flight starts with momentum of " in message


def test_open_parameters_have_no_band(capsys):
    direction = np.eye(30)[28]
    estimate = AlignmentEstimate(
        parameters=np.linspace(-0.01, 0.02, 30),
        covariance=np.diag(np.full(30, 1e-6)),
        initial_momentum_B=np.zeros(3),
        observability=Observability(
            scale=np.ones(30),
            common_scale=OpenDirection(direction=np.ones(30), name=COMMON_SCALE, std=0.4),
            others=(OpenDirection(direction=direction, name=parameter_names(6)[28], std=float("inf")),),
            basis=np.eye(30),
        ),
        residual_sigma=0.001658,
        iterations=3,
    )
    true = np.r_[np.full(3, 0.022), np.zeros(27)]
    print_alignments(Aligning(estimate=estimate, failure="", true_parameters=true))
    printed = capsys.readouterr().out
    assert printed.count("open") == 1
    assert printed.count("±1.0") == 23 + 6  # alignments, and the inertia with three more digits
    assert "a common scale of J and all rotor momenta: ±40% at best" in printed
    assert "momentum scale of cmg5: not seen at all" in printed
