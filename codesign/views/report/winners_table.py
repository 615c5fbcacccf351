"""The variant, or the value of another decision, that is best at each setting of all else."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import count
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.figures import ResultFigure
from codesign.ground.units import counted
from codesign.inputs.edit import VARIANT_AXIS
from codesign.study.groups import Groups
from codesign.study.outcomes import State
from codesign.study.rivals import StudyRivals
from codesign.study.sensitivity import inside_of
from codesign.study.table import first_of_equals
from codesign.system.results.result import Result
from codesign.views.report.axes import axis_levels, level_texts, short_names, varying_axes
from codesign.views.report.sentences import verdict_text
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Table,
    axis_text,
    figure_cell,
    left,
    quantity_cell,
    right,
    word,
    words,
)

if TYPE_CHECKING:
    from codesign.study import Study, StudyPoint

Points = NDArray[np.int64]

_EQUAL = " = "

MOST_SETTINGS = 30
"""A table shows no more settings than this; its notes count the others."""


def winners_table(
    study: Study, objective: ResultFigure | None = None, axis: str = VARIANT_AXIS, *, most: int = MOST_SETTINGS
) -> Table | None:
    """For each condition and setting of the other axes the best value of ``axis``, the runner-up, and the ratio.

    Best is by an objective. A point counts if it is feasible and its mission, if it has one, reached its goals. Values
    that are equal to the last digit win together. For each of the study's objectives a note says how often each variant
    wins by it. Settings without a computed point are counted in a note. None where ``axis`` has fewer than two values.

    Axes that exist for some values of ``axis`` only are no part of a setting: each value is taken at the best that they
    make of it.

    Args:
        study: with ``axis``.
        objective: by default the study's first.
        axis: by default the axis of the variants.
        most: settings that are shown, the first ones with a computed point.
    """
    if axis not in study.axes or len(axis_levels(study, axis)) < 2:
        return None
    objective = objective or study.objectives[0]
    own = inside_of(study.when, axis)
    others = tuple(name for name in varying_axes(study) if name not in (axis, *own))
    others = (*(name for name in study.conditions if len(axis_levels(study, name)) > 1), *others)
    # In one condition a point is a design of its own, and keeps the constraints by itself.
    alone = replace(study, axes=study.every_axis, conditions={}, aggregate={})
    settings = _Settings(study, alone, others)
    headings = short_names((*others, *own))
    texts = [(name, level_texts(study, name)) for name in others]
    rows = []
    for every in settings.first(most):
        indices = settings.best_of_each(every, objective, axis) if own else every
        points = [alone.points[index] for index in indices.tolist()]
        axes = points[0].axes
        setting = words(*(text(axes.get(name)) for name, text in texts))
        rows.append((*setting, *_contest(alone, points, objective, axis)))
    best = (*left(*headings[: len(others)], "best"), *right(objective.label, unit=objective.unit))
    second = (*left("runner-up"), *right(f"its {objective.label}", unit=objective.unit))
    columns = (*best, *second, *right("times better"), *left("how sure", "left out"))
    if not any(row[-1].text for row in rows):
        columns, rows = columns[:-1], [row[:-1] for row in rows]
    notes = tuple(
        _wins_text(name, settings.winners(name, axis)) for name in dict.fromkeys((objective, *study.objectives))
    )
    if own:
        notes += (f"each at its best over the axes that depend on it: {', '.join(headings[len(others) :])}",)
    if len(settings.computed) > len(rows):
        notes += (f"the first {len(rows):,} of {len(settings.computed):,} settings",)
    if missing := settings.count - len(settings.computed):
        notes += (f"{counted(missing, 'setting')} without a computed point",)
    title = f"Best {axis.rpartition('.')[2]} by setting: {objective.aim}"
    return Table(title, columns, tuple(rows), notes)


class _Settings:
    """The points of a study by the settings of the axes but one, in the order of the conditions.

    ``alone``: the study with each point as a design. ``others``: the names of the axes that make a setting.
    """

    def __init__(self, study: Study, alone: Study, others: Sequence[str]) -> None:
        self._alone = alone
        points = np.arange(len(alone.outcomes)).reshape(-1, study.judged.conditions).T.reshape(-1)
        keys, levels = np.zeros(len(points), np.int64), alone.space.levels(points)
        for name in others:
            values = alone.axes[name]
            keys = keys * (len(values) + 1) + first_of_equals(values)[levels[name]] + 1
        # Settings are numbered as they come up.
        self._settings, self._points = Groups.of(keys).in_turn, points
        self._setting, self.count = self._settings.which, len(self._settings.firsts)

    @cached_property
    def computed(self) -> NDArray[np.intp]:
        """The settings with a computed point."""
        done = self._alone.outcomes.state[self._points] != State.MISSING
        return np.flatnonzero(np.bincount(self._setting[done], minlength=self.count))

    def first(self, most: int) -> Iterator[Points]:
        """The points of each of the first settings with a computed one."""
        for number in self.computed[:most].tolist():
            yield self._points[self._setting == number]

    def best_of_each(self, points: Points, objective: ResultFigure, axis: str) -> Points:
        """Of points of one setting the best with each value of an axis; the first where none counts."""
        levels, losses = self._alone.space.levels(points)[axis], self._losses(points, objective)
        return points[Groups.of(levels).least(losses)]

    def _losses(self, points: Points, objective: ResultFigure) -> NDArray[np.float64]:
        """The values of an objective with the sign that makes less of it better; NaN of points that do not count."""
        judged, values = self._alone.judged, self._alone.outcomes.column(objective, points)
        fine = (judged.feasible_points & ~judged.unreached_points)[points]
        return np.where(fine, -values if objective.maximise else values, math.nan)

    def winners(self, objective: ResultFigure, axis: str) -> Counter[str]:
        """The number of wins of each value of an axis, or of several equal ones, by an objective; "": none wins."""
        alone, setting = self._alone, self._setting
        losses = self._losses(self._points, objective)
        losses[self._differs[setting]] = math.nan
        best = losses[self._settings.least(losses)]
        winners = np.flatnonzero(losses == best[setting])
        levels = alone.space.levels(self._points[winners])[axis]
        # Several points of one value are one winner.
        firsts = Groups.of(setting[winners], levels).firsts
        winners, levels = winners[firsts], levels[firsts]
        wins = np.bincount(setting[winners], minlength=self.count)
        counts: Counter[str] = Counter()
        # In the order of the settings, which decides between equal counts.
        texts = (axis_text(axis, value) or "none" for value in (*alone.axes[axis], None))
        names = ["a tie" if _EQUAL in text else text for text in texts]
        name_of = np.full(self.count, len(names), np.int64)
        name_of[setting[winners]] = np.where(levels < 0, len(names) - 1, levels)
        name_of[wins > 1] = len(names) + 1
        words_of = [*names, "none", "a tie"]
        for members in Groups.of(name_of).in_turn.members:
            counts[words_of[name_of[members[0]]]] += len(members)
        return counts

    @cached_property
    def _differs(self) -> NDArray[np.bool_]:
        """In which settings the points were asked different questions."""
        numbers = defaultdict[str, int](count().__next__)

        def number(template: Result) -> int:
            task = template.task
            return -1 if task is None else numbers[task.question]

        asked = self._alone.outcomes.each(number, -1)[self._points]
        known = asked >= 0
        least, most = np.full(self.count, len(numbers)), np.full(self.count, -1)
        np.minimum.at(least, self._setting[known], asked[known])
        np.maximum.at(most, self._setting[known], asked[known])
        return np.asarray(least < most)


def _contest(study: Study, points: Sequence[StudyPoint], objective: ResultFigure, axis: str) -> tuple[Cell, ...]:
    """The cells from ``best`` to ``left out`` at one setting. There is no winner where the questions differ."""
    compared: list[int] = []
    names_of_losses, out = [], []
    tasks = (point.template.task for point in points if point.template is not None)
    differ = len({task.question for task in tasks if task is not None}) > 1
    for point in points:
        name = axis_text(axis, point.axes.get(axis))
        value = point.figure(objective) if point.feasible and point.unreached is None else None
        if differ:
            out.append(f"{name}: another question")
        elif value is None:
            out.append(f"{name}: {_fate(point, objective)}")
        else:
            names_of_losses.append((_loss(objective, value), name))
            compared.append(point.index)
    names_by_loss = map_reduce(names_of_losses, itemgetter(0), itemgetter(1))
    ranks = sorted(names_by_loss)[:2]
    names = [_EQUAL.join(names_by_loss[rank]) for rank in ranks]
    values = [_loss(objective, rank) for rank in ranks]
    pairs = zip(names, values, strict=True)
    cells = [cell for name, value in pairs for cell in (word(name), figure_cell(objective, value))]
    cells += [Cell(ABSENT)] * (4 - len(cells))
    ratio = None
    if len(values) == 2:
        over, under = values if objective.maximise else values[::-1]
        ratio = over / under if under > 0 else None
    sure = ABSENT
    if len(compared) > 1:
        sure = verdict_text(StudyRivals(study.outcomes, np.array(compared, np.intp), study.result).verdict(objective))
    return *cells, quantity_cell(ratio), word(sure), word("; ".join(out))


def _fate(point: StudyPoint, objective: ResultFigure) -> str:
    """The reason why a point is not compared, in a word."""
    if point.unreached is not None:
        return "goals not reached"
    if point.state != "done":
        return "failed" if point.state == "failed" else "not computed"
    return f"no {objective.label}" if point.feasible else "infeasible"


def _wins_text(objective: ResultFigure, wins: Counter[str]) -> str:
    """The number of wins of each variant by an objective, in a sentence."""
    parts = (f"{name} in {count}" for name, count in wins.most_common())
    return f"{objective.aim}, of {counted(wins.total(), 'setting')}: {', '.join(parts)}"


def _loss(objective: ResultFigure, value: float) -> float:
    """The value with the sign that makes less of it better."""
    return -value if objective.maximise else value
