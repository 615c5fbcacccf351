"""The outcomes of every point of a study, in columns.

Points that compute the same differ in what prices move: times, energy, power, and whether the clock is too fast. These
stand in columns, one entry a point. Everything else is the same of many points, and stands once, in a template.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.derived import DerivedFigure, derived_bounds, derived_column
from codesign.study.constraints import Why, figure_of, whys_of
from codesign.study.groups import Groups
from codesign.study.pricing.price import PRICED, Priced
from codesign.system.results.result import Reason, Result

Column = NDArray[np.float64]
Numbers = NDArray[np.int32]
Some = slice | NDArray[np.int64]
"""Some points: by a slice, or by their indices."""
ALL = slice(None)


class State(IntEnum):
    """The state of a point."""

    MISSING = 0
    DONE = 1
    FAILED = 2


Word = Literal["missing", "done", "failed"]
STATES: tuple[Word, ...] = ("missing", "done", "failed")
"""The words for the states, by their numbers."""


@dataclass(eq=False)
class Outcomes:
    """The outcomes of ``count`` points.

    - ``state``: int8, ``State``. ``which``: int32, the number of the template; -1: not done.
    - ``figures``: float64 of each figure of ``PRICED``, by name; NaN: none. ``lows``, ``highs``: the ends of its
      interval; NaN: none.
    - ``reason``: int32, the number of the reason why a clock is too fast; -1: none. A point with one was not run, and
      its template is one without a run.
    - ``templates``: results. One that ``whole`` names is the full result of its one point; the others lack what prices
      move. ``reasons``: those that ``reason`` numbers. ``failures``: why a point failed, by its index.
    """

    state: NDArray[np.int8]
    which: Numbers
    figures: Mapping[str, Column]
    lows: Mapping[str, Column]
    highs: Mapping[str, Column]
    reason: Numbers
    templates: list[Result] = field(default_factory=list)
    whole: set[int] = field(default_factory=set)
    reasons: list[Reason] = field(default_factory=list)
    failures: dict[int, str] = field(default_factory=dict)
    _tables: dict[ResultFigure, Column] = field(default_factory=dict, repr=False)
    _end_tables: dict[ResultFigure, Column] = field(default_factory=dict, repr=False)

    @classmethod
    def empty(cls, count: int) -> Outcomes:
        """The outcomes of points of which none is computed."""
        figures, lows, highs = ({name: np.full(count, math.nan) for name in PRICED} for _ in range(3))
        numbers = np.full((2, count), -1, np.int32)
        return cls(np.zeros(count, np.int8), numbers[0], figures, lows, highs, numbers[1])

    @classmethod
    def of(cls, results: Sequence[Result | str | None]) -> Outcomes:
        """The outcomes of points by their full results; of one that failed the message, None of a missing one."""
        outcomes = cls.empty(len(results))
        for index, result in enumerate(results):
            if isinstance(result, Result):
                outcomes.put(index, result)
            elif result is not None:
                outcomes.fail(index, result)
        return outcomes

    @classmethod
    def of_priced(cls, priced: Priced) -> Outcomes:
        """The outcomes of points that were priced side by side, in their order. They share its columns."""
        state = np.full(len(priced.which), State.DONE, np.int8)
        which, reason = (numbers.astype(np.int32) for numbers in (priced.which, priced.reason))
        columns = priced.figures, priced.lows, priced.highs
        return cls(state, which, *columns, reason, [*priced.templates], reasons=[*priced.reasons])

    def __len__(self) -> int:
        return len(self.state)

    def __eq__(self, other: object) -> bool:
        """True if the same came of every point, however the templates are numbered."""
        if not isinstance(other, Outcomes) or len(self) != len(other):
            return False
        columns = zip(self._columns(), other._columns(), strict=True)
        if self.failures != other.failures or not all(np.array_equal(*pair, equal_nan=True) for pair in columns):
            return False
        pairs = (
            {*zip(self.which.tolist(), other.which.tolist(), strict=True)},
            {*zip(self.reason.tolist(), other.reason.tolist(), strict=True)},
        )
        return all(_listed(self.templates, own) == _listed(other.templates, its) for own, its in pairs[0]) and all(
            _listed(self.reasons, own) == _listed(other.reasons, its) for own, its in pairs[1]
        )

    __hash__ = None  # type: ignore[assignment]

    def _columns(self) -> list[NDArray[Any]]:
        return [self.state, *(held[name] for held in self._priced() for name in PRICED)]

    def _priced(self) -> tuple[Mapping[str, Column], ...]:
        return self.figures, self.lows, self.highs

    def put(self, index: int, result: Result) -> None:
        """Take the full result of a point that was simulated by itself."""
        self.state[index] = State.DONE
        self.which[index] = len(self.templates)
        self.whole.add(len(self.templates))
        self.templates.append(result)
        for name in PRICED:
            figure = FIGURES[name]
            value, ends = result.figure(figure), result.interval(figure)
            self.figures[name][index] = math.nan if value is None else value
            if ends is not None:
                self.lows[name][index], self.highs[name][index] = ends

    def fail(self, index: int, message: str) -> None:
        """Take a point that could not be computed."""
        self.state[index] = State.FAILED
        self.failures[index] = message

    def join(self, indices: NDArray[np.intp], batch: Outcomes) -> None:
        """Take the outcomes of the points with these indices: the first outcome belongs to the first index."""
        run = len(indices) and (np.diff(indices) == 1).all()
        # Points in a row are copied many times as fast as points of any indices.
        some = slice(int(indices[0]), int(indices[0]) + len(indices)) if run else indices
        self.state[some] = batch.state
        self.which[some] = np.where(batch.which < 0, -1, batch.which + len(self.templates))
        self.reason[some] = np.where(batch.reason < 0, -1, batch.reason + len(self.reasons))
        for own, its in zip(self._priced(), batch._priced(), strict=True):
            for name in PRICED:
                own[name][some] = its[name]
        self.whole |= {number + len(self.templates) for number in batch.whole}
        self.templates += batch.templates
        self.reasons += batch.reasons
        self.failures |= {int(indices[place]): message for place, message in batch.failures.items()}

    def chosen(self, indices: NDArray[np.intp]) -> Outcomes:
        """The outcomes of the points with these indices, in this order."""
        failures = {
            place: self.failures[int(indices[place])]
            for place in np.flatnonzero(self.state[indices] == State.FAILED).tolist()
        }
        figures, lows, highs = ({name: held[name][indices] for name in PRICED} for held in self._priced())
        columns = self.state[indices], self.which[indices], figures, lows, highs, self.reason[indices]
        return Outcomes(*columns, self.templates, self.whole, self.reasons, failures)

    @property
    def computed(self) -> NDArray[np.int64]:
        """The indices of the points that were computed, those that failed among them."""
        return np.flatnonzero(self.state != State.MISSING)

    def template(self, index: int) -> Result | None:
        """The part of the result of a point that other points share; None if it has no result."""
        number = int(self.which[index])
        return None if number < 0 else self.templates[number]

    def is_priced(self, index: int) -> bool:
        """True if a point has a template in place of a full result."""
        number = int(self.which[index])
        return number >= 0 and number not in self.whole

    def each(self, measure: Callable[[Result], Any], none: Any) -> NDArray[Any]:
        """Of each point what its template measures; ``none`` where it has no template."""
        # The number -1 takes the last one.
        return np.array([*map(measure, self.templates), none])[self.which]

    def column(self, figure: ResultFigure, within: Some = ALL) -> Column:
        """One figure of each point, or of some of them, as designs are compared by it; NaN: none."""
        if isinstance(figure, DerivedFigure):
            return derived_column(figure, lambda name: self.column(FIGURES[name], within))
        if figure.name in PRICED:
            return self.figures[figure.name][within]
        return self._table(figure)[self.which[within]]

    def value(self, figure: ResultFigure, index: int) -> float | None:
        """One figure of a point; None where it has none."""
        if isinstance(figure, DerivedFigure):
            return figure.of(lambda name: self.value(FIGURES[name], index))
        held = self.figures[figure.name][index] if figure.name in PRICED else self._table(figure)[self.which[index]]
        return None if math.isnan(held) else float(held)

    def whys(self, figure: ResultFigure) -> list[Why]:
        """The reasons for no value of a figure, each with its points (bool); the first of a point is its reason.

        None are named of a declared figure.
        """
        return whys_of(figure, lambda name: self.column(FIGURES[name]))

    def _table(self, figure: ResultFigure) -> Column:
        """A figure that no price moves, of each template, and NaN behind them for what has none."""
        table = self._tables.get(figure)
        if table is None or len(table) <= len(self.templates):
            values = (figure_of(template, figure) for template in self.templates)
            table = np.array([*(math.nan if value is None else value for value in values), math.nan], np.float64)
            self._tables[figure] = table
        return table

    def ends(self, figure: ResultFigure, index: int) -> tuple[float, float] | None:
        """The least and the greatest value of a figure of a point inside all intervals; None where it has none."""
        if isinstance(figure, DerivedFigure):
            low, high = (float(ends[0]) for ends in self.chosen(np.array([index])).bounds(figure))
            return None if math.isnan(low) else (low, high)
        if figure.name not in PRICED:
            template = self.template(index)
            return None if template is None else template.interval(figure)
        low, high = float(self.lows[figure.name][index]), float(self.highs[figure.name][index])
        return None if math.isnan(low) else (low, high)

    def bounds(self, figure: ResultFigure, within: Some = ALL) -> tuple[Column, Column]:
        """``ends`` of each point, or of some of them: the least values, and the greatest; NaN: none."""
        if isinstance(figure, DerivedFigure):
            columns, bounds = (
                lambda name: self.column(FIGURES[name], within),
                lambda name: self.bounds(FIGURES[name], within),
            )
            return derived_bounds(figure, columns, bounds)
        if figure.name in PRICED:
            return self.lows[figure.name][within], self.highs[figure.name][within]
        table = self._end_tables.get(figure)
        if table is None or len(table) <= len(self.templates):
            none = math.nan, math.nan
            ends = (template.interval(figure) or none for template in self.templates)
            table = self._end_tables[figure] = np.array([*ends, none], np.float64)
        both = table[self.which[within]]
        return both[:, 0], both[:, 1]

    def used(self) -> list[int]:
        """The numbers of the templates that points have, in the order of their first points."""
        numbers = self.which[Groups.of(self.which).in_turn.firsts].tolist()
        return [number for number in numbers if number >= 0]


def _listed(held: Sequence[Any], number: int) -> Any:
    return None if number < 0 else held[number]
