"""From a scenario file to a Scenario, or to one message with everything that is wrong with the file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from testbed.errors import InputError
from testbed.scenario.body import BodyScenario
from testbed.scenario.maneuver import Maneuver
from testbed.scenario.places import Place, key_lines, line_of
from testbed.scenario.problems import Problem, problems_of
from testbed.scenario.scenario import FLIGHT, Scenario

_Form = TypeVar("_Form", bound=BodyScenario)


def read_scenario(path: Path) -> Scenario:
    """Read and check the scenario file of a platform that is flown.

    Args:
        path: a TOML file; the paths in it are relative to its folder.

    Raises:
        InputError: the file is missing, unreadable, not TOML, or not a scenario; all problems with their places; or it
            describes a platform without control moment gyros.
    """
    text = _read(path)
    tree = _parse(path, text)
    if _is_body(tree):
        raise InputError(
            f"{path}: has no [cluster]: a platform without control moment gyros is compared with its records by "
            "`testbed diagnose`; it is not flown, and nothing is designed for it or estimated from its flights"
        )
    return _validated(path, text, tree, Scenario)


def read_body_scenario(path: Path) -> BodyScenario:
    """Read and check the scenario file of a platform that is measured; it is a `Scenario` where it can be flown too.

    Args:
        path: a TOML file; the paths in it are relative to its folder.

    Raises:
        InputError: the file is missing, unreadable, not TOML, or not a scenario; all problems with their places.
    """
    text = _read(path)
    tree = _parse(path, text)
    return _validated(path, text, tree, BodyScenario if _is_body(tree) else Scenario)


def read_maneuver(path: Path) -> Maneuver:
    """Read and check a [maneuver] section that stands in a file of its own, as `testbed design` writes it.

    Raises:
        InputError: the file is missing, unreadable, not TOML, or no such section.
    """
    tree = _parse(path, _read(path)).get("maneuver", {})
    try:
        section: Maneuver = TypeAdapter(Maneuver).validate_python(tree, context={"folder": path.parent})
    except ValidationError as error:
        raise InputError(f"{path}: is no [maneuver] section ({error.error_count()} problems)") from None
    return section


def _is_body(tree: Mapping[str, Any]) -> bool:
    """Tell whether a file has all that a platform without control moment gyros needs, and nothing of a flight."""
    return {"platform", "gyro", "estimation"} <= tree.keys() and not FLIGHT & tree.keys()


def _validated(path: Path, text: str, tree: dict[str, Any], form: type[_Form]) -> _Form:
    try:
        return form.model_validate(tree, context={"folder": path.parent})
    except ValidationError as error:
        raise InputError(_message(path, text, problems_of(error, tree))) from None


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors begin a file with a byte order mark
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the path of a scenario file") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: is not TOML: {error}; mend the file there") from None


def _message(path: Path, text: str, problems: list[Problem]) -> str:
    lines = key_lines(text)
    count = f"{len(problems)} problem" + "s" * (len(problems) > 1)
    ordered = sorted(problems, key=lambda problem: line_of(problem.place, lines) or 0)
    return "\n".join([f"{path}: {count}", *(_entry(problem, lines) for problem in ordered)])


def _entry(problem: Problem, lines: Mapping[Place, int]) -> str:
    line = line_of(problem.place, lines)
    return f"  {problem}" if line is None else f"  line {line}, {problem}"
