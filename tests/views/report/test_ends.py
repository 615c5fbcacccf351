"""Two ends in brackets are an interval of what is assumed, wherever they are printed; spreads and confidence say so."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from places import ROOT

from codesign.views.report.wording import Ends, with_ends

IN_BRACKETS = re.compile(r"\([^()]*\{\}[^()]* to [^()]*\{\}[^()]*\)")
INTERVALS = {"sentence.py", "certainty.py"}
"""Of ``study.advice``, which prints intervals of times and of assumed figures, below the room of the reports."""


def printed(source: str) -> Iterator[str]:
    """The f-strings of a module, with {} in the place of each value."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)


def test_brackets_are_an_intervals_alone() -> None:
    told = {meaning: with_ends("4 ms", "3 ms to 5 ms", meaning) for meaning in Ends}
    assert [meaning for meaning, text in told.items() if "(" in text] == [Ends.INTERVAL]
    assert len(set(told.values())) == len(Ends)
    assert all(text.startswith("4 ms") and "3 ms to 5 ms" in text for text in told.values())
    assert "over the conditions" in told[Ends.SPREAD]


@pytest.mark.parametrize("path", sorted((ROOT / "codesign").rglob("*.py")), ids=lambda path: path.name)
def test_no_module_puts_two_ends_into_brackets_by_itself(path: Path) -> None:
    found = [text for text in printed(path.read_text(encoding="utf-8")) if IN_BRACKETS.search(text)]
    assert not found or (path.parent.name == "advice" and path.name in INTERVALS), found


def test_two_ends_in_brackets_are_found() -> None:
    assert [bool(IN_BRACKETS.search(text)) for text in printed('f"{a} ({b} to {c})"; f"{a}, {b} to {c}"')] == [
        True,
        False,
    ]
