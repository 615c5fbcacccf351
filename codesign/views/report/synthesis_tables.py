"""Synthesis and placement against the laws: by line of the demand, by module, and the clock."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter

from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.units import format_count
from codesign.hardware.rtl.compared import Compared
from codesign.views.report.wording import Cell, Ends, Table, left, right, with_ends, words


def synthesis_tables(result: Compared) -> Iterator[Table]:
    """The lines, the modules, and the clock where the circuit was placed."""
    yield _lines(result)
    yield _modules(result)
    if result.placements:
        yield _clocks(result)


def _count(value: float | None) -> Cell:
    return Cell("-") if value is None else Cell(format_count(int(value)), int(value))


def _lines(result: Compared) -> Table:
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
    shown = Cell("-") if ratio is None else Cell(f"{ratio:.2f}", ratio)
    return _count(predicted), _count(synthesised), shown


def _modules(result: Compared) -> Table:
    rows = tuple(
        (*words(each.module), *map(_count, (each.instances, *each.counts.by_resource().values())))
        for each in result.synthesis.modules
    )
    columns = (*left("module"), *right("instances", "LUT", "flip-flops", "block RAMs", "multipliers"))
    notes = (f"{format_count(result.synthesis.registers)} flip-flops stand in block RAMs, behind their outputs",)
    title = "Modules, without the modules in them"
    return Table(title, columns, rows, notes if result.synthesis.registers else ())


def _clocks(result: Compared) -> Table:
    rows = [
        (*words(f"placed, seed {each.seed}"), Cell(f"{each.clock / 1e6:.1f}", each.clock / 1e6))
        for each in result.placements
    ]
    clock, median = result.clock, result.median
    assert clock is not None
    assert median is not None
    rows.append((*words("median of the seeds"), Cell(f"{clock / 1e6:.1f}", clock / 1e6)))
    low, high = (bound / 1e6 for bound in result.law.interval)
    law = result.law.value / 1e6
    limit = with_ends(f"{law:.1f}", f"{low:.0f} to {high:.0f}", Ends.INTERVAL)
    rows.append((*words("clock limit of the law"), Cell(limit, law)))
    columns = (*left("clock"), *right("MHz"))
    notes = (f"critical path: {median.path.words}", f"law: {result.law.source}")
    return Table(f"Clock on {result.part}", columns, tuple(rows), notes, frozenset({len(rows) - 2}))
