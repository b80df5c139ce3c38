"""Hooks of mkdocs: files of the repository that the documentation links to become files of the site.

The notebooks among the examples become pages of it, under tutorials/notebooks/.

On GitHub a link such as `../scenarios/zero_g.toml` leads out of docs/ into the repository. A site holds docs/ only:
these files are added to it under repository/, and the links lead there.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from notebook_pages import page_of

ROOT = Path(__file__).resolve().parents[1]
COPIES = "repository"
NOTEBOOKS = "tutorials/notebooks"
LINK = re.compile(r"(?<=\]\()([^)#:\s]+)(?=[)#])")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the notebooks, every file outside docs/ that a page links to, and those that these pages link to."""
    for notebook in sorted((ROOT / "examples").glob("*.ipynb")):
        files.append(File.generated(config, f"{NOTEBOOKS}/{notebook.stem}.md", content=page_of(notebook)))
    waiting = [(file.src_uri, file.content_string) for file in files.documentation_pages()]
    while waiting:
        page, text = waiting.pop()
        for target in _outside(page, text):
            copy = f"{COPIES}/{target}"
            if files.get_file_from_path(copy) is None and (ROOT / target).is_file():
                files.append(File.generated(config, copy, abs_src_path=str(ROOT / target)))
                if target.endswith(".md"):
                    waiting.append((copy, (ROOT / target).read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Lead links that leave docs/ to the copies in the site; a link to a folder becomes its name."""
    here = page.file.src_uri

    def led(match: re.Match[str]) -> str:
        held = _held(_target(here, match[1]), here)
        if files.get_file_from_path(held) is None:
            return match[1]
        return posixpath.relpath(held, posixpath.dirname(here))

    return LINK.sub(led, _without_folders(markdown, here))


def _held(target: str, here: str) -> str:
    """Return where the site holds a file of the repository: a notebook as its page, which itself links to the file."""
    as_page = f"{NOTEBOOKS}/{posixpath.basename(target)}".replace(".ipynb", ".md")
    if target.endswith(".ipynb") and here != as_page:
        return as_page
    return target.removeprefix("docs/") if target.startswith("docs/") else f"{COPIES}/{target}"


def _outside(page: str, text: str) -> Iterator[str]:
    for link in LINK.findall(text):
        target = _target(page, link)
        if not target.startswith(("docs/", "../")):
            yield target


def _target(page: str, link: str) -> str:
    """Return the place in the repository that a link of a page leads to."""
    source = page.removeprefix(f"{COPIES}/") if page.startswith(f"{COPIES}/") else f"docs/{page}"
    return posixpath.normpath(posixpath.join(posixpath.dirname(source), link))


def _without_folders(markdown: str, page: str) -> str:
    def named(match: re.Match[str]) -> str:
        return match[1] if (ROOT / _target(page, match[2])).is_dir() else match[0]

    return re.sub(r"\[([^\]]+)\]\(([^)#:\s]+)\)", named, markdown)
