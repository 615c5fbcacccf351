"""What a design takes of its part, of time and of power, as tables, and where all these figures come from."""

from __future__ import annotations

from collections.abc import Iterable

from codesign.figures import Figure, label
from codesign.report.mission_tables import NOT_DECLARED, not_declared_notes
from codesign.report.table import Cell, Table, left, right, word, words
from codesign.report.wording import count_cell, interval_text, part_cell, plural, quantity_text
from codesign.results.result import Result

_MOST_SOURCES = 100


def resource_table(result: Result) -> Table:
    """Demand against budget, kind by kind, each with its items. Kinds are never added up."""
    rows: list[tuple[Cell, ...]] = []
    strong = []
    for use in result.resources:
        strong.append(len(rows))
        rows.append(
            (
                word(label(use.resource)),
                word("all"),
                count_cell(use.demand),
                count_cell(use.budget),
                part_cell(use.demand, use.budget),
                count_cell(use.gap),
                Cell(""),
            )
        )
        rows += [
            (
                Cell(""),
                word(item.name),
                count_cell(int(item.figure.value)),
                Cell(""),
                Cell(""),
                Cell(""),
                word(item.figure.status),
            )
            for item in use.items
        ]
    columns = (
        *left("resource", "item"),
        *right("demand", "budget"),
        *right("used", unit="1"),
        *right("gap"),
        *left("status"),
    )
    return Table("Resources", columns, tuple(rows), strong=frozenset(strong))


def physical_table(result: Result) -> Table:
    """Clock, power and energy with their intervals and where they come from."""
    rows, each = [], "" if result.fleet is None else " of each board"
    notes: tuple[str, ...] = ()
    if result.clock is not None:
        rows.append(
            (word("clock"), Cell(quantity_text(result.clock.hz, "Hz"), result.clock.hz), Cell(""), Cell(""))
        )
        rows.append((word("clock limit"), *_source_cells(result.clock.limit)))
    if result.power is not None:
        rows.append((word(f"static power{each}"), *_source_cells(result.power.static)))
        rows.append((word(f"dynamic power{each}"), *_source_cells(result.power.dynamic)))
    rows += [
        (word(f"static power of {name}, which has no task"), *_source_cells(power))
        for name, power in result.idle_fpgas.items()
    ]
    if result.energy is not None and result.mission is None:
        energy = result.energy
        for name, joules in (
            (f"energy of {'the FPGA' if result.fleet is None else 'all FPGAs'}", energy.fpga_j),
            *((("energy of FPGAs without a task", energy.idle_fpgas_j),) if energy.idle_fpgas_j else ()),
            ("energy of processors", energy.processors_j),
            ("energy of links", energy.links_j),
            ("energy of memories", energy.memories_j),
            (f"energy {'up to the first plan' if result.fleet is None else 'of the run'}", energy.energy_j),
        ):
            told = Cell(quantity_text(joules, "J"), joules)
            if not joules and name in ("energy of links", "energy of memories"):
                if name.removeprefix("energy of ") not in energy.not_declared:
                    continue
                told = Cell(NOT_DECLARED)
            rows.append((word(name), told, Cell(""), Cell("")))
        notes = not_declared_notes(energy.not_declared)
    columns = (*left("figure"), *right("value"), *left("interval", "status"))
    return Table("Clock, power and energy", columns, tuple(rows), notes)


def sources_table(results: Iterable[Result]) -> Table:
    """Where the figures come from: each source once, with its status and the figures that rest on it."""
    figures: dict[tuple[str, str], dict[str, dict[str, None]]] = {}
    for result in results:
        for name, item, figure in _sources(result):
            items = figures.setdefault((figure.status.value, figure.source), {}).setdefault(name, {})
            items |= {item: None} if item else {}
    lines = sorted(figures.items(), key=lambda line: (_STRENGTH.index(line[0][0]), line[0][1]))
    left_out = len(lines) - _MOST_SOURCES
    return Table(
        "Where the figures come from",
        left("status", "figures", "source"),
        tuple(words(status, _listed(names), source) for (status, source), names in lines[:_MOST_SOURCES]),
        (f"{plural(left_out, 'more source')} in the JSON",) if left_out > 0 else (),
    )


_STRENGTH = ["published", "calibrated", "measured", "assumed"]


def _listed(names: dict[str, dict[str, None]]) -> str:
    return "; ".join(f"{name}: {', '.join(items)}" if items else name for name, items in names.items())


def _sources(result: Result) -> Iterable[tuple[str, str, Figure]]:
    """Each figure with a source: its name, the item of it or nothing, and the figure."""
    for use in result.resources:
        for item in use.items:
            yield label(use.resource), item.name, item.figure
    for name, figure in result.processor.items():
        yield name, "", figure
    if result.clock is not None:
        yield "clock limit", "", result.clock.limit
    if result.power is not None:
        yield "static power", "", result.power.static
        yield "dynamic power", "", result.power.dynamic
    for name, figure in result.idle_fpgas.items():
        yield "static power", name, figure


def _source_cells(figure: Figure) -> tuple[Cell, Cell, Cell]:
    return (
        Cell(quantity_text(figure.value, figure.unit), figure.value),
        word(interval_text(*figure.interval, figure.unit)),
        word(figure.status),
    )
