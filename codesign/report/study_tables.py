"""A study, its front and what could not be built, as tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.figures import FIGURES, ResultFigure, label
from codesign.report.render import write_csv
from codesign.report.table import Cell, Column, Table, left, right
from codesign.report.wording import (
    ABSENT,
    axis_text,
    count_cell,
    figure_cell,
    quantity_text,
)
from codesign.results.result import Reason
from codesign.units import format_count

if TYPE_CHECKING:
    from codesign.exploration import Study, StudyPoint


def summary(study: Study) -> str:
    """What was explored and what came of it, in one sentence."""
    (_, total), *counts = study_counts(study)
    told = ", ".join(f"{count} {name}" for name, count in counts)
    return f"{total} design point{'' if len(study.points) == 1 else 's'}: {told}"


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


def varying_axes(study: Study) -> tuple[str, ...]:
    """The axes with more than one value, in the order of the workload."""
    return tuple(name for name in study.axes if len(axis_levels(study, name)) > 1)


def short_names(axes: Sequence[str]) -> tuple[str, ...]:
    """The axes as headings: without the task or component where no other axis has the same last word.

    >>> short_names(["relax.block", "fpga.clock", "host.clock"])
    ('block', 'fpga.clock', 'host.clock')
    """
    last = Counter(name.rpartition(".")[2] for name in axes)
    return tuple(word if last[word := name.rpartition(".")[2]] == 1 else name for name in axes)


def fixed_axes(study: Study) -> tuple[tuple[str, str], ...]:
    """The axes with a single value, and that value."""
    return tuple((name, levels[0]) for name in study.axes if len(levels := axis_levels(study, name)) == 1)


def axis_levels(study: Study, name: str) -> list[str]:
    """The values of an axis as texts, in the order of the workload."""
    return list(dict.fromkeys(map(level_teller(study, name), study.axes[name])))


def level_teller(study: Study, name: str) -> Callable[[Any], str]:
    """What says a value of an axis: of mappings (whole problems, whole scenarios) only what differs among them."""
    values = study.axes.get(name, ())
    told_apart = [_leaves(value) for value in values if isinstance(value, Mapping)]
    ranges = all(set(value) == {"first", "step", "last"} for value in values if isinstance(value, Mapping))
    if len(told_apart) < len(values) or len(values) < 2 or ranges:
        return lambda value: axis_text(name, value)
    paths = list(dict.fromkeys(path for leaves in told_apart for path in leaves))
    differing = [path for path in paths if len({repr(leaves.get(path)) for leaves in told_apart}) > 1]

    def told(value: Any) -> str:
        leaves = _leaves(value) if isinstance(value, Mapping) else {}
        parts = (f"{path[-1]} {axis_text(path[-1], leaves[path])}" for path in differing if path in leaves)
        return ", ".join(parts) or axis_text(name, value)

    return told


def _leaves(value: Mapping[str, Any], path: tuple[str, ...] = ()) -> dict[tuple[str, ...], Any]:
    """What stands inside nested mappings, by the way to it."""
    found: dict[tuple[str, ...], Any] = {}
    for key, inner in value.items():
        if isinstance(inner, Mapping):
            found |= _leaves(inner, (*path, str(key)))
        else:
            found[(*path, str(key))] = inner
    return found


def axis_cells(study: Study, axes: Sequence[str]) -> Callable[[StudyPoint], tuple[Cell, ...]]:
    """What makes the cells of these axes for a point of the study."""
    tellers = [(name, level_teller(study, name)) for name in axes]

    def cells(point: StudyPoint) -> tuple[Cell, ...]:
        return tuple(Cell(text := told(point.axes.get(name)), text) for name, told in tellers)

    return cells


def study_table(study: Study, *, every_figure: bool = False) -> Table:
    """All points in the order of enumeration: axes that vary, objectives, feasible, on the front.

    ``every_figure``, made for CSV: every axis, and every figure that any point has, under the names that JSON has.
    """
    axes = tuple(study.axes) if every_figure else varying_axes(study)
    figures = figures_with_values(study) if every_figure else tuple(study.objectives)
    front, feasible = set(study.front), set(study.feasible)
    of_axes = _full_cells(axes) if every_figure else axis_cells(study, axes)
    rows = []
    for position, point in enumerate(study.points):
        rows.append(
            (
                _number(point),
                *of_axes(point),
                *_figure_cells(point, figures),
                _yes(position in feasible),
                _yes(position in front),
                Cell(why := why_not(point, study.lacking(point)), why),
            )
        )
    columns = (
        *right("index" if every_figure else "point"),
        *left(*(axes if every_figure else short_names(axes))),
        *figure_columns(figures, named=not every_figure),
        *(
            left("feasible", "on_front", "why_not")
            if every_figure
            else left("feasible", "on the front", "why not")
        ),
    )
    return Table("All points", columns, tuple(rows), fixed_notes(study), frozenset(study.front))


def write_study_csv(study: Study, path: Path) -> None:
    """Write every point with every axis and figure as CSV.

    Raises:
        RunError: the file cannot be written.
    """
    write_csv(study_table(study, every_figure=True), path)


def front_table(study: Study) -> Table:
    """The points that no other point beats in every objective, best first by the first objective."""
    axes = varying_axes(study)
    objectives = tuple(study.objectives)
    sign = -1 if objectives and objectives[0].maximise else 1

    of_axes = axis_cells(study, axes)

    def rank(position: int) -> tuple[float, int]:
        value = study.points[position].figure(objectives[0])
        return (math.inf if value is None else sign * value, position)

    rows = tuple(
        (
            _number(point),
            *of_axes(point),
            *_figure_cells(point, objectives),
        )
        for point in (study.points[position] for position in sorted(study.front, key=rank))
    )
    notes = (summary(study), *fixed_notes(study))
    return Table(
        "Front", (*right("point"), *left(*short_names(axes)), *figure_columns(objectives)), rows, notes
    )


def best_table(study: Study) -> Table:
    """For each objective the point of the front that is best in it; of equals the first."""
    axes = varying_axes(study)
    objectives = tuple(study.objectives)
    of_axes = axis_cells(study, axes)
    rows = []
    for objective in objectives:
        valued = [
            (value, position)
            for position in study.front
            if (value := study.points[position].figure(objective)) is not None
        ]
        if not valued:
            continue
        sign = -1 if objective.maximise else 1
        point = study.points[min(valued, key=lambda pair: (sign * pair[0], pair[1]))[1]]
        rows.append(
            (
                Cell(objective.aim, objective.name),
                _number(point),
                *of_axes(point),
                *_figure_cells(point, objectives),
            )
        )
    columns = (*left("best"), *right("point"), *left(*short_names(axes)), *figure_columns(objectives))
    return Table("Best in each objective", columns, tuple(rows))


def infeasible_table(study: Study) -> Table:
    """Every point that cannot be built, is not wanted, failed or was not computed, with all its reasons."""
    feasible = set(study.feasible)
    return _left_out(study, "Points left out", [i for i in range(len(study.points)) if i not in feasible])


def nearest_table(study: Study) -> Table:
    """The points that miss feasibility by least, nearest first."""
    return _left_out(study, "Nearest to feasible", study.nearest())


def _left_out(study: Study, title: str, positions: Sequence[int]) -> Table:
    axes = varying_axes(study)
    of_axes = axis_cells(study, axes)
    rows = tuple(
        (_number(point), *of_axes(point), Cell(why := why_not(point), why))
        for point in (study.points[position] for position in positions)
    )
    return Table(title, (*right("point"), *left(*short_names(axes), "why")), rows)


def reasons_table(study: Study) -> Table:
    """Why points were left out, most frequent first: how many, by how little at best, which point that is, and
    what would help there."""
    rows = []
    for count in study.reasons:
        measured = count.kind not in {"failure", "unreached", "no figure"}
        told = count.kind in {"failure", "unreached"}
        least = quantity_text(count.least_gap, count.unit) if measured else ABSENT
        advice = "; ".join(count.levers) or ABSENT
        rows.append(
            (
                Cell(count.kind, count.kind),
                Cell(count.name if told else label(count.name), count.name),
                count_cell(count.points),
                Cell(least, count.least_gap if measured else None),
                Cell(str(count.nearest), count.nearest),
                Cell(advice, advice),
            )
        )
    columns = (
        *left("kind", "what"),
        *right("points", "least gap", "at point"),
        *left("what would help there"),
    )
    return Table("Why points were left out", columns, tuple(rows))


def why_not(point: StudyPoint, lacking: Sequence[ResultFigure] = ()) -> str:
    """All that keeps a point off the front besides better ones, in one line; nothing where nothing does.

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
    demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
    return f"{label(reason.name)} {demand} against {limit}"


def figures_with_values(study: Study) -> tuple[ResultFigure, ...]:
    """The figures that at least one point has: the objectives first, then the rest in their own order."""
    ordered = (*study.objectives, *(figure for figure in FIGURES.values() if figure not in study.objectives))
    return tuple(
        figure for figure in ordered if any(point.figure(figure) is not None for point in study.points)
    )


def figure_columns(figures: Sequence[ResultFigure], *, named: bool = True) -> tuple[Column, ...]:
    """A column for each figure, in the figure's unit; headed by its label, or else by its name.

    A name that ends with its unit is left as JSON has it.
    """
    if named:
        return tuple(Column(figure.label, figure.unit, "right") for figure in figures)
    return tuple(
        Column(figure.name, "" if figure.name.endswith(f"_{figure.unit.lower()}") else figure.unit, "right")
        for figure in figures
    )


def fixed_notes(study: Study) -> tuple[str, ...]:
    """What all points share, said once in place of a column each."""
    fixed = fixed_axes(study)
    return (f"the same for all: {', '.join(f'{name} {value}' for name, value in fixed)}",) if fixed else ()


def _full_cells(axes: Sequence[str]) -> Callable[[StudyPoint], tuple[Cell, ...]]:
    """As ``axis_cells``, with all that a value says: for programs."""

    def cells(point: StudyPoint) -> tuple[Cell, ...]:
        return tuple(Cell(text := axis_text(name, point.axes.get(name)), text) for name in axes)

    return cells


def _figure_cells(point: StudyPoint, figures: Sequence[ResultFigure]) -> tuple[Cell, ...]:
    return tuple(figure_cell(figure, point.figure(figure)) for figure in figures)


def _number(point: StudyPoint) -> Cell:
    return Cell(str(point.index), point.index)


def _yes(truth: bool) -> Cell:
    return Cell("yes" if truth else "no", truth)
