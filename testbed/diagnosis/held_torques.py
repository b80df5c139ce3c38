"""Whether applied torques are held from sample to sample, where the scenario does not say: the motion's corners tell.

Torques that are held look late by half a sample to a model that joins samples by straight lines. What such a delay does
not explain are the corners in between.
"""

from __future__ import annotations

import numpy as np

from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError

_IN_DOUBT = 1.5
"""Root mean square of a residual, in sigma, from which on straight lines between torques are in doubt.

Source: chosen: a rig whose torque is held at 10 Hz has 23; below it there is little to lose."""
_SEEN = 30.0
"""Of χ², by which held torques have to explain more than lines that are late.

Source: chosen: five times what decides between hypotheses."""
_MOST = 0.5
"""Share of the residual of lines, beyond noise, that held torques may have: where both miss much, something else lacks.

Source: chosen: of that rig's it is a share of 0.014."""
HELD = (
    "applied_torque is held from each sample until the next, as the motion shows, and is taken so; [diagnosis] "
    'applied_torque = "sampled" would join the samples by straight lines'
)


def may_be_held(runs: Runs, joined: Fit) -> bool:
    """Return whether straight lines between samples of an applied torque leave so much that they may be wrong.

    Args:
        runs: with such lines; windows are none that tell.
        joined: the nominal model fitted to them.
    """
    return runs.trimmed and not runs.known_in_part and joined.root_mean_square > _IN_DOUBT


def are_held(runs: Runs, joined: Fit, held_runs: Runs, held: Fit) -> bool:
    """Return whether runs show that torques are held, rather than late by whatever it is.

    Args:
        runs: with straight lines between samples of the torque.
        joined: the nominal model fitted to them.
        held_runs: the same with a torque that is held from each sample until the next.
        held: likewise.
    """
    in_one_noise = float(np.mean(held_runs.sigma**2) / np.mean(runs.sigma**2))
    lines, steps = _least_of_late(runs, joined, 0.5), _least_of_late(held_runs, held, 0.0) * in_one_noise
    return steps < lines - _SEEN and steps - joined.freedom < _MOST * (lines - joined.freedom)


def _least_of_late(runs: Runs, fit: Fit, share: float) -> float:
    """Return χ² of torques that are late by a share of the time between their samples, or by what fits better.

    Behind a lag as well: actuators mostly have one, and either shape of a torque misses much without it.
    """
    interval = float(np.median([np.median(np.diff(run.actuator_time)) for run in runs.grid.runs]))
    skew, lag = (Hypothesis(effect=EFFECTS[each], component="actuators") for each in ("telemetry_skew", "actuator_lag"))
    late, starts = [skew, lag], [np.array([-share * interval]), np.array([lag.effect.parameters[0].typical])]
    try:
        return min(fitted(runs, late, fit.theta, starts, fit).chi_square, fit.chi_square)
    except InputError:  # the motion runs away
        return fit.chi_square
