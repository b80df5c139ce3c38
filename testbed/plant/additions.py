"""Parts and torques that effects add to a platform, as plain data, and how each is written into an MjSpec."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import mujoco

from testbed.arrays import Vector3


@dataclass(frozen=True, kw_only=True)
class RateTorque:
    """A torque -c ω on each body axis.

    Attributes:
        coefficient: c, shape (3,), N·m·s/rad.
    """

    coefficient: Vector3


Addition: TypeAlias = RateTorque
"""Everything that can be added."""


def add(spec: mujoco.MjSpec, additions: Iterable[Addition]) -> None:
    """Write additions into a platform's specification.

    Args:
        spec: with the parts that `require_parts` asks for.
        additions: in any order; names of what they add begin with `added_`.
    """
    for number, addition in enumerate(additions, start=1):
        _WRITERS[type(addition)](spec, addition, f"added_{number}")


def _add_rate_torque(spec: mujoco.MjSpec, addition: RateTorque, name: str) -> None:
    """One actuator per axis on a site of the bus: its speed is that axis' body rate, its bias the torque."""
    site = spec.body("bus").add_site(name=name)
    for axis, coefficient in enumerate(addition.coefficient):
        gear = [0.0] * 6
        gear[3 + axis] = 1.0
        spec.add_actuator(
            name=f"{name}_{'xyz'[axis]}",
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            target=site.name,
            gear=gear,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            gainprm=[0.0] * 10,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, 0.0, -float(coefficient)] + [0.0] * 7,
        )


_WRITERS: Mapping[type[Addition], Callable[[mujoco.MjSpec, Addition, str], None]] = {RateTorque: _add_rate_torque}
