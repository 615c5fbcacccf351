"""Designs that are compared by one figure: values and intervals as columns, results where they are needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import ResultFigure
from codesign.system.results.result import Result

Floats = NDArray[np.float64]


class Rivals(Protocol):
    """Designs by their positions."""

    def values(self, figure: ResultFigure) -> Floats:
        """The figure of each; NaN: it is infeasible or has none."""

    def ends(self, figure: ResultFigure) -> tuple[Floats, Floats]:
        """The ends of the interval of the figure of each; NaN: it has none, or the figure is no sum of terms."""

    def assessed(self, why_not: Callable[[Result], str]) -> NDArray[np.bool_]:
        """Whether there is no reason against a verdict in what each has in common with others."""

    def at_hand(self, position: int) -> bool:
        """Whether the full result of one is at hand, or has to be simulated."""

    def result(self, position: int) -> Result:
        """The full result of one."""

    def shared(self, position: int) -> Result:
        """Its result, or what that has in common with others: all but what rests on times, energy and clock."""


class Listed:
    """Results as rivals."""

    def __init__(self, results: Sequence[Result]) -> None:
        self._results = results

    def values(self, figure: ResultFigure) -> Floats:
        """The figure of each; NaN: it is infeasible or has none."""
        values = (result.figure(figure) if result.feasible else None for result in self._results)
        return np.array([math.nan if value is None else value for value in values], np.float64)

    def ends(self, figure: ResultFigure) -> tuple[Floats, Floats]:
        """The ends of the interval of the figure of each."""
        pairs = [_interval(result, figure) for result in self._results]
        table = np.array(pairs, np.float64).reshape(-1, 2)
        return table[:, 0], table[:, 1]

    def assessed(self, why_not: Callable[[Result], str]) -> NDArray[np.bool_]:
        """Whether there is no reason against a verdict about each."""
        return np.array([not why_not(result) for result in self._results], np.bool_)

    def at_hand(self, position: int) -> bool:  # noqa: ARG002
        """All are."""
        return True

    def result(self, position: int) -> Result:
        """One of them."""
        return self._results[position]

    def shared(self, position: int) -> Result:
        """The same."""
        return self._results[position]


def _interval(result: Result, figure: ResultFigure) -> tuple[float, float]:
    """The interval of a figure that is a sum of terms; NaN where it is none."""
    none = math.nan, math.nan
    return none if result.terms is None else result.interval(figure) or none
