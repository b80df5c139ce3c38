"""A notebook as a page of the site: its text, its code, and the outputs that are stored with it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

Cell: TypeAlias = dict[str, Any]
"""A cell, or an output, as it stands in the file."""

_VIEWER = "<rerun_notebook.Viewer object>"
"""What is stored of a viewer, which lives as long as its kernel; a picture of it takes its place."""

_OF_PANDAS = ' border="1" class="dataframe"'
"""How a table of pandas looks in a notebook; without it, as all others of the site."""


def page_of(notebook: Path) -> str:
    """Return a notebook as Markdown.

    Args:
        notebook: among the examples; a picture of its viewer is `images/notebooks/NAME.png`.
    """
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    parts = [part for cell in cells for part in _parts(cell, notebook.stem)]
    title, *rest = parts
    source = f"This page is the notebook [`{notebook.name}`](../../../examples/{notebook.name}) with its outputs."
    return "\n\n".join([title, source, *rest]) + "\n"


def _parts(cell: Cell, name: str) -> Iterator[str]:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield re.sub(r"\]\((\w+)\.ipynb\)", r"](\1.md)", source)
        return
    yield f"```python\n{source}\n```"
    for output in cell["outputs"]:
        yield _shown(output.get("data", {"text/plain": output.get("text", "")}), name)


def _shown(data: Cell, name: str) -> str:
    text = "".join(data.get("text/plain", ""))
    if text == _VIEWER:
        return f"![The recording in the rerun viewer](../../images/notebooks/{name}.png)"
    if "image/png" in data:
        return f'<div><img alt="" src="data:image/png;base64,{"".join(data["image/png"]).strip()}"></div>'
    if "text/html" in data:
        html = "".join(data["text/html"]).strip().replace(_OF_PANDAS, "")
        return "<div>" + html.replace("\n", "&#10;" if html.startswith("<iframe") else " ") + "</div>"
    return f"```text\n{text.rstrip()}\n```"
