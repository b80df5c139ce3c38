"""testbed conceal: a blind data set and its sealed answer, by the engine that a checkout has beside its tests."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from testbed.cli.console import say
from testbed.errors import InputError
from testbed.library.scenarios import located
from testbed.outputs.folder import reserved_folder
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

DATA, ANSWER = "data", "answer"
_ENGINE = "concealing"
_GYROS = 6
"""That its maneuvers are of."""


def conceal_effects(
    source: str, out: Path, effects: Sequence[str], seed: int, *, drawn: bool, size: float | None, runs: int | None
) -> None:
    """Fly a platform with hidden effects, write its records into out/data and the sealed answer into out/answer.

    Args:
        source: path of the nominal scenario, or name of a shipped one.
        out: new or empty folder.
        effects: ids of what to hide; none for a set without any effect.
        seed: of everything.
        drawn: whether to hide one effect, whichever is drawn.
        size: in smallest detectable sizes, or sigma where an effect is of no library; None for a drawn one.
        runs: how many; None for a drawn number.

    Raises:
        InputError: there is no engine here, the scenario or the folder cannot be used, an effect is not known, or no
            data set shows it as much as asked for.
    """
    path = located(source)
    scenario = read_scenario(path)
    kind = scenario.environment.kind
    if kind != "free":
        raise InputError(
            f'{path}: environment.kind is "{kind}", but the concealing engine flies platforms on which nothing acts; '
            "leave [environment] out"
        )
    if isinstance(scenario, Scenario) and (scenario.actuators or scenario.gyros.units != _GYROS):
        raise InputError(
            f"{path}: testbed conceal flies platforms with {_GYROS} control moment gyros in a pyramid, as [cluster] "
            "has them, and no other actuators; `python -m benchmarks.blind_wheels make` hides effects in craft with "
            "reaction wheels"
        )
    if drawn and effects:
        raise InputError("--random: draws the effect; leave --effect out, or --random")
    if size is not None and not (drawn or effects):
        raise InputError("--size: of which effect? name it with --effect, or have one drawn with --random")
    asked, files = _engine("asked"), _engine("files")
    rng = np.random.default_rng(seed)
    try:
        case = asked.asked_case(rng, path, (asked.any_effect(rng),) if drawn else effects, size, runs)
    except ValueError as error:
        raise InputError(str(error)) from error
    with reserved_folder(out, out.name) as folder:
        folder.deliver(lambda place: files.conceal(case, place / DATA, place / ANSWER))
    say(f"Data       {out / DATA}")
    say(f"Answer     {out / ANSWER}; its hash is in {out / DATA / _engine('sealing').SEAL}")


def _engine(module: str) -> ModuleType:
    """Return a module of the engine.

    Raises:
        InputError: this is no checkout, or the command was not given in its folder.
    """
    try:
        return import_module(f"{_ENGINE}.{module}")
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != _ENGINE:
            raise
        raise InputError(
            "conceal: the engine that makes blind data sets is not installed with the testbed, so that no "
            "diagnosis can use it; run this in a checkout, installed with `pip install -e .`"
        ) from error
