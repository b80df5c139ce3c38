"""The notebooks among the examples: executed as a reader would, and stored with outputs that fit into a repository.

`python -m support.notebooks` executes them all and stores what their cells show, from the root of the repository.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode
from traitlets.config import Config

from support.processes import ROOT

NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
WIDGET = "application/vnd.jupyter.widget-view+json"
LONGEST = 300
"""s; ten times as much as any takes."""


def executed(path: Path, folder: Path) -> NotebookNode:
    """Return a notebook with all cells executed in a new kernel.

    Args:
        path: of the notebook.
        folder: in which the kernel works.
    """
    notebook = nbformat.read(path, as_version=4)
    place = {"metadata": {"path": str(folder)}}
    with tempfile.TemporaryDirectory() as sockets:
        private = Config({"KernelManager": {"transport": "ipc", "ip": f"{sockets}/kernel"}})  # listens on no port
        client = NotebookClient(
            notebook, timeout=LONGEST, resources=place, store_widget_state=False, coalesce_streams=True, config=private
        )
        return client.execute()


def stored(notebook: NotebookNode) -> NotebookNode:
    """Return a notebook as it is stored: without what only its kernel could show, and places on this machine."""
    notebook.metadata = {"kernelspec": notebook.metadata["kernelspec"], "language_info": {"name": "python"}}
    for cell in notebook.cells:
        cell.metadata = {}
        for output in cell.get("outputs", ()):
            output.get("metadata", {}).clear()
            shown = output.get("data", {})
            shown.pop(WIDGET, None)
            if "text/html" in shown:
                shown["text/html"] = shown["text/html"].replace(f"{ROOT}/", "")
            if "text/plain" in shown:
                shown["text/plain"] = without_addresses(shown["text/plain"])
    return notebook


def texts_of(notebook: NotebookNode) -> Iterator[str]:
    """Yield what the cells show as text, in order."""
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            yield without_addresses(text)


def without_addresses(text: str) -> str:
    """Return a text in which objects do not say where in memory they are."""
    return re.sub(r" at 0x[0-9a-f]+", "", text)


def main() -> None:
    """Execute and store all notebooks."""
    for path in NOTEBOOKS:
        with tempfile.TemporaryDirectory() as folder:
            nbformat.write(stored(executed(path, Path(folder))), path)


if __name__ == "__main__":
    main()
