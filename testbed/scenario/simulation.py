"""The clock of a run."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.quantities import LONGEST
from testbed.scenario.section import Section
from testbed.scenario.values import Duration, Rate, Step


class Simulation(Section):
    """Step, duration and rates; every period is a whole number of steps, and of the faster periods."""

    step_s: Step
    """Integration step."""
    duration_s: Duration | None = None
    """Length of the run, a whole number of control periods; omitted: the maneuver and settle_s."""
    settle_s: Annotated[float, Field(ge=0, le=LONGEST)] = 0.0
    """Time flown on after the maneuver, where duration_s is omitted."""
    control_rate_hz: Rate = 80.0
    """Ticks of the rate tracker and the gimbal servo."""
    telemetry_rate_hz: Rate = 16.0
    """Samples of the record."""
    engine: Literal["mujoco", "compiled", "auto"] = "auto"
    """What integrates the motion: MuJoCo; or the equations of motion of a platform with gyros and wheels as machine
    code, ten times as fast and within 1e-9 rad/s of it, which know no contacts, no dry friction and no torques by
    formulas; "auto": these for campaigns whose platform they cover, MuJoCo for single runs and all else."""
