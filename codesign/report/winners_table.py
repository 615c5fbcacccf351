"""The variant, or the value of another decision, that is best at each setting of all else."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from codesign.figures import ResultFigure
from codesign.inputs.edit import VARIANT_AXIS
from codesign.report.axes import axis_levels, level_texts, short_names, varying_axes
from codesign.report.certainty import verdict_text
from codesign.report.table import Cell, Column, Table, left, right, word, words
from codesign.report.wording import ABSENT, axis_text, figure_cell, quantity_cell
from codesign.results.result import Result
from codesign.units import counted
from codesign.verdicts import winner_verdict

if TYPE_CHECKING:
    from codesign.exploration import Study, StudyPoint

_EQUAL = " = "


def winners_table(
    study: Study, objective: ResultFigure | None = None, axis: str = VARIANT_AXIS
) -> Table | None:
    """For each condition and setting of the other axes the best value of ``axis``, the runner-up, and the ratio.

    Best is by an objective. A point counts if it is feasible and its mission, if it has one, reached its goals. Values
    that are equal to the last digit win together. For each of the study's objectives a note says how often each variant
    wins by it. None where ``axis`` has fewer than two values.

    Args:
        study: with ``axis``.
        objective: by default the study's first.
        axis: by default that of the variants.
    """
    if axis not in study.axes or len(axis_levels(study, axis)) < 2:
        return None
    objective = objective or study.objectives[0]
    others = tuple(name for name in varying_axes(study) if name != axis)
    others = (*(name for name in study.conditions if len(axis_levels(study, name)) > 1), *others)
    settings: dict[str, list[StudyPoint]] = {}
    # In one condition a point is a design of its own, and keeps the constraints by itself.
    for part in map(study.at, study.world.each):
        for point in part.points:
            setting = json.dumps([point.axes.get(name) for name in others], sort_keys=True)
            settings.setdefault(setting, []).append(point)
    texts = [(name, level_texts(study, name)) for name in others]
    rows = [
        (
            *words(*(text(points[0].axes.get(name)) for name, text in texts)),
            *_contest(points, objective, axis)[1],
        )
        for points in settings.values()
    ]
    figure = objective.label
    columns = (
        *left(*short_names(others), "best"),
        Column(figure, objective.unit, "right"),
        *left("runner-up"),
        Column(f"its {figure}", objective.unit, "right"),
        *right("times better"),
        *left("how sure", "left out"),
    )
    if not any(row[-1].text for row in rows):
        columns, rows = columns[:-1], [row[:-1] for row in rows]
    notes = tuple(
        _wins_text(name, [_contest(points, name, axis)[0] for points in settings.values()])
        for name in dict.fromkeys((objective, *study.objectives))
    )
    title = f"Best {axis.rpartition('.')[2]} by setting: {objective.aim}"
    return Table(title, columns, tuple(rows), notes)


def _contest(
    points: Sequence[StudyPoint], objective: ResultFigure, axis: str
) -> tuple[str, tuple[Cell, ...]]:
    """The winner at one setting, and the cells from ``best`` to ``left out``.

    There is none where the questions of the points differ.
    """
    names_by_loss: dict[float, list[str]] = {}
    compared: list[Result] = []
    out = []
    differ = len({point.result.task.question for point in points if point.result and point.result.task}) > 1
    for point in points:
        name = axis_text(axis, point.axes.get(axis))
        value = point.figure(objective) if point.feasible and point.unreached is None else None
        if differ:
            out.append(f"{name}: another question")
        elif value is None:
            out.append(f"{name}: {_fate(point, objective)}")
        else:
            names_by_loss.setdefault(_loss(objective, value), []).append(name)
            compared += [point.result] if point.result is not None else []
    ranks = sorted(names_by_loss)[:2]
    names = [_EQUAL.join(names_by_loss[rank]) for rank in ranks]
    values = [_loss(objective, rank) for rank in ranks]
    cells = [
        cell
        for name, value in zip(names, values, strict=True)
        for cell in (word(name), figure_cell(objective, value))
    ]
    cells += [Cell(ABSENT)] * (4 - len(cells))
    ratio = None
    if len(values) == 2:
        over, under = values if objective.maximise else values[::-1]
        ratio = over / under if under > 0 else None
    sure = verdict_text(winner_verdict(compared, objective)) if len(compared) > 1 else ABSENT
    return names[0] if names else "", (*cells, quantity_cell(ratio), word(sure), word("; ".join(out)))


def _fate(point: StudyPoint, objective: ResultFigure) -> str:
    """Why a point is not compared, in a word."""
    if point.unreached is not None:
        return "goals not reached"
    if point.state != "done":
        return "failed" if point.state == "failed" else "not computed"
    return f"no {objective.label}" if point.feasible else "infeasible"


def _wins_text(objective: ResultFigure, winners: Sequence[str]) -> str:
    """How often each variant wins by an objective, in a sentence."""
    wins = Counter("a tie" if _EQUAL in name else name or "none" for name in winners)
    parts = (f"{name} in {count}" for name, count in wins.most_common())
    return f"{objective.aim}, of {counted(len(winners), 'setting')}: {', '.join(parts)}"


def _loss(objective: ResultFigure, value: float) -> float:
    """The value with the sign that makes less of it better."""
    return -value if objective.maximise else value
