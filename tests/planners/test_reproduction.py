"""What a published figure was used for: said at every row, and never of a figure that the paper does not give."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import codesign.planners
from codesign.figures import Status
from codesign.planners.reproduction import Use, row
from codesign.planners.velocity_obstacle.paper.tables import table_rows

SILENT = "theory.py"
"""Estimates of the paper against runs: all held out, which is what ``row`` takes where nothing is said."""


def makers(tree: ast.AST) -> Iterator[ast.Call]:
    """The calls that make a row or fix some of its arguments."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            named = node.args[0] if node.func.id == "partial" and node.args else node.func
            if isinstance(named, ast.Name) and named.id == "row":
                yield node


def rows_of_makers(tree: ast.AST) -> int:
    """The calls of functions that a maker has fixed arguments of, as in ``own = partial(row, ...)``."""
    fixed = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and any(call is node.value for call in makers(node))
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    calls = (node.func for node in ast.walk(tree) if isinstance(node, ast.Call))
    return sum(isinstance(function, ast.Name) and function.id in fixed for function in calls)


def test_every_row_says_what_it_was_used_for() -> None:
    folder = Path(codesign.planners.__file__).parent
    rows = 0
    for file in sorted(folder.glob("*/paper/*.py")):
        if file.name == SILENT:
            continue
        tree = ast.parse(file.read_text(encoding="utf-8"))
        rows += rows_of_makers(tree)
        for call in makers(tree):
            rows += 1
            assert "use" in {given.arg for given in call.keywords}, f"{file.name}:{call.lineno}"
    assert rows > 60


def test_a_figure_that_is_not_published_has_nothing_to_hold_out() -> None:
    for published, use in ((None, Use.HELD_OUT), (None, Use.FITTED), (None, Use.KNOWN), (3.0, Use.NOTHING)):
        with pytest.raises(ValueError, match="published"):
            row("T", "q", published, 1.0, status=Status.MEASURED, source="s", use=use)
    assert row("T", "q", "-", 1.0, status=Status.MEASURED, source="s", use=Use.NOTHING).use is Use.NOTHING


def test_figures_that_a_rule_was_chosen_in_view_of_are_not_held_out() -> None:
    uses = {row.quantity: row.use for row in table_rows()}
    assert [uses[f"hybrid, {robots} robots, on XC3S500E"] for robots in (2, 4, 8)] == [
        Use.FITTED,
        Use.KNOWN,
        Use.HELD_OUT,
    ]
    assert uses["power, 8 robots, hybrid"] is Use.NOTHING
    assert {use for name, use in uses.items() if name.startswith("cycles of")} == {Use.HELD_OUT}
