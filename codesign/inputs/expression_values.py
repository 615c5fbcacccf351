"""The arithmetic of expressions over columns; a single result is a column without an axis, equal to the bit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]
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
