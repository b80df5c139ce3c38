"""Bring docs/reference/log-maps.md up to date with the map's keys.

Run `python -m testbed.logs.published` from the root of the repository.
"""

from __future__ import annotations

from pathlib import Path

from testbed.logs.map import LogMap
from testbed.scenario.schema import schema_of
from testbed.scenario.tables import key_tables
from testbed.signals import SIGNALS

MARK = "<!-- The rest is written by `python -m testbed.logs.published`. -->"
"""Line of docs/reference/log-maps.md above which people write."""


def published(docs: Path) -> dict[Path, str]:
    """Return what each published file should contain.

    Args:
        docs: the folder of the documentation; the part of log-maps.md above the mark is kept.
    """
    page = docs / "reference" / "log-maps.md"
    prose = page.read_text(encoding="utf-8").partition(MARK)[0]
    return {page: f"{prose}{MARK}\n\n{_tables()}"}


def _tables() -> str:
    """Return the tables of keys; all channels have the same, which stand once, as those of NAME."""
    schema = schema_of(LogMap)
    channels = schema["$defs"]["Channels"]["properties"]
    channel = {**channels["body_rate"], "description": f"A channel; NAME is one of {', '.join(map(_code, SIGNALS))}."}
    schema["$defs"]["Channels"]["properties"] = {"NAME": channel}
    schema["$defs"]["Channels"].pop("required", None)
    return key_tables(schema)


def _code(name: str) -> str:
    return f"`{name}`"


def main() -> None:
    """Write the published files."""
    for path, text in published(Path("docs")).items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
