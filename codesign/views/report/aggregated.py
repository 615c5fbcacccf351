"""Designs over the conditions of a study, in a reader's words: rules, conditions, and figures with their spread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from more_itertools import map_reduce

from codesign.ground.figures import ResultFigure
from codesign.ground.units import counted
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import Constraint
from codesign.views.report.axes import level_texts, short_names
from codesign.views.report.table import Cell, Column, Table, left, right, word
from codesign.views.report.wording import ABSENT, figure_cell, quantity_text, share_cell

if TYPE_CHECKING:
    from codesign.study import Design, Study

_MOST_NAMED = 4


def kind_of_row(study: Study) -> str:
    """The name of a row in the tables of a study: a ``point``, or a ``design`` over all conditions."""
    return "design" if study.conditions else "point"


def figure_label(study: Study, figure: ResultFigure) -> str:
    """The name of the aggregated figure: its label, or the share that meets a limit of it."""
    rule = study.world.rule(figure)
    return f"share with {_limit_text(rule.share)}" if isinstance(rule, Share) else figure.label


def aim_text(study: Study, figure: ResultFigure) -> str:
    """The aim of the exploration for a figure: ``least time``, ``most share with time at most 5 ms``."""
    return f"{'most' if study.world.maximise(figure) else 'least'} {figure_label(study, figure)}"


def _limit_text(limit: Constraint) -> str:
    texts = []
    for bound, value in limit.bounds.items():
        text = f"{100 * value:.6g} %" if limit.of_part else quantity_text(value, limit.figure.unit)
        texts.append(f"{bound.replace('_', ' ')} {text}")
    return f"{limit.figure.label} {' and '.join(texts)}"


def figure_column(study: Study, figure: ResultFigure) -> Column:
    """The column of an aggregated figure."""
    unit = "1" if isinstance(study.world.rule(figure), Share) else figure.unit
    return Column(figure_label(study, figure), unit, "right")


def aggregated_cell(study: Study, design: Design, figure: ResultFigure, *, spread: bool = False) -> Cell:
    """An aggregated figure; with ``spread``, its least and greatest value over the conditions beside it.

    Without conditions, ``spread`` shows the interval that the assumed figures give it.
    """
    value = design.figure(figure)
    if spread and not study.conditions:
        return figure_cell(figure, value, design.points[0].interval(figure))
    by_share = isinstance(study.world.rule(figure), Share)
    cell = share_cell(value) if by_share else figure_cell(figure, value)
    extent = design.spread(figure) if spread else None
    if extent is None or value is None or (extent.least == extent.greatest and not by_share):
        return cell
    least, greatest = (figure_cell(figure, end).text for end in (extent.least, extent.greatest))
    return Cell(f"{cell.text} ({least} to {greatest})", cell.value)


def rules_text(study: Study) -> str:
    """The rule of each objective and constrained figure, in words; figures of one rule together."""
    figures = dict.fromkeys((*study.objectives, *(limit.figure for limit in study.constraints)))
    by_rule = map_reduce(
        figures, lambda figure: str(study.world.rule(figure)), lambda figure: figure_label(study, figure)
    )
    if len(by_rule) == 1:
        return f"by the {next(iter(by_rule))} over the conditions"
    texts = (f"{', '.join(names)} by the {rule}" for rule, names in by_rule.items())
    return f"over the conditions, {'; '.join(texts)}"


def condition_text(study: Study, number: int) -> str:
    """One combination of conditions, by what differs among them."""
    values, names = study.world.each[number], tuple(study.conditions)
    shown = [(name, short) for name, short in zip(names, short_names(names), strict=True)]
    varying = [(name, short) for name, short in shown if len(study.conditions[name]) > 1] or shown
    return ", ".join(f"{short} {level_texts(study, name)(values[name])}" for name, short in varying)


def designs_text(indices: Sequence[int]) -> str:
    """The numbers of some designs; of many, the first and how many more."""
    named = ", ".join(map(str, indices[:_MOST_NAMED]))
    return f"{named} and {len(indices) - _MOST_NAMED} more" if len(indices) > _MOST_NAMED else named


def same_text(study: Study, index: int) -> str:
    """The other values of the axes that change nothing for a design, such as ``axi.clock 1 MHz, 50 kHz``."""
    design, others = study.designs[index], study.same.get(index, ())
    parts = []
    for name, short in zip(study.axes, short_names(tuple(study.axes)), strict=True):
        text_of = level_texts(study, name)
        texts = dict.fromkeys(text_of(study.designs[other].axes.get(name)) for other in others)
        texts.pop(text_of(design.axes.get(name)), None)
        if texts:
            parts.append(f"{short} {', '.join(texts)}")
    return "; ".join(parts)


def alike_note(study: Study) -> tuple[str, ...]:
    """A note that says what it means that designs are not told apart."""
    if study.world.draws is None:
        why = "each of the two is better in some conditions, or they are equal in all"
    else:
        why = "the 95 % interval of their mean difference over the seeds holds 0"
    return (f"not told apart: {why}",)


def spread_table(study: Study) -> Table:
    """For each design of the front and each objective: its aggregated value, its interval, and its spread."""
    rows = []
    for index in study.front:
        for figure in study.objectives:
            design = study.designs[index]
            extent = design.spread(figure)
            if extent is None:
                continue
            bounds = Cell(ABSENT)
            if extent.interval is not None:
                by_share = isinstance(study.world.rule(figure), Share)
                low, high = (
                    (share_cell(min(max(end, 0.0), 1.0)) if by_share else figure_cell(figure, end)).text
                    for end in extent.interval
                )
                bounds = word(f"{low} to {high}")
            ends = (figure_cell(figure, end) for end in (extent.least, extent.greatest))
            deviation = Cell(quantity_text(extent.deviation, figure.unit), extent.deviation)
            rows.append(
                (
                    Cell(str(index), index),
                    Cell(figure_label(study, figure), figure.name),
                    aggregated_cell(study, design, figure),
                    bounds,
                    *ends,
                    deviation,
                )
            )
    columns = (
        *right("design"),
        *left("figure"),
        *right("aggregated"),
        *left("95 % interval"),
        *right("least", "greatest", "standard deviation"),
    )
    return Table(f"Spread over {counted(len(study.world.each), 'condition')}", columns, tuple(rows))
