"""Which hypotheses, an effect at a component each, the records at hand can test, and why not the others."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from testbed.diagnosis.control_loop import NO_FEEDBACK, acts_steadily
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Hypothesis
from testbed.effects.contract import (
    AXES,
    CLUSTER,
    SHOWING_UNITS,
    TYPICAL_INERTIA,
    WHEELS,
    Channel,
    Effect,
    NamedEffect,
    components_in,
)
from testbed.prediction.environment import environment_kind
from testbed.prediction.grid import thruster_count, unit_count, wheel_count
from testbed.prediction.motor_torques import has_torques
from testbed.prediction.wheel_response import compared_wheels


@dataclass(frozen=True, kw_only=True)
class Untestable:
    """An effect that these data cannot show.

    Attributes:
        effect: its id.
        needs: the channel that is missing, or the size that would have been seen.
        component: where that is so; None of an effect that cannot be tested for anywhere.
        look_alikes: ids of effects that are confounded with it.
        keeps_share: whether it may be there all the same, so that what looks like it is as little certain as it is; not
            where the channels that are there would show it.
    """

    effect: str
    needs: str
    component: str | None = None
    look_alikes: tuple[str, ...] = ()
    keeps_share: bool = False

    @property
    def key(self) -> str:
        """Unique name among hypotheses, e.g. `actuator_lag:untested`."""
        return f"{self.effect}:untested"

    def looks_like(self, other: NamedEffect) -> bool:
        """Return whether another effect is confounded with it, by what either says."""
        return other.id in self.look_alikes or self.effect in other.look_alikes


def hypotheses(
    runs: Runs, effects: Mapping[str, Effect], moment: float = TYPICAL_INERTIA
) -> tuple[list[Hypothesis], list[Untestable]]:
    """Return what can be tested with the channels that the runs carry, and what cannot.

    Args:
        runs: to be explained.
        effects: by id; those of another environment are neither.
        moment: mean moment of inertia of the platform, kg·m².
    """
    present, environments = channels_of(runs), {"", environment_kind(runs.grid)}
    testable, not_testable = [], []
    longest = float(np.ptp(runs.grid.time, axis=1).max())
    in_loop = runs.known_in_part and runs.belief is not None and runs.belief.of_loop
    for effect in effects.values():
        if effect.id == "inertia" and (runs.belief is not None or runs.grid.runs[0].surroundings is not None):
            continue  # as an effect it would be one of no body, and in orbit one that gravity does not act on
        if effect.environment not in environments:
            continue
        missing = [need for need in effect.needs if need not in present]
        if missing:
            not_testable.append(
                Untestable(
                    effect=effect.id,
                    needs=" and ".join(missing),
                    look_alikes=effect.look_alikes,
                    keeps_share=_may_be_there(effect, present),
                )
            )
        elif in_loop and not acts_steadily(effect, runs.grid):
            not_testable.append(Untestable(effect=effect.id, needs=NO_FEEDBACK))
        else:
            unseen = _wheels_not_compared(runs) if _OF_MOTORS.intersection(effect.needs) else []
            for component in components_on(runs, effect):
                if component in unseen:
                    not_testable.append(Untestable(effect=effect.id, component=component, needs=_IMPULSES))
                else:
                    testable.append(Hypothesis(effect=effect, component=component, moment=moment, longest=longest))
    return testable, not_testable


def _may_be_there(effect: Effect, present: Collection[Channel]) -> bool:
    """Return whether an effect that cannot be tested for may act all the same.

    Not where a channel shows what it does, nor in units of a kind that the platform lacks: telemetry has those of
    another alone, or a torque on the body and no momentum.
    """
    of_units = set(SHOWING_UNITS).intersection(present)
    holds_momentum = "applied_torque" not in present or "cluster_momentum" in present
    needed = set(SHOWING_UNITS).intersection(effect.needs)
    lacks_units = not needed <= of_units if of_units or not holds_momentum else False
    return not lacks_units and set(effect.measured_by).isdisjoint(present)


_OF_MOTORS: frozenset[Channel] = frozenset({"wheel_torque", "wheel_torque_command"})
"""Channels that show what a wheel's motor gives, if its impulses are compared."""
INNER_CHANNELS: frozenset[Channel] = _OF_MOTORS | {"gimbal_rate_command", "gimbal_torque"}
"""Channels of what units do inside, which are compared beside the gyro's samples; `data.joined` leaves them out."""
_IMPULSES = "that wheel turning one way, below its limits"
"""What is missing of one wheel that stands still or always is where impulses are not compared, others turning."""


def _wheels_not_compared(runs: Runs) -> list[str]:
    """Return the wheels whose motors' impulses are not compared."""
    compared = compared_wheels(runs.grid)
    return [WHEELS[wheel] for wheel in range(wheel_count(runs.grid)) if wheel not in compared]


def components_on(runs: Runs, effect: NamedEffect) -> list[str]:
    """Return where an effect can sit: on the units that there are, and on axes about which some run turns."""
    turning = [axis for axis, live in zip(AXES, np.any(runs.live, axis=0).tolist(), strict=True) if live]
    every = components_in(effect, unit_count(runs.grid), wheel_count(runs.grid), thruster_count(runs.grid))
    whole = {"gyro"} if len(turning) == 1 and turning[0] in every else set()  # all of it is that one axis
    return [each for each in every if each not in whole and (each in turning or each not in AXES)]


def channels_of(runs: Runs) -> set[Channel]:
    """Return the channels that the runs carry."""
    run = runs.grid.runs[0]
    present: set[Channel] = set()
    if run.gimbals is not None:
        present.add("gimbal_angle")
        if run.gimbals.rotor_momentum is not None:
            present.add("rotor_speed")
    if run.applied_torque is not None:
        present.add("applied_torque")
    if runs.grid.thrust is not None:
        present.add("thrust")
    if has_torques(runs.grid):
        present.add("gimbal_torque")
    if runs.grid.follows_commands:
        present.add("gimbal_rate_command")
    if run.wheels is not None:
        present.add("wheel_speed")
    if runs.grid.wheel_noise is not None:
        present.add("wheel_torque")
        if runs.grid.wheel_noise.commanded:
            present.add("wheel_torque_command")
    if run.gimbals is None and run.wheels is None and run.cluster_momentum is not None:
        present.add("cluster_momentum")
    if run.applied_torque is not None or "cluster_momentum" in present:
        present.add("applied_torque_or_cluster_momentum")
    if present or run.cluster_momentum is not None:
        present.add("any_actuator")
    return present


def without(candidates: Iterable[Hypothesis], chosen: Iterable[Hypothesis]) -> list[Hypothesis]:
    """Return the hypotheses that are not in the model yet, nor confounded by what is; of events one more of each."""
    present, every = tuple(chosen), tuple(candidates)
    taken = {each.key for each in present}
    others = [each for each in every if each.key not in taken and confounding(each, present) is None]
    return [*others, *(_once_more(each, taken) for each in every if each.effect.instant and each.key in taken)]


def _once_more(event: Hypothesis, taken: Collection[str]) -> Hypothesis:
    """Return an event that happens another time, at the same component: the first that is not in the model."""
    again = (replace(event, component=f"{event.component}, {number}") for number in count(2))
    return next(each for each in again if each.key not in taken)


def confounding(candidate: Hypothesis, present: Iterable[Hypothesis]) -> Hypothesis | None:
    """Return the effect in the model that confounds a hypothesis; None where there is none."""
    return next((each for each in present if _confounds(each, candidate)), None)


def _confounds(present: Hypothesis, candidate: Hypothesis) -> bool:
    return candidate.effect.id in present.effect.confounds and candidate.component in (present.component, CLUSTER)
