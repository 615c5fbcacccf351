"""The points of a study that are compared by single figures: those that are feasible and reached their goals."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError
from codesign.ground.figures import ResultFigure
from codesign.inputs.derived import DerivedFigure
from codesign.study.aggregation import Floats
from codesign.study.groups import Groups
from codesign.study.outcomes import Outcomes
from codesign.study.pricing.price import PRICED
from codesign.system.results.result import Result
from codesign.system.verdicts import Verdict, winner_verdict


class StudyRivals:
    """Points by their positions in ``points``, which has their indices. See ``verdicts.rivals.Rivals``.

    ``result``: gives the full result of a point.
    """

    def __init__(self, outcomes: Outcomes, points: NDArray[np.intp], result: Callable[[int], Result | None]) -> None:
        self.points, self._outcomes, self._result = points, outcomes, result
        self._verdicts: dict[ResultFigure, Verdict] = {}

    def verdict(self, figure: ResultFigure) -> Verdict:
        """True if the best point by a figure is the best at every value inside all intervals.

        Not assessed where points would have to be simulated, and the files of the study are missing.
        """
        if figure not in self._verdicts:
            try:
                self._verdicts[figure] = winner_verdict(self, figure)
            except CodesignError as wrong:
                values = self.values(figure)
                best = np.nanargmax(values) if figure.maximise else np.nanargmin(values)
                reason = str(wrong).partition("\n")[0]
                self._verdicts[figure] = Verdict(
                    state="not assessed", figure=figure.name, holds=True, reason=reason, winner=int(best)
                )
        return self._verdicts[figure]

    def values(self, figure: ResultFigure) -> Floats:
        """The figure of each; NaN: none."""
        if figure.name in PRICED or isinstance(figure, DerivedFigure):
            return self._outcomes.column(figure, self.points)

        # A design without a chip is compared by what it has, not as one that takes nothing.
        def value(number: int) -> float:
            held = self._outcomes.templates[number].figure(figure)
            return math.nan if held is None else held

        return np.asarray(self._of_each(value), np.float64)

    def ends(self, figure: ResultFigure) -> tuple[Floats, Floats]:
        """The ends of the interval of the figure of each; NaN: it has none, or the figure is no sum of terms."""
        low, high = self._outcomes.bounds(figure, self.points)
        whole, templates = self._outcomes.whole, self._outcomes.templates
        # Power has an interval of its own, whatever the terms; a full result that has none is not assessed.
        termless = self._of_each(lambda number: number in whole and templates[number].terms is None)
        return np.where(np.asarray(termless, np.bool_), math.nan, low), high

    def assessed(self, why_not: Callable[[Result], str]) -> NDArray[np.bool_]:
        """True if there is no reason against a verdict in what each has in common with others."""
        return np.asarray(self._of_each(lambda number: not why_not(self._outcomes.templates[number])), np.bool_)

    def at_hand(self, position: int) -> bool:
        """True if the full result of one was kept, or has to be simulated."""
        return not self._outcomes.is_priced(int(self.points[position]))

    def result(self, position: int) -> Result:
        """The full result of one."""
        result = self._result(int(self.points[position]))
        assert result is not None, "a feasible point"
        return result

    def shared(self, position: int) -> Result:
        """The part of the result of one that other points share."""
        template = self._outcomes.template(int(self.points[position]))
        assert template is not None, "a feasible point"
        return template

    def _of_each(self, measure: Callable[[int], object]) -> NDArray[np.generic]:
        """Of each point what follows from the number of its template."""
        templates = self._outcomes.which[self.points]
        groups = Groups.of(templates)
        measured = [measure(number) for number in templates[groups.firsts].tolist()]
        return np.asarray(np.array(measured)[groups.which])
