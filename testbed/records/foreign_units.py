"""Column names that mean a signal in a unit that records do not use, and what brings them to SI."""

from __future__ import annotations

from math import pi

from testbed.signals import MOST_UNITS, SIGNALS

_FACTORS = {
    "rad": {"deg": pi / 180, "mrad": 1e-3},
    "rad/s": {"deg_s": pi / 180, "dps": pi / 180, "mrad_s": 1e-3, "rpm": pi / 30},
    "N·m": {"Nm": 1.0, "mN_m": 1e-3, "mNm": 1e-3},
    "N·m·s": {"Nms": 1.0, "mN_m_s": 1e-3, "mNms": 1e-3},
    "m": {"cm": 1e-2, "mm": 1e-3},
    "m/s²": {"g": 9.80665, "mg": 9.80665e-3},
}


def foreign_column_problem(column: str) -> str | None:
    """Return what is wrong with a column's unit and how to mend it; None for any other column."""
    if column not in _FOREIGN_COLUMNS:
        return None
    right_column, factor = _FOREIGN_COLUMNS[column]
    if factor is None:
        return f"column {column} does not say its unit: bring it to SI and name it {right_column}"
    return f"column {column} is in another unit: multiply it by {factor:.10g} and name it {right_column}"


def si_column(column: str) -> str:
    """Return the column's name in SI; its own where it is not a signal in another unit."""
    return _FOREIGN_COLUMNS[column][0] if column in _FOREIGN_COLUMNS else column


def _foreign_columns() -> dict[str, tuple[str, float | None]]:
    foreign: dict[str, tuple[str, float | None]] = {
        "time": ("time_s", None),
        "time_ms": ("time_s", 1e-3),
        "time_us": ("time_s", 1e-6),
        "time_ns": ("time_s", 1e-9),
    }
    for signal in (each.sized(MOST_UNITS) for each in SIGNALS.values()):
        for column, component in zip(signal.columns, signal.components or ("",), strict=True):
            stem = f"{signal.name}_{component}" if component else signal.name
            factors = _FACTORS.get(signal.unit, {})
            foreign |= {f"{stem}_{suffix}": (column, factor) for suffix, factor in factors.items()}
            foreign |= {stem: (column, None)} if signal.unit else {}
    return foreign


_FOREIGN_COLUMNS = _foreign_columns()
