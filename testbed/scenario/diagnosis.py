"""How measured records are compared with the nominal platform."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Strict, model_validator

from testbed.scenario.maneuver import MIN_SAMPLES
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Distinct, Rate

Doubt: TypeAlias = Literal["body_rate", "unit", "inertia", "telemetry", "clocks", "rest", "stuck", "gap", "torque"]
"""Of the gate, that a person may know better."""


class Diagnosis(Section):
    """What `testbed diagnose` compares: whole runs as they were sampled, unless these say otherwise."""

    horizon_s: Annotated[float, Field(gt=0, le=60)] | None = None
    """Runs are cut into windows of this length, each with an initial rate of its own, because over whole runs the
    errors of torques that are known in part add up to any motion; omitted: whole runs. The first window of a run tells
    what slow actuators were doing when the second began, and is not compared."""
    sample_rate_hz: Rate | None = None
    """Gyro and actuators are averaged down to about this rate, for records with more samples than the motion needs;
    omitted: as they were sampled."""
    applied_torque: Literal["sampled", "held"] | None = None
    """What a sample of `applied_torque` says: the torque at its time, with straight lines between samples, or the
    torque from its time until the next sample, as a flight computer commands it; omitted: straight lines, unless the
    motion of whole runs shows its corners."""
    control_rate_hz: Rate | None = None
    """Rate at which the controller of the measured flights commands gimbals and wheels; omitted: that of [simulation].
    Of a platform that is only measured, commands are believed to change no faster than they are sampled, unless the
    wheels' speeds show that they do."""
    accept: Annotated[tuple[Doubt, ...], Strict(False), Distinct] = ()
    """Doubts in spite of which records are used, as somebody knows better than the gate that refuses them for one; its
    message names the word. `body_rate`: they turn faster than 20 rad/s; `unit`: the gyro seems to be in another unit;
    `inertia`: they show another inertia by far; `telemetry`: the actuators do not explain the motion; `clocks`: the
    clocks of gyro and actuators differ between runs; `rest`: the platform hardly turns; `stuck`: an axis reads one and
    the same rate; `gap`: no effect of the library comes near explaining them; `torque`: the applied torque is off at
    random from sample to sample. What is accepted stands among the notices."""
    null_prior_odds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Prior odds of no missing effect against all effects of the library together, and the odds that a first name
    needs: 1 where every other set of records has an effect, 19 where one in twenty has; omitted: 5."""
    unmodelled_prior_odds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Prior odds of each kind of torque that the library does not list against one effect of the library; omitted: 1,
    no less and no more usual."""

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
