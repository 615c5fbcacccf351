"""A table before anyone decided how to show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from codesign.ground.errors import clip
from codesign.ground.notebooks import InNotebooks
from codesign.ground.units import counted

Align = Literal["left", "right"]
Value = float | int | str | bool | None


@dataclass(frozen=True)
class Column:
    """A column: its name, the unit of its values (texts carry their own), and its alignment."""

    name: str
    unit: str = ""
    align: Align = "left"


@dataclass(frozen=True)
class Cell:
    """A cell: what a reader sees (``text``) and what a program takes (``value``, in the unit of the column)."""

    text: str
    value: Value = None


@dataclass(frozen=True, repr=False)
class Table(InNotebooks):
    """A title, columns, rows of as many cells, and notes to be read below.

    ``strong`` holds the numbers of the rows that stand out: totals, points of the front.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()
    strong: frozenset[int] = field(default_factory=frozenset)

    def __repr__(self) -> str:
        size = f"{counted(len(self.rows), 'row')}, {counted(len(self.columns), 'column')}"
        return f"Table({clip(self.title)!r}: {size})"

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.columns):
                raise ValueError(f"row {number} of {self.title!r} has {len(row)} cells, not {len(self.columns)}")


def left(*names: str) -> tuple[Column, ...]:
    """Columns of words."""
    return tuple(Column(name) for name in names)


def right(*names: str, unit: str = "") -> tuple[Column, ...]:
    """Columns of numbers in one unit."""
    return tuple(Column(name, unit, "right") for name in names)


def word(text: str) -> Cell:
    """A word as a cell."""
    return Cell(text, text)


def words(*texts: str) -> tuple[Cell, ...]:
    """Cells of words."""
    return tuple(map(word, texts))


def pairs(title: str, rows: Sequence[tuple[str, Cell]], notes: tuple[str, ...] = ()) -> Table:
    """A table of two columns: what, and how much."""
    return Table(title, left("figure", "value"), tuple((Cell(name, name), cell) for name, cell in rows), notes)
