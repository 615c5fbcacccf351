"""Circuits against the model: a row for each style, and the first difference of each point that has one."""

from __future__ import annotations

from collections.abc import Sequence

from codesign.ground.units import format_count
from codesign.hardware.rtl.campaign import Checked, StyleChecked
from codesign.views.report.table import Cell, Table, left, right, words


def verification_table(styles: Sequence[StyleChecked]) -> Table:
    """Style, points, events and cycles compared, and differences."""
    rows = []
    for each in styles:
        points = each.verified
        counts = (
            len(each.points),
            sum(point.events for point in points),
            sum(point.cycles for point in points),
            sum(point.differences for point in points),
            len(each.points) - len(points),
        )
        cells = (Cell(format_count(count), count) for count in counts)
        rows.append((*words(each.planner, each.task or "planning", each.style), *cells))
    columns = (*left("planner", "task", "style"), *right("points", "events", "cycles", "differences", "failed"))
    return Table("Circuits against the model", columns, tuple(rows), notes=_notes(styles))


def _notes(styles: Sequence[StyleChecked]) -> tuple[str, ...]:
    shown = {each: sum(point.shown for point in each.verified) for each in styles}
    return tuple(
        f"{each.planner} {each.style}: the outputs of its display are compared in {format_count(cycles)} cycles, up to"
        " a frame after the end"
        for each, cycles in shown.items()
        if cycles
    ) + tuple(
        f"{each.planner} {each.style}: contention for a memory moves its cycles by {each.deviation:.2%} in the mean"
        for each in styles
        if each.deviation
    )


def difference_text(checked: Checked) -> str:
    """A point that differs or failed, in one line."""
    verified = checked.verified
    what = checked.failure if verified is None else str(verified.first)
    task = f" {checked.task}" if checked.task else ""
    return f"{checked.planner}{task} {checked.style}, {checked.point}: {what}"
