"""How the library's objects show themselves: a paragraph in a terminal, a page's sections in a notebook, tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from testbed.arrays import Array
from testbed.report.frame.blocks import Page
from testbed.report.frame.page import render_frame

if TYPE_CHECKING:
    import pandas as pd


class Shown:
    """An object that prints as a short text, and shows itself in a notebook."""

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        page = self._page()
        return f"<p>{escape(str(self))}</p>" if page is None else render_frame(page)

    def _page(self) -> Page | None:
        """Return the page of which a notebook shows the sections; None where the text says all."""
        return None


def parameter_frame(columns: Mapping[str, Array], parameters: Sequence[str]) -> pd.DataFrame:
    """Return a table with a row for each parameter."""
    import pandas as pd  # noqa: PLC0415 - an optional extra

    return pd.DataFrame(dict(columns), index=pd.Index(parameters, name="parameter"))
