"""The frame of the pages: one well-formed file that fetches nothing, whatever stands in it."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import plotly.graph_objects as go
import pytest
from plotly.offline import get_plotlyjs_version

from support.report_pages import ParsedPage
from testbed.errors import InputError
from testbed.report.frame.blocks import Cell, Column, Figure, Listing, Notice, Page, Paragraph, Section, Table
from testbed.report.frame.chart import line_chart
from testbed.report.frame.page import render_frame, render_page, write_page
from testbed.report.frame.series import component_lines

NASTY = "</script><b>\"&'<!-- ü ω"


def page(*blocks, title="A title"):
    sections = (Section(title="First part", blocks=blocks), Section(title="Second part", blocks=()))
    return Page(title=title, subtitle="", verdict=Notice(text="Well.", tone="good"), notices=(), sections=sections)


def figure(title="A chart", name="x"):
    lines = component_lines((name, "y", "z"), np.arange(4.0), np.arange(12.0).reshape(4, 3))
    return Figure(title=title, chart=line_chart(lines, y_title="rate, rad/s"))


def table(text):
    return Table(columns=(Column(title="a"), Column(title="b", unit="N·m")), rows=((Cell(text=text), Cell(text="1")),))


def test_a_page_fetches_nothing():
    parsed = ParsedPage(render_page(page(figure(), table("t"), Listing(title="l", text="t"), Paragraph(text="p"))))
    links = [value for _, name, value in parsed.attributes if name in {"src", "href", "srcset", "action", "data"}]
    assert links
    assert all(value.startswith(("#", "data:")) for value in links)


def test_the_browser_has_to_refuse_every_request():
    parsed = ParsedPage(render_page(page()))
    policy = next(value for tag, name, value in parsed.attributes if tag == "meta" and "default-src" in value)
    rules = dict(rule.split(maxsplit=1) for rule in policy.split("; "))
    assert rules.pop("default-src") == "'none'"
    assert set(" ".join(rules.values()).split()) == {"'unsafe-inline'", "data:", "blob:"}


def test_the_style_sheet_fetches_nothing():
    style = re.search(r"<style>(.*?)</style>", render_page(page()), re.DOTALL)
    assert style is not None
    assert "url(" not in style[1]
    assert "@import" not in style[1]


def test_text_is_escaped_wherever_it_stands():
    blocks = (figure(NASTY, NASTY), table(NASTY), Listing(title=NASTY, text=NASTY), Paragraph(text=NASTY))
    parsed = ParsedPage(render_page(page(*blocks, title=NASTY)))  # the parser refuses a tag that slipped through
    assert parsed.charts[0]["data"][0]["name"] == NASTY
    assert parsed.tables[0][1][0] == NASTY
    assert parsed.texts["first-part"].count(NASTY) == 5  # caption, cell, summary, listing, paragraph
    assert not [tag for tag, _, _ in parsed.attributes if tag == "b"]


def test_links_lead_to_sections():
    parsed = ParsedPage(render_page(page()))
    anchors = [value[1:] for tag, name, value in parsed.attributes if tag == "a" and name == "href"]
    assert anchors == ["first-part", "second-part"] == parsed.ids


def test_the_charting_library_stands_in_the_page_once():
    banner = re.compile(r"^\* plotly\.js ", re.MULTILINE)
    assert len(banner.findall(render_page(page(figure(), figure())))) == 1
    assert not banner.findall(render_page(page(table("t"))))


def test_a_page_of_flat_charts_takes_the_small_library_and_one_with_solids_the_whole():
    """5 MB a page were 4.8 MB of library, of which maps and solids are the greater part."""
    flat = render_page(page(figure()))
    assert len(flat) < 1.7e6
    assert "plotly.js (cartesian - minified)" in flat
    assert "Licensed under the MIT license" in flat
    solid = Figure(title="A body", chart=go.Figure(go.Mesh3d(x=[0, 1, 0], y=[0, 0, 1], z=[0, 0, 0])))
    assert "plotly.js (cartesian" not in render_page(page(figure(), solid))


def test_the_small_library_is_of_the_version_that_the_charts_are_made_for():
    assert f"plotly.js (cartesian - minified) v{get_plotlyjs_version()}" in render_page(page(figure()))


def test_a_folded_table_is_collapsed_under_its_name():
    html = render_page(page(replace(table("t"), folded="Of every component")))
    assert (
        html.index("<details><summary>Of every component</summary>") < html.index("<table") < html.index("</details>")
    )


def test_a_page_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "report.html"
    write_page(path, page(table("old")))
    old = path.read_text(encoding="utf-8")
    broken = page(figure())
    object.__setattr__(broken.sections[0].blocks[0], "chart", None)
    with pytest.raises(AttributeError):
        write_page(path, broken)
    assert path.read_text(encoding="utf-8") == old
    assert list(tmp_path.iterdir()) == [path]


def test_who_reads_the_old_page_is_not_disturbed_by_the_new_one(tmp_path):
    path = tmp_path / "report.html"
    write_page(path, page(table("old")))
    with path.open(encoding="utf-8") as reader:
        write_page(path, page(table("new")))
        assert ">old<" in reader.read()
    assert ">new<" in path.read_text(encoding="utf-8")


def test_a_page_that_cannot_be_written_says_so(tmp_path):
    path = tmp_path / "missing" / "report.html"
    with pytest.raises(InputError, match="cannot be written"):
        write_page(path, page())


def test_a_frame_has_tables_and_text_but_no_charts_and_says_where_they_are():
    parsed = ParsedPage(framed(page(figure(), table("t"), Paragraph(text="p"))))
    assert not parsed.charts
    assert len(parsed.tables) == 1
    assert any("Its charts are in report.html" in text for _, text in parsed.tones)
    assert "Its charts" not in framed(page(table("t")))


def test_a_frame_leaves_out_sections_that_are_empty_without_charts():
    assert "First part" not in framed(page(figure()))


def framed(content):
    """Return the page in a frame, as the browser unpacks it."""
    (document,) = re.findall(r'srcdoc="([^"]*)"', render_frame(content))
    return unescape(document)
