"""The reports of an FPGA tool beside the laws: as tables, and as a JSON document."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Any

from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.units import format_count
from codesign.hardware.calibrate.calibration import Compared
from codesign.hardware.calibrate.fpga import Comparison
from codesign.hardware.rtl.place import Compared as Synthesised
from codesign.hardware.rtl.verify import Checked, StyleChecked
from codesign.inputs.library import UNITS
from codesign.views.report.wording import (
    Cell,
    Ends,
    Table,
    count_cell,
    formed_cell,
    left,
    number_cell,
    right,
    with_ends,
    word,
    words,
)

# Circuits against the model: a row for each style, and the first difference of each point that has one.


def verification_table(styles: Sequence[StyleChecked]) -> Table:
    """Style, points, events and cycles compared, and differences."""
    rows = []
    for each in styles:
        sums = (sum(getattr(point, name) for point in each.verified) for name in ("events", "cycles", "differences"))
        counts = (len(each.points), *sums, len(each.points) - len(each.verified))
        rows.append((*words(each.planner, each.task or "planning", each.style), *map(count_cell, counts)))
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
        tables.append(Table("Lines of the demand", (*left("line"), *columns), by_line))
    calibration = compared.calibration
    if calibration is not None:
        fitted = []
        for term, errors in compared.errors.items():
            fit = calibration.terms[term]
            low, high = fit.factor.interval
            fitted.append(
                (
                    word(label(term)),
                    formed_cell(fit.factor.value, "{:.4g}"),
                    word(f"{low:.4g} to {high:.4g}"),
                    Cell(f"{fit.offset:+,.0f}" if fit.offset else "-", fit.offset),
                    *(formed_cell(error, "{:.1%}") for error in (errors.before, errors.after, errors.held_out)),
                    number_cell(len(fit.samples)),
                )
            )
        errors_left = right("offset", "error of the law", "error left", "error held out", "samples")
        heads = (*left("term"), *right("factor"), *left("interval"), *errors_left)
        tables.append(Table(f"Calibration {calibration.name}", heads, tuple(fitted)))
    return tuple(tables)


def _row(each: Compared) -> tuple[Cell, ...]:
    low, high = each.predicted.interval
    return (
        *words(label(each.term), each.design),
        *(_amount(each.term, value) for value in (each.predicted.value, each.reported)),
        formed_cell(each.ratio, "{:.3f}"),
        *words("inside" if low <= each.reported <= high else "outside", each.report),
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


def synthesis_tables(result: Synthesised) -> Iterator[Table]:
    """The lines, the modules, and the clock where the circuit was placed."""
    yield _lines(result)
    yield _modules(result)
    if result.placements:
        yield _clocks(result)


def _lines(result: Synthesised) -> Table:
    rows = [
        (*words(each.line or "no line", label(each.resource)), *_pair(each.predicted, each.synthesised))
        for each in result.lines
    ]
    first_total = len(rows)
    for resource, lines in map_reduce(result.lines, attrgetter("resource")).items():
        known = None if result.lines[0].predicted is None else sum(each.predicted or 0 for each in lines)
        rows.append((*words("all", label(resource)), *_pair(known, sum(each.synthesised for each in lines))))
    columns = (*left("line", "resource"), *right("predicted", "synthesised", "predicted / synthesised"))
    strong = frozenset(range(first_total, len(rows)))
    return Table(f"Lines of the demand, {result.synthesis.family}", columns, tuple(rows), result.notes, strong)


def _pair(predicted: int | None, synthesised: int) -> tuple[Cell, Cell, Cell]:
    ratio = predicted / synthesised if predicted is not None and synthesised else None
    return formed_cell(predicted, "{:,}"), count_cell(synthesised), formed_cell(ratio, "{:.2f}")


def _modules(result: Synthesised) -> Table:
    rows = tuple(
        (word(each.module), *map(count_cell, (each.instances, *each.counts.by_resource().values())))
        for each in result.synthesis.modules
    )
    columns = (*left("module"), *right("instances", "LUT", "flip-flops", "block RAMs", "multipliers"))
    notes = (f"{format_count(result.synthesis.registers)} flip-flops stand in block RAMs, behind their outputs",)
    title = "Modules, without the modules in them"
    return Table(title, columns, rows, notes if result.synthesis.registers else ())


def _clocks(result: Synthesised) -> Table:
    rows = [(word(f"placed, seed {each.seed}"), formed_cell(each.clock / 1e6, "{:.1f}")) for each in result.placements]
    clock, median = result.clock, result.median
    assert clock is not None
    assert median is not None
    rows.append((word("median of the seeds"), formed_cell(clock / 1e6, "{:.1f}")))
    low, high = (bound / 1e6 for bound in result.law.interval)
    law = result.law.value / 1e6
    limit = with_ends(f"{law:.1f}", f"{low:.0f} to {high:.0f}", Ends.INTERVAL)
    rows.append((word("clock limit of the law"), Cell(limit, law)))
    notes = (f"critical path: {median.path.words}", f"law: {result.law.source}")
    columns = (*left("clock"), *right("MHz"))
    return Table(f"Clock on {result.part}", columns, tuple(rows), notes, frozenset({len(rows) - 2}))
