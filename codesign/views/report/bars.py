"""Bars of one figure with intervals, as places in percent of a width: a template draws them as inline SVG.

What is a percentage keeps its letters at any width of a page, and the colours are those of the page.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from codesign.ground.figures import ResultFigure
from codesign.system.results.result import Result
from codesign.views.report.certainty import sure_cell
from codesign.views.report.wording import ABSENT, figure_cell, wants_logarithm

_TICKS = 4


@dataclass(frozen=True)
class Bar:
    """The bar of one design: all places in percent of the width; None where there is no value or no interval.

    ``begin``, ``end``: of the bar. ``low``, ``high``: the interval. ``kind``: best, plain or infeasible.
    """

    name: str
    text: str
    kind: str
    begin: float = 0.0
    end: float | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class BarChart:
    """The bars of one figure, and the ticks of their axis: (place in percent, text)."""

    title: str
    logarithmic: bool
    bars: tuple[Bar, ...]
    ticks: tuple[tuple[float, str], ...]

    @property
    def whiskers(self) -> bool:
        """Whether any bar has an interval."""
        return any(bar.low is not None for bar in self.bars)


def bar_chart(
    names: Sequence[str], results: Sequence[Result | None], figure: ResultFigure, best: str | None
) -> BarChart | None:
    """The bars of a figure of named results; None where fewer than two have it, or all of them the same.

    ``best``: the name of the best design, which is marked.
    """
    values = [None if result is None else result.figure(figure) for result in results]
    ends = [_ends(result, figure, value) for result, value in zip(results, values, strict=True)]
    real = [end for pair in ends if pair for end in pair]
    if sum(pair is not None for pair in ends) < 2 or min(real) == max(real):
        return None
    axis = _Axis.over(real, share=figure.counted == "share")
    bars = []
    for name, result, value, pair in zip(names, results, values, ends, strict=True):
        if result is None or value is None or pair is None:
            bars.append(Bar(name, "did not run" if result is None else ABSENT, "infeasible"))
            continue
        kind = "infeasible" if not result.feasible else "best" if name == best else "plain"
        low, high = (axis.place(end) for end in pair) if pair[0] < pair[1] else (None, None)
        text = sure_cell(result, figure, value).text
        bars.append(Bar(name, text, kind, 0.0, axis.place(value), low, high))
    ticks = tuple((axis.place(tick), figure_cell(figure, tick).text) for tick in axis.ticks())
    return BarChart(figure.label, axis.logarithmic, tuple(bars), ticks)


def _ends(result: Result | None, figure: ResultFigure, value: float | None) -> tuple[float, float] | None:
    """The interval of a figure, or its value twice; None without a finite value."""
    if result is None or value is None or not math.isfinite(value):
        return None
    low, high = result.interval(figure) or (value, value)
    return (low, high) if math.isfinite(low) and math.isfinite(high) else (value, value)


@dataclass(frozen=True)
class _Axis:
    least: float
    most: float
    logarithmic: bool

    @classmethod
    def over(cls, values: Sequence[float], *, share: bool) -> _Axis:
        """The axis of these values: from 0, or by logarithm between the decades around them."""
        least, most = min(values), max(values)
        if wants_logarithm(least, most) and not share:
            return cls(10.0 ** math.floor(math.log10(least)), 10.0 ** math.ceil(math.log10(most)), True)
        # The longest bar leaves room for the end of its whisker.
        return cls(min(least, 0.0), max(most * 1.02, 1.0 if share else 0.0, 0.0), False)

    def place(self, value: float) -> float:
        """Percent of the width."""
        if self.logarithmic:
            share = math.log(value / self.least) / math.log(self.most / self.least)
        else:
            share = (value - self.least) / (self.most - self.least)
        return round(100 * min(max(share, 0.0), 1.0), 3)

    def ticks(self) -> list[float]:
        """Round values, at most five."""
        if self.logarithmic:
            first, last = round(math.log10(self.least)), round(math.log10(self.most))
            step = math.ceil((last - first) / _TICKS)
            return [10.0**power for power in range(first, last + 1, step)]
        span = self.most - self.least
        size = 10.0 ** math.floor(math.log10(span / _TICKS))
        size_of_step = next(size * factor for factor in (1, 2, 5, 10) if span / (size * factor) <= _TICKS)
        numbers = range(math.ceil(self.least / size_of_step), math.floor(self.most / size_of_step) + 1)
        return [size_of_step * number for number in numbers]
