"""Scenarios by path or by the name of a shipped one, with values changed by key."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from testbed.errors import InfeasibleDesignError, InputError, UnphysicalPlatformError
from testbed.files import DEEPEST, TextFile, parsed_toml, readable
from testbed.library.arguments import AnyPath, Overrides, checked
from testbed.scenario.body import BodyScenario
from testbed.scenario.reader import NOT_FLOWN, body_scenario_of, scenario_file
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario, shipped_scenarios


@checked
def read_scenario(source: AnyPath, overrides: Overrides | None = None) -> BodyScenario:
    """Read and check a scenario.

    Args:
        source: path of a TOML file, or the name of a shipped scenario, such as `zero_g`.
        overrides: values by dotted key, such as `{"gyro.noise_rad_s": 0.01}`; they are checked like the file's own.

    Returns:
        A `Scenario`, which can be flown; without the sections of a flight a `BodyScenario`, whose records can be
        estimated from and diagnosed.

    Raises:
        InputError: there is no such file, it is not a scenario, or an override fits none of its keys.

    Example:
        >>> import testbed as tb
        >>> scenario = tb.read_scenario("zero_g", {"gyro.noise_rad_s": 0.01})
        >>> scenario.gyro.noise_rad_s
        0.01
    """
    file = scenario_file(located(source))
    return body_scenario_of(overridden(file, overrides) if overrides else file)


def located(source: str | Path) -> Path:
    """Return the path of a scenario that is given by path, or by the name of a shipped one.

    Raises:
        InputError: there is neither.
    """
    path, names = Path(source), shipped_scenarios()
    if str(source) in names and not path.is_file():
        return shipped_scenario(str(source))
    if path.suffix == ".toml" or _is_there(path):
        return path
    shipped = ", ".join(names)
    raise InputError(f"{source}: there is no such file, nor a shipped scenario of that name; these are {shipped}")


def _is_there(path: Path) -> bool:
    """Tell whether there is a file; of a name that no file can have, reading it says why."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return True


def overridden(file: TextFile, overrides: Mapping[str, object]) -> TextFile:
    """Return a scenario's file as if it had other values; its comments are lost.

    Args:
        file: of the scenario.
        overrides: values by dotted key; arrays of NumPy count as lists.

    Raises:
        InputError: the file is not TOML, a key leads through something that is no table, or TOML has no such value.
    """
    tree = parsed_toml(file)
    plain = {key: _as_toml(key, value) for key, value in overrides.items()}
    for key, value in plain.items():
        _set(tree, key, value, file.path)
    said = ", ".join(f"{key} = {value!r}" for key, value in plain.items())
    text = f"# {file.path.name} with {said}\n{tomli_w.dumps(tree)}"
    return TextFile(path=file.path, content=text.encode("utf-8"), text=text, changes=said)


def _as_toml(key: str, value: object) -> object:
    plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    try:
        tomli_w.dumps({"value": plain})
    except TypeError:
        raise InputError(
            f"{key} = {plain!r}: give numbers, texts, true or false, lists or tables of these; leave a key out for its "
            "default"
        ) from None
    return plain


_BARE_NUMBER = re.compile(r"[+-]?(\d+\.|\.\d+)([eE][+-]?\d+)?")


def override_of(assignment: str) -> tuple[str, object]:
    """Return key and value of an override as the command line has it, KEY=VALUE, the value as in TOML.

    What is no TOML value, such as a word without quotes, is taken for a text; numbers may begin or end with the point.

    Raises:
        InputError: there is no key, or no `=`.
    """
    key, equals, value = readable(assignment).partition("=")
    if not equals or not key.strip():
        raise InputError(f"--set {assignment}: give KEY=VALUE, such as gyro.noise_rad_s=0.01")
    text = f"value = {value}"
    try:
        tree = parsed_toml(TextFile(path=Path("--set"), content=text.encode("utf-8"), text=text))
    except InputError:
        return key.strip(), float(value) if _BARE_NUMBER.fullmatch(value.strip()) else value.strip()
    return key.strip(), tree["value"] if len(tree) == 1 else value.strip()


def overrides_of(assignments: Sequence[str]) -> dict[str, object]:
    """Return overrides as the command line has them; as `override_of`."""
    pairs = [override_of(assignment) for assignment in assignments]
    overrides = dict(pairs)
    if len(overrides) < len(pairs):
        twice = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise InputError(f"--set {twice}: is given more than once; give it one value")
    return overrides


@contextmanager
def naming(scenario: BodyScenario) -> Iterator[None]:
    """Put the path of a scenario's file before what is reported of its platform or its maneuver."""
    path = scenario.file.path
    try:
        yield
    except UnphysicalPlatformError as error:
        raise InputError(f"{path}: {error}") from error
    except InfeasibleDesignError as error:
        raise InputError(f"{path}: [maneuver]: {error}") from error


def require_flyable(scenario: BodyScenario) -> Scenario:
    """Return a scenario that can be flown.

    Raises:
        InputError: it is of a platform that is only measured.
    """
    if isinstance(scenario, Scenario):
        return scenario
    raise InputError(f"{scenario.file.path}: {NOT_FLOWN}")


def _set(tree: dict[str, Any], key: str, value: object, path: Path) -> None:
    *tables, last = key.split(".")
    if len(tables) >= DEEPEST:
        raise InputError(f"{path}: {key[:40]}...: no key of a scenario has {len(tables) + 1} parts")
    for table in tables:
        tree = tree.setdefault(table, {})
        if not isinstance(tree, dict):
            raise InputError(f"{path}: {key} cannot be set: {table} is no table")
    tree[last] = value
