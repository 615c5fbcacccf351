"""The numbers of a record as rows or columns of a table: labels, units and kinds are those that the record declares.

A field is called by its title, else by the label of the figure of its name, else by its name in words. A name that ends
in ``_s``, ``_j`` or ``_m`` has this unit. So a field that is added to a record of a result stands in its table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.figures import FIGURES, Counted, named_unit
from codesign.report.table import Cell, Column, Table, left, word
from codesign.report.wording import ABSENT, count_cell, number_cell, quantity_text, share_cell


@dataclass(frozen=True)
class Shown:
    """A field that holds a number: its name, what it is called, its unit, and whether it is a count or a share.

    The unit of a count stands in the head of its column only.
    """

    name: str
    label: str
    unit: str
    counted: Counted

    def cell(self, value: Any) -> Cell:
        """A value of it; of counts by reason their sum."""
        if value is None:
            return Cell(ABSENT)
        if isinstance(value, Mapping):
            return count_cell(sum(value.values()))
        if self.counted == "share":
            return share_cell(value)
        if self.counted == "count" or (self.unit == "1" and isinstance(value, int)):
            return count_cell(value)
        return number_cell(value) if self.unit == "1" else Cell(quantity_text(value, self.unit), value)

    @property
    def column(self) -> Column:
        """A column of its values."""
        unit = "" if self.unit == "1" and self.counted != "share" else self.unit
        return Column(self.label, unit, "right")


@cache
def shown_fields(kind: type) -> tuple[Shown, ...]:
    """The fields of a record that hold numbers, in their order; counts by reason where they have a title."""
    if issubclass(kind, BaseModel):
        fields = dict(kind.model_fields)
    else:
        hints = get_type_hints(kind, include_extras=True)
        fields = {name: FieldInfo.from_annotation(hint) for name, hint in hints.items()}
    return tuple(
        _shown(name, info.title)
        for name, info in fields.items()
        if _is_number(info.annotation) or (info.annotation == dict[str, int] and info.title)
    )


def _is_number(annotation: Any) -> bool:
    """Whether it is a whole number or another one, or none."""
    optional = get_origin(annotation) in (Union, UnionType)
    return annotation in (int, float) or (optional and set(get_args(annotation)) <= {int, float, NoneType})


def _shown(name: str, title: str | None) -> Shown:
    if name in FIGURES:
        figure = FIGURES[name]
        return Shown(name, title or figure.label, figure.unit, figure.counted)
    words, unit = named_unit(name)
    share = unit == "1" and ("share" in name or name == "utilisation")
    return Shown(name, title or words, unit, "share" if share else "measure")


def _fields_of(record: Any) -> tuple[Shown, ...]:
    kind: type = type(record)
    return shown_fields(kind)


def row_of(record: Any, name: str) -> tuple[str, Cell]:
    """One number of a record: what it is called, and its value."""
    (field,) = (field for field in _fields_of(record) if field.name == name)
    return field.label, field.cell(vars(record)[name])


def rows_of(record: Any, *left_out: str, always: bool = True) -> list[tuple[str, Cell]]:
    """A row for each number of a record, in the order of its fields: what it is called, and its value.

    Without ``always``, a number that there is none of has no row.
    """
    return [
        (field.label, field.cell(value))
        for field in _fields_of(record)
        if field.name not in left_out and ((value := vars(record)[field.name]) is not None or always)
    ]


def records_table(
    title: str, first: str, records: Iterable[tuple[str, Any]], kind: type, notes: tuple[str, ...] = ()
) -> Table:
    """A row for each named record of one ``kind``, a column for each of its numbers; ``first`` heads the names."""
    fields = shown_fields(kind)
    return Table(
        title,
        (*left(first), *(field.column for field in fields)),
        tuple(
            (word(name), *(field.cell(vars(record)[field.name]) for field in fields))
            for name, record in records
        ),
        notes,
    )
