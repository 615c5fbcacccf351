"""What the user is told when something is wrong: where, what, and the remedy.

Every class crosses a process pool unchanged (the constructor's arguments are the exception's ``args``).
Exit codes: 0 done, 1 the run failed, 2 bad spec or usage, 3 nothing feasible, 130 interrupted (Ctrl-C), 143 terminated
(SIGTERM).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

EXIT_DONE = 0
EXIT_FAILED = 1
EXIT_BAD_SPEC = 2
EXIT_INFEASIBLE = 3
EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143


_SPACES = "\N{NO-BREAK SPACE}\N{THIN SPACE}\N{NARROW NO-BREAK SPACE}"


def printable(text: str, most: int | None = 200) -> str:
    """Text of foreign origin, fit for a terminal.

    No control characters, no writing direction, no bytes that were no text; and no endless line: at most ``most``
    characters, where given.

    >>> printable("a\\x1b[31mb")
    'a�[31mb'
    """
    shown = "".join(
        mark if mark.isprintable() or mark in _SPACES else "\N{REPLACEMENT CHARACTER}" for mark in text[:most]
    )
    return shown + "…" if most is not None and len(text) > most else shown


def _lines(text: str) -> str:
    return "\n".join(printable(line, None) for line in text.split("\n"))


class CodesignError(Exception):
    """A mistake that the user can mend.

    Args:
        what: one sentence, naming the value at fault.
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
        what = _lines(self.what)
        head = f"{printable(self.where, None)}: {what}" if self.where else what
        return f"{head}\n  hint: {_lines(self.hint)}" if self.hint else head


class InputError(CodesignError):
    """A value handed to a function or to the command line cannot be used."""

    exit_code = EXIT_BAD_SPEC


class MapError(InputError):
    """A map cannot be read, made, or planned on."""


class RunError(CodesignError):
    """A run that began cannot go on."""


class TraceError(CodesignError):
    """A trace file cannot be read or written."""


class StoreError(CodesignError):
    """A file of explored points cannot be read or written."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C struck a command.

    A class of its own: Python ends a process by SIGINT, whatever its exit code, once a ``KeyboardInterrupt`` itself has
    passed through code that is made from text, as that of dataclasses is.
    """

    exit_code = EXIT_INTERRUPTED
    word = "interrupted"


class Terminated(Interrupted):
    """SIGTERM struck a command: it ends as by Ctrl-C, with an exit code of its own."""

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
        head = printable(f"{place}: {self.key}" if self.key else place, None) + f": {_lines(self.what)}"
        return f"{head}\n  hint: {_lines(self.hint)}" if self.hint else head


class SpecError(CodesignError):
    """All the faults of a spec at once, in file order."""

    exit_code = EXIT_BAD_SPEC

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: (fault.file, fault.line, fault.column)))
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[SpecError], tuple[tuple[Fault, ...]]]:
        return type(self), (self.faults,)


def nearest(word: str, accepted: Iterable[str]) -> str | None:
    """The accepted word nearest to what was typed, or None where nothing is near.

    >>> nearest("shedule", ["schedule", "block"])
    'schedule'
    """
    matches = difflib.get_close_matches(word, list(accepted), n=1, cutoff=0.6)
    return matches[0] if matches else None


def choose_hint(word: str, accepted: Iterable[str]) -> str:
    """The remedy for a word that is none of the accepted ones.

    >>> choose_hint("shedule", ["block", "schedule"])
    'did you mean schedule? accepted: block, schedule'
    """
    words = sorted(accepted)
    listed = f"accepted: {', '.join(words)}"
    near = nearest(word, words)
    return f"did you mean {near}? {listed}" if near else listed


def outside_map(cell: Sequence[int], shape: Sequence[int], name: str = "cell") -> tuple[str, str]:
    """What is wrong with a cell that no map of this shape has, and the remedy.

    >>> outside_map((40, 0), (40, 60), "goal")
    ('goal (40, 0) is outside of the map of 40 × 60 cells', '(row, column) from (0, 0) to (39, 59)')
    """
    here, first, last = (
        f"({', '.join(str(int(part)) for part in place)})"
        for place in (cell, [0] * len(shape), [side - 1 for side in shape])
    )
    axes = "(row, column) " if len(shape) == 2 else ""
    sides = " × ".join(str(side) for side in shape)
    return f"{name} {here} is outside of the map of {sides} cells", f"{axes}from {first} to {last}"


class WrittenFloat(float):
    """A number that keeps its ``text``, so that ``1e6`` is not told to have been 1000000.0."""

    text: str

    def __new__(cls, value: float, text: str = "") -> Self:
        """The number ``value``, written as ``text``."""
        made = super().__new__(cls, value)
        made.text = text
        return made


def clip(text: str, most: int = 80) -> str:
    """Text cut to what fits on a line."""
    return text if len(text) <= most else f"{text[:most]}..."


def show(value: object) -> str:
    """A value of a tree as the user wrote it, as far as that can be told, cut to what fits on a line.

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
