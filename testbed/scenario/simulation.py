"""The clock of a run."""

from __future__ import annotations

from testbed.scenario.section import Section
from testbed.scenario.values import NonNegative, Positive


class Simulation(Section):
    """Step, duration and rates; every period is a whole number of steps, and of the faster periods."""

    step_s: Positive
    """Integration step."""
    duration_s: Positive | None = None
    """Length of the run, a whole number of control periods; omitted: the maneuver and settle_s."""
    settle_s: NonNegative = 0.0
    """Time flown on after the maneuver, where duration_s is omitted."""
    control_rate_hz: Positive = 80.0
    """Ticks of the rate tracker and the gimbal servo."""
    telemetry_rate_hz: Positive = 16.0
    """Samples of the record."""
