"""Designs over the conditions of a study, in a reader's words: rules, conditions, and figures with their spread."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from more_itertools import map_reduce

from codesign.ground.figures import ResultFigure
from codesign.ground.units import counted
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import Constraint
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.study.groups import Groups
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Column,
    Ends,
    Table,
    axis_text,
    figure_cell,
    left,
    number_cell,
    quantity_cell,
    quantity_text,
    right,
    share_cell,
    with_ends,
    word,
)

if TYPE_CHECKING:
    from codesign.study import Design, Study

# The axes of a study in a reader's words: which vary, what they are called, and their values as texts.


def varying_axes(study: Study) -> tuple[str, ...]:
    """The decisions with more than one value, in the order of the workload."""
    return tuple(name for name in study.axes if len(axis_levels(study, name)) > 1)


def short_names(axes: Sequence[str]) -> tuple[str, ...]:
    """The axes as headings: without the task or component where no other axis has the same last word.

    >>> short_names(["relax.block", "fpga.clock", "host.clock"])
    ('block', 'fpga.clock', 'host.clock')
    """
    last = Counter(name.rpartition(".")[2] for name in axes)
    return tuple(short if last[short := name.rpartition(".")[2]] == 1 else name for name in axes)


def fixed_axes(study: Study) -> tuple[tuple[str, str], ...]:
    """The axes and conditions with a single value, and that value."""
    return tuple((name, levels[0]) for name in study.every_axis if len(levels := axis_levels(study, name)) == 1)


def axis_levels(study: Study, name: str) -> list[str]:
    """The values of an axis as texts, in the order of the workload."""
    return list(dict.fromkeys(map(level_texts(study, name), study.every_axis[name])))


def level_texts(study: Study, name: str) -> Callable[[Any], str]:
    """The function that gives the text of a value of an axis.

    Of mappings, such as whole problems and whole scenarios, the text has only what differs among them. A platform is
    shown with its part, unless an axis moves parts.
    """
    values = study.every_axis.get(name, ())
    if name == PLATFORM_AXIS:
        platforms = _platform_texts(study)
        return lambda value: platforms.get(value, axis_text(name, value))
    mappings = [value for value in values if isinstance(value, Mapping)]
    ranges = all(set(value) == {"first", "step", "last"} for value in mappings)
    if len(mappings) < len(values) or len(values) < 2 or ranges:
        return lambda value: axis_text(name, value)
    leaves_of = [_leaves(value) for value in mappings]
    paths = list(dict.fromkeys(path for leaves in leaves_of for path in leaves))
    differing = [path for path in paths if len({repr(leaves.get(path)) for leaves in leaves_of}) > 1]

    def text(value: Any) -> str:
        leaves = _leaves(value) if isinstance(value, Mapping) else {}
        parts = (f"{path[-1]} {axis_text(path[-1], leaves[path])}" for path in differing if path in leaves)
        return ", ".join(parts) or axis_text(name, value)

    return text


def _platform_texts(study: Study) -> dict[str, str]:
    """The name and part of the platform that each value of the axis stands for; of values with a result."""
    moved = any(name.endswith(".part") for name in study.axes)
    templates, which = study.outcomes.templates, study.outcomes.which
    done = np.flatnonzero(which >= 0)[::-1]
    levels = study.space.levels(done)[PLATFORM_AXIS]
    pairs = (levels.astype(np.int64) * len(templates) + which[done])[levels >= 0]
    texts: dict[str, str] = {}
    # Of several parts the last one is shown.
    for number in pairs[Groups.of(pairs).in_turn.firsts[::-1]].tolist():
        place, template = divmod(number, len(templates))
        value, result = study.every_axis[PLATFORM_AXIS][place], templates[template]
        part = None if moved else result.part
        texts[value] = f"{result.platform} ({part})" if part else texts.get(value, result.platform)
    return texts


def _leaves(value: Mapping[str, Any], path: tuple[str, ...] = ()) -> dict[tuple[str, ...], Any]:
    """The values inside nested mappings, by their paths."""
    leaves: dict[tuple[str, ...], Any] = {}
    for key, inner in value.items():
        inner_path = (*path, str(key))
        leaves |= _leaves(inner, inner_path) if isinstance(inner, Mapping) else {inner_path: inner}
    return leaves


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
    return Cell(with_ends(cell.text, f"{least} to {greatest}", Ends.SPREAD), cell.value)


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
        why = "the 95 % confidence interval of their mean difference over the seeds holds 0"
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
            name = Cell(figure_label(study, figure), figure.name)
            ends = (figure_cell(figure, end) for end in (extent.least, extent.greatest))
            deviation = quantity_cell(extent.deviation, figure.unit)
            rows.append((number_cell(index), name, aggregated_cell(study, design, figure), bounds, *ends, deviation))
    spread = right("least", "greatest", "standard deviation")
    aggregated = (*right("aggregated"), *left("95 % confidence interval"))
    columns = (*right("design"), *left("figure"), *aggregated, *spread)
    return Table(f"Spread over {counted(len(study.world.each), 'condition')}", columns, tuple(rows))
