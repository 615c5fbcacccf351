"""One engine for the reports of all tools: a tool is an entry ``Tool``, and each kind of its reports a ``Kind``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from re import fullmatch
from typing import Any

from more_itertools import map_reduce, unique_everseen

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Text

Fields = Mapping[str, Any]
"""Fields of a ``Report``, by name."""

Find = Callable[[Text], Fields]

Named = tuple[str, str, int]
"""A count in a report: its name, the number as it is written, and the line."""

Used = Mapping[str, tuple[Mapping[str, float], ...]]
"""The names by which reports count a resource, with the amount that one of them counts as.

A name is a pattern of the whole name. The names of one mapping add up. Of several mappings the first one that a report
has names of counts.
"""


@dataclass(frozen=True)
class Kind:
    """One kind of report of a tool.

    ``mark``: the pattern of a line that only this kind has. ``read``: the fields that it tells. ``end``: words without
    which it is cut off. ``stage``: how far the design had come, if ``read`` and the head of the report do not say it.
    """

    mark: str
    read: Find
    end: str = ""
    stage: Stage = Stage.ROUTED


@dataclass(frozen=True)
class Tool:
    """The reports of one tool.

    ``marks``: patterns of lines that all its reports have. ``keys``: the keys that reports in JSON have instead; none
    where it writes no JSON. ``head``: version, date, top, part. ``known``: the kinds of reports in words.
    """

    name: str
    marks: tuple[str, ...]
    kinds: tuple[Kind, ...]
    head: Find = lambda _text: {}
    known: str = ""
    keys: tuple[str, ...] = ()

    def wrote(self, text: Text) -> bool:
        """True if the tool wrote a text, by its content."""
        if text.is_json:
            return bool(self.keys) and all(text.has(f'"{key}"') for key in self.keys)
        return all(text.find(mark) for mark in self.marks)

    def read(self, text: Text) -> Report:
        """A report of the tool.

        Raises:
            SpecError: it is cut off, or is another kind of report.
        """
        kind = next((kind for kind in self.kinds if text.find(kind.mark)), None)
        if kind is None:
            raise text.fault(1, f"is another report of {self.name}", f"{self.known} are read")
        if not text.has(kind.end):
            raise text.cut_off(repr(kind.end))
        defaults = {"tool": self.name, "version": "", "stage": kind.stage}
        return Report(file=text.file, digest=text.digest, **{**defaults, **self.head(text), **kind.read(text)})


def rows(text: Text, *patterns: str) -> Iterator[Named]:
    """The counts of lines: their name and number are the groups of a pattern. Patterns are looked for one by one."""
    for pattern in patterns:
        for line, match in text.all(pattern):
            yield match.group(1), match.group(2), line


def counted(text: Text, found: Iterable[Named], used: Used, missing: tuple[str, str] | None = None) -> Fields:
    """The resources that counts stand for, by the table of a tool; the first count of a name is taken.

    ``missing``: what is said if there is no LUT among them, and the remedy.

    Raises:
        SpecError: a count is no number, or there is no LUT.
    """
    counts = {}
    held = list(unique_everseen(found, key=itemgetter(0)))
    for resource, choices in used.items():
        readings = (
            [
                text.reading(amount, line, scale)
                for name, amount, line in held
                for pattern, scale in names.items()
                if fullmatch(pattern, name)
            ]
            for names in choices
        )
        of_first = next(filter(None, readings), None)
        if of_first is not None:
            counts[resource] = Reading(math.fsum(each.value for each in of_first), min(each.line for each in of_first))
    if missing is not None and "lut4" not in counts:
        raise text.fault(0, *missing)
    return {"used": counts}


def slowest(clocks: Iterable[ClockReading]) -> tuple[ClockReading, ...]:
    """Of each clock its slowest reading."""
    slow = map_reduce(clocks, attrgetter("name"), None, lambda held: min(held, key=lambda each: each.fmax.value))
    return tuple(slow.values())
