"""From a scenario file to a Scenario, or to one message with everything that is wrong with the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from testbed.errors import InputError
from testbed.files import TextFile, parsed_toml, read_text
from testbed.scenario.body import BodyScenario
from testbed.scenario.keys import Parsed
from testbed.scenario.maneuver import Maneuver
from testbed.scenario.places import Place, key_lines, line_of
from testbed.scenario.problems import Problem, problems_of
from testbed.scenario.scenario import NEEDED_TO_FLY, Scenario
from testbed.scenario.section import Section

LARGEST_SCENARIO = 4_000_000
"""Bytes. A maneuver of 1,000 control points for six gimbals takes 0.13 MB; a larger file is no scenario."""

_Form = TypeVar("_Form", bound=BodyScenario)


NOT_FLOWN = (
    f"has none of {', '.join(f'[{key}]' for key in sorted(NEEDED_TO_FLY))}: a platform that is only measured is "
    "estimated and compared with its records by `testbed estimate` and `testbed diagnose`; it is not flown, and "
    "nothing is designed for it"
)
"""What to say of a scenario without the sections of a flight where one is needed that can be flown."""


def scenario_file(path: Path) -> TextFile:
    """Read a scenario file, once: what a command stores and hashes of it is what it read.

    Raises:
        InputError: the file is missing, no file, too large, or no text.
    """
    return read_text(path, "a scenario file", LARGEST_SCENARIO)


def read_scenario(path: Path) -> Scenario:
    """Read and check the scenario file of a platform that is flown; as `scenario_of`."""
    return scenario_of(scenario_file(path))


def read_body_scenario(path: Path) -> BodyScenario:
    """Read and check the scenario file of a platform that is measured; as `body_scenario_of`."""
    return body_scenario_of(scenario_file(path))


def scenario_of(file: TextFile) -> Scenario:
    """Check a scenario of a platform that is flown.

    Args:
        file: TOML; the paths in it are relative to its folder.

    Raises:
        InputError: not TOML, or not a scenario; all problems with their places; or it describes a platform that is
            only measured.
    """
    tree = parsed_toml(file)
    if _is_body(tree):
        raise InputError(f"{file.path}: {NOT_FLOWN}")
    return _validated(file, tree, Scenario)


def body_scenario_of(file: TextFile) -> BodyScenario:
    """Check a scenario of a platform that is measured; it is a `Scenario` where it can be flown too.

    Args:
        file: TOML; the paths in it are relative to its folder.

    Raises:
        InputError: not TOML, or not a scenario; all problems with their places.
    """
    tree = parsed_toml(file)
    return _validated(file, tree, BodyScenario if _is_body(tree) else Scenario)


def read_maneuver(path: Path) -> Maneuver:
    """Read and check a [maneuver] section that stands in a file of its own, as `testbed design` writes it.

    Raises:
        InputError: the file is missing, unreadable, not TOML, or no such section.
    """
    tree = parsed_toml(read_text(path, "a [maneuver] section", LARGEST_SCENARIO)).get("maneuver", {})
    try:
        section: Maneuver = TypeAdapter(Maneuver).validate_python(tree, context={"folder": path.parent})
    except ValidationError as error:
        raise InputError(f"{path}: is no [maneuver] section ({error.error_count()} problems)") from None
    return section


def _is_body(tree: Mapping[str, Any]) -> bool:
    """Tell whether a file has all that a platform needs which is only measured, and nothing of a flight."""
    return {"platform", "gyro"} <= tree.keys() and not NEEDED_TO_FLY & tree.keys()


def _validated(file: TextFile, tree: dict[str, Any], form: type[_Form]) -> _Form:
    try:
        return form.model_validate(tree, context={"folder": file.path.parent}).read_from(file)
    except ValidationError as error:
        # A platform that is only measured is described by some of the keys of one that is flown.
        raise InputError(problem_listing(file, error, tree, Scenario)) from None


def problem_listing(file: TextFile, error: ValidationError, tree: Mapping[str, Any], form: type[Section]) -> str:
    """Return everything that is wrong with a file as one message; each problem with its line, unless keys were changed.

    Args:
        file: as it was read.
        error: pydantic's.
        tree: the file as parsed.
        form: the section that it should be.
    """
    problems = problems_of(error, Parsed(tree=tree, form=form))
    lines = {} if file.changes else key_lines(file.text)
    name = f"{file.path} with {file.changes}" if file.changes else f"{file.path}"
    count = f"{len(problems)} problem" + "s" * (len(problems) > 1)
    ordered = sorted(problems, key=lambda problem: line_of(problem.place, lines) or 0)
    return "\n".join([f"{name}: {count}", *(_entry(problem, lines) for problem in ordered)])


def _entry(problem: Problem, lines: Mapping[Place, int]) -> str:
    line = line_of(problem.place, lines)
    return f"  {problem}" if line is None else f"  line {line}, {problem}"
