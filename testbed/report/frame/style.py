"""The look that all charts share; colours are names of the style sheet's custom properties."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

_FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


def color(name: str) -> str:
    """Return a colour of the style sheet."""
    return f"var(--{name})"


def layout(x_title: str, y_title: str) -> go.Layout:
    """Return the layout that all charts share."""
    return go.Layout(
        template=None,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": _FONT, "size": 12, "color": color("ink")},
        margin={"l": 64, "r": 12, "t": 8, "b": 44},
        xaxis={**axis_style(x_title), "hoverformat": ".4~f"},
        yaxis={**axis_style(y_title), "hoverformat": ".4~g"},
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
        hovermode="x unified",
        hoverlabel={"bgcolor": color("card"), "bordercolor": color("rule"), "font": {"color": color("ink")}},
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": color("faint"), "activecolor": color("ink")},
        uirevision="kept",  # a redraw in other colours keeps the zoom
    )


def axis_style(title: str) -> dict[str, Any]:
    """Return the look of an axis with its title."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": color("grid"),
        "linecolor": color("rule"),
        "zerolinecolor": color("rule"),
        "zerolinewidth": 1,
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": color("rule"),
        "exponentformat": "power",
        "showexponent": "all",
        "automargin": True,
    }
