"""The scenarios that come with the testbed."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def shipped_scenario(name: str) -> Path:
    """Return the path of a shipped scenario, in a checkout or in an installed package.

    Args:
        name: of its file, without the ending.
    """
    candidates = (folder / f"{name}.toml" for folder in (_PACKAGE.parent / "scenarios", _PACKAGE / "scenarios"))
    return next(path for path in candidates if path.is_file())
