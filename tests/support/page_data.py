"""The data of a study's page, taken out again as the page's script takes it out."""

from __future__ import annotations

import base64
import json
import re
import zlib
from html.parser import HTMLParser
from typing import Any

import numpy as np


class Page(HTMLParser):
    """What a browser would make of a page: elements, attributes, and the text outside of scripts."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.scripts: list[str] = []
        self._in: str | None = None
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._in = tag if tag in {"script", "style"} else None
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._in = None

    def handle_data(self, data: str) -> None:
        if self._in == "script":
            self.scripts[-1] += data
        elif self._in is None:
            self.text += data


def data_of(html: str) -> dict[str, Any]:
    """What stands in the page."""
    element = re.search(r'<script type="application/json" id="study-data">(.*?)</script>', html, re.S)
    assert element
    data: dict[str, Any] = json.loads(element[1])
    return data


def column(data: dict[str, Any], entry: dict[str, Any]) -> Any:
    """The numbers, or the texts, of a column."""
    content = zlib.decompress(base64.b64decode(data["columns"]))
    at, count = entry.get("at", 0), entry["count"]
    match entry["type"]:
        case "coded":
            values, codes = (column(data, each) for each in entry["of"])
            return values[codes]
        case "steps":
            coded = column(data, entry["of"][0]).astype(np.int64)
            return np.cumsum(np.where(coded % 2, -(coded + 1) // 2, coded // 2))
        case "json":
            return json.loads(content[at : at + count])
        case "f8":
            planes = np.frombuffer(content, np.uint8, 8 * count, at).reshape(8, count)
            return np.ascontiguousarray(planes.T).view("<f8").ravel()
        case kind:
            return np.frombuffer(content, f"<{kind}", count, at)
