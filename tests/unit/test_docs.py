"""What the documents say is what the code does."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from support.printed import require_printed
from testbed.cli.app import app
from testbed.records.schema import signals_table

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
REFERENCE = ROOT / "docs" / "reference"
DOCUMENTS = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "examples/README.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
LONGEST_README = 150


def test_the_published_signals_are_the_table_of_signals():
    page = (REFERENCE / "records.md").read_text(encoding="utf-8")
    between = page.split("<!-- signals: ")[1].split("-->", 1)[1].split("<!-- end of signals -->")[0]
    assert between.strip() == signals_table().strip()


def test_every_shipped_scenario_is_listed_with_its_question():
    page = (REFERENCE / "shipped-scenarios.md").read_text(encoding="utf-8")
    for path in (ROOT / "scenarios").glob("*.toml"):
        question = path.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        assert f"| [`{path.name}`](../../scenarios/{path.name}) | {question} |" in page


def test_every_command_is_listed():
    named = set(re.findall(r"\| `testbed ([\w-]+)", (REFERENCE / "commands.md").read_text(encoding="utf-8")))
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert named == commands | {group.typer_instance.info.name for group in app.registered_groups}


def test_the_readme_is_short():
    assert len(README.splitlines()) <= LONGEST_README


def test_the_readmes_python_prints_what_stands_below_it():
    """Numbers to a tenth of the standard deviations, in 1e-3 kg·m²."""
    require_printed(README, tolerance=3e-3)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    for target in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8")):
        assert "://" in target or (path.parent / target).exists(), target


def test_the_constraints_pin_every_dependency_and_name_no_host():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    constraints = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in constraints.splitlines() if "==" in line}
    assert {re.split(r"[<>=!~ \[]", name)[0].lower() for name in wanted} <= pinned
    assert "http" not in constraints
