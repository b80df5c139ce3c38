"""How measured records are compared with the nominal platform."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, model_validator

from testbed.scenario.maneuver import MIN_SAMPLES
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Rate


class Diagnosis(Section):
    """What `testbed diagnose` compares: whole runs as they were sampled, unless these say otherwise."""

    horizon_s: Annotated[float, Field(gt=0, le=60)] | None = None
    """Runs are cut into windows of this length, each with an initial rate of its own, because over whole runs the
    errors of torques that are known in part add up to any motion; omitted: whole runs. The first window of a run tells
    what slow actuators were doing when the second began, and is not compared."""
    sample_rate_hz: Rate | None = None
    """Gyro and actuators are averaged down to about this rate, for records with more samples than the motion needs;
    omitted: as they were sampled."""

    @model_validator(mode="after")
    def _consistent(self) -> Diagnosis:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if self.horizon_s is None or self.sample_rate_hz is None:
            return
        samples = self.horizon_s * self.sample_rate_hz
        if samples < MIN_SAMPLES:
            text = (
                f"{self.horizon_s} s at sample_rate_hz = {self.sample_rate_hz} holds {samples:.3g} samples; at least "
                f"{MIN_SAMPLES} are needed: use {MIN_SAMPLES / self.sample_rate_hz:.3g} s or a higher rate"
            )
            yield Conflict(key="horizon_s", text=text)
