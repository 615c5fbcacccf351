"""What came of every point of a study, in columns.

Points that compute the same differ in what prices move: times, energy, power, and whether the clock is too fast. These
stand in columns, one entry a point. Everything else is the same of many points, and stands once, in a template.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from codesign.pricing.price import PRICED, Priced
from codesign.results.result import Reason, Result

Column = NDArray[np.float64]
Numbers = NDArray[np.int32]


class State(IntEnum):
    """What became of a point."""

    MISSING = 0
    DONE = 1
    FAILED = 2


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

    def __len__(self) -> int:
        return len(self.state)

    def put(self, index: int, result: Result) -> None:
        """Take the full result of a point that was simulated by itself."""
        from codesign.figures import FIGURES

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

    def take(self, numbers: NDArray[np.int64], priced: Priced) -> None:
        """Take the outcomes of points that were priced side by side, in their order."""
        self.state[numbers] = State.DONE
        self.which[numbers] = priced.which + len(self.templates)
        self.templates += priced.templates
        late = priced.reason >= 0
        self.reason[numbers[late]] = priced.reason[late] + len(self.reasons)
        self.reasons += priced.reasons
        for name in PRICED:
            self.figures[name][numbers] = priced.figures[name]
            self.lows[name][numbers], self.highs[name][numbers] = priced.lows[name], priced.highs[name]

    def fail(self, index: int, message: str) -> None:
        """Take a point that could not be computed."""
        self.state[index] = State.FAILED
        self.failures[index] = message
