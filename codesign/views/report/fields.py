"""The numbers of a record as rows or columns of a table, with the labels, units and kinds that the record declares.

The label of a field is its title, else the label of the declared figure of its name, else its name in words. Its unit
is the unit of the declared figure, else the one that ``json_schema_extra`` declares, else the ending of its name:
``_s``, ``_j`` or ``_m``. So a field that is added to a record of a result stands in its table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.ground.figures import FIGURES, Counted, named_unit
from codesign.views.report.table import Cell, Column, Table, left, right, word, words
from codesign.views.report.wording import count_cell, quantity_cell, share_cell


@dataclass(frozen=True)
class Shown:
    """A field that holds a number: its name, its label, its unit, and whether it is a count or a share.

    The unit of a count stands only in the heading of its column.
    """

    name: str
    label: str
    unit: str
    counted: Counted

    def cell(self, value: Any) -> Cell:
        """One value. Counts by reason are added up."""
        if isinstance(value, Mapping):
            return count_cell(sum(value.values()))
        if self.counted == "share":
            return share_cell(value)
        if self.counted == "count" or (self.unit == "1" and isinstance(value, int)):
            return count_cell(value)
        return quantity_cell(value, self.unit)

    @property
    def is_declared(self) -> bool:
        """True if it is a declared figure of results."""
        return self.name in FIGURES

    @property
    def column(self) -> Column:
        """The column of its values."""
        unit = "" if self.unit == "1" and self.counted != "share" else self.unit
        return Column(self.label, unit, "right")


@cache
def shown_fields(kind: type) -> tuple[Shown, ...]:
    """The fields of a record that hold numbers, in their order; counts by reason if they have a title."""
    if issubclass(kind, BaseModel):
        fields = dict(kind.model_fields)
    else:
        hints = get_type_hints(kind, include_extras=True)
        fields = {name: FieldInfo.from_annotation(hint) for name, hint in hints.items()}
    return tuple(
        _shown(name, info)
        for name, info in fields.items()
        if _is_number(info.annotation) or (info.annotation == dict[str, int] and info.title)
    )


def _is_number(annotation: Any) -> bool:
    """True if the field holds a number, or a number or None."""
    optional = get_origin(annotation) in (Union, UnionType)
    return annotation in (int, float) or (optional and set(get_args(annotation)) <= {int, float, NoneType})


def _shown(name: str, info: FieldInfo) -> Shown:
    if name in FIGURES:
        figure = FIGURES[name]
        return Shown(name, info.title or figure.label, figure.unit, figure.counted)
    in_words, unit = named_unit(name)
    if isinstance(info.json_schema_extra, dict):
        unit = str(info.json_schema_extra.get("unit", unit))
    share = unit == "1" and ("share" in name or name == "utilisation")
    return Shown(name, info.title or in_words, unit, "share" if share else "measure")


def _fields_of(record: Any) -> tuple[Shown, ...]:
    kind: type = type(record)
    return shown_fields(kind)


def row_of(record: Any, name: str) -> tuple[str, Cell]:
    """One number of a record: its label and its value."""
    (field,) = (field for field in _fields_of(record) if field.name == name)
    return field.label, field.cell(vars(record)[name])


def rows_of(record: Any, *left_out: str, always: bool = True) -> list[tuple[str, Cell]]:
    """A row for each number of a record, in the order of its fields: its label and its value.

    Without ``always``, a number that is None has no row.
    """
    return [
        (field.label, field.cell(value))
        for field in _fields_of(record)
        if field.name not in left_out and ((value := vars(record)[field.name]) is not None or always)
    ]


def records_table(
    title: str, first: str, records: Iterable[tuple[str, Any]], kind: type, notes: tuple[str, ...] = ()
) -> Table:
    """A row for each named record of one ``kind``, and a column for each of its numbers.

    ``first`` is the heading of the names; where it is "", no column shows them.
    """
    fields = shown_fields(kind)
    names = left(first) if first else ()
    return Table(
        title,
        (*names, *(field.column for field in fields)),
        tuple(
            (*words(name)[: len(names)], *(field.cell(vars(record)[field.name]) for field in fields))
            for name, record in records
        ),
        notes,
    )


def shares_table(
    title: str,
    names: tuple[str, ...],
    amount: Column,
    parts: Iterable[tuple[Cell, ...]],
    total: Cell | None = None,
    notes: tuple[str, ...] = (),
) -> Table:
    """The parts of a whole, and their sum in the last row where it is given.

    A part is a tuple of cells: its ``names``, its ``amount`` and its share of the whole.
    """
    rows = tuple(parts)
    columns = (*left(*names), amount, *right("share", unit="1"))
    if total is None:
        return Table(title, columns, rows, notes)
    last = (word("all"), total, share_cell(1.0 if total.value else None))
    return Table(title, columns, (*rows, last), notes, strong=frozenset([len(rows)]))
