"""Rows of tables over the six inertia parameters, in thousandths of a kg·m²."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import MILLI
from testbed.report.frame.blocks import Cell, Column, Tone

Row = tuple[Cell, ...]


def parameter_columns(first: str, *, unit: str = MILLI.text) -> tuple[Column, ...]:
    """Return the headers: what the rows are, and the six parameters."""
    return (Column(title=first), *(Column(title=name, unit=unit) for name in PARAMETER_NAMES))


def inertia_row(title: str, theta: Theta, *, decimals: int = 2, tone: Tone = "plain") -> Row:
    """Return a row of values in 1e-3 kg·m²."""
    return (Cell(text=title, tone=tone), *(Cell(text=_finite(value, decimals), tone=tone) for value in theta))


def uncertain_row(title: str, theta: Theta, error: Theta, *, decimals: int = 2) -> Row:
    """Return a row of values with their standard errors in 1e-3 kg·m²."""
    pairs = zip(theta, error, strict=True)
    texts = (f"{_finite(value, decimals)} ± {_finite(one, decimals)}" for value, one in pairs)
    return (Cell(text=title), *(Cell(text=text) for text in texts))


def ratio_row(title: str, ratios: Theta, *, low: float = -np.inf, high: float = np.inf, tone: Tone = "faint") -> Row:
    """Return a row of pure numbers; what leaves [low, high] stands out."""
    cells = (Cell(text=f"{ratio:.2f}", tone=tone if low <= ratio <= high else "warn") for ratio in ratios)
    return (Cell(text=title, tone=tone), *cells)


def text_rows(rows: Iterable[Iterable[str]]) -> tuple[Row, ...]:
    """Return rows of plain texts."""
    return tuple(tuple(Cell(text=text) for text in row) for row in rows)


def _finite(value: float, decimals: int) -> str:
    return MILLI.shown(value, decimals) if np.isfinite(value) else "–"
