"""The folder of a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from testbed.files import write_json
from testbed.outputs.provenance import Provenance
from testbed.report.comparison import ComparedFigures, comparison_page
from testbed.report.frame.page import write_page

SCHEMA = 1


def write_comparison(
    folder: Path,
    origin: Provenance,
    kind: Literal["run", "campaign"],
    results: Mapping[str, Mapping[str, Any]],
    figures: Sequence[ComparedFigures],
) -> None:
    """Write comparison.json, provenance.json and report.html.

    Args:
        folder: to write into.
        origin: what made the comparison; the results are its inputs.
        kind: of the results.
        results: what the JSON file of each holds, by name.
        figures: of each estimator.

    Raises:
        OSError: the folder cannot be written.
    """
    content = {"schema": SCHEMA, "kind": kind, "results": dict(results), "provenance": origin.reproducible}
    write_json(folder / "comparison.json", content)
    write_json(folder / "provenance.json", origin.content)
    write_page(folder / "report.html", comparison_page(kind, results, figures))
