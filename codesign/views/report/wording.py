"""The numbers of a record as rows or columns of a table, with the labels, units and kinds that the record declares.

The label of a field is its title, else the label of the declared figure of its name, else its name in words. Its unit
is the unit of the declared figure, else the one that ``json_schema_extra`` declares, else the ending of its name:
``_s``, ``_j`` or ``_m``. So a field that is added to a record of a result stands in its table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.ground.errors import clip
from codesign.ground.figures import FIGURES, Counted, ResultFigure, named_unit
from codesign.ground.notebooks import InNotebooks
from codesign.ground.units import (
    PICOSECONDS_PER_SECOND,
    Dimension,
    counted,
    format_count,
    format_energy,
    format_frequency,
    format_power,
    format_time,
    shown_units,
)

# Numbers and parameters in a reader's words: one place, so that a page and a terminal say the same.

# A table before anyone decided how to show it.

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


def figure_columns(figures: Iterable[ResultFigure]) -> tuple[Column, ...]:
    """A column for each figure, in the figure's unit, headed by its label."""
    return tuple(Column(figure.label, figure.unit, "right") for figure in figures)


def word(text: str) -> Cell:
    """A word as a cell."""
    return Cell(text, text)


def words(*texts: str) -> tuple[Cell, ...]:
    """Cells of words."""
    return tuple(map(word, texts))


def pairs(title: str, rows: Sequence[tuple[str, Cell]], notes: tuple[str, ...] = ()) -> Table:
    """A table of two columns: what, and how much."""
    return Table(title, left("figure", "value"), tuple((Cell(name, name), cell) for name, cell in rows), notes)


ABSENT = "–"
"""Stands where there is no figure."""

ENDED, PACE = "ended", "what sets the pace"
"""Rows of tables. A page shows them in its head."""

_LONGEST = 160
_SHAPES = {"block", "blocks"}
_PREFIXES = ((1e-9, "n"), (1e-6, "u"), (1e-3, "m"), (1.0, ""))


def figure_cell(figure: ResultFigure, value: float | None, interval: tuple[float, float] | None = None) -> Cell:
    """A figure of a result, with its interval where one is given. The value is in the unit of ``figure``."""
    if figure.counted == "share":
        return share_cell(value)
    whole = figure.counted == "count" and value is not None
    cell = quantity_cell(round(value) if whole and value is not None else value, figure.unit)
    ends = "" if interval is None or value is None else ends_text(cell.text, *interval, figure.unit)
    return Cell(with_ends(cell.text, ends, Ends.INTERVAL), value) if ends else cell


def quantity_cell(value: float | None, unit: str = "") -> Cell:
    """A quantity in ``unit``, or a bare number."""
    return Cell(ABSENT) if value is None else Cell(quantity_text(value, unit), value)


def time_cell(picoseconds: int | None) -> Cell:
    """A time; its value is in seconds."""
    if picoseconds is None:
        return Cell(ABSENT)
    return Cell(format_time(picoseconds), picoseconds / PICOSECONDS_PER_SECOND)


def formed_cell(value: float | None, form: str) -> Cell:
    """A number as a format says it, such as ``{:.1%}``; "-" where there is none."""
    return Cell("-") if value is None else Cell(form.format(value), value)


def number_cell(number: int) -> Cell:
    """A number that names something, such as a design."""
    return Cell(str(number), number)


def count_cell(count: int | None) -> Cell:
    """A whole number."""
    return Cell(ABSENT) if count is None else Cell(format_count(count), count)


def share_cell(share: float | None) -> Cell:
    """A share of one."""
    return Cell(ABSENT) if share is None else Cell(share_text(share), share)


def part_cell(part: float, whole: float) -> Cell:
    """The share that ``part`` is of ``whole``, which may be more than all of it."""
    if whole <= 0:
        return Cell(ABSENT)
    return Cell(part_text(part / whole), part / whole)


def part_text(share: float) -> str:
    """A share that may be more than one, as percent: above 1 its cautious rounding has no meaning."""
    return share_text(share) if share <= 1 else f"{100 * share:.4g} %"


def yes_cell(truth: bool | None) -> Cell:
    """True if something holds."""
    return Cell(ABSENT) if truth is None else Cell("yes" if truth else "no", truth)


def share_text(share: float) -> str:
    """A share as percent. Only 1 is 100 %, only 0 is 0 %.

    >>> share_text(0.9999999), share_text(0.5), share_text(1)
    ('>99.99 %', '50 %', '100 %')
    """
    if 0.9999 < share < 1:
        return ">99.99 %"
    if 0 < share < 0.0001:
        return "<0.01 %"
    return f"{100 * share:.2f}".rstrip("0").rstrip(".") + " %"


def quantity_text(value: float, unit: str) -> str:
    """A quantity with the unit prefix that suits it.

    ``unit`` belongs to ``value``: s, ps, Hz, W, J or 1. Any other word stands behind the number.

    >>> quantity_text(0.00321, "s"), quantity_text(2.5, "cells"), quantity_text(1, "cells")
    ('3.21 ms', '2.5 cells', '1 cell')
    """
    if not math.isfinite(value):
        return f"{value}"
    if unit in {"s", "ps"}:
        picoseconds = round(value if unit == "ps" else value * PICOSECONDS_PER_SECOND)
        return format_time(picoseconds) if picoseconds else "0 s"
    if unit == "Hz" and value > 0:
        return format_frequency(value)
    if unit in {"W", "J"} and value >= 0:
        return format_power(value) if unit == "W" else format_energy(value)
    # From 10,000 on a fraction is no news; %g would turn to exponents.
    whole = (value == round(value) or abs(value) >= 1e4) and abs(value) < 1e15
    number = format_count(round(value)) if whole else f"{value:,.4g}"
    if unit in {"", "1"}:
        return number
    return f"{number} {unit.removesuffix('s') if value == 1 else unit}"


class Ends(StrEnum):
    """The meaning of two ends beside a value. Brackets are kept for what is assumed.

    A confidence interval has a column of its own, whose heading says so.

    >>> with_ends("4 ms", "1.5 to 15", Ends.INTERVAL), with_ends("4 ms", "3 ms to 4 ms", Ends.SPREAD)
    ('4 ms (1.5 to 15)', '4 ms, over the conditions 3 ms to 4 ms')
    """

    INTERVAL = "{value} ({ends})"
    """From the least to the greatest value that declared intervals leave open."""

    SPREAD = "{value}, over the conditions {ends}"
    """From the least to the greatest value that was computed."""


def with_ends(value: str, ends: str, meaning: Ends) -> str:
    """A value with two ends, marked by what they mean."""
    return meaning.format(value=value, ends=ends)


def interval_text(low: float, high: float, unit: str) -> str:
    """The interval of a figure; nothing where it is a point."""
    if low == high:
        return ""
    return f"{quantity_text(low, unit)} to {quantity_text(high, unit)}"


def ends_text(value: str, low: float, high: float, unit: str) -> str:
    """The interval of a figure of a result behind its ``value``, to three digits, without the unit that both share.

    Rounded outwards: what is shown holds all that may be. Nothing where both ends are one.

    >>> ends_text("12.3 ms", 0.008, 0.02501, "s"), ends_text("900 us", 0.0008, 0.0025, "s")
    ('8 to 25.1', '800 us to 2.5 ms')
    """
    if low == high:
        return ""
    ends = [quantity_text(_outwards(low, math.floor), unit), quantity_text(_outwards(high, math.ceil), unit)]
    shared = value.partition(" ")[2]
    if shared and all(end.endswith(f" {shared}") for end in ends):
        ends = [end.removesuffix(f" {shared}") for end in ends]
    return " to ".join(ends)


def _outwards(value: float, rounded: Callable[[float], int]) -> float:
    """A value rounded up or down to three digits."""
    if not value or not math.isfinite(value):
        return value
    scale = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    # What is on the grid but for its last bits stays there.
    steps = value / scale
    nearest = round(steps)
    return (nearest if math.isclose(steps, nearest, rel_tol=1e-9) else rounded(steps)) * scale


def axis_text(name: str, value: Any) -> str:
    """The value of an axis, or of a parameter, in a reader's words.

    >>> axis_text("relax.block", [36, 66]), axis_text("relax.schedule", [15, 31])
    ('36×66', '15, 31')
    >>> axis_text("relax.schedule", {"first": 7, "step": 8, "last": 255})
    '7 to 255 by 8'
    """
    if isinstance(value, Mapping):
        if set(value) == {"first", "step", "last"}:
            return f"{value['first']} to {value['last']} by {value['step']}"
        return cut(", ".join(f"{key} {axis_text(key, inner)}" for key, inner in value.items()))
    if isinstance(value, Sequence) and not isinstance(value, str):
        joint = "×" if name.rpartition(".")[2] in _SHAPES else ", "
        return cut(joint.join(axis_text("", inner) for inner in value))
    return _scalar_text(value)


def prefix(values: Sequence[float], unit: str) -> tuple[float, str]:
    """The prefixed unit that suits most of these values of one axis of a plot, and its size in ``unit``.

    >>> prefix([0.002, 0.003, 1.0], "s")
    (0.001, 'ms')
    """
    sizes = [(size, f"{sign}{unit}") for size, sign in _PREFIXES] if unit in {"s", "J", "W"} else [(1.0, unit)]
    middle = sorted(map(abs, values))[len(values) // 2] if values else 0.0
    if not middle:
        return 1.0, unit
    return next((size for size in reversed(sizes) if size[0] <= middle), sizes[0])


def labelled(name: str, unit: str) -> str:
    """The label of an axis of a plot.

    >>> labelled("time", "ms"), labelled("block RAMs", "1")
    ('time (ms)', 'block RAMs')
    """
    return name if unit in {"", "1"} else f"{name} ({unit})"


def wants_logarithm(least: float, most: float) -> bool:
    """True if an axis from ``least`` to ``most`` is easier to read by its logarithm."""
    return least > 0 and most / least > 20


_DIMENSIONS = {"s": Dimension.TIME, "Hz": Dimension.FREQUENCY, "W": Dimension.POWER, "J": Dimension.ENERGY}


def number_scales() -> dict[str, Any]:
    """The units that the script ``numbers.js`` chooses from, by the unit of a value."""
    units = {unit: [(name, float(size)) for name, size in shown_units(kind)] for unit, kind in _DIMENSIONS.items()}
    # A time is a whole number of picoseconds, and 0 of it is written in seconds.
    return {unit: {"base": next(name for name, size in of if size == 1), "units": of} for unit, of in units.items()}


def _scalar_text(value: Any) -> str:
    if value is None:
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    return quantity_text(value, "") if isinstance(value, float) else cut(str(value))


def cut(text: str, most: int = _LONGEST) -> str:
    """The text, of at most so many letters."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


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
