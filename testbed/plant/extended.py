"""A platform with additions, as a file of its own."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from testbed.errors import InputError
from testbed.plant.additions import Addition, add
from testbed.plant.build import shipped_model, specification
from testbed.plant.properties import PlatformProperties


def extended_platform(properties: PlatformProperties, path: Path | None, additions: Iterable[Addition]) -> str:
    """Return the MJCF of a platform with a scenario's numbers and additions written into it; numbers have six digits.

    Args:
        properties: the numbers; None fields keep the MJCF's.
        path: the MJCF; the shipped platform where absent.
        additions: torques and parts.

    Raises:
        InputError: as `testbed.plant.build.build`, or the platform cannot carry an addition.
    """
    source = shipped_model() if path is None else path
    spec = specification(properties, source)
    try:
        add(spec, additions)  # which compiles what those before it left
        spec.compile()
    except ValueError as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"{source}: with what was added it is no platform that could fly: a part that was found has a mass or an "
            f"inertia that no body has (MuJoCo: {reason})"
        ) from error
    return str(spec.to_xml())
