"""The part of the objectives' space that the designs of a search dominate, over the evaluations.

The hypervolume is exact, by moocore (extra ``search``). Each objective is normalised: 0 is the best value of any
feasible design that was evaluated, 1 the worst. The reference point is at 1.1 in each, so that the extremes of a front
count too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from codesign.study.constraints import Floats
from codesign.study.front import non_dominated
from codesign.study.search import Trace
from codesign.study.table import Table

REFERENCE = 1.1
"""The reference point, in each normalised objective."""

_STEPS = 20


@dataclass(frozen=True, eq=False)
class Scale:
    """``best``, ``worst``: of each objective, negated where more is better; what 0 and 1 stand for."""

    best: Floats
    worst: Floats

    @classmethod
    def of(cls, costs: Floats) -> Scale:
        """The scale of designs × objectives; rows with NaN do not count."""
        fine = costs[~np.isnan(costs).any(axis=1)]
        if not len(fine):
            return cls(np.zeros(costs.shape[1]), np.ones(costs.shape[1]))
        return cls(fine.min(axis=0), fine.max(axis=0))

    @property
    def reference(self) -> Floats:
        """The reference point in the units of the objectives."""
        return self.best + REFERENCE * (self.worst - self.best)

    def hypervolume(self, costs: Floats) -> float | None:
        """The share of the space below the reference point that designs dominate, 0 to 1; None without moocore."""
        try:
            import moocore
        except ImportError:
            return None
        fine = costs[~np.isnan(costs).any(axis=1)]
        span = self.worst - self.best
        held = span > 0
        # An objective that all share tells nothing apart.
        if not len(fine) or not held.any():
            return float(len(fine) > 0)
        rows = ((fine - self.best) / np.where(held, span, 1.0))[:, held]
        rows = rows[non_dominated(rows, np.zeros(rows.shape[1], np.bool_))]
        whole = float(REFERENCE ** rows.shape[1])
        return float(moocore.hypervolume(rows, ref=[REFERENCE] * rows.shape[1]) / whole)


@dataclass(frozen=True, eq=False)
class Curve:
    """The hypervolume of a search after so many ``evaluations``; None without moocore."""

    trace: Trace
    evaluations: tuple[int, ...]
    hypervolumes: tuple[float | None, ...]


def costs_of(table: Table, designs: Sequence[int]) -> Floats:
    """The objectives of designs by their place among all; negated where more is better, NaN: not comparable."""
    rows = np.array(designs, np.int64)
    if table.chosen is not None:
        places = {design: row for row, design in enumerate(table.chosen)}
        rows = np.array([places[design] for design in designs], np.int64)
    judged = table.judged
    signs = [-1.0 if table.world.maximise(figure) else 1.0 for figure in table.objectives]
    columns = [sign * judged.figure(figure)[rows] for sign, figure in zip(signs, table.objectives, strict=True)]
    fine = (judged.feasible & ~judged.unreached)[rows]
    return np.where(fine[:, None], np.column_stack(columns), np.nan)


def scale_of(table: Table) -> Scale:
    """The scale of all designs that were evaluated."""
    chosen = range(table.judged.count) if table.chosen is None else table.chosen
    return Scale.of(costs_of(table, chosen))


def curves_of(table: Table) -> tuple[Curve, ...]:
    """The curve of each search of a study."""
    if table.search is None:
        return ()
    scale = scale_of(table)
    return tuple(curve_of(trace, costs_of(table, trace.designs), scale) for trace in table.search.traces)


def curve_of(trace: Trace, costs: Floats, scale: Scale, steps: int = _STEPS) -> Curve:
    """The curve of a search by the objectives of its designs, in their order."""
    ends = np.unique(np.linspace(0, len(costs), steps + 1).round().astype(int))[1:].tolist()
    return Curve(trace, tuple(ends), tuple(scale.hypervolume(costs[:end]) for end in ends))
