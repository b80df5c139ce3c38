"""The scenarios that come with the testbed."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def shipped_scenario(name: str) -> Path:
    """Return the path of a shipped scenario, in a checkout or in an installed package.

    Args:
        name: of its file, without the ending.
    """
    return _folder() / f"{name}.toml"


def shipped_scenarios() -> tuple[str, ...]:
    """Return the names of all shipped scenarios, in order."""
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def _folder() -> Path:
    candidates = (_PACKAGE.parent / "scenarios", _PACKAGE / "scenarios")
    return next(folder for folder in candidates if (folder / "zero_g.toml").is_file())
