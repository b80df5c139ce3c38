"""What the documents say is what the code does."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from testbed.cli.app import app
from testbed.records.schema import signals_table

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
DOCUMENTS = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


def test_the_readmes_signals_are_the_table_of_signals():
    between = README.split("<!-- signals: ")[1].split("-->", 1)[1].split("<!-- end of signals -->")[0]
    assert between.strip() == signals_table().strip()


def test_the_readme_lists_every_scenario_with_its_question():
    for path in (ROOT / "scenarios").glob("*.toml"):
        question = path.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        assert f"| [`{path.name}`](scenarios/{path.name}) | {question} |" in README


def test_the_readme_lists_every_command():
    named = set(re.findall(r"\| `testbed (\w+)", README))
    assert named == {command.name or command.callback.__name__ for command in app.registered_commands}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    for target in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8")):
        assert "://" in target or (path.parent / target).exists(), target


def test_the_constraints_pin_every_dependency_and_name_no_host():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    constraints = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in constraints.splitlines() if "==" in line}
    assert {re.split(r"[<>=!~ ]", name)[0].lower() for name in wanted} <= pinned
    assert "http" not in constraints
