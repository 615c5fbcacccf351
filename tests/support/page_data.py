"""The data of a study's page, taken out again as the page's script takes it out."""

from __future__ import annotations

import base64
import json
import re
import zlib
from typing import Any

import numpy as np


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
        case "json":
            return json.loads(content[at : at + count])
        case "f8":
            planes = np.frombuffer(content, np.uint8, 8 * count, at).reshape(8, count)
            return np.ascontiguousarray(planes.T).view("<f8").ravel()
        case kind:
            return np.frombuffer(content, f"<{kind}", count, at)
