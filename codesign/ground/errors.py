"""Errors for the user: the place, the fault and the remedy.

Every class crosses a process pool unchanged: the constructor's arguments are the exception's ``args``.
Exit codes: 0 done, 1 the run failed, 2 bad spec or usage, 3 the answer is no, 4 no answer is proved, 130 interrupted
(Ctrl-C), 143 terminated (SIGTERM).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

EXIT_DONE = 0
EXIT_FAILED = 1
EXIT_BAD_SPEC = 2
EXIT_NO = 3
"""The answer is no: nothing is feasible, a need is missed, two things differ, a certificate is refused."""
EXIT_OPEN = 4
"""A search ended before its answer was proved: its budget was spent, or the code of a planner failed."""
EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143


_SPACES = "\N{NO-BREAK SPACE}\N{THIN SPACE}\N{NARROW NO-BREAK SPACE}"


def printable(text: str, most: int | None = 200) -> str:
    """Text of any origin, made safe for a terminal.

    Control characters, marks of the writing direction and undecodable bytes are replaced. The text is cut to ``most``
    characters, unless that is None.

    >>> printable("a\\x1b[31mb")
    'a�[31mb'
    """
    shown = "".join(
        mark if mark.isprintable() or mark in _SPACES else "\N{REPLACEMENT CHARACTER}" for mark in text[:most]
    )
    return shown + "…" if most is not None and len(text) > most else shown


def printable_lines(text: str) -> str:
    """Text of several lines, each made safe for a terminal as by ``printable``, and not cut."""
    return "\n".join(printable(line, None) for line in text.split("\n"))


class CodesignError(Exception):
    """A mistake that the user can correct.

    Args:
        what: one sentence that names the value at fault.
        where: ``FILE:LINE:COLUMN``, ``FILE``, or the name of the argument.
        hint: the remedy, without "hint:".
    """

    exit_code = EXIT_FAILED

    def __init__(self, what: str, where: str | None = None, hint: str | None = None) -> None:
        super().__init__(what, where, hint)
        self.what = what
        self.where = where
        self.hint = hint

    def __str__(self) -> str:
        what = printable_lines(self.what)
        head = f"{printable(self.where, None)}: {what}" if self.where else what
        return f"{head}\n  hint: {printable_lines(self.hint)}" if self.hint else head


class InputError(CodesignError):
    """A value given to a function or to the command line cannot be used."""

    exit_code = EXIT_BAD_SPEC


class MapError(InputError):
    """A map cannot be read, generated, or planned on."""


class RunError(CodesignError):
    """A run cannot continue."""


class TraceError(CodesignError):
    """A trace file cannot be read or written."""


class StoreError(CodesignError):
    """A file of explored points cannot be read or written."""


class CertificateError(CodesignError):
    """A certificate of a front cannot be made or read, or is refused."""


class RefusedError(CertificateError):
    """A certificate was read, and does not hold."""

    exit_code = EXIT_NO


class Interrupted(KeyboardInterrupt):
    """Ctrl-C struck a command.

    It is not a plain ``KeyboardInterrupt``: where one has passed through code that was made from text, as the code of
    dataclasses is, Python ends the process by SIGINT with any exit code.
    """

    exit_code = EXIT_INTERRUPTED
    word = "interrupted"


class Terminated(Interrupted):
    """SIGTERM struck a command. The command ends as by Ctrl-C, with another exit code."""

    exit_code = EXIT_TERMINATED
    word = "terminated"


@dataclass(frozen=True)
class Fault:
    """One fault of a user's file.

    ``line`` and ``column`` count from 1; 0 means the file as a whole. ``key`` is the dotted path of the key.
    """

    file: str
    line: int
    column: int
    key: str
    what: str
    hint: str | None = None

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        head = printable(f"{place}: {self.key}" if self.key else place, None) + f": {printable_lines(self.what)}"
        return f"{head}\n  hint: {printable_lines(self.hint)}" if self.hint else head


class SpecError(CodesignError):
    """All faults of a spec, in the order of the file."""

    exit_code = EXIT_BAD_SPEC

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: (fault.file, fault.line, fault.column)))
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[SpecError], tuple[tuple[Fault, ...]]]:
        return type(self), (self.faults,)


class UnsuitedError(SpecError):
    """Faults between sound specs: this workload, or this point of it, cannot be placed on this platform."""


def reason_of(fault: Exception) -> str:
    """The reason that the system gives for a fault of reading or writing, or else its text."""
    return (isinstance(fault, OSError) and fault.strerror) or str(fault)


def nearest(word: str, accepted: Iterable[str]) -> str | None:
    """The accepted word nearest to ``word``, or None where none is near.

    >>> nearest("shedule", ["schedule", "block"])
    'schedule'
    """
    matches = difflib.get_close_matches(word, list(accepted), n=1, cutoff=0.6)
    return matches[0] if matches else None


def choose_hint(word: str, accepted: Iterable[str]) -> str:
    """The remedy for a word that is not accepted.

    >>> choose_hint("shedule", ["block", "schedule"])
    'did you mean schedule? accepted: block, schedule'
    """
    words = sorted(accepted)
    listed = f"accepted: {', '.join(words)}"
    near = nearest(word, words)
    return f"did you mean {near}? {listed}" if near else listed


def outside_map(
    cell: Sequence[int], shape: Sequence[int], name: str = "cell", first: Sequence[int] = ()
) -> tuple[str, str]:
    """The fault of a cell outside of a map of this shape, and the remedy.

    ``first``: the first cell of a map that is cropped.

    >>> outside_map((40, 0), (40, 60), "goal")
    ('goal (40, 0) is outside of the map of 40 × 60 cells', '(row, column) from (0, 0) to (39, 59)')
    """
    begin = first if any(first) else [0] * len(shape)
    end = [start + side - 1 for start, side in zip(begin, shape, strict=True)]
    here, lowest, highest = (f"({', '.join(str(int(part)) for part in place)})" for place in (cell, begin, end))
    axes = "(row, column) " if len(shape) == 2 else ""
    sides = " × ".join(str(side) for side in shape)
    kind = "cropped map" if any(first) else "map"
    return f"{name} {here} is outside of the {kind} of {sides} cells", f"{axes}from {lowest} to {highest}"


class WrittenFloat(float):
    """A number that keeps its ``text``, so that messages show ``1e6`` and not 1000000.0."""

    text: str

    def __new__(cls, value: float, text: str = "") -> Self:
        """The number ``value``, written as ``text``."""
        number = super().__new__(cls, value)
        number.text = text
        return number


def clip(text: str, most: int = 80) -> str:
    """Text cut to the length of a line."""
    return text if len(text) <= most else f"{text[:most]}..."


def show(value: object) -> str:
    """A value of a tree as the user wrote it, as far as known, cut to the length of a line.

    >>> [show(value) for value in (WrittenFloat(1e6, "1e6"), 7, True, "seven", None)]
    ['1e6', '7', 'true', "'seven'", 'an empty value']
    """
    if value is None:
        return "an empty value"
    if isinstance(value, WrittenFloat):
        return value.text
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    return clip(repr(value), 60)
