"""The best figures that the designs of a box may have, by bounds on those that prices move."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from codesign.exploration.constraints import Floats, figure_of
from codesign.figures import FIGURES, ResultFigure
from codesign.inputs.constraint import LOWER, Constraint
from codesign.inputs.derived import DerivedFigure, derived_ends
from codesign.pricing.price import PRICED, Priced
from codesign.results.result import Result

_MOST = 1e100
"""No time, power or energy is more."""

_ROUNDING = 1e-9
"""Relative: more than what an expression in floats may be off."""


@dataclass(frozen=True, eq=False)
class Best:
    """What boxes may come to in one condition: ``lows``, bounds below figures.

    ``pilot``: figures of the slowest design. ``template``: has the figures that no price moves. ``count``: of boxes.
    """

    lows: Mapping[str, Floats]
    pilot: Mapping[str, float]
    template: Result
    count: int

    def ends(self, name: str) -> tuple[Floats, Floats]:
        """The least and the greatest value that a declared figure may have in each box; NaN: none."""
        if name in self.lows:
            return self.lows[name], np.full(self.count, _MOST)
        value = self.pilot[name] if name in PRICED else figure_of(self.template, FIGURES[name])
        held = np.full(self.count, math.nan if value is None else value)
        return held, held


def best_of(figure: ResultFigure, best: Best) -> Floats:
    """The best value of a figure that boxes may have: infinite where no bound is known."""
    unknown = math.inf if figure.maximise else -math.inf
    if isinstance(figure, DerivedFigure):
        with np.errstate(all="ignore"):
            low, high = derived_ends(figure, best.ends)
            low, high = low - _ROUNDING * np.abs(low), high + _ROUNDING * np.abs(high)
    else:
        low, high = best.ends(figure.name)
    bound = np.asarray(high if figure.maximise else low, np.float64)
    return np.where(np.isnan(bound), unknown, bound)


def value_of(figure: ResultFigure, template: Result, priced: Priced) -> float | None:
    """A declared figure of the slowest design of a family; None where it has none."""
    if figure.name in PRICED:
        value = float(priced.figures[figure.name][0])
        return None if math.isnan(value) else value
    return figure_of(template, figure)


def upper_of(limit: Constraint) -> Constraint | None:
    """The upper bounds of a constraint alone; None where it has none."""
    kept = {name: value for name, value in limit.bounds.items() if name not in LOWER}
    lower: dict[str, Any] = dict.fromkeys(LOWER)
    return limit.model_copy(update=lower) if kept else None
