"""The margin of a figure that an expression makes of others, as a function of the inputs of these.

Its least value follows from the intervals of the figures in the expression, each taken by itself. Two of them may rest
on one input, and so may two designs. So it is a bound: it holds, but may not be reached.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from codesign.ground.figures import FIGURES
from codesign.inputs.derived import DerivedFigure, derived_ends
from codesign.inputs.expression import evaluate
from codesign.system.results.result import Result
from codesign.system.results.terms import priced
from codesign.system.verdicts.sums import Bound, Difference, Input, Inputs, Sum, greatest_of


@dataclass(frozen=True)
class Side:
    """A derived figure of one result; or a limit. ``parts``: the sums or the value of each figure that it is made of.

    ``low``, ``high``: the ends of its interval.
    """

    figure: DerivedFigure
    parts: Mapping[str, tuple[Sum, ...] | float]
    low: float
    high: float
    limit: float | None = None

    @classmethod
    def of(cls, held: Result | float, figure: DerivedFigure, inputs: Inputs) -> Side:
        """The side of a result, which has the figure inside all intervals (``ends_of``); or of a limit."""
        if not isinstance(held, Result):
            return cls(figure, {}, held, held, held)
        ends = ends_of(held, figure)
        assert ends is not None, "the caller looks"
        parts: dict[str, tuple[Sum, ...] | float] = {}
        for name in figure.names:
            sums = inputs.sums(held, name) if priced(FIGURES[name]) else ()
            parts[name] = sums or held.figure(FIGURES[name]) or 0.0
        return cls(figure, parts, *ends)

    def at(self, values: Mapping[str, Any]) -> Any:
        """The figure where inputs have these values."""
        if self.limit is not None:
            return self.limit

        def column(name: str) -> Any:
            part = self.parts[name]
            return np.asarray(greatest_of(part, values) if isinstance(part, tuple) else part, np.float64)

        return evaluate(self.figure.node, column) / self.figure.size

    @property
    def sums(self) -> Iterable[Sum]:
        """Every sum that it is made of."""
        return chain.from_iterable(part for part in self.parts.values() if isinstance(part, tuple))


@dataclass(frozen=True)
class DerivedMargin(Difference):
    """How much ``theirs`` exceeds ``ours``."""

    ours: Side
    theirs: Side
    inputs: Mapping[str, Input]

    @property
    def reversed(self) -> DerivedMargin:
        """The same with the sides exchanged."""
        return DerivedMargin(self.theirs, self.ours, self.inputs)

    @property
    def names(self) -> Iterable[str]:
        """The inputs of all sums."""
        sums = (*self.ours.sums, *self.theirs.sums)
        return chain.from_iterable(each.inputs for plan in sums for each in plan)

    def at(self, values: Mapping[str, Any] | None = None) -> Any:
        """The margin where inputs have the given values (numbers or arrays), all others their own."""
        full = {name: each.value for name, each in self.inputs.items()} | dict(values or {})
        return self.theirs.at(full) - self.ours.at(full)

    def least(self) -> Bound:
        """The least margin inside all intervals, or a bound of it."""
        return Bound(self.theirs.low - self.ours.high, exact=False)


def ends_of(result: Result, figure: DerivedFigure) -> tuple[float, float] | None:
    """The least and the greatest value of a derived figure of a result, which are one where it rests on no interval.

    None where it has no value somewhere inside the intervals. Of a resource, what it demands may have one too.
    """

    def ends(name: str) -> tuple[Any, Any]:
        declared = FIGURES[name]
        value = result.figure(declared)
        low, high = result.interval(declared) or (value, value)
        items = [item for use in result.resources if use.resource == name for item in use.items]
        if declared.is_resource and items:
            low, high = (sum(item.figure.interval[end] for item in items) for end in (0, 1))
        least, most = (math.nan if end is None else end for end in (low, high))
        return np.array(least, np.float64), np.array(most, np.float64)

    low, high = map(float, derived_ends(figure, ends))
    return None if math.isnan(low) else (low, high)
