"""Published against modelled, row by row.

What a reproduction holds is told by protocols: this package and ``codesign.reproduce`` stand on one level,
and neither imports the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from codesign.report.table import Cell, Table, left, right
from codesign.report.wording import ABSENT, quantity_text


class Row(Protocol):
    """One figure of a paper and what the model makes of it.

    ``published`` and ``modelled`` in ``unit``; ``error``: (modelled - published) / published, None where
    there is none; ``use``: what the published figure was used for before.
    """

    @property
    def table(self) -> str:
        """The table, figure or section of the paper."""

    @property
    def quantity(self) -> str:
        """What is counted or timed."""

    @property
    def published(self) -> float | str | None:
        """The figure in the paper."""

    @property
    def modelled(self) -> float | str | None:
        """The figure of the model."""

    @property
    def error(self) -> float | None:
        """The relative error of the model."""

    @property
    def unit(self) -> str:
        """The unit of both figures."""

    @property
    def status(self) -> str:
        """How the modelled figure is known."""

    @property
    def source(self) -> str:
        """Where the law comes from."""

    @property
    def use(self) -> str:
        """Whether a law was fitted to the row, or it was held out, or known when something was chosen."""

    @property
    def note(self) -> str:
        """What a reader should know about the row."""


class Reproduction(Protocol):
    """A paper's rows, and what agrees and what does not in words."""

    @property
    def rows(self) -> Sequence[Row]:
        """The rows in the order of the paper."""

    @property
    def findings(self) -> Sequence[str]:
        """Sentences made from the figures."""


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
                Cell(row.quantity, row.quantity),
                _figure(row.published, row.unit),
                _figure(row.modelled, row.unit),
                Cell(ABSENT if row.error is None else error_text(row.error), row.error),
                Cell(str(row.status), str(row.status)),
                Cell(str(row.use), str(row.use)),
                Cell(row.note, row.note),
            )
        )
    columns = (
        *left("table", "quantity"),
        *right("published", "modelled"),
        *right("error", unit="1"),
        *left("status", "use", "note"),
    )
    return Table("Published against modelled", columns, tuple(rows))


def reproduction_sources_table(reproduction: Reproduction) -> Table:
    """Each source once, with the tables, figures and sections of the paper that rest on it."""
    tables: dict[tuple[str, str], dict[str, None]] = {}
    for row in reproduction.rows:
        tables.setdefault((str(row.status), row.source), {})[row.table] = None
    return Table(
        "Where the modelled figures come from",
        left("status", "tables", "source"),
        tuple(
            (Cell(status, status), Cell(where := ", ".join(named), where), Cell(source, source))
            for (status, source), named in tables.items()
        ),
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


def _figure(value: float | str | None, unit: str) -> Cell:
    if value is None:
        return Cell(ABSENT)
    if isinstance(value, str):
        return Cell(value, value)
    return Cell(quantity_text(value, unit), value)
