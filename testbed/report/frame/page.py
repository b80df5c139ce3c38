"""From a page's content to one HTML file that needs nothing else: no network, no neighbour, no server."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs

from testbed.errors import OutputError
from testbed.files import whole_file
from testbed.report.frame.blocks import Figure, Page, Section

_TEMPLATES = Environment(
    loader=PackageLoader(__package__, "template"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


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
    charting = Markup(get_plotlyjs()) if page.has_figures else None
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
        style=_asset("page.css"),
        script=_asset(script),
        charting=charting,
        chart_json=_chart_json,
        framed=framed,
    )


def _asset(name: str) -> Markup:
    return Markup(_TEMPLATES.get_template(name).render())


def _chart_json(figure: Figure) -> Markup:
    """Return a chart as JSON; plotly escapes the `<` that could end the script element around it."""
    return Markup(figure.chart.to_json(validate=False))
