"""Expressions over figures: read, checked for units, and evaluated as Python evaluates the same tree."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.figures import FIGURES
from codesign.ground.models import RefusalError
from codesign.inputs.derived import DerivedFigure, nodes
from codesign.inputs.expression import (
    MAX_DEPTH,
    MAX_NODES,
    MAX_TEXT,
    Column,
    Node,
    as_number,
    column,
    evaluate,
    evaluate_ends,
    figure_node,
    parse,
    parse_comparison,
    unit_text,
    why_undefined,
)

NAMES = ("a", "b", "c")
PLAIN = {name: figure_node(name, "1") for name in NAMES}
VALUES = st.one_of(st.integers(-5, 5).map(float), st.floats(-1e6, 1e6, allow_subnormal=False), st.just(math.nan))


def value(text: str, **figures: float | None) -> float:
    known = {**nodes(), **{name: figure_node(name, "1") for name in figures if name not in FIGURES}}
    return as_number(evaluate(parse(text, known), lambda name: column(figures[name])))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("8 / 4 / 2", 1),
        ("8 - 4 - 2", 2),
        ("-2 * -3", 6),
        ("- - 2", 2),
        ("min(3, 1, 2) + max(4, 5)", 6),
        ("sqrt(16) + abs(-3) + log(1)", 7),
        ("0.1 + 0.2", 0.1 + 0.2),
        ("1.5e3", 1500),
        ("80 %", 0.8),
        ("6 J / 3 s / 1 W", 2),
        ("2 ms / us", 2000),
        ("5 min / 1 min", 5),
        ("18 km / h / (1 m / s)", 5),
        ("energy_j * plan_time_worst_s / (1 mJ s)", 1500),
        ("energy * time / (1 mJ s)", 1500),
    ],
)
def test_what_an_expression_comes_to(text: str, expected: float) -> None:
    assert value(text, energy_j=3.0, plan_time_worst_s=0.5) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("energy_j / power", "s"),
        ("energy_j * plan_time_worst_s", "J s"),
        ("slices / (plan_time_worst_s / 1 ms)", "1"),
        ("1 / plan_time_worst_s", "Hz"),
        ("slices / energy_j", "/ J"),
        ("sqrt(energy_j * energy_j)", "J"),
        ("sqrt(energy_j)", "J^(1/2)"),
        ("energy_j * energy_j / mission_time_s", "J^2 / s"),
        ("clearance_mean * 2", "cells"),
    ],
)
def test_the_unit_of_an_expression(text: str, unit: str) -> None:
    node = parse(text, nodes())
    assert unit_text(node.powers) == unit
    assert parse(f"1 {unit}" if unit != "1" else "1", {}).powers == node.powers


@pytest.mark.parametrize(
    ("text", "what", "hint"),
    [
        ("energy_j * cycle", "'energy_j * cycle', character 12: there is no figure 'cycle'", "cycles?"),
        ("energy_j + power", "character 10: the units differ: J + W", "same unit"),
        ("min(energy_j, 1 s)", "character 13: the units differ: J , s", "same unit"),
        ("log(energy_j)", "log of a number with the unit J", "divide by 1 J"),
        ("slices ** 2", "character 8: there are no powers", "multiply: slices * slices"),
        ("(slices", "character 8: a closing ) is missing", None),
        ("slices)", "character 7: ')' is left over", "write figures"),
        ("2 3", "character 3: '3' is left over", "write figures"),
        ("pow(2)", "character 1: there is no function 'pow'", "accepted: abs"),
        ("sqrt(1, 2)", "sqrt of 2 expressions", "sqrt takes 1"),
        ("min(1)", "min of 1 expression", "min takes 2 to 8"),
        ("3 mjoule", "character 3: 'mjoule' is no unit", "accepted"),
        ("", "character 1: a figure or a number is missing", "write figures"),
        ("slices +", "character 9: a figure or a number is missing", "write figures"),
        ("__import__('os')", 'character 12: "\'" is not accepted', "write figures"),
        ("slices.real", "character 7: '.' is not accepted", "write figures"),
        ("9" * 400, "a number that is too large", "at most 1e+300"),
        ("slices ^ 2", "character 8: there are no powers", "multiply: slices * slices"),
        ("1e301 * slices", "character 1: a number that is too large", "at most 1e+300"),
        ("1e-301 * slices", "character 1: a number that is too small", "at least 1e-300"),
        ("slices / 1e999999999", "character 10: a number that is too large or too small", "at most 1e+300"),
        ("slices / 0", "has no value for any point: division by zero in slices / 0", "leave it out"),
        ("slices / (2 - 2)", "has no value for any point: division by zero in slices / (2 - 2)", "leave it out"),
        ("1e200 * 1e200 * slices", "has no value for any point: a number too large in 1e200 * 1e200", "leave it out"),
        ("slices + sqrt(1 - 2)", "root of a negative number in sqrt(1 - 2)", "leave it out"),
        ("1" * (MAX_TEXT + 1), "is too long", f"at most {MAX_TEXT}"),
        ("(" * 99 + "1" + ")" * 99, "nested too deep", f"at most {MAX_DEPTH}"),
        ("-" * 99 + "1", "nested too deep", f"at most {MAX_DEPTH}"),
        ("+".join("1" * (MAX_NODES)), "is too long", f"at most {MAX_NODES}"),
    ],
)
def test_what_is_no_expression(text: str, what: str, hint: str | None) -> None:
    with pytest.raises(RefusalError) as caught:
        parse(text, nodes())
    assert what in caught.value.what
    assert (hint is None and caught.value.hint is None) or str(hint) in str(caught.value.hint)


def test_a_comparison_has_two_sides_of_one_unit() -> None:
    left, sign, right = parse_comparison("energy_j * 2 <= 3 mJ", nodes())
    assert (left.names, sign, right.names) == (("energy_j",), "<=", ())
    for text in ("energy_j", "energy_j = 3 J", "energy_j < 3 s", "energy_j < 1 J < 2 J"):
        with pytest.raises(RefusalError):
            parse_comparison(text, nodes())


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a / (b - 2)", "division by zero in a / (b - 2)"),
        ("1 + a / b / (b - 2)", "division by zero in a / b / (b - 2)"),
        ("1 / (a / (b - 2))", "division by zero in a / (b - 2)"),
        ("sqrt(-b)", "root of a negative number in sqrt(-b)"),
        ("log(a)", "logarithm of a number that is not above 0 in log(a)"),
        ("a + c", "there is no c"),
        ("1e200 * b * 1e200", "a number too large in 1e200 * b * 1e200"),
        ("a + b", None),
    ],
)
def test_why_there_is_no_value(text: str, reason: str | None) -> None:
    figures: dict[str, float | None] = {"a": 0.0, "b": 2.0, "c": None}
    assert why_undefined(parse(text, PLAIN), figures.get) == reason
    assert math.isnan(value(text, **figures)) == (reason is not None)


def trees() -> st.SearchStrategy[str]:
    leaves = st.one_of(st.sampled_from(NAMES), st.integers(0, 9).map(str), st.just("0.1"))
    binary = st.sampled_from(["({} + {})", "({} - {})", "{} * {}", "{} / ({})", "min({}, {})", "max({}, {})"])
    unary = st.sampled_from(["(-{})", "sqrt({})", "abs({})", "log({})"])

    def wider(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pairs = st.tuples(binary, inner, inner).map(lambda each: each[0].format(each[1], each[2]))
        return pairs | st.tuples(unary, inner).map(lambda each: each[0].format(each[1]))

    return st.recursive(leaves, wider, max_leaves=12)


def by_python(text: str, figures: dict[str, float]) -> float:
    """The value that Python's own evaluation gives; NaN where a step has none."""

    def of(function: Any) -> Any:
        return lambda *operands: math.nan if any(map(math.isnan, operands)) else function(*operands)

    functions = {
        "min": of(min),
        "max": of(max),
        "sqrt": of(math.sqrt),
        "log": of(math.log),
        "abs": abs,
        "__builtins__": {},
    }
    try:
        result = float(eval(text, functions, dict(figures)))
    except (ZeroDivisionError, ValueError, OverflowError):
        return math.nan
    return result if math.isfinite(result) else math.nan


@given(trees(), st.lists(st.tuples(VALUES, VALUES, VALUES), min_size=1, max_size=9))
def test_columns_single_results_and_python_agree_to_the_bit(text: str, rows: list[tuple[float, float, float]]) -> None:
    columns = dict(zip(NAMES, np.array(rows).T, strict=True))
    try:
        node = parse(text, PLAIN)
    except RefusalError:
        # It has no value whatever the figures are.
        assert all(math.isnan(by_python(text, dict(zip(NAMES, row, strict=True)))) for row in rows)
        return
    together = np.broadcast_to(evaluate(node, lambda name: columns[name]), len(rows))
    for row, entry in zip(rows, together, strict=True):
        figures = dict(zip(NAMES, row, strict=True))
        alone = value(text, **figures)
        expected = by_python(text, figures)
        assert np.array_equal([alone, entry], [expected, expected], equal_nan=True), (text, row)


SPANS = st.tuples(st.floats(-9, 9), st.floats(0, 3)).map(lambda span: (span[0], span[0] + span[1]))


@given(trees(), st.tuples(SPANS, SPANS, SPANS), st.data())
def test_every_value_lies_between_the_ends(
    text: str, spans: tuple[tuple[float, float], ...], data: st.DataObject
) -> None:
    try:
        node, ends = parse(text, PLAIN), dict(zip(NAMES, spans, strict=True))
    except RefusalError:
        return

    def columns(name: str) -> tuple[Column, Column]:
        return column(ends[name][0]), column(ends[name][1])

    low, high = map(as_number, evaluate_ends(node, columns))
    figures = {name: data.draw(st.floats(*ends[name])) for name in NAMES}
    inside = as_number(evaluate(node, lambda name: column(figures[name])))
    if not math.isnan(inside) and not math.isnan(low) and not math.isnan(high):
        assert low <= inside <= high


@given(st.text(alphabet="ab12+-*/(), <minsqrtJ%.e", max_size=40))
def test_any_text_is_an_expression_or_refused(text: str) -> None:
    with contextlib.suppress(RefusalError):
        assert isinstance(parse(text, PLAIN), Node)


@given(trees(), st.lists(st.tuples(VALUES, VALUES, VALUES), min_size=1, max_size=9))
def test_reasons_of_columns_are_those_of_single_results(text: str, rows: list[tuple[float, float, float]]) -> None:
    try:
        figure = DerivedFigure("f", "derived", "", node=parse(text, PLAIN))
    except RefusalError:
        return
    columns = dict(zip(NAMES, np.array(rows).T, strict=True))
    if not figure.names:
        return
    whys = figure.whys(columns.__getitem__)
    for place, row in enumerate(rows):
        alone = figure.why_none(dict(zip(NAMES, row, strict=True)).get)
        assert next((why for why, where in whys if where[place]), None) == alone
