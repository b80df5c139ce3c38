"""What steps the flights of a scenario: MuJoCo, or the compiled equations of motion of a gyrostat."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.assembly.platform import true_platform
from testbed.errors import InputError
from testbed.plant.gyrostat import uncovered
from testbed.plant.plant import Engine, Model
from testbed.scenario.scenario import Scenario
from testbed.signals import AXES


def engine_of(scenario: Scenario, model: Model | None = None, *, many: bool) -> Engine:
    """Return what steps the platforms of a scenario's flights.

    Args:
        scenario: with its [simulation] engine.
        model: of what flies; compiled here where it is looked at and None.
        many: whether it is for many flights, as of a campaign, which "auto" flies by the compiled equations.

    Raises:
        InputError: the compiled equations are asked for, and do not cover the platform; the message says what of it; or
            a rig that turns about some axes only, which no engine holds.
    """
    if scenario.platform.axes is not None and set(scenario.platform.axes) < set(AXES):
        raise InputError(
            f"{scenario.name}: [platform] axes = {list(scenario.platform.axes)} is of a rig whose records are "
            "measured: what flies here turns about all three axes; take axes out to fly it"
        )
    wanted = scenario.simulation.engine
    if wanted == "mujoco" or (wanted == "auto" and not many):
        return "mujoco"
    reasons = list(_uncovered(scenario, true_platform(scenario).model if model is None else model))
    if wanted == "compiled" and reasons:
        raise InputError(
            f'{scenario.name}: simulation.engine is "compiled", but the platform has {"; ".join(reasons)}, which these '
            'equations of motion do not; write "auto" or "mujoco", which fly it in MuJoCo'
        )
    return "mujoco" if reasons else "compiled"


def with_engine(scenario: Scenario, engine: Engine) -> Scenario:
    """Return a scenario that one engine flies, single runs and campaigns alike."""
    return scenario.model_copy(update={"simulation": scenario.simulation.model_copy(update={"engine": engine})})


def require_comparable(scenario: Scenario, compared: int, runs: int) -> None:
    """Refuse a comparison of engines that cannot be made.

    Args:
        scenario: to fly.
        compared: how many runs both engines are to fly.
        runs: how many the campaign has.

    Raises:
        InputError: it has fewer, or a platform that the compiled equations do not cover; names what of it.
    """
    if compared > runs:
        raise InputError(
            f"check (--check): {compared:,} runs in both engines, but the campaign has {runs:,}; give no more"
        )
    if reasons := list(_uncovered(scenario, true_platform(scenario).model)):
        raise InputError(
            f"{scenario.name}: a check (--check) flies runs in MuJoCo and by the compiled equations, but the platform "
            f"has {'; '.join(reasons)}, which these do not cover; leave the check out"
        )


def _uncovered(scenario: Scenario, model: Model) -> Iterator[str]:
    yield from uncovered(model)
    if scenario.truth.torque:
        yield "torques by formulas (truth.torque)"
