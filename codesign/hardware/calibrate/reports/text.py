"""The text of a report: read within bounds, decoded, and looked at line by line.

A reader refuses what it cannot take by a fault with the line. So every number of a report has a place.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from codesign.ground.errors import Fault, SpecError, clip, reason_of
from codesign.hardware.calibrate.reports.record import Reading

MAX_BYTES = 2**26
"""A timing report with all its paths has some tens of MB."""

MAX_COUNT = 10**9

MOST_COLUMNS = 4096
"""Of a line that a pattern is looked for in: no line of a report has more that is read, but for JSON."""

_NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:[eE][-+]?\d+)?")
_BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}


@dataclass(frozen=True)
class Row:
    """A row of a table: its cells, stripped, and its line in the file."""

    cells: tuple[str, ...]
    line: int


class Text:
    """The lines of a report. ``file``: as the user named it. ``digest``: SHA-256 of its bytes."""

    def __init__(self, file: str, content: bytes) -> None:
        self.file = file
        self.digest = hashlib.sha256(content).hexdigest()
        self.whole = _decode(content, file)
        self.lines = self.whole.splitlines()

    def fault(self, line: int, what: str, hint: str | None = None) -> SpecError:
        """A fault of a line (from 1), or of the whole file (0)."""
        return SpecError([Fault(self.file, line, 1 if line else 0, "", what, hint)])

    def cut_off(self, what: str) -> SpecError:
        """The fault of a report that ends early; ``what`` is missing."""
        return self.fault(len(self.lines), f"the report is cut off: {what} is missing", "write it again")

    def find(self, pattern: str, start: int = 1) -> tuple[int, re.Match[str]] | None:
        """The first line from ``start`` that a pattern is found in, with the match."""
        compiled = re.compile(pattern)
        for number, line in enumerate(self.lines[start - 1 :], start):
            match = compiled.search(line[:MOST_COLUMNS])
            if match:
                return number, match
        return None

    def all(self, pattern: str, start: int = 1) -> Iterator[tuple[int, re.Match[str]]]:
        """Every line from ``start`` that a pattern is found in, with the match."""
        compiled = re.compile(pattern)
        for number, line in enumerate(self.lines[start - 1 :], start):
            match = compiled.search(line[:MOST_COLUMNS])
            if match:
                yield number, match

    def value(self, *patterns: str) -> str:
        """The groups of the first match, as one text; of several patterns the first one with a text, else ""."""
        matches = filter(None, map(self.find, patterns))
        return next(filter(None, ("".join(match.groups()).strip() for _, match in matches)), "")

    def has(self, words: str) -> bool:
        """True if the text has these words anywhere."""
        return words in self.whole

    @property
    def is_json(self) -> bool:
        """True if it is JSON, or the begin of it."""
        return self.whole.lstrip().startswith("{")

    def json(self) -> dict[str, Any]:
        """The object of JSON that it is.

        Raises:
            SpecError: it is none, with the place.
        """
        try:
            tree = json.loads(self.whole)
        except (ValueError, RecursionError) as error:
            line = getattr(error, "lineno", len(self.lines))
            raise self.fault(line, "no JSON: the report is cut off or was edited", "write it again") from None
        if not isinstance(tree, dict):
            raise self.fault(1, "no JSON object", "write it again")
        return tree

    def line_of(self, name: str) -> int:
        """The first line that has a name of JSON; 1 where none has."""
        found = self.find(re.escape(json.dumps(name)))
        return found[0] if found else 1

    def number(self, text: str, line: int) -> float:
        """A number as tools write it: ``1,329``, ``-3.463``, ``0.5``. It is finite, and no larger than a chip.

        Raises:
            SpecError: it is no number, or out of bounds.
        """
        match = _NUMBER.fullmatch(text.strip())
        if match is None:
            raise self.fault(line, f"{clip(text.strip(), 40)!r} is not a number", "write the report in English")
        value = float(match.group().replace(",", ""))
        if abs(value) > MAX_COUNT:
            raise self.fault(line, f"{clip(text.strip(), 40)} is out of bounds", f"up to {MAX_COUNT:,}")
        return value

    def reading(self, text: str, line: int, scale: float = 1.0) -> Reading:
        """A number that cannot be negative, in the unit that ``scale`` makes of it.

        Raises:
            SpecError: it is no number, negative, or out of bounds.
        """
        value = self.number(text, line)
        if value < 0:
            raise self.fault(line, f"{clip(text.strip(), 40)} is negative", "check the report")
        return Reading(value * scale, line)

    def rows(self, start: int, mark: str) -> Iterator[Row]:
        """The rows of the first table from line ``start``: lines that begin with ``mark``, which parts cells too.

        Raises:
            SpecError: the file ends inside the table.
        """
        begun = False
        for number, line in enumerate(self.lines[start - 1 :], start):
            text = line.strip()
            if text.startswith(mark) and not text.startswith(mark + "--"):
                begun = True
                if not text.endswith(mark) or len(text) == 1:
                    raise self.fault(number, "the report is cut off inside a table", "write it again")
                yield Row(tuple(cell.strip() for cell in text[1:-1].split(mark)), number)
            elif begun and not text.startswith(("+", "-", mark)):
                return
        if begun and not self.lines[-1].strip().startswith(("+", "-")):
            raise self.cut_off("the end of a table")


def read_text(path: Path, file: str) -> Text:
    """The text of a file.

    Raises:
        SpecError: it is no readable file, is empty or too large, or is no text.
    """
    try:
        if not path.is_file():
            kind = "is a folder" if path.is_dir() else "is no file" if path.exists() else "does not exist"
            raise SpecError([Fault(file, 0, 0, "", kind, "name a report file")])
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise SpecError([Fault(file, 0, 0, "", f"cannot be read: {reason_of(error)}")]) from None
    if len(content) > MAX_BYTES:
        what, hint = f"is larger than {MAX_BYTES // 2**20} MiB", "write the report without its paths"
        raise SpecError([Fault(file, 0, 0, "", what, hint)])
    if not content.strip():
        raise SpecError([Fault(file, 0, 0, "", "is empty", "write the report again")])
    return Text(file, content)


def _decode(content: bytes, file: str) -> str:
    """UTF-8, UTF-16 with its mark, or else Latin-1, which Quartus writes."""
    encoding = next((name for mark, name in _BOMS.items() if content.startswith(mark)), "utf-8")
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if "\x00" in text:
        line = text[: text.index("\x00")].count("\n") + 1
        what, hint = "is no text: it has a zero byte", "name the report as text, not the database of the tool"
        raise SpecError([Fault(file, line, 1, "", what, hint)])
    return text
