"""testbed list and testbed new: the shipped scenarios, and one of your own from one of them."""

from __future__ import annotations

import re
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table

from testbed.cli.console import further_command, say, show
from testbed.errors import InputError
from testbed.library.scenarios import located
from testbed.scenario.reader import body_scenario_of, read_body_scenario, scenario_file
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario, shipped_scenarios

_NAME = re.compile(r'^(\s*name\s*=\s*)"[^"\n]*"', re.MULTILINE)
_SCHEMA = re.compile(r"^#:schema ([^\s]+)\n", re.MULTILINE)


def list_scenarios() -> None:
    """Print the shipped scenarios and what each is for."""
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in ("scenario", "maneuver", "what it is for"):
        table.add_column(column, overflow="fold")
    for name in shipped_scenarios():
        scenario = read_body_scenario(shipped_scenario(name))
        maneuver = scenario.maneuver.kind if isinstance(scenario, Scenario) else "not flown"
        table.add_row(name, maneuver, scenario.description)
    show(table)
    say()
    say("testbed run NAME flies one; testbed new MINE --from NAME makes one of your own.")


def new_scenario(name: str, source: str) -> None:
    """Write NAME.toml, a copy of a scenario under another name, comments included.

    Raises:
        InputError: the file exists, the name cannot be a scenario's, or the source names files beside itself.
    """
    path = Path(f"{name.removesuffix('.toml')}.toml")
    file = scenario_file(located(source))
    scenario = body_scenario_of(file)
    beside = scenario.platform.model or getattr(getattr(scenario, "maneuver", None), "file", None)
    if beside is not None:
        raise InputError(f"{source}: names a file of its own, {beside}; copy both yourself")
    text = _NAME.sub(lambda found: f'{found[1]}"{path.stem}"', file.text, count=1)
    if (schema := _SCHEMA.search(text)) and not (path.parent / schema[1]).is_file():
        text = text.replace(schema[0], "")  # relative to the folder of the source: editors would look for it in vain
    try:
        with path.open("x", encoding="utf-8") as new:
            new.write(text)
        body_scenario_of(scenario_file(path))
    except FileExistsError:
        raise InputError(f"{path}: exists; choose another name") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another name or folder") from error
    except InputError:
        path.unlink()
        raise
    say(f"{path}: a copy of {file.path}; change it, then {further_command('check', path)}")
