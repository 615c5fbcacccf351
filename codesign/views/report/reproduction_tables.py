"""Published against modelled, row by row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields

from more_itertools import map_reduce

from codesign.planners.reproduction import Reproduction, Row
from codesign.system.results.provenance import Provenance
from codesign.views.report.table import Cell, Table, left, right, word, words
from codesign.views.report.wording import ABSENT, quantity_cell, yes_cell


def reproduction_table(reproduction: Reproduction) -> Table:
    """All rows in the order given, under the names that JSON has, with the relative error; notes come last.

    ``use``: whether a law was fitted to the row, or it was held out, or known when something was chosen.
    """
    rows = []
    previous = None
    for row in reproduction.rows:
        place = "" if row.table == previous else row.table
        previous = row.table
        rows.append(
            (
                Cell(place, row.table),
                word(row.quantity),
                figure_of_row(row.published, row.unit),
                figure_of_row(row.modelled, row.unit),
                Cell(ABSENT if row.error is None else error_text(row.error), row.error),
                *words(str(row.status), str(row.use), row.note),
            )
        )
    columns = (
        *left("table", "quantity"),
        *right("published", "modelled"),
        *right("error", unit="1"),
        *left("status", "use", "note"),
    )
    return Table("Published against modelled", columns, tuple(rows))


def reproduction_csv(reproductions: Sequence[Reproduction]) -> Table:
    """The rows of all papers as raw values: ``paper``, then the fields of ``Row``; the unit is a column of its own.

    The last columns are the version and the date.
    """
    made = Provenance().stamped().constants
    rows = ((each.paper, *astuple(row), *made.values()) for each in reproductions for row in each.rows)
    names = ("paper", *(field.name for field in fields(Row)), *made)
    return Table(
        "Published against modelled", left(*names), tuple(tuple(Cell("", value) for value in row) for row in rows)
    )


def findings_table(reproduction: Reproduction) -> Table:
    """Each statement, whether it holds in the run, and the figures that it rests on, a row for each."""
    rows = []
    for finding in reproduction.findings:
        first = (word(finding.statement), yes_cell(finding.holds))
        later = tuple(Cell("", cell.value) for cell in first)
        for index, texts in enumerate(finding.figures.items() or [("", "")]):
            rows.append((*(later if index else first), *words(*texts)))
    return Table("Findings", left("statement", "holds", "figure", "measured"), tuple(rows))


def joined_findings_table(reproduction: Reproduction) -> Table:
    """The findings in a row each, with the figures that they rest on in one cell."""
    rows = (
        (
            word(finding.statement),
            yes_cell(finding.holds),
            word("; ".join(f"{name}: {value}" for name, value in finding.figures.items())),
        )
        for finding in reproduction.findings
    )
    return Table("Findings", left("statement", "holds", "figures"), tuple(rows))


def reproduction_sources_table(reproduction: Reproduction) -> Table:
    """Each source once, with the tables, figures and sections of the paper that rest on it."""
    tables = map_reduce(
        reproduction.rows, lambda row: (str(row.status), row.source), lambda row: row.table, dict.fromkeys
    )
    return Table(
        "Where the modelled figures come from",
        left("status", "tables", "source"),
        tuple(words(status, ", ".join(named), source) for (status, source), named in tables.items()),
    )


def error_text(error: float) -> str:
    """A relative error as signed percent.

    >>> error_text(0.0), error_text(-0.0123), error_text(1.5)
    ('0 %', '-1.2 %', '+150 %')
    """
    if error == 0:
        return "0 %"
    percent = 100 * error
    if abs(percent) < 0.001:
        return "<0.001 %"
    return f"{percent:+.0f} %" if abs(percent) >= 10 else f"{percent:+.2g} %"


def figure_of_row(value: float | str | None, unit: str) -> Cell:
    """A figure of a row: a number with its unit, or words."""
    return word(value) if isinstance(value, str) else quantity_cell(value, unit)
