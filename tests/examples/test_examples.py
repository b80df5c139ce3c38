"""Every example runs as a newcomer would run it, and draws something."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import matplotlib.image
import pytest

from support.notebooks import NOTEBOOKS
from support.printed import require_printed
from support.processes import ROOT

PROGRAMS = sorted((ROOT / "examples").glob("*.py"))
LONGEST = 40


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("examples")


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_an_example_runs_and_draws(program, folder):
    ran = subprocess.run(
        [sys.executable, program, "results"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout
    picture = matplotlib.image.imread(folder / "results" / f"{program.stem}.png")
    assert min(picture.shape[:2]) >= 400
    assert picture[..., :3].std() > 0.05


def test_the_guide_estimates_from_the_files_of_an_example(folder, monkeypatch):
    """Numbers to a tenth of the standard deviations, kg m²."""
    if not (folder / "results" / "flight_2.csv").is_file():
        pytest.skip("the example that writes them was not run")
    monkeypatch.chdir(folder / "results")
    require_printed((ROOT / "docs" / "how-to" / "own-data.md").read_text(encoding="utf-8"), tolerance=3e-6)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_an_example_is_short(program):
    assert len(program.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_the_list_of_examples_is_complete():
    page = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    listed = {link.rstrip("/") for link in re.findall(r"\| \[[^\]]+\]\(([^)]+)\)", page)}
    assert {path.name for path in [*PROGRAMS, *NOTEBOOKS]} | {"own_effect"} == listed
