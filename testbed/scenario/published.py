"""Bring docs/scenario.schema.json and the tables of docs/scenarios.md up to date with the models.

Run `python -m testbed.scenario.published` from the root of the repository.
"""

from __future__ import annotations

from pathlib import Path

from testbed.scenario.schema import scenario_schema, schema_text
from testbed.scenario.tables import key_tables

MARK = "<!-- The rest is written by `python -m testbed.scenario.published`. -->"
"""Line of docs/scenarios.md above which people write."""


def published(docs: Path) -> dict[Path, str]:
    """Return what each published file should contain.

    Args:
        docs: the folder of the documentation; the part of scenarios.md above the mark is kept.
    """
    page = docs / "scenarios.md"
    prose = page.read_text(encoding="utf-8").partition(MARK)[0]
    return {
        docs / "scenario.schema.json": schema_text(),
        page: f"{prose}{MARK}\n\n{key_tables(scenario_schema())}",
    }


def main() -> None:
    """Write the published files."""
    for path, text in published(Path("docs")).items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
