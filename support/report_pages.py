"""A page taken apart with the standard library's parser, for the tests of the pages."""

from __future__ import annotations

import json
from html.parser import HTMLParser

VOID = {"meta", "link", "br", "hr", "img", "input"}


class ParsedPage(HTMLParser):
    """Elements of a page; refuses tags that are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[tuple[str, dict[str, str | None]]] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.ids: list[str] = []
        self.texts: dict[str, str] = {}
        self.tables: list[list[list[str]]] = []
        self.tones: list[tuple[str, str]] = []
        self.charts: list[dict] = []
        self.scripts: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        self.ids += [value for name, value in attrs if name == "id"]
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in {"td", "th"}:
            self.tables[-1][-1].append("")
        if tag not in VOID:
            self.open.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        opened, _ = self.open.pop()
        assert opened == tag, f"</{tag}> closes <{opened}>"

    def handle_data(self, data):
        tag, attributes = self.open[-1] if self.open else ("", {})
        if tag == "script":
            self._script(data, attributes)
        elif tag != "style":
            for _, around in self.open:
                if around.get("id"):
                    self.texts[around["id"]] = self.texts.get(around["id"], "") + data
            if {"td", "th"} & {around for around, _ in self.open}:
                self.tables[-1][-1][-1] += data
            self.tones.append((attributes.get("class") or "", data))

    def _script(self, data, attributes):
        if attributes.get("type") == "application/json":
            self.charts.append(json.loads(data))
        else:
            self.scripts.append(data)

    def said_with(self, style: str) -> list[str]:
        """Texts of the elements of a class, such as `notice warn`."""
        return [text for own, text in self.tones if own == style]

    def row(self, header: str) -> list[str]:
        """The cells beside the first row header of that text."""
        return next(row[1:] for table in self.tables for row in table if row[0] == header)
