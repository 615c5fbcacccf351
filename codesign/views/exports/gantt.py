"""A run as a Gantt chart of characters: ``hwsw trace timeline FILE``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import Mark, Span, activities, share_over_time, union
from codesign.ground.errors import printable
from codesign.ground.records import Record
from codesign.ground.units import format_time

_SHADES = " ░▒▓█"
_MARK = "▾"
_LEAST_WIDTH = 20
_MOST_NAME = 32


@dataclass(frozen=True, eq=False)
class Row:
    """A track: the share of each part of the time in which it was busy, float64; of marks, how many fall into it."""

    name: str
    values: NDArray[np.float64]
    marks: bool = False

    def line(self) -> str:
        """A character for each part: none, up to a quarter, a half, three quarters, more."""
        if self.marks:
            return "".join(_MARK if value else " " for value in self.values)
        steps = np.minimum(np.ceil(self.values * (len(_SHADES) - 1)), len(_SHADES) - 1).astype(np.intp)
        return "".join(_SHADES[step] for step in steps)


@dataclass(frozen=True)
class Gantt:
    """Rows over so many equal parts of the time from ``begin`` to ``end``, ps."""

    begin: int
    end: int
    rows: tuple[Row, ...]
    parts: int

    def lines(self) -> list[str]:
        """The chart as text: a head with times, a line a row, and what the shades mean."""
        names = [printable(row.name, _MOST_NAME) for row in self.rows]
        wide = max(map(len, names), default=0)
        head = f"{'':<{wide}}  {_scale(self.begin, self.end, self.parts)}"
        body = [f"{name:<{wide}}  {row.line()}{_percent(row)}" for name, row in zip(names, self.rows, strict=True)]
        part = format_time((self.end - self.begin) // self.parts)
        return [head, *body, f"one character is {part}; busy in it:  ░ up to 25 %  ▒ 50 %  ▓ 75 %  █ more"]


def _columns(terminal: int, names: Iterable[str]) -> int:
    """The number of characters of a terminal that are left for the time."""
    wide = max((min(len(name), _MOST_NAME) for name in names), default=0)
    return max(_LEAST_WIDTH, terminal - wide - len("  ") - len("  100 %"))


def gantt(records: Iterable[Record], terminal: int, begin: int = 0, end: int | None = None) -> Gantt:
    """The rows of all tracks between ``begin`` and ``end`` (ps; None: the end of the run), for so wide a terminal."""
    said = list(activities(records))
    spans = map_reduce((each for each in said if isinstance(each, Span)), lambda each: each.track)
    marks = [each.time for each in said if isinstance(each, Mark) and not each.track]
    last = max([*marks, *(each.end for own in spans.values() for each in own)], default=0)
    until = max(begin + 1, last if end is None else min(end, max(last, begin + 1)))
    names = sorted(spans)
    bins = _columns(terminal, names)
    rows = [Row(name, share_over_time(union(each.times for each in spans[name]), begin, until, bins)) for name in names]
    if marks:
        inside = [time for time in marks if begin <= time <= until]
        counts = np.histogram(inside, bins, (begin, until))[0].astype(np.float64)
        rows.insert(0, Row("events", counts, marks=True))
    return Gantt(begin, until, tuple(rows), bins)


def _scale(begin: int, end: int, width: int) -> str:
    first, last = format_time(begin), format_time(end)
    return f"{first}{'':<{max(1, width - len(first) - len(last))}}{last}"


def _percent(row: Row) -> str:
    if row.marks:
        return f"  {int(row.values.sum()):,}"
    share = 100 * float(row.values.mean())
    return f"  {share:.3g} %" if share else ""
