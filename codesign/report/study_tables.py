"""A study as tables: its points, its front, the points left out, and the variant that is best at each setting."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from codesign.exploration.rows import study_columns
from codesign.figures import ResultFigure, label
from codesign.inputs.edit import VARIANT_AXIS
from codesign.report.axes import axis_levels, fixed_axes, level_texts, short_names, varying_axes
from codesign.report.certainty import sure_cell, verdict_text
from codesign.report.render import write_csv
from codesign.report.sentences import asked_notes
from codesign.report.table import Cell, Column, Table, left, right, word, words
from codesign.report.wording import (
    ABSENT,
    axis_text,
    count_cell,
    figure_cell,
    quantity_cell,
    quantity_text,
    yes_cell,
)
from codesign.results.result import Reason, Result
from codesign.units import counted, format_count
from codesign.verdicts import winner_verdict

if TYPE_CHECKING:
    from codesign.exploration import Study, StudyPoint

_EQUAL = " = "


def summary(study: Study) -> str:
    """What was explored, and how many points have each fate, in one sentence."""
    _, *counts = study_counts(study)
    fates = ", ".join(f"{count} {name}" for name, count in counts)
    return f"{counted(len(study.points), 'design point')}: {fates}"


def study_counts(study: Study) -> tuple[tuple[str, str], ...]:
    """How many points there are, and how many of each fate; failed and missing ones only where any are."""
    counts = {
        "explored": len(study.points),
        "feasible": len(study.feasible),
        "infeasible": len(study.points) - len(study.feasible) - len(study.failed) - len(study.missing),
    }
    counts |= {"without their goals": len(study.unreached)} if study.unreached else {}
    counts |= {"failed": len(study.failed)} if study.failed else {}
    counts |= {"not computed": len(study.missing)} if study.missing else {}
    counts["on the front"] = len(study.front)
    return tuple((name, format_count(count)) for name, count in counts.items())


class _Points:
    """The number, the axes that vary and some figures of each point of a study, as the cells of a row."""

    def __init__(self, study: Study, figures: Sequence[ResultFigure] = (), *, sure: bool = False) -> None:
        axes = varying_axes(study)
        self._figures, self._sure = figures, sure
        self._texts = [(name, level_texts(study, name)) for name in axes]
        self.columns = (*right("point"), *left(*short_names(axes)), *_figure_columns(figures))

    def cells(self, point: StudyPoint) -> tuple[Cell, ...]:
        axes = words(*(text(point.axes.get(name)) for name, text in self._texts))
        return (_number(point), *axes, *_figure_cells(point, self._figures, sure=self._sure))


def study_table(study: Study) -> Table:
    """All points in the order of enumeration: axes that vary, objectives, feasible, on the front."""
    points = _Points(study, study.objectives)
    front, feasible = set(study.front), set(study.feasible)
    rows = tuple(
        (
            *points.cells(point),
            yes_cell(position in feasible),
            yes_cell(position in front),
            word(why_not(point, study.lacking(point))),
        )
        for position, point in enumerate(study.points)
    )
    columns = (*points.columns, *left("feasible", "on the front", "why not"))
    return Table("All points", columns, rows, _fixed_notes(study), frozenset(study.front))


def study_csv(study: Study) -> Table:
    """All points as raw values: ``study_columns``, and in words why a point is not on the front."""
    columns = study_columns(study)
    reasons = [why_not(point, study.lacking(point)) for point in study.points]
    rows = zip(*columns.values(), reasons, strict=True)
    cells = tuple(tuple(Cell(str(value), value) for value in row) for row in rows)
    return Table("All points", left(*columns, "why_not"), cells)


def write_study_csv(study: Study, path: Path) -> None:
    """Write every point with every axis and figure as CSV.

    Raises:
        RunError: the file cannot be written.
    """
    write_csv(study_csv(study), path)


def front_table(study: Study) -> Table:
    """The points that no other point beats in every objective, best first by the first objective."""
    points = _Points(study, study.objectives, sure=True)
    rows = tuple(points.cells(study.points[position]) for position in _ranked(study, *study.objectives[:1]))
    asked = asked_notes(point.result for point in study.points)
    return Table("Front", points.columns, rows, (*asked, summary(study), *_fixed_notes(study)))


def best_table(study: Study) -> Table:
    """For each objective the point of the front that is best in it, and whether that holds; of equals the first."""
    points = _Points(study, study.objectives, sure=True)
    compared = [point for point in study.points if point.feasible and point.unreached is None]
    results = [point.result for point in compared if point.result is not None]
    rows = []
    for objective in study.objectives:
        for position in _ranked(study, objective)[:1]:
            point = study.points[position]
            if point.figure(objective) is not None:
                sure = word(verdict_text(winner_verdict(results, objective)))
                rows.append((Cell(objective.aim, objective.name), *points.cells(point), sure))
    columns = (*left("best"), *points.columns, *left("how sure"))
    return Table("Best in each objective", columns, tuple(rows))


def _ranked(study: Study, *objectives: ResultFigure) -> list[int]:
    """The positions of the front, best first by these objectives; a point without a value comes last."""

    def rank(position: int) -> tuple[float, ...]:
        values = [(study.points[position].figure(objective), objective) for objective in objectives]
        losses = [math.inf if value is None else _loss(objective, value) for value, objective in values]
        return (*losses, position)

    return sorted(study.front, key=rank)


def _loss(objective: ResultFigure, value: float) -> float:
    """The value with the sign that makes less of it better."""
    return -value if objective.maximise else value


def infeasible_table(study: Study) -> Table:
    """Every point that cannot be built, is not wanted, failed or was not computed, with all its reasons."""
    feasible = set(study.feasible)
    return _left_out(study, "Points left out", [i for i in range(len(study.points)) if i not in feasible])


def nearest_table(study: Study) -> Table:
    """The points that miss feasibility by least, nearest first."""
    return _left_out(study, "Nearest to feasible", study.nearest())


def _left_out(study: Study, title: str, positions: Sequence[int]) -> Table:
    points = _Points(study)
    rows = tuple(
        (*points.cells(point), word(why_not(point)))
        for point in (study.points[position] for position in positions)
    )
    return Table(title, (*points.columns, *left("why")), rows)


def reasons_table(study: Study) -> Table:
    """Why points were left out, most frequent first.

    Each reason has its number of points, the least gap, the point that has this gap, and the levers at that point.
    """
    rows = []
    for count in study.reasons:
        measured = count.kind not in {"failure", "unreached", "no figure", "mapping"}
        in_words = count.kind in {"failure", "unreached", "mapping"}
        rows.append(
            (
                word(count.kind),
                Cell(count.name if in_words else label(count.name), count.name),
                count_cell(count.points),
                quantity_cell(count.least_gap if measured else None, count.unit),
                Cell(str(count.nearest), count.nearest),
                word("; ".join(count.levers) or ABSENT),
            )
        )
    columns = (
        *left("kind", "what"),
        *right("points", "least gap", "at point"),
        *left("what would help there"),
    )
    return Table("Why points were left out", columns, tuple(rows))


def why_not(point: StudyPoint, lacking: Sequence[ResultFigure] = ()) -> str:
    """Why a point is not on the front, in one line; "" where only better points are the reason.

    ``lacking``: the objectives that it does not have, though it is feasible.
    """
    if point.result is None:
        return "not computed" if point.failure is None else f"failed: {point.failure}"
    if point.unreached is not None:
        return f"goals not reached: {point.unreached}"
    if lacking:
        return f"has no {', no '.join(name.label for name in lacking)}"
    return "; ".join(reason_text(reason) for reason in point.result.reasons)


def reason_text(reason: Reason) -> str:
    """A reason in a line, without its levers.

    >>> reason_text(Reason(kind="resource", name="slices", demand=40000, limit=33792, gap=6208, unit=""))
    'slices 40,000 against 33,792'
    """
    if reason.kind == "mapping":
        return reason.name
    demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
    return f"{label(reason.name)} {demand} against {limit}"


def _figure_columns(figures: Sequence[ResultFigure]) -> tuple[Column, ...]:
    """A column for each figure, in the figure's unit, headed by its label."""
    return tuple(Column(figure.label, figure.unit, "right") for figure in figures)


def _fixed_notes(study: Study) -> tuple[str, ...]:
    """The axes with one value, in a note in place of a column each."""
    fixed = fixed_axes(study)
    return (f"the same for all: {', '.join(f'{name} {value}' for name, value in fixed)}",) if fixed else ()


def _figure_cells(
    point: StudyPoint, figures: Sequence[ResultFigure], *, sure: bool = False
) -> tuple[Cell, ...]:
    """``sure``: with the intervals."""
    result = point.result if sure else None
    return tuple(sure_cell(result, figure, point.figure(figure)) for figure in figures)


def _number(point: StudyPoint) -> Cell:
    return Cell(str(point.index), point.index)


def winners_table(
    study: Study, objective: ResultFigure | None = None, axis: str = VARIANT_AXIS
) -> Table | None:
    """For each setting of the other axes the best value of ``axis`` by an objective, the runner-up, and the ratio.

    A point counts if it is feasible and its mission, if it has one, reached its goals. Values that are equal to the
    last digit win together. For each of the study's objectives a note says how often each variant wins by it. None
    where ``axis`` has fewer than two values.

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
