"""Time decides no test: a clock is read to notice what hangs, in a loop that waits, and for nothing else."""

from __future__ import annotations

import ast

import pytest
from places import ROOT

CLOCKS = {"monotonic", "perf_counter", "process_time", "time", "monotonic_ns", "perf_counter_ns", "time_ns"}


def decided_by_time(text: str) -> list[int]:
    """The lines of asserts that read a clock, or a name that was assigned from one, outside of a loop that waits."""
    tree = ast.parse(text)
    waits = {id(inner) for loop in ast.walk(tree) if isinstance(loop, ast.While) for inner in ast.walk(loop)}
    timed = {
        target.id
        for each in ast.walk(tree)
        if isinstance(each, ast.Assign) and _reads(each.value, set())
        for target in each.targets
        if isinstance(target, ast.Name)
    }
    asserts = (each for each in ast.walk(tree) if isinstance(each, ast.Assert) and id(each) not in waits)
    return [each.lineno for each in asserts if _reads(each.test, timed)]


def _reads(expression: ast.expr, timed: set[str]) -> bool:
    return any(
        (isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and each.func.attr in CLOCKS
         and isinstance(each.func.value, ast.Name) and each.func.value.id == "time")
        or (isinstance(each, ast.Name) and each.id in timed)
        for each in ast.walk(expression)
    )  # fmt: skip


def test_no_test_is_decided_by_time() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for line in decided_by_time(path.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        "begun = time.process_time()\nwork()\nassert time.process_time() - begun < 5",
        "took = time.perf_counter() - begun\nassert took < 1",
        "assert time.time() < end",
    ],
)
def test_a_test_that_is_decided_by_time_is_noticed(text: str) -> None:
    assert decided_by_time(text) == [text.count("\n") + 1]
