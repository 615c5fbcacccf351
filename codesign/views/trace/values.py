"""Bounds of what a trace holds, and JSON that is parsed within them."""

from __future__ import annotations

import json
from typing import Any, NoReturn

from codesign.ground.errors import TraceError

MAX_ELEMENTS = 2**24
"""Most elements of an array: the cells of the largest map."""

MAX_MESSAGE_BYTES = 2**28 - 2**22
"""Most bytes of a message. ``MAX_ELEMENTS`` float64 values take 128 MiB of them.

The chunk around it stays below the limit of readers (``scan.MAX_RECORD_BYTES``).
"""

MAX_SEPARATORS = 1_000_000
"""Most commas, brackets and braces of a JSON text. They bound the objects that parsing makes."""


def parse_json(text: bytes) -> Any:
    """The value of a JSON text of bounded size and depth, without NaN and infinities.

    Raises:
        TraceError: the text is not such JSON.
    """
    separators = sum(text.count(mark) for mark in (b",", b"[", b"{"))
    if separators > MAX_SEPARATORS:
        raise TraceError(f"a JSON text with {separators} values", None, "the file was not written by hwsw")
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as fault:
        raise TraceError(f"not JSON of a trace: {str(fault)[:120]}") from fault


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")
