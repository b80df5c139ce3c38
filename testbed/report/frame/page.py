"""From a page's content to one HTML file that needs nothing else: no network, no neighbour, no server."""

from __future__ import annotations

from collections.abc import Set
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs

from testbed.errors import OutputError
from testbed.files import whole_file
from testbed.palette import SHADES
from testbed.report.frame.blocks import Figure, Page, Section

_TEMPLATES = Environment(
    loader=PackageLoader(__package__, "template"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)

_FLAT_CHARTS = Path(__file__).parent / "plotly" / "plotly-cartesian.min.js"
"""plotly.js without maps, solids and the like, as published in the npm package plotly.js-cartesian-dist-min (MIT, its
licence beside it): 1.5 MB in every page instead of 4.8 MB. Its version is that of the plotly that this project is
tested with."""
_FLAT_KINDS = frozenset({"scatter", "bar", "box", "heatmap"})
"""Of the traces that it draws, those that pages have."""


def write_page(path: Path, page: Page) -> None:
    """Write a page, whole or not at all.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        with whole_file(path) as part:
            part.write_text(render_page(page), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror}); choose another place") from error


def render_page(page: Page) -> str:
    """Return a page as HTML, style, scripts and the charting library inside."""
    blocks = (block for section in page.sections for block in section.blocks)
    kinds = {trace.type for block in blocks if isinstance(block, Figure) for trace in block.chart.data}
    charting = Markup(_charting(kinds)) if kinds else None
    return _rendered(page, page.sections, "page.js", charting=charting, framed=False)


def render_frame(page: Page) -> str:
    """Return a page in a frame, as a notebook shows it: its style touches nothing else there.

    Charts are left out: the library that draws them would add 5 MB to the notebook with every object that it shows.
    """
    shown = escape(_rendered(page, page.sections_without_figures, "frame.js", charting=None, framed=True))
    return f'<iframe srcdoc="{shown}" style="width:100%; height:40rem; max-height:40rem; border:0"></iframe>'


def _rendered(page: Page, sections: tuple[Section, ...], script: str, *, charting: Markup | None, framed: bool) -> str:
    return _TEMPLATES.get_template("page.html").render(
        page=page,
        sections=sections,
        style=_asset("page.css", shades=SHADES),
        script=_asset(script),
        charting=charting,
        chart_json=_chart_json,
        framed=framed,
    )


def _charting(kinds: Set[str]) -> str:
    """Return a charting library that draws some kinds of traces: the smaller one where it knows them all."""
    return _FLAT_CHARTS.read_text(encoding="utf-8") if kinds <= _FLAT_KINDS else get_plotlyjs()


def _asset(name: str, **values: object) -> Markup:
    return Markup(_TEMPLATES.get_template(name).render(**values))


def _chart_json(figure: Figure) -> Markup:
    """Return a chart as JSON; plotly escapes the `<` that could end the script element around it."""
    return Markup(figure.chart.to_json(validate=False))
