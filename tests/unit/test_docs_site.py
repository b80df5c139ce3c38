"""The documentation builds as a site without a warning, asks no other host, and names all that the library offers."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

import testbed as tb
from support.processes import ROOT


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return the folder of the site, built as `make docs` builds it."""
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return folder


def test_its_pages_ask_no_other_host(site):
    pages = list(site.rglob("*.html"))
    assert pages
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=\"https?:", text), page
        assert 'class="mermaid"' not in text, "the theme would load mermaid from a CDN"


def test_the_reference_has_every_name_of_the_library(site):
    page = (site / "reference" / "api.html").read_text(encoding="utf-8")
    missing = [name for name in tb.__all__ if name != "__version__" and f'id="testbed.{name}"' not in page]
    assert not missing
    assert "Example</p>" not in page, "an example would be shown as a remark, its lines run together"


def test_a_parameter_shows_its_type_and_not_its_check(site):
    page = re.sub(r"<[^>]+>", "", (site / "reference" / "api.html").read_text(encoding="utf-8"))
    assert "seed: int | None = None" in page
    assert "folders: Sequence[str | Path]" in page
    assert "Seed | None" not in page
    assert "AnyPath" not in page


def test_files_of_the_repository_are_on_it(site):
    assert (site / "repository" / "scenarios" / "zero_g.toml").is_file()
    assert (site / "repository" / "examples" / "index.html").is_file()
    assert "../repository/scenarios/zero_g.toml" in (site / "reference" / "shipped-scenarios.html").read_text("utf-8")


@pytest.mark.parametrize("name", ["first_flight", "diagnose_and_extend"])
def test_a_notebook_is_a_page_with_its_outputs(site, name):
    page = (site / "tutorials" / "notebooks" / f"{name}.html").read_text(encoding="utf-8")
    assert '<div><iframe srcdoc="' in page
    assert f"images/notebooks/{name}.png" in page
    assert "data:image/png;base64," in page
    assert (site / "repository" / "examples" / f"{name}.ipynb").is_file()
    listed = (site / "tutorials" / "python.html").read_text(encoding="utf-8")
    assert f'href="notebooks/{name}.html"' in listed


def test_every_page_is_in_its_contents():
    contents = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = (path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md"))
    assert not [page for page in pages if not page.startswith("notes/") and f": {page}\n" not in contents]
