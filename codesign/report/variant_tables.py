"""Who wins where: at each setting of the other axes, the variant that is best, and by how much."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from codesign.figures import ResultFigure
from codesign.inputs.edit import VARIANT_AXIS
from codesign.report.study_tables import axis_cells, axis_levels, short_names, varying_axes
from codesign.report.table import Cell, Column, Table, left, right
from codesign.report.wording import ABSENT, axis_text, figure_cell, number_cell, plural

if TYPE_CHECKING:
    from codesign.exploration import Study, StudyPoint

_EQUAL = " = "


def winners_table(
    study: Study, objective: ResultFigure | None = None, axis: str = VARIANT_AXIS
) -> Table | None:
    """For each setting of the other axes the best value of ``axis`` by an objective, the runner-up, and the ratio.

    Only feasible points count whose mission, if they have one, reached its goals. Values that are equal to the last
    digit win together. A note for each of the study's objectives says who wins how often by it. None where ``axis`` has
    fewer than two values.

    Args:
        study: with ``axis``.
        objective: by default the study's first.
        axis: by default that of the variants.
    """
    if axis not in study.axes or len(axis_levels(study, axis)) < 2:
        return None
    objective = objective or study.objectives[0]
    others = tuple(name for name in varying_axes(study) if name != axis)
    settings: dict[str, list[StudyPoint]] = {}
    for point in study.points:
        setting = json.dumps([point.axes.get(name) for name in others], sort_keys=True)
        settings.setdefault(setting, []).append(point)
    of_axes = axis_cells(study, others)
    rows = [(*of_axes(points[0]), *_contest(points, objective, axis)[1]) for points in settings.values()]
    figure = objective.label
    columns = (
        *left(*short_names(others), "best"),
        Column(figure, objective.unit, "right"),
        *left("runner-up"),
        Column(f"its {figure}", objective.unit, "right"),
        *right("times better"),
        *left("left out"),
    )
    if not any(row[-1].text for row in rows):
        columns, rows = columns[:-1], [row[:-1] for row in rows]
    notes = tuple(
        _told(name, [_contest(points, name, axis)[0] for points in settings.values()])
        for name in dict.fromkeys((objective, *study.objectives))
    )
    title = f"Best {axis.rpartition('.')[2]} by setting: {objective.aim}"
    return Table(title, columns, tuple(rows), notes)


def _contest(
    points: Sequence[StudyPoint], objective: ResultFigure, axis: str
) -> tuple[str, tuple[Cell, ...]]:
    """The winner at one setting, and the cells that say so."""
    sign = -1 if objective.maximise else 1
    valued = []
    out = []
    for point in points:
        name = axis_text(axis, point.axes.get(axis))
        value = point.figure(objective) if point.feasible and point.unreached is None else None
        if value is None:
            out.append(f"{name}: {_fate(point, objective)}")
        else:
            valued.append((sign * value, name))
    left_out = Cell("; ".join(out), "; ".join(out))
    if not valued:
        return "", (Cell(ABSENT), Cell(ABSENT), Cell(ABSENT), Cell(ABSENT), Cell(ABSENT), left_out)
    ranks = sorted({value for value, _ in valued})
    best, best_names = sign * ranks[0], _EQUAL.join(name for value, name in valued if value == ranks[0])
    winner = (Cell(best_names, best_names), figure_cell(objective, best))
    if len(ranks) == 1:
        return best_names, (*winner, Cell(ABSENT), Cell(ABSENT), Cell(ABSENT), left_out)
    second = sign * ranks[1]
    names = _EQUAL.join(name for value, name in valued if value == ranks[1])
    over, under = (best, second) if objective.maximise else (second, best)
    ratio = over / under if under > 0 else None
    runner_up = (Cell(names, names), figure_cell(objective, second), number_cell(ratio))
    return best_names, (*winner, *runner_up, left_out)


def _fate(point: StudyPoint, objective: ResultFigure) -> str:
    """In a word, why a point is in no contest."""
    if point.unreached is not None:
        return "goals not reached"
    if point.state != "done":
        return "failed" if point.state == "failed" else "not computed"
    return f"no {objective.label}" if point.feasible else "infeasible"


def _told(objective: ResultFigure, winners: Sequence[str]) -> str:
    """Who wins how often by an objective, in a sentence."""
    wins = Counter("a tie" if _EQUAL in name else name or "none" for name in winners)
    parts = (f"{name} in {count}" for name, count in wins.most_common())
    return f"{objective.aim}, of {plural(len(winners), 'setting')}: {', '.join(parts)}"
