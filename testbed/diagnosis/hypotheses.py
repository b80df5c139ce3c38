"""What is tested: every effect at every component that the data's channels allow; and what they do not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Placed
from testbed.effects.contract import CLUSTER, Channel, Effect
from testbed.prediction.motor_torques import has_torques


@dataclass(frozen=True, kw_only=True)
class Untestable:
    """An effect that these data cannot show.

    Attributes:
        effect: its id.
        needs: the channel that is missing, or the size that would have been seen.
    """

    effect: str
    needs: str


def hypotheses(runs: Runs, effects: Mapping[str, Effect]) -> tuple[list[Placed], list[Untestable]]:
    """Return what can be tested with the channels that the runs carry, and what cannot.

    Args:
        runs: to be explained.
        effects: by id.
    """
    present = channels_of(runs)
    testable, not_testable = [], []
    for effect in effects.values():
        missing = [need for need in effect.needs if need not in present]
        if missing:
            not_testable.append(Untestable(effect=effect.id, needs=" and ".join(missing)))
        else:
            testable += [Placed(effect=effect, component=component) for component in effect.components]
    return testable, not_testable


def channels_of(runs: Runs) -> set[Channel]:
    """Return the channels that the runs carry."""
    run = runs.grid.runs[0]
    present: set[Channel] = set()
    if run.gimbal_angle is not None:
        present.add("gimbal_angle")
    if run.rotor_momentum is not None:
        present.add("rotor_speed")
    if run.applied_torque is not None:
        present.add("applied_torque")
    if has_torques(runs.grid):
        present.add("gimbal_torque")
    if runs.grid.follows_commands:
        present.add("gimbal_rate_command")
    if present or run.cluster_momentum is not None:
        present.add("any_actuator")
    return present


def without(candidates: Iterable[Placed], chosen: Iterable[Placed]) -> list[Placed]:
    """Return the hypotheses that are not in the model yet, nor masked by what is."""
    present = tuple(chosen)
    taken = {each.key for each in present}
    return [each for each in candidates if each.key not in taken and masking(each, present) is None]


def masking(candidate: Placed, present: Iterable[Placed]) -> Placed | None:
    """Return the effect in the model beside which a hypothesis cannot be told; None where there is none."""
    return next((each for each in present if _masks(each, candidate)), None)


def _masks(present: Placed, candidate: Placed) -> bool:
    return candidate.effect.id in present.effect.masks and candidate.component in (present.component, CLUSTER)
