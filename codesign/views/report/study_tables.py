"""A study as tables: its points, the front of its designs, and the designs left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError
from codesign.ground.figures import FIGURES, ResultFigure, label
from codesign.ground.progress import Show, doing, silent, tracked
from codesign.ground.units import counted, format_count
from codesign.inputs.derived import DerivedFigure
from codesign.study.columns import provenance_columns, study_columns
from codesign.study.conditions import Scalar
from codesign.study.groups import Groups
from codesign.study.hypervolume import REFERENCE, Curve, curves_of, scale_of
from codesign.system.results.result import Result
from codesign.system.verdicts import fit_verdict
from codesign.views.report.axes import (
    aggregated_cell,
    aim_text,
    alike_note,
    axis_levels,
    condition_text,
    designs_text,
    figure_column,
    fixed_axes,
    kind_of_row,
    level_texts,
    rules_text,
    same_text,
    short_names,
    spread_table,
    varying_axes,
)
from codesign.views.report.canvas import Picture, canvas, drawn, legend, style
from codesign.views.report.explain_tables import effects_table
from codesign.views.report.render import printable, write_columns_csv
from codesign.views.report.result_tables import sources_table
from codesign.views.report.sentences import asked_notes, reach_notes, reason_text, verdict_text, winners_certainty_table
from codesign.views.report.winners_table import winners_table
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Table,
    count_cell,
    figure_cell,
    figure_columns,
    left,
    number_cell,
    quantity_cell,
    quantity_text,
    right,
    word,
    words,
    yes_cell,
)

if TYPE_CHECKING:
    from codesign.study import Design, Study, StudyPoint
    from codesign.study.search import Trace

# What searches made of a space: their evaluations and hypervolumes, as a table and a picture.

_QUARTERS = (0.25, 0.5, 1.0)


def search_table(study: Study) -> Table | None:
    """The searches side by side, at the same number of evaluations; None where all designs were asked for."""
    if study.search is None:
        return None
    if why := study.search.traces[0].enumerated:
        return _in_its_place(study, study.search.traces[0], why)
    curves = curves_of(study)
    columns = (
        *left("search"),
        *right("seed", "evaluated", "asked again", "excluded"),
        *right(*(f"hypervolume at {share:.0%}" for share in _QUARTERS)),
        *left("end"),
    )
    rows = tuple(_row(curve) for curve in curves)
    return Table("Searches", columns, rows, _notes(study, curves))


def _in_its_place(study: Study, trace: Trace, why: str) -> Table:
    count = len(study.outcomes) - len(study.missing)
    end = "all points computed" if trace.proved else trace.ended
    columns = (*left("search asked for"), *right("points"), *left("end"))
    return Table("Searches", columns, ((word(trace.name), count_cell(count), word(end)),), (why,))


def _row(curve: Curve) -> tuple[Cell, ...]:
    trace = curve.trace
    excluded = sum(box.designs for box in trace.excluded)
    end = "front proved" if trace.proved else trace.ended or "as many evaluations"
    return (
        word(trace.name),
        number_cell(trace.seed),
        count_cell(len(trace.designs)),
        count_cell(trace.repeated),
        count_cell(excluded),
        *(_at(curve, share) for share in _QUARTERS),
        word(end),
    )


def _at(curve: Curve, share: float) -> Cell:
    most = max(1, round(share * len(curve.trace.designs)))
    places = [place for place, count in enumerate(curve.evaluations) if count <= most]
    value = curve.hypervolumes[places[-1]] if places else None
    return Cell(ABSENT) if value is None else Cell(f"{value:.4f}", value)


def _notes(study: Study, curves: tuple[Curve, ...]) -> tuple[str, ...]:
    assert study.search is not None, "the caller looks"
    scale = scale_of(study)
    signs = [-1.0 if study.world.maximise(figure) else 1.0 for figure in study.objectives]
    point = "; ".join(
        f"{figure.label} {quantity_text(float(sign * value), figure.unit)}"
        for figure, sign, value in zip(study.objectives, signs, scale.reference, strict=True)
    )
    notes = [
        f"hypervolume: the share of the space up to the reference point that the designs dominate. 0 is the best value"
        f" of all designs here, 1 the worst, and the reference {REFERENCE}: {point}"
    ]
    if curves and curves[0].hypervolumes and curves[0].hypervolumes[0] is None:
        notes = ["hypervolume: pip install 'hwsw-codesign[search]'"]
    found = study.search
    if found.excluded:
        notes.append(
            f"excluded: designs in {format_count(len(found.excluded))} boxes that a bound or a limit keeps out"
        )
    notes.append(f"{format_count(found.simulated)} simulations, {counted(found.kept, 'point')} from the store")
    return tuple(notes)


def search_picture(study: Study) -> Picture | None:
    """The hypervolume over the evaluations of each search; None where there is none."""
    curves = [curve for curve in curves_of(study) if curve.hypervolumes and None not in curve.hypervolumes]
    if not curves:
        return None
    with style():
        picture, axes = canvas((7.2, 3.4))
        for curve in curves:
            axes.plot(curve.evaluations, curve.hypervolumes, label=curve.trace.name, drawstyle="steps-post")
        axes.set(xlabel="evaluated designs", ylabel="hypervolume")
        axes.grid(visible=True, alpha=0.3)
        legend(picture)
        names = ", ".join(curve.trace.name for curve in curves)
        alt = f"Hypervolume over the number of evaluated designs, of {names}"
        return drawn(picture, "svg", "Hypervolume over evaluations", alt)


def summary(study: Study) -> str:
    """The exploration in one sentence: what was explored, and how many designs have each fate."""
    _, *counts = study_counts(study)
    fates = ", ".join(f"{count} {name}" for name, count in counts)
    again = len(study.designs) - len(study.distinct)
    once = f", {len(study.distinct)} of them distinct" if again else ""
    if not study.conditions:
        return f"{counted(len(study.points), 'design point')}{once}: {fates}"
    over = counted(len(study.world.each), "condition")
    points = counted(len(study.points), "point")
    designs = counted(len(study.designs), "design")
    return f"{designs} × {over} = {points}{once}, compared {rules_text(study)}: {fates}"


def study_counts(study: Study) -> tuple[tuple[str, str], ...]:
    """The numbers of designs, and of each fate; failed and missing ones only if there are any."""
    count = len(study.distinct)
    counts = {
        "explored": count,
        "feasible": len(study.feasible),
        "infeasible": count - len(study.feasible) - len(study.failed) - len(study.missing),
    }
    perhaps = _perhaps_feasible(study)
    counts |= {"of these not surely": perhaps} if perhaps else {}
    counts |= {"without their goals": len(study.unreached)} if study.unreached else {}
    counts |= {"failed": len(study.failed)} if study.failed else {}
    counts |= {"not computed": len(study.missing)} if study.missing else {}
    counts["on the front"] = len(study.front)
    return tuple((name, format_count(count)) for name, count in counts.items())


def _perhaps_feasible(study: Study) -> int:
    """The number of designs that do not fit at the figures' own values, and do at others; 0 over conditions."""
    if study.conditions:
        return 0
    fits = study.outcomes.each(lambda each: not each.feasible and fit_verdict(each).fits == "uncertain", False)
    return int((fits & (study.outcomes.reason < 0))[list(study.distinct)].sum())


class _Designs:
    """The number, the decisions that vary and some figures of each design of a study, as the cells of a row."""

    def __init__(self, study: Study, figures: Sequence[ResultFigure] = (), *, spread: bool = False) -> None:
        axes = varying_axes(study)
        self._study, self._figures, self._spread = study, figures, spread
        self._texts = [(name, level_texts(study, name)) for name in axes]
        columns = (figure_column(study, figure) for figure in figures)
        self.columns = (*right(kind_of_row(study)), *left(*short_names(axes)), *columns)

    def cells(self, design: Design) -> tuple[Cell, ...]:
        axes = words(*(text(design.axes.get(name)) for name, text in self._texts))
        figures = (aggregated_cell(self._study, design, figure, spread=self._spread) for figure in self._figures)
        return (number_cell(design.index), *axes, *figures)


def study_table(study: Study, show: Show = silent) -> Table:
    """All computed points in the order of enumeration: axes that vary, objectives, feasible, on the front.

    A point is feasible by itself; it is on the front if its design is.
    """
    names = tuple(name for name in study.every_axis if len(axis_levels(study, name)) > 1)
    figures = study.objectives
    texts = {name: level_texts(study, name) for name in names}
    number = (*right("point"), *right(*(["design"] if study.conditions else [])))
    axes = left(*short_names(names))
    columns = (*number, *axes, *figure_columns(figures), *left("feasible", "on the front", "why not"))
    rows = []
    computed, why = study.outcomes.computed, PointWhys(study)
    for index in tracked(computed.tolist(), show, "points put into the table of all points", len(computed)):
        point, design = study.points[index], study.designs[index // study.judged.conditions]
        rows.append(
            (
                *(number_cell(each.index) for each in (point, design)[: len(number)]),
                *words(*(text(point.axes.get(name)) for name, text in texts.items())),
                *(figure_cell(figure, point.figure(figure)) for figure in figures),
                yes_cell(point.feasible and (design.feasible or bool(study.conditions))),
                yes_cell(bool(study.on_front[design.index])),
                word(why.of(index)),
            )
        )
    strong = frozenset(number for number, row in enumerate(rows) if row[-2].value)
    notes = (*_missing_notes(len(study.points) - len(computed), "point"), *_fixed_notes(study))
    return Table("All points", columns, tuple(rows), notes, strong)


def study_csv(study: Study) -> Table:
    """The computed points as raw values: ``study_columns``, why each is not on the front, and the provenance."""
    columns = _raw_columns(study, study.outcomes.computed, PointWhys(study))
    cells = tuple(tuple(Cell(str(value), value) for value in row) for row in zip(*columns.values(), strict=True))
    return Table("All points", left(*columns), cells)


def _raw_columns(study: Study, points: NDArray[np.int64], why: PointWhys) -> dict[str, list[Scalar]]:
    reasons: list[Scalar] = [why.of(index) for index in points.tolist()]
    return study_columns(study, points) | {"why_not": reasons} | provenance_columns(study, points)


class PointWhys:
    """The reasons why points are not on the front, in words; for points with the same reasons these are made once.

    See ``reason_text`` for ``gaps``.
    """

    def __init__(self, study: Study, *, gaps: bool = False) -> None:
        judged = self._judged = study.judged
        self._study, self._gaps = study, gaps
        lacking = np.zeros(judged.count, np.bool_)
        for figure in study.objectives:
            lacking |= np.isnan(judged.figure(figure))
        self._fine = np.repeat(judged.feasible & ~judged.unreached & ~lacking, judged.conditions)
        self._fine &= judged.feasible_points & ~judged.unreached_points
        self._own = np.zeros(len(study.outcomes), np.bool_)
        for broken in judged.broken_points:
            self._own[broken.which] = True
        self._texts: dict[tuple[int, int], str] = {}

    def of(self, index: int) -> str:
        """Of one point."""
        if self._fine[index]:
            return ""
        judged, outcomes = self._judged, self._study.outcomes
        # A constraint has a gap of its own at each point; so has a design over conditions.
        if judged.fits_points[index] or self._own[index] or outcomes.which[index] < 0:
            return self._text(index)
        key = int(outcomes.which[index]), int(outcomes.reason[index])
        if key not in self._texts:
            self._texts[key] = why_not(self._study.points[index], gaps=self._gaps)
        return self._texts[key] or self._text(index)

    def _text(self, index: int) -> str:
        study, gaps = self._study, self._gaps
        design = study.designs[index // self._judged.conditions]
        return why_not(study.points[index], gaps=gaps) or why_out(study, design, gaps=gaps)


_ROWS_AT_ONCE = 20_000


def write_study_csv(study: Study, path: Path, show: Show = silent) -> None:
    """Write every computed point with every axis and figure as CSV. ``show`` is told how far it is.

    Raises:
        RunError: the file cannot be written.
    """
    computed = study.outcomes.computed
    # Of no point there is a block too: it has the heading.
    parts = [computed[begin : begin + _ROWS_AT_ONCE] for begin in range(0, max(len(computed), 1), _ROWS_AT_ONCE)]
    why = PointWhys(study)
    blocks = (
        _raw_columns(study, rows, why) for rows in tracked(parts, show, "rows of CSV written", len(computed), size=len)
    )
    write_columns_csv(blocks, path)


def front_table(study: Study, most: int | None = None) -> Table:
    """The designs that no other design beats in every objective, best first by the first objective.

    Over conditions, a figure has its spread beside it. Further columns, where any design has them: the axes whose other
    values change nothing for it, and the designs that no objective tells apart from it. ``most``: rows; None: all.
    """
    designs = _Designs(study, study.objectives, spread=True)
    ranked = _ranked(study, *study.objectives[:1])[:most]
    rows = [designs.cells(study.designs[index]) for index in ranked]
    # Conditions are other questions on purpose, and the figures are over all of them.
    asked = () if study.conditions else asked_notes(study.templates)
    columns, notes = designs.columns, [*asked, *reach_notes(study.templates), summary(study)]
    if any(index in study.same for index in study.front):
        columns = (*columns, *left("the same with"))
        rows = [(*row, word(same_text(study, index))) for row, index in zip(rows, ranked, strict=True)]
    if study.alike:
        columns = (*columns, *left("not told apart from"))
        notes += alike_note(study)
        alike = (word(designs_text(study.alike.get(index, ()))) for index in ranked)
        rows = [(*row, cell) for row, cell in zip(rows, alike, strict=True)]
    return Table("Front", columns, tuple(rows), (*notes, *_fixed_notes(study)))


def best_design(study: Study, objective: ResultFigure) -> Design | None:
    """The design of the front that is best by an objective, of equals the first; None where none has it."""
    designs = (study.designs[index] for index in _ranked(study, objective)[:1])
    return next((design for design in designs if design.figure(objective) is not None), None)


def best_table(study: Study) -> Table:
    """For each objective the design of the front that is best in it, of equals the first.

    A further column says how sure that is (``verdicts``). Over conditions, it has the designs that this objective does
    not tell apart from it.
    """
    designs = _Designs(study, study.objectives, spread=True)
    rows = []
    for objective in study.objectives:
        design = best_design(study, objective)
        if design is not None:
            row = (Cell(aim_text(study, objective), objective.name), *designs.cells(design))
            apart = designs_text(study.alike_in(design.index, (objective,)))
            sure = apart if study.conditions else verdict_text(study.rivals.verdict(objective))
            rows.append((*row, word(sure)))
    columns = (*left("best"), *designs.columns, *left("not told apart in it from" if study.conditions else "how sure"))
    notes = alike_note(study) if study.conditions and any(row[-1].text for row in rows) else ()
    return Table("Best in each objective", columns, tuple(rows), notes)


def _ranked(study: Study, *objectives: ResultFigure) -> list[int]:
    """The designs of the front, best first by these objectives; a design without a value comes last."""

    def rank(index: int) -> tuple[float, ...]:
        values = [(study.designs[index].figure(objective), objective) for objective in objectives]
        losses = [
            math.inf if value is None else -value if study.world.maximise(objective) else value
            for value, objective in values
        ]
        return (*losses, index)

    return sorted(study.front, key=rank)


def infeasible_table(study: Study, show: Show = silent) -> Table:
    """Every design that cannot be built, is not wanted, or failed, with all its reasons."""
    kept = {*study.feasible, *study.missing}
    title = f"{kind_of_row(study).capitalize()}s left out"
    table = _left_out(study, title, [index for index in study.distinct if index not in kept], show)
    return replace(table, notes=_missing_notes(len(study.missing), kind_of_row(study)))


def nearest_table(study: Study) -> Table:
    """The designs that miss feasibility by least, nearest first."""
    return _left_out(study, "Nearest to feasible", study.nearest())


def _left_out(study: Study, title: str, indices: Sequence[int], show: Show = silent) -> Table:
    designs = _Designs(study)
    shown = tracked(indices, show, f"rows of the table {title} made", len(indices))
    rows = tuple(
        (*designs.cells(design), word(why_out(study, design))) for design in (study.designs[index] for index in shown)
    )
    return Table(title, (*designs.columns, *left("why")), rows)


def reasons_table(study: Study) -> Table:
    """The reasons why designs were left out, most frequent first.

    Each reason has its number of designs, the least gap, the design that has this gap, and the levers there.
    """
    kind, rows = kind_of_row(study), []
    for count in study.reasons:
        # Of a constraint on a figure that has no value, the name ends with the reason.
        without = count.kind == "constraint" and ": " in count.name
        measured = count.kind not in {"failure", "unreached", "no figure", "mapping"} and not without
        in_words = count.kind in {"failure", "unreached", "mapping"}
        rows.append(
            (
                word(count.kind),
                Cell(count.name if in_words else label(count.name), count.name),
                count_cell(count.designs),
                quantity_cell(count.least_gap if measured else None, count.unit),
                number_cell(count.nearest),
                word("; ".join(count.levers) or ABSENT),
            )
        )
    columns = (*left("kind", "what"), *right(f"{kind}s", "least gap", f"at {kind}"), *left("what would help there"))
    return Table(f"Why {kind}s were left out", columns, tuple(rows))


def why_not(point: StudyPoint, *, gaps: bool = False) -> str:
    """The reason why a point is out by itself, or did not reach its goals, in a line; else "". See ``reason_text``."""
    if point.state != "done":
        return "not computed" if point.failure is None else f"failed: {point.failure}"
    if point.unreached is not None:
        return f"goals not reached: {point.unreached}"
    return "; ".join(reason_text(reason, gap=gaps) for reason in point.reasons)


def why_out(study: Study, design: Design, *, gaps: bool = False) -> str:
    """The reason why a design is not on the front, in one line; "" if only better designs are the reason.

    A reason of one condition names this condition. See ``reason_text`` for ``gaps``.
    """
    if not study.conditions and (why := why_not(design.points[0], gaps=gaps)):
        return why
    if design.state != "done":
        return "not computed" if design.failure is None else f"failed: {design.failure}"
    if design.ended is not None:
        why, number = design.ended
        return f"goals not reached: {why} (at {condition_text(study, number)})"
    if lacking := study.lacking(design):
        return f"has no {', no '.join(_lack(design, figure) for figure in lacking)}"
    return "; ".join(
        reason_text(out.reason, gap=gaps)
        + ("" if out.condition is None else f" (at {condition_text(study, out.condition)})")
        for out in design.out
    )


def _lack(design: Design, figure: ResultFigure) -> str:
    """A figure that a design does not have; of a derived one with the reason in its first condition without it."""
    if not isinstance(figure, DerivedFigure):
        return figure.label

    def value(point: StudyPoint, name: str) -> float | None:
        return point.figure(FIGURES[name])

    whys = (figure.why_none(partial(value, point)) for point in design.points)
    why = next(filter(None, whys), "")
    return f"{figure.label}: {why}" if why else figure.label


def _missing_notes(count: int, kind: str) -> tuple[str, ...]:
    """The number that is not in a table, as they were not computed."""
    return (f"{counted(count, kind)} not computed",) if count else ()


def _fixed_notes(study: Study) -> tuple[str, ...]:
    """The axes with one value, in a note in place of a column each."""
    fixed = fixed_axes(study)
    return (f"the same for all: {', '.join(f'{name} {value}' for name, value in fixed)}",) if fixed else ()


# The answer of an exploration: one sentence, then the tables in reading order.

# The results of a study whose figures have all of its sources.


def sourced_results(study: Study) -> Iterator[Result]:
    """Results that have every source of the figures of a study, in the order of the points.

    Points that were priced differ in clock and power. Their sources follow from the laws of a style and from the part,
    so one point of each kind is simulated; where its files are missing, it is left out.
    """
    outcomes = study.outcomes
    kinds = set()
    for first in Groups.of(outcomes.which).in_turn.firsts.tolist():
        number = int(outcomes.which[first])
        if number < 0:
            continue
        template = outcomes.templates[number]
        yield template
        kind = (
            *(template.platform, template.planner, template.style, template.component, template.part),
            *(template.feasible, *sorted(template.places.items())),
        )
        if number not in outcomes.whole and kind not in kinds:
            kinds.add(kind)
            try:
                result = study.result(first)
            except CodesignError:
                continue
            assert result is not None, "it has a template"
            yield result


def study_sentence(study: Study) -> str:
    """The sentence of a study: what was explored, how many points have each fate, and the best of the first objective.

    If no point is feasible: the point that misses feasibility by least, and by what.
    """
    head = f"{study.workload} on {study.platform}, {summary(study)}"
    if not study.objectives:
        return printable(f"{head}.")
    best, nearest, kind = best_design(study, study.objectives[0]), study.nearest(), kind_of_row(study)
    end = ""
    if best is not None:
        value = aggregated_cell(study, best, study.objectives[0], spread=True).text
        end = f"; {aim_text(study, study.objectives[0])}: {value}, {kind} {best.index}"
    elif lack := _lacking(study):
        end = f"; no {kind} has {label(lack)}"
    elif nearest:
        design = study.designs[nearest[0]]
        end = f"; nearest to feasible: {kind} {design.index}, {why_out(study, design)}"
    return printable(f"{head}{end}.")


def _lacking(study: Study) -> str:
    """The first objective, and why, where feasible designs have none; "" where none is feasible."""
    first = study.objectives[0].name
    lacks = (reason.name for reason in study.reasons if reason.kind == "no figure")
    return next((name for name in lacks if name.partition(": ")[0] == first), "")


def study_tables(study: Study, *, everything: bool = False, show: Show = silent) -> tuple[Table, ...]:
    """The front, or the points nearest to feasible; how sure the best points are; winners and reasons.

    ``everything``: also the best points, every point, the reasons of each, and the sources of the figures.
    ``show`` is told how far it is.
    """
    doing(show, "finding the front, and how sure it is")
    tables = [front_table(study) if study.feasible else nearest_table(study)]
    if study.feasible and study.conditions:
        tables += [best_table(study), *([spread_table(study)] if study.world.draws is not None else [])]
    tables += filter(None, [search_table(study), winners_certainty_table(study)])
    doing(show, "comparing designs value by value")
    tables += filter(None, [winners_table(study), reasons_table(study)])
    if everything:
        doing(show, "finding what each axis moves")
        effects = effects_table(study.sensitivity(), study.objectives)
        tables += [best_table(study), effects, study_table(study, show), infeasible_table(study, show)]
        tables.append(sources_table(sourced_results(study)))
    return tuple(table for table in tables if table.rows)
