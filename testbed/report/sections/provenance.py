"""Provenance: what made the run, and the files to make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from testbed.report.frame.blocks import Cell, Column, Listing, Section, Table


def provenance_section(provenance: Mapping[str, str], file: str, result: Mapping[str, Any]) -> Section:
    """Return the section that says where the run comes from.

    Args:
        provenance: what to its value; a value of several lines, such as a scenario's text, is listed as it is.
        file: name of the file of the result.
        result: what it holds.
    """
    short = {what: value for what, value in provenance.items() if not _is_text(value)}
    texts = {what: value for what, value in provenance.items() if _is_text(value)}
    texts[file] = json.dumps(result, indent=2, ensure_ascii=False)
    listings = (Listing(title=what, text=value) for what, value in texts.items())
    return Section(title="Provenance", blocks=(_table(short), *listings))


def _is_text(value: str) -> bool:
    return "\n" in value


def _table(entries: Mapping[str, str]) -> Table:
    rows = tuple((Cell(text=what), Cell(text=value)) for what, value in entries.items())
    return Table(columns=(Column(title="What"), Column(title="value")), rows=rows, numeric=False)
