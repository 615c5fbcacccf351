"""Expressions over named figures, such as ``energy_j * plan_time_worst_s``: read, checked for units, evaluated.

::

    comparison = sum SIGN sum                 SIGN: < <= > >= ≤ ≥
    sum        = product {(+ | -) product}
    product    = factor {(* | /) factor}
    factor     = - factor | ( sum ) | NUMBER {UNIT [^ POWER]} | FIGURE | UNIT [^ POWER] | FUNCTION ( sum {, sum} )
    POWER      = a whole number such as 2 or -1, or a fraction in brackets such as (1/2)
    FUNCTION   = min | max | sqrt | log | abs

A unit alone is 1 of it. Numbers are exact decimals until they are evaluated. Units are checked when an expression is
read: ``energy_j + power`` is refused, ``energy_j / power`` is a time. Nothing is given to Python to evaluate.

Rejected: libraries. Those that are kept up evaluate Python's own syntax tree, without units or columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, reduce
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import choose_hint, clip, show
from codesign.ground.models import RefusalError
from codesign.ground.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, counted

Column = NDArray[np.float64]
Why = tuple[str, NDArray[np.bool_]]


MAX_TEXT = 500
MAX_DEPTH = 32
MAX_NODES = 200
"""Numbers, figures and operations of one expression, with those in the expressions that it names."""

FUNCTIONS: Mapping[str, tuple[int, int]] = {"min": (2, 8), "max": (2, 8), "sqrt": (1, 1), "log": (1, 1), "abs": (1, 1)}
"""The functions, each with the least and the most operands."""

_MOST = Fraction(10**300)
_EXPONENT = 3
_LARGEST_POWER = 999
_LARGEST = "at most 1e+300, and at least 1e-300, or 0"

SIGNS = ("<=", ">=", "<", ">", "≤", "≥")

_TOKEN = re.compile(
    r"\s*(?:(?P<number>[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)|(?P<word>%|[^\W\d]\w*)"
    r"|(?P<power>\*\*|\^\s*(?:-?[0-9]{1,3}(?![0-9.])|\(-?[0-9]{1,64}/[1-9][0-9]{0,63}\))?)|(?P<sign><=|>=|[-+*/(),<>≤≥])|(?P<other>\S))",
    re.S,
)
_FORM = "write figures and numbers with + - * / ( ), min, max, sqrt, log and abs"


@dataclass(frozen=True)
class Node:
    """A number (``value``), a figure (``name``), or an operation on ``operands``, with the text that it was read from.

    ``powers``: of its unit. Everything is in base units.
    """

    operation: str
    powers: Powers
    text: str = field(compare=False)
    operands: tuple[Node, ...] = ()
    name: str = ""
    value: Fraction = Fraction(0)

    @property
    def size(self) -> int:
        """The number of nodes."""
        return 1 + sum(operand.size for operand in self.operands)

    @property
    def names(self) -> tuple[str, ...]:
        """The figures in it, each once."""
        inner = [name for operand in self.operands for name in operand.names]
        return tuple(dict.fromkeys([self.name, *inner] if self.name else inner))


def parse(text: str, figures: Mapping[str, Node]) -> Node:
    """The expression of a text.

    Args:
        text: of at most ``MAX_TEXT`` characters.
        figures: what each name stands for (``figure_node``).

    Raises:
        RefusalError: it is none, names no figure, or adds or compares different units; with the place in the text.
    """
    reader = _Reader(text, figures)
    node = reader.sum()
    reader.end()
    return _bounded(node, text)


def parse_comparison(text: str, figures: Mapping[str, Node]) -> tuple[Node, str, Node]:
    """The two sides of a comparison, and the sign between them.

    Raises:
        RefusalError: see ``parse``.
    """
    reader = _Reader(text, figures)
    left = reader.sum()
    begin, sign = reader.place, reader.take()
    if sign not in SIGNS:
        reader.refuse(f"{show(sign)} compares nothing" if sign else "nothing is compared", begin, _LIMIT)
    right = reader.sum()
    reader.end()
    reader.same_unit(left, right, sign, begin)
    return _bounded(left, text), sign, _bounded(right, text)


_LIMIT = f"write EXPRESSION SIGN EXPRESSION; accepted signs: {', '.join(SIGNS)}"


def figure_node(name: str, unit: str) -> Node:
    """A figure by its name, in its unit."""
    return Node("figure", unit_powers(unit), name, name=name)


def unit_powers(unit: str) -> Powers:
    """The powers of a figure's unit; a word that is no known unit counts as a unit of its own."""
    known = known_units().get(unit)
    return known[1] if known else ((unit, Fraction(1)),)


def _bounded(node: Node, text: str) -> Node:
    if node.size > MAX_NODES:
        what = f"{show(clip(text, 60))} is too long: {node.size:,} numbers, figures and operations"
        raise RefusalError(what, f"at most {MAX_NODES}, with those of the figures that it names")
    why = _never(node)
    if why is not None:
        raise RefusalError(f"{show(clip(text, 60))} has no value for any point: {why}", "leave it out")
    return node


def _never(node: Node) -> str | None:
    """The reason for which an expression has no value whatever its figures are; None if that depends on them."""
    for operand in node.operands:
        if (why := _never(operand)) is not None:
            return why
    if node.operation in ("figure", "number"):
        return None
    if not node.names:
        return why_undefined(node, lambda _name: None)
    divisor = node.operands[-1]
    if node.operation == "/" and not divisor.names and evaluate(divisor, no_figure) == 0:
        return f"division by zero in {node.text}"
    return None


def no_figure(name: str) -> Column:
    """The columns of an expression without figures: none."""
    raise KeyError(name)


class _Reader:
    """Reads an expression from left to right. ``place``: where the next token begins."""

    def __init__(self, text: str, figures: Mapping[str, Node]) -> None:
        if len(text) > MAX_TEXT:
            raise RefusalError(f"an expression of {len(text):,} characters is too long", f"at most {MAX_TEXT}")
        self.text, self.figures = text, figures
        self._tokens = list(self._split())
        self._next = 0
        self._open = 0

    def _split(self) -> Iterator[tuple[str, str, int]]:
        before = ""
        for match in _TOKEN.finditer(self.text):
            kind = str(match.lastgroup)
            if kind == "power" and (match[kind] in ("**", "^") or before not in known_units()):
                self.refuse("there are no powers", match.start(kind), "multiply: slices * slices")
            if kind == "other":
                self.refuse(f"{show(match[kind])} is not accepted", match.start(kind), _FORM)
            before = match[kind]
            yield kind, before, match.start(kind)

    def refuse(self, what: str, place: int, hint: str | None = None) -> None:
        """Refuse the text.

        Raises:
            RefusalError: always.
        """
        shown = show(clip(self.text, 60))
        raise RefusalError(f"{shown}, character {place + 1}: {what}", hint)

    @property
    def place(self) -> int:
        """The place at which the next token begins, from 0; at the end, the length of the text."""
        return self._tokens[self._next][2] if self._next < len(self._tokens) else len(self.text)

    def peek(self) -> str:
        """The next token; "" at the end."""
        return self._tokens[self._next][1] if self._next < len(self._tokens) else ""

    def take(self) -> str:
        """The next token, which is then behind."""
        token = self.peek()
        self._next += 1
        return token

    def end(self) -> None:
        """Refuse what is left."""
        if self.peek():
            self.refuse(f"{show(self.peek())} is left over", self.place, _FORM)

    def sum(self) -> Node:
        """A sum, or a product alone."""
        self._open += 1
        if self._open > MAX_DEPTH:
            self.refuse("nested too deep", self.place, f"at most {MAX_DEPTH}")
        begin, node = self.place, self._product()
        while self.peek() in ("+", "-"):
            at, sign = self.place, self.take()
            right = self._product()
            self.same_unit(node, right, sign, at)
            node = Node(sign, node.powers, self._since(begin), (node, right))
        self._open -= 1
        return node

    def same_unit(self, left: Node, right: Node, sign: str, place: int) -> None:
        """Refuse two operands of different units."""
        if left.powers != right.powers:
            units = f"{unit_text(left.powers)} {sign} {unit_text(right.powers)}"
            self.refuse(f"the units differ: {units}", place, "give both sides the same unit")

    def _product(self) -> Node:
        begin, node = self.place, self._factor()
        while self.peek() in ("*", "/"):
            sign = self.take()
            right = self._factor()
            powers = times(node.powers, right.powers, 1 if sign == "*" else -1)
            node = Node(sign, powers, self._since(begin), (node, right))
        return node

    def _since(self, begin: int) -> str:
        return self.text[begin : self._tokens[self._next - 1][2] + len(self._tokens[self._next - 1][1])]

    def _factor(self) -> Node:
        begin = self.place
        if self._next == len(self._tokens):
            self.refuse("a figure or a number is missing", begin, _FORM)
        kind, token, _ = self._tokens[self._next]
        self._next += 1
        if kind == "number":
            if len(token.lower().partition("e")[2].lstrip("+-0")) > _EXPONENT:
                self.refuse("a number that is too large or too small", begin, _LARGEST)
            return self._quantity(Fraction(token), begin)
        if kind == "word":
            return self._word(token, begin)
        if token == "-":
            self._open += 1
            if self._open > MAX_DEPTH:
                self.refuse("nested too deep", begin, f"at most {MAX_DEPTH}")
            inner = self._factor()
            self._open -= 1
            return Node("negative", inner.powers, self._since(begin), (inner,))
        if token == "(":
            node = self.sum()
            self._close()
            return node
        self.refuse(f"{show(token)} where a figure or a number belongs", begin, _FORM)
        raise AssertionError("refused")

    def _close(self) -> None:
        if self.peek() != ")":
            self.refuse("a closing ) is missing", self.place)
        self.take()

    def _quantity(self, value: Fraction, begin: int) -> Node:
        """A number with its unit: the longest unit at the place, then further ones, which multiply it."""
        powers = NUMBER
        while self._next < len(self._tokens) and self._tokens[self._next][0] == "word":
            size, own = self._unit()
            value, powers = value * size, times(powers, own)
        if value > _MOST or 0 < value < 1 / _MOST:
            what = "too large" if value > 1 else "too small"
            self.refuse(f"a number that is {what}", begin, _LARGEST)
        return Node("number", powers, self._since(begin), value=value)

    def _unit(self) -> tuple[Fraction, Powers]:
        """The size in base units, and the powers, of the unit at the place, with the power behind it."""
        place, unit = self.place, self.take()
        size, powers = known_units().get(unit, (Fraction(0), NUMBER))
        if not size:
            self.refuse(f"{show(unit)} is no unit", place, choose_hint(clip(unit, 60), _plain_units()))
        if self.peek()[:1] != "^":
            return size, powers
        power = Fraction(self.take()[1:].strip(" ()"))
        if abs(power) > _LARGEST_POWER:
            self.refuse("a power that is too large", place, f"at most {_LARGEST_POWER}")
        if power.denominator > 1 and size != 1:
            self.refuse(f"a root of {unit} is not exact", place, f"write sqrt(1 {unit})")
        return (size if size == 1 else size**power.numerator), raised(powers, power)

    def _word(self, word: str, begin: int) -> Node:
        if self.peek() == "(":
            return self._call(word, begin)
        if word in self.figures:
            return self.figures[word]
        if word in known_units():
            self._next -= 1
            size, powers = self._unit()
            return Node("number", powers, self._since(begin), value=size)
        accepted = [*self.figures, *FUNCTIONS]
        self.refuse(f"there is no figure {show(word)}", begin, choose_hint(clip(word, 60), accepted))
        raise AssertionError("refused")

    def _call(self, name: str, begin: int) -> Node:
        if name not in FUNCTIONS:
            self.refuse(f"there is no function {show(name)}", begin, choose_hint(clip(name, 60), FUNCTIONS))
        self.take()
        operands = [self.sum()]
        while self.peek() == ",":
            place = self.place
            self.take()
            operands.append(self.sum())
            self.same_unit(operands[0], operands[-1], ",", place)
        self._close()
        least, most = FUNCTIONS[name]
        if not least <= len(operands) <= most:
            wanted = str(least) if least == most else f"{least} to {most}"
            self.refuse(f"{name} of {counted(len(operands), 'expression')}", begin, f"{name} takes {wanted}")
        powers = operands[0].powers
        if name == "log" and powers:
            hint = f"divide by 1 {unit_text(powers)} first"
            self.refuse(f"log of a number with the unit {unit_text(powers)}", begin, hint)
        return Node(
            name, raised(powers, Fraction(1, 2)) if name == "sqrt" else powers, self._since(begin), tuple(operands)
        )


def _plain_units() -> list[str]:
    return [unit for unit in known_units() if "/" not in unit and unit.isascii() and unit != "1"]


def evaluate(node: Node, values: Callable[[str], Column]) -> Column:
    """The value of an expression for each entry of the columns of its figures; NaN where it has none.

    There is none where a figure is NaN, a divisor is 0, a root or logarithm does not exist, or a number is not finite.

    Args:
        values: the column of a figure, in base units: float64, all of one shape; of one result, of no axes.
    """
    if node.operation == "figure":
        return values(node.name)
    if node.operation == "number":
        return constant(node.value)
    return apply(node.operation, [evaluate(operand, values) for operand in node.operands])


def evaluate_ends(node: Node, ends: Callable[[str], tuple[Column, Column]]) -> tuple[Column, Column]:
    """The least and the greatest value while each figure is anywhere between its ends; NaN where there is none.

    Figures are taken to vary independently. Where they do not (both rest on one clock), the interval is too wide, and
    never too narrow.
    """
    if node.operation == "figure":
        return ends(node.name)
    if node.operation == "number":
        number = constant(node.value)
        return number, number
    return apply_to_ends(node.operation, [evaluate_ends(operand, ends) for operand in node.operands])


def why_undefined(node: Node, values: Callable[[str], float | None]) -> str | None:
    """The reason for which an expression has no value for these figures; None if it has one.

    >>> node = parse("cycles / (slices - 4)", {name: figure_node(name, "1") for name in ("cycles", "slices")})
    >>> why_undefined(node, {"cycles": 100.0, "slices": 4.0}.get)
    'division by zero in cycles / (slices - 4)'
    """
    whys = undefined(node, lambda name: column(values(name)))
    return next((reason for reason, where in whys if where), None)


_UNDEFINED = {"sqrt": "root of a negative number", "log": "logarithm of a number that is not above 0"}


def undefined(node: Node, values: Callable[[str], Column]) -> Iterator[Why]:
    """The reasons for which an expression has no value, each with the entries of the columns (bool) that it holds for.

    The first that holds an entry is its reason: an operand comes before the operation.
    """
    for operand in node.operands:
        yield from undefined(operand, values)
    without = np.isnan(evaluate(node, values))
    if node.operation == "figure":
        yield f"there is no {node.name}", without
        return
    if node.operation == "/":
        yield f"division by zero in {node.text}", without & (evaluate(node.operands[1], values) == 0)
    yield f"{_UNDEFINED.get(node.operation, 'a number too large')} in {node.text}", without


Ends = tuple[Column, Column]


def constant(value: Fraction) -> Column:
    """A number as a column without an axis."""
    return column(float(value))


def column(value: float | None) -> Column:
    """The figure of one result as a column without an axis; NaN of none."""
    return np.asarray(math.nan if value is None else value, np.float64)


def as_number(values: Column) -> float:
    """The entry of a column without an axis."""
    return float(values)


def _divided(left: Column, right: Column) -> Column:
    return np.where(right == 0, math.nan, left / np.where(right == 0, 1.0, right))


def _logarithm(values: Column) -> Column:
    # By math: numpy's own loops differ in the last bit by the length of the column and the processor.
    flat = [math.log(value) if value > 0 else math.nan for value in np.ravel(values).tolist()]
    return np.array(flat, np.float64).reshape(np.shape(values))


_OPERATIONS: Mapping[str, Callable[[Sequence[Column]], Column]] = {
    "+": lambda of: of[0] + of[1],
    "-": lambda of: of[0] - of[1],
    "*": lambda of: of[0] * of[1],
    "/": lambda of: _divided(*of),
    "negative": lambda of: -of[0],
    "min": lambda of: reduce(np.minimum, of),
    "max": lambda of: reduce(np.maximum, of),
    "sqrt": lambda of: np.sqrt(of[0]),
    "log": lambda of: _logarithm(of[0]),
    "abs": lambda of: np.abs(of[0]),
}


def apply(operation: str, operands: Sequence[Column]) -> Column:
    """The operation on columns, entry by entry; NaN where it has no finite value."""
    with np.errstate(all="ignore"):
        values = np.asarray(_OPERATIONS[operation](operands), np.float64)
        return np.where(np.isfinite(values), values, math.nan)


def apply_to_ends(operation: str, operands: Sequence[Ends]) -> Ends:
    """The ends of an operation on intervals: all of its values lie between them."""
    lows, highs = [low for low, _ in operands], [high for _, high in operands]
    if operation == "-":
        return apply("-", [lows[0], highs[1]]), apply("-", [highs[0], lows[1]])
    if operation == "negative":
        return apply("negative", highs), apply("negative", lows)
    if operation == "abs":
        inside = (lows[0] <= 0) & (highs[0] >= 0)
        corners = [np.abs(lows[0]), np.abs(highs[0])]
        return np.where(inside, 0.0, apply("min", corners)), apply("max", corners)
    if operation in ("*", "/"):
        # Each is monotone in each operand, so the ends are among the corners; a divisor that may be 0 has none.
        corners = [apply(operation, [left, right]) for left in operands[0] for right in operands[1]]
        ends = apply("min", corners), apply("max", corners)
        crossed = (lows[1] <= 0) & (highs[1] >= 0) if operation == "/" else np.zeros_like(lows[1], bool)
        return np.where(crossed, math.nan, ends[0]), np.where(crossed, math.nan, ends[1])
    return apply(operation, lows), apply(operation, highs)


Powers = tuple[tuple[str, Fraction], ...]
"""Base unit and its power, which is not 0, by the name of the unit; empty of a plain number."""

NUMBER: Powers = ()

_POWERS: Mapping[Dimension, Mapping[str, int]] = MappingProxyType(
    {
        Dimension.TIME: {"s": 1},
        Dimension.FREQUENCY: {"s": -1},
        Dimension.DATA: {"b": 1},
        Dimension.DATA_RATE: {"b": 1, "s": -1},
        Dimension.POWER: {"J": 1, "s": -1},
        Dimension.ENERGY: {"J": 1},
        Dimension.LENGTH: {"m": 1},
        Dimension.CURRENT: {"A": 1},
        Dimension.VOLTAGE: {"J": 1, "s": -1, "A": -1},
        Dimension.SPEED: {"m": 1, "s": -1},
        Dimension.ACCELERATION: {"m": 1, "s": -2},
        Dimension.TURN_RATE: {"rad": 1, "s": -1},
        Dimension.MONEY: {"USD": 1},
        Dimension.RATE: {"s": -1},
    }
)
_OWN: Mapping[str, tuple[Fraction, Powers]] = MappingProxyType(
    {
        "1": (Fraction(1), NUMBER),
        "%": (Fraction(1, 100), NUMBER),
        "bits": (Fraction(1), (("b", Fraction(1)),)),
        "cells": (Fraction(1), (("cells", Fraction(1)),)),
        "deg": (Fraction(1), (("deg", Fraction(1)),)),
    }
)
"""Units of figures that no quantity of a spec has, and the percent."""


def times(left: Powers, right: Powers, sign: int = 1) -> Powers:
    """The powers of a product; with ``sign`` -1, of a quotient."""
    powers = dict(left)
    for unit, power in right:
        powers[unit] = powers.get(unit, Fraction(0)) + sign * power
    return tuple(sorted((unit, power) for unit, power in powers.items() if power))


def raised(powers: Powers, power: Fraction) -> Powers:
    """The powers of a power; of a square root with 1/2."""
    return tuple((unit, each * power) for unit, each in powers if power)


@cache
def known_units() -> Mapping[str, tuple[Fraction, Powers]]:
    """The size in base units, and the powers, of every unit that has one word or one sign in it."""
    units = dict(_OWN)
    for dimension, scale in SCALES.items():
        powers = tuple(sorted((unit, Fraction(power)) for unit, power in _POWERS[dimension].items()))
        per_base = PICOSECONDS_PER_SECOND if dimension is Dimension.TIME else 1
        units |= {unit: (size / per_base, powers) for unit, size in scale.units.items()}
    return MappingProxyType(units)


def unit_text(powers: Powers) -> str:
    """A unit as people write it: the unit of a quantity where one fits, else its base units.

    >>> unit_text((("J", Fraction(1)), ("s", Fraction(1)))), unit_text((("J", Fraction(1)), ("s", Fraction(-1))))
    ('J s', 'W')
    >>> unit_text((("J", Fraction(1, 2)), ("s", Fraction(-2))))
    'J^(1/2) / s^2'
    """
    bases = {scale.base for dimension, scale in SCALES.items() if dimension is not Dimension.TIME}
    named = {powers: unit for unit, (size, powers) in known_units().items() if size == 1 and unit in bases}
    if powers in named or not powers:
        return named.get(powers, "1")
    above = [_power_text(unit, power) for unit, power in powers if power > 0]
    below = [f"/ {_power_text(unit, -power)}" for unit, power in powers if power < 0]
    return " ".join([*above, *below])


def _power_text(unit: str, power: Fraction) -> str:
    """A unit and its power, as an expression reads it behind a number."""
    if power == 1:
        return unit
    return f"{unit}^{power}" if power.denominator == 1 else f"{unit}^({power})"
