"""The reports of an FPGA tool beside the laws: as tables, and as a JSON document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from codesign.ground.figures import label
from codesign.ground.units import format_count
from codesign.hardware.calibrate.calibration import Compared
from codesign.hardware.calibrate.fpga import Comparison
from codesign.hardware.rtl.campaign import Checked, StyleChecked
from codesign.inputs.library import UNITS
from codesign.views.report.wording import Cell, Column, Table, left, right, word, words

# Circuits against the model: a row for each style, and the first difference of each point that has one.


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


_SCALES = {"Hz": (1e6, "MHz"), "W": (1e-3, "mW"), "": (1.0, "")}
"""The unit of a table for each unit of a term, and how much of the latter it is."""


def calibration_tables(compared: Comparison) -> tuple[Table, ...]:
    """Predicted against reported, and the factors that were fitted."""
    rows = tuple(_row(each) for each in compared.rows)
    columns = (*left("term", "design"), *right("predicted", "reported", "ratio"), *left("in law", "report"))
    tables = [Table("Predicted against reported", columns, rows)]
    if compared.lines:
        by_line = tuple((word(each.line), *_row(each)) for each in compared.lines)
        tables.append(Table("Lines of the demand", (Column("line"), *columns), by_line))
    calibration = compared.calibration
    if calibration is not None:
        fitted = []
        for term, errors in compared.errors.items():
            factor, offset = calibration.terms[term].factor, calibration.terms[term].offset
            low, high = factor.interval
            held_out = "-" if errors.held_out is None else f"{errors.held_out:.1%}"
            fitted.append(
                (
                    word(label(term)),
                    Cell(f"{factor.value:.4g}", factor.value),
                    word(f"{low:.4g} to {high:.4g}"),
                    Cell(f"{offset:+,.0f}" if offset else "-", offset),
                    Cell(f"{errors.before:.1%}", errors.before),
                    Cell(f"{errors.after:.1%}", errors.after),
                    Cell(held_out, errors.held_out),
                    Cell(str(len(calibration.terms[term].samples)), len(calibration.terms[term].samples)),
                )
            )
        heads = (
            Column("term"),
            *right("factor"),
            Column("interval"),
            *right("offset", "error of the law", "error left", "error held out", "samples"),
        )
        tables.append(Table(f"Calibration {calibration.name}", heads, tuple(fitted)))
    return tuple(tables)


def _row(each: Compared) -> tuple[Cell, ...]:
    low, high = each.predicted.interval
    inside = low <= each.reported <= high
    ratio = each.ratio
    return (
        word(label(each.term)),
        word(each.design),
        _amount(each.term, each.predicted.value),
        _amount(each.term, each.reported),
        Cell("-" if ratio is None else f"{ratio:.3f}", ratio),
        word("inside" if inside else "outside"),
        word(each.report),
    )


def _amount(term: str, value: float) -> Cell:
    scale, unit = _SCALES[UNITS.get(term, "")]
    scaled = value / scale
    text = f"{scaled:,.0f}" if unit == "" and scaled == int(scaled) else f"{scaled:,.1f}"
    return Cell(f"{text} {unit}".rstrip(), value)


def calibration_document(compared: Comparison) -> dict[str, Any]:
    """The comparison for programs: every row, the errors and the factors, in Hz, W and counts."""
    calibration = compared.calibration
    return {
        "rows": [_row_document(each) for each in compared.rows],
        "lines": [{"line": each.line, **_row_document(each)} for each in compared.lines],
        "terms": {
            term: {"before": errors.before, "after": errors.after, "held_out": errors.held_out}
            for term, errors in compared.errors.items()
        },
        "calibration": None if calibration is None else calibration.model_dump(mode="json"),
        "notes": list(compared.notes),
    }


def _row_document(each: Compared) -> dict[str, Any]:
    return {
        "term": each.term,
        "design": each.design,
        "predicted": each.predicted.value,
        "low": each.predicted.interval[0],
        "high": each.predicted.interval[1],
        "reported": each.reported,
        "ratio": each.ratio,
        "unit": UNITS.get(each.term, ""),
        "report": each.report,
        "law": each.predicted.source,
    }
