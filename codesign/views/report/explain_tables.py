"""An explanation as one sentence and tables."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

from more_itertools import map_reduce

from codesign.ground.figures import ResultFigure, label, named
from codesign.ground.units import counted
from codesign.inputs.constraint import BOUNDS
from codesign.system.explanation import AxisEffect, Explanation, Moved, Why
from codesign.system.results.result import Reason
from codesign.views.report.axes import short_names
from codesign.views.report.render import printable
from codesign.views.report.sentences import named_figure, reach_notes, reason_text, verdict_text
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Column,
    Table,
    axis_text,
    figure_cell,
    figure_columns,
    left,
    quantity_cell,
    quantity_text,
    right,
    share_text,
    word,
    words,
)

_FEW = 6
"""Rows of a table without -v; the rest is summed, or counted in a note."""

_MANY = 100
EQUAL = "equal"
_IN_SENTENCE = 2
LITTLE = 0.001
"""A share below this is little: 0.1 %."""

EFFECTS_NOTE = (
    "share of the variance over the feasible designs that the axis moves by itself; in brackets, by itself and"
    " together with others"
)
HOLES_NOTE = (
    "some combinations are out, so shares need not add up; a total share counts only designs with a feasible partner"
    " that differs in the axis alone"
)


def explanation_sentence(explanation: Explanation) -> str:
    """True if the design is feasible, what its time goes into or why it is out, and what is better."""
    number = "" if explanation.index is None else f"design {explanation.index} of "
    head = f"{number}{explanation.workload} on {explanation.platform}"
    if explanation.out:
        return printable(f"{head} is out: {_out_text(explanation)}.")
    fate = {True: "is on the front", False: "is feasible, but not on the front", None: "is feasible"}
    parts = [part for part in (_time_text(explanation), _best_text(explanation)) if part]
    return printable(f"{head} {fate[explanation.on_front]}{': ' if parts else ''}{'; '.join(parts)}.")


def _time_text(explanation: Explanation) -> str:
    why = explanation.time
    if why is None or not why.parts:
        return ""
    figure, first = named(why.figure), why.parts[0]
    value = figure_cell(figure, why.value).text
    share = share_text(min(first.share, 1.0))
    return f"{first.where} ({first.what}) takes {share} of the {figure.label} of {value}"


def _best_text(explanation: Explanation) -> str:
    """The neighbour that is better in something and worse in nothing."""
    better = [each for each in explanation.neighbours if each.dominates]
    if not better:
        return "no neighbour is better in all" if explanation.neighbours else ""
    return f"better is {_change_text(better[0])}, in {_labels(explanation, better[0].better)}"


def _out_text(explanation: Explanation) -> str:
    # The same reason in several conditions is said once.
    every = list(dict.fromkeys(_against(each.reason) for each in explanation.out))
    texts = every[:_IN_SENTENCE]
    more = len(every) - len(texts)
    text = " and ".join(texts) + (f" and {counted(more, 'more reason')}" if more else "")
    mends = [lever for each in explanation.out for lever in each.levers if lever.feasible]
    if mends:
        return f"{text}; {mends[0].what} makes it feasible"
    tried = any(lever.feasible is not None for each in explanation.out for lever in each.levers)
    return f"{text}; no single lever makes it feasible" if tried else text


def _against(reason: Reason) -> str:
    for bound in (f" {name.replace('_', ' ')}" for name in BOUNDS):
        if reason.kind == "constraint" and reason.name.endswith(bound) and not reason.words:
            demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
            return f"{label(reason.name.removesuffix(bound))} {demand}, not{bound} {limit}"
    return reason_text(reason)


def _change_text(moved: Moved) -> str:
    number = "" if moved.index is None else f"design {moved.index}, "
    return f"{number}{moved.what} {_value_text(moved.what, moved.before)} → {_value_text(moved.what, moved.after)}"


def _value_text(axis: str, value: Any) -> str:
    if isinstance(value, dict) and all("." in str(key) for key in value):
        return ", ".join(f"{key} {axis_text(key, inner)}" for key, inner in value.items())
    return axis_text(axis, value)


def _labels(explanation: Explanation, names: Sequence[str]) -> str:
    return ", ".join(_named(explanation, name).label for name in names)


def _named(explanation: Explanation, name: str) -> ResultFigure:
    words = explanation.derived.get(name)
    return named(name) if words is None else ResultFigure(name, "derived", "", words.label, words.unit)


def explanation_tables(explanation: Explanation, *, everything: bool = False) -> tuple[Table, ...]:
    """The tables: why out, with each lever by itself; why this time and this energy; neighbours; how sure; axes.

    ``everything``: all parts and all neighbours.
    """
    most = _MANY if everything else _FEW
    tables = [_chosen_table(explanation), _reasons_table(explanation), _levers_table(explanation, most)]
    for title, why in (("Why this time", explanation.time), ("Why this energy", explanation.energy)):
        if why is not None:
            tables.append(_why_table(title, why, explanation.condition, most))
    tables += [_neighbours_table(explanation, most), _sure_table(explanation)]
    names = list(explanation.objectives)
    tables.append(effects_table(explanation.effects, [_named(explanation, name) for name in names]))
    return tuple(table for table in tables if table.rows)


def _chosen_table(explanation: Explanation) -> Table:
    """The decisions, and what the objectives come to."""
    rows = [words(axis, axis_text(axis, value)) for axis, value in explanation.axes.items()]
    rows += [
        (word(_named(explanation, name).label), figure_cell(_named(explanation, name), value))
        for name, value in explanation.objectives.items()
    ]
    notes = (*explanation.notes, *reach_notes([explanation.result]))
    return Table("The design", left("axis or figure", "value"), tuple(rows), notes)


def _reasons_table(explanation: Explanation) -> Table:
    rows = []
    for each in explanation.out:
        reason = each.reason
        values = (None,) * 3 if reason.words else (reason.demand, reason.limit, reason.gap)
        numbers = (quantity_cell(value, reason.unit) for value in values)
        rows.append((word(reason.kind), word(label(reason.name)), *numbers, word(each.condition)))
    columns = (*left("kind", "what"), *right("demand", "limit", "gap"), *left("at"))
    if not any(row[-1].text for row in rows):
        columns, rows = columns[:-1], [row[:-1] for row in rows]
    return Table("Why it is out", columns, tuple(rows))


def _levers_table(explanation: Explanation, most: int) -> Table:
    """Each lever by itself: whether its reason goes, what the whole design is then, and its objectives."""
    rows = []
    figures = _differing(explanation, [lever for each in explanation.out for lever in each.levers])
    left_out = 0
    for each in explanation.out:
        left_out += max(0, len(each.levers) - most)
        for lever in each.levers[:most]:
            goes = ABSENT if lever.goes is None else "yes" if lever.goes else "no"
            what = lever.what
            if lever.before is not None or ": " not in what:
                what = f"{what}: {_value_text(what, lever.after)}" if lever.after is not None else what
            values = (figure_cell(figure, lever.figures.get(figure.name)) for figure in figures)
            rows.append((*words(label(each.reason.name), what, goes, _fate(lever)), *values))
    columns = (*left("reason", "lever", "reason goes", "design then"), *figure_columns(figures))
    notes = (f"{counted(left_out, 'more lever')}: -v",) if left_out else ()
    return Table("Each lever by itself", columns, tuple(rows), notes)


def _differing(explanation: Explanation, moved: Sequence[Moved]) -> list[ResultFigure]:
    """The objectives that are not the same everywhere."""
    values = {
        name: {own, *(each.figures[name] for each in moved if name in each.figures)}
        for name, own in explanation.objectives.items()
    }
    return [_named(explanation, name) for name, held in values.items() if len(held) > 1]


def _fate(moved: Moved) -> str:
    if moved.note and moved.feasible is None:
        return moved.note
    return "feasible" if moved.feasible else f"out: {', '.join(moved.out) or moved.note}"


def _why_table(title: str, why: Why, condition: str, most: int) -> Table:
    """The largest parts; the others, and parts of little share, as one row."""
    figure = named(why.figure)
    shown = [each for each in why.parts[:most] if each.share >= LITTLE or most > _FEW]
    rest = why.parts[len(shown) :]
    rows = [
        (
            *words(each.where, each.what),
            figure_cell(figure, each.amount),
            _share_cell(each.share),
            word("; ".join(named_figure(name, figure) for name, figure in each.figures.items())),
        )
        for each in shown
    ]
    if rest:
        amount, share = sum(each.amount for each in rest), sum(each.share for each in rest)
        text = f"{len(rest)} more"
        rows.append((*words("all else", text), figure_cell(figure, amount), _share_cell(share), word("")))
    rows.append((*words("all", ""), figure_cell(figure, why.value), _share_cell(1.0), word("")))
    where = f", at {condition}" if condition else ""
    columns = (
        *left("where", "what"),
        Column(figure.label, figure.unit, "right"),
        *right("share", unit="1"),
        *left("rests on"),
    )
    notes = (why.note,) if why.note else ()
    return Table(f"{title}{where}", columns, tuple(rows), notes, frozenset({len(rows) - 1}))


def _share_cell(share: float) -> Cell:
    return Cell(share_text(min(share, 1.0)), share)


def _neighbours_table(explanation: Explanation, most: int) -> Table:
    """The designs that differ in one thing: whether each is better, in what, and what its objectives come to."""
    figures = _differing(explanation, explanation.neighbours)
    rows, strong = [], set()
    telling = [each for each in explanation.neighbours if most > _FEW or _relation(explanation, each) != EQUAL]
    for number, each in enumerate(telling[:most]):
        if each.dominates:
            strong.add(number)
        index = () if explanation.index is None else (Cell(str(each.index), each.index),)
        values = (
            _against_cell(figure, explanation.objectives[figure.name], each.figures.get(figure.name))
            for figure in figures
        )
        change = words(each.what, f"{_value_text(each.what, each.before)} → {_value_text(each.what, each.after)}")
        rows.append((*index, *change, word(_relation(explanation, each)), *values))
    left_out = len(explanation.neighbours) - len(rows)
    index_column = () if explanation.index is None else right("design")
    title = "Steps to the next value" if explanation.index is None else "Neighbours: one axis differs"
    columns = (*index_column, *left("axis", "change", "it is"), *figure_columns(figures))
    notes = (f"{left_out} more: -v",) if left_out > 0 else ()
    return Table(title, columns, tuple(rows), notes, frozenset(strong))


def _relation(explanation: Explanation, moved: Moved) -> str:
    if moved.note:
        return moved.note
    if not moved.feasible:
        return f"out: {', '.join(moved.out)}"
    if not explanation.feasible:
        return "feasible"
    parts = [f"better in {_labels(explanation, moved.better)}"] if moved.better else []
    parts += [f"worse in {_labels(explanation, moved.worse)}"] if moved.worse else []
    return "; ".join(parts) or EQUAL


def _against_cell(figure: ResultFigure, own: float | None, there: float | None) -> Cell:
    """The value there, with the change from the design's own."""
    cell = figure_cell(figure, there)
    if own is None or there is None or own == there or own <= 0 or figure.counted == "share":
        return cell
    factor = there / own
    change = f"{100 * (factor - 1):+.3g} %" if factor < _FACTOR else f"× {factor:.3g}"
    return Cell(f"{cell.text} ({change})", there)


_FACTOR = 10
"""From here on a change is told as a factor."""


def _sure_table(explanation: Explanation) -> Table:
    """The interval of each objective, what moves it most, and whether the best design by it is sure."""
    rows = []
    for each in explanation.sure:
        figure = named(each.figure)
        ends = (figure_cell(figure, end) for end in (each.least, each.most))
        moved = "" if each.moved is None else named_figure(each.moved.name, each.moved.figure)
        best = "" if each.best is None else str(each.best)
        sure = "" if each.verdict is None else verdict_text(each.verdict)
        rival = "" if each.rival is None else str(each.rival)
        rows.append((word(figure.label), figure_cell(figure, each.value), *ends, *words(moved, best, sure, rival)))
    of_study = ("best design", "it is the best", "against") if explanation.index is not None else ()
    names = of_study or ("", "limit", "")
    columns = (*left("figure"), *right("value", "least", "most"), *left("moved most by", *names))
    kept = [number for number in range(len(columns)) if any(row[number].text for row in rows)]
    return Table(
        "How sure",
        tuple(columns[number] for number in kept),
        tuple(tuple(row[number] for number in kept) for row in rows),
    )


def effects_table(effects: Sequence[AxisEffect], figures: Sequence[ResultFigure]) -> Table:
    """The axes that move objectives: the share of its spread that the axis moves by itself, and its total share."""
    by_axis = map_reduce(effects, attrgetter("axis"), None, lambda held: {each.figure: each for each in held})
    moving = [
        figure for figure in figures if any(each.figure == figure.name and each.main is not None for each in effects)
    ]
    holes = any(not each.complete for each in effects)
    rows = []
    for name, held in zip(short_names(tuple(by_axis)), by_axis.values(), strict=True):
        cells = [_effect_cell(held[figure.name]) for figure in moving]
        paired = [Cell(share_text(min(each.paired for each in held.values())))] if holes else []
        rows.append((word(name), *cells, *paired))
    columns = (*left("axis"), *right(*(figure.label for figure in moving), *(["with a partner"] if holes else [])))
    notes = (EFFECTS_NOTE, *((HOLES_NOTE,) if holes else ()))
    return Table("Which axis moves which objective", columns, tuple(rows) if moving else (), notes)


def _effect_cell(effect: AxisEffect) -> Cell:
    if effect.main is None or effect.total is None:
        return Cell(ABSENT)
    return Cell(f"{_tenth(effect.main)} ({_tenth(effect.total)})", effect.main)


def _tenth(share: float) -> str:
    """A share to a tenth of a percent."""
    return "0 %" if not share else "<0.1 %" if share < LITTLE else f"{100 * share:.1f} %"
