"""One engine for the reports of all tools: a tool is an entry ``Tool``, and each kind of its reports a ``Kind``."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from enum import IntEnum
from operator import attrgetter, itemgetter
from pathlib import Path
from re import fullmatch
from typing import Any

from more_itertools import map_reduce, unique_everseen

from codesign.ground.errors import Fault, SpecError, clip, reason_of
from codesign.hardware.rtl.cells import COUNTED, Counts

# The text of a report: read within bounds, decoded, and looked at line by line.

# What a report of a synthesis or place-and-route tool says, in the terms of the laws.


class Stage(IntEnum):
    """The state that the design had come to, earliest first. A later stage takes the place of an earlier one."""

    SYNTHESISED = 0
    PLACED = 1
    ROUTED = 2

    @property
    def word(self) -> str:
        """The stage in a word: ``routed``."""
        return self.name.lower()


@dataclass(frozen=True)
class Reading:
    """One number of a report, and its line."""

    value: float
    line: int


@dataclass(frozen=True)
class ClockReading:
    """The clock of one domain, Hz.

    - ``fmax``: the fastest clock by the tool's analysis. ``constraint``: what was asked for; None where nothing was.
    """

    name: str
    fmax: Reading
    constraint: float | None = None

    @property
    def met(self) -> bool:
        """True if the constraint was met. The tool then had no reason to go on, so ``fmax`` is a lower bound."""
        return self.constraint is not None and self.fmax.value >= self.constraint


@dataclass(frozen=True)
class Inside:
    """The resources of one place of the hierarchy by itself, without what is deeper inside.

    ``modules``: the path of modules to it, with its own, from the one below the top on; () is the top. Equal places are
    summed.
    """

    modules: tuple[str, ...]
    used: Mapping[str, Reading]


@dataclass(frozen=True)
class Report:
    """One report file.

    - ``tool``, ``version``, ``date``: as the report writes them; "" where it does not.
    - ``family``: how the name of the family of the part begins, where the report shows that alone.
    - ``top``: the top module. ``part``: the part with its speed grade, as the tool writes it. "" where not said.
    - ``used``: by resource. ``hierarchy``: the same by place, where the report has a hierarchy.
    - ``clocks``: by domain. ``static``, ``dynamic``: power, W. ``power_clock``: the clock of the power analysis, Hz.
    - ``notes``: what a reader must know of these numbers, sentences.
    """

    file: str
    digest: str
    tool: str
    version: str
    stage: Stage
    date: str = ""
    top: str = ""
    part: str = ""
    family: str = ""
    used: Mapping[str, Reading] = field(default_factory=dict)
    hierarchy: tuple[Inside, ...] = ()
    clocks: tuple[ClockReading, ...] = ()
    static: Reading | None = None
    dynamic: Reading | None = None
    power_clock: float | None = None
    notes: tuple[str, ...] = ()

    def cited(self, reading: Reading) -> str:
        """Tool, file and line of a number."""
        return f"{self.made_by}, {self.file}:{reading.line}"

    @property
    def made_by(self) -> str:
        """The tool and its version."""
        return f"{self.tool} {self.version}".rstrip()


def added(used: Mapping[str, Reading], more: Mapping[str, Reading], times: int = 1) -> dict[str, Reading]:
    """Two counts as one, the second ``times`` over. A line is the later of both."""
    total = dict(used)
    for resource, reading in more.items():
        before = total.get(resource, Reading(0.0, 0))
        total[resource] = Reading(before.value + times * reading.value, max(before.line, reading.line))
    return total


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

    def sought(self, pattern: str, what: str, start: int = 1) -> tuple[int, re.Match[str]]:
        """The first line that a pattern is found in; ``what``: the part of the report that has it.

        Raises:
            SpecError: there is none, so the report is cut off.
        """
        found = self.find(pattern, start)
        if found is None:
            raise self.cut_off(what)
        return found

    def find(self, pattern: str, start: int = 1) -> tuple[int, re.Match[str]] | None:
        """The first line from ``start`` that a pattern is found in, with the match."""
        return next(self.all(pattern, start), None)

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


_TITLE = r"^=== (.*) ===$"
_DEEPEST = 256
_MOST_PLACES = 100_000

Modules = dict[str, dict[str, tuple[int, int]]]
"""Of each module, the count and the line of each type of cell, inner modules included."""


def _stat(text: Text) -> Fields:
    """The counts of ``stat``.

    Raises:
        SpecError: it is cut off or no JSON, or has several designs.
    """
    modules, version = _of_json(text) if text.is_json else (_of_text(text), "")
    inner = {name for cells in modules.values() for name in cells if name in modules}
    tops = [name for name in modules if name not in inner]
    if len(tops) != 1:
        listed = ", ".join(_plain(name) for name in tops[:6]) or "none"
        what = f"has {len(tops)} modules at the top: {listed}"
        raise text.fault(0, what, "run stat on one design, after hierarchy -top")
    places = _places(text, modules, tops[0])
    used: Mapping[str, Reading] = {resource: Reading(0.0, 1) for resource in asdict(Counts())}
    for place in places:
        used = added(used, place.used)
    hierarchy = places if len(places) > 1 else ()
    return {"version": version, "top": _plain(tops[0]), "used": used, "hierarchy": hierarchy}


def _plain(name: str) -> str:
    r"""The name of a module as its file has it.

    >>> _plain("$paramod\\node\\W=s32'1"), _plain("\\top"), _plain("$paramod$1a2b\\node")
    ('node', 'top', 'node')
    """
    if name.startswith("$paramod"):
        return name.split("\\")[1] if "\\" in name else name
    return name.removeprefix("\\")


def _of_text(text: Text) -> Modules:
    modules: Modules = {}
    needed: set[str] = set()
    titles = [(line, match.group(1)) for line, match in text.all(_TITLE)]
    for index, (begin, name) in enumerate(titles):
        if name == "design hierarchy":
            continue
        end = titles[index + 1][0] - 1 if index + 1 < len(titles) else len(text.lines)
        modules[name], inner = _cells(text, begin, end)
        needed |= inner
    missing = needed - modules.keys()
    if missing:
        raise text.cut_off(f"module {_plain(min(missing))}")
    return modules


def _cells(text: Text, begin: int, end: int) -> tuple[dict[str, tuple[int, int]], set[str]]:
    """The cells of a section, and the types among them that are modules of the design.

    A line is ``4  CCU2C``, in older versions ``CCU2C  4``. The sum is the line ``cells``.
    """
    cells: dict[str, tuple[int, int]] = {}
    modules: set[str] = set()
    total, inner = 0, None
    seen = False
    for number in range(begin + 1, end + 1):
        line = text.lines[number - 1]
        match = re.match(r"^\s*(?:([\d-]+) +)?(\d+|-)(?: +(?:[\d.eE+-]+))? +(\S+)\s*$", line)
        older = re.match(r"^\s*(\S+?):?\s+(\d+)\s*$", line)
        if re.match(r"^\s*(?:[\d-]+ +)?[\d-]+ cells\s*$|^\s*Number of cells:", line):
            seen = True
            digits = re.findall(r"\d+", line)
            total = int(digits[-1]) if digits else 0
        elif re.match(r"^\s*(?:[\d-]+ +)?[\d-]+ submodules\s*$", line):
            digits = re.findall(r"\d+", line)
            inner = int(digits[-1]) if digits else 0
        elif seen and match:
            modules |= set() if inner is None else {match.group(3)}
            cells[match.group(3)] = (0 if match.group(2) == "-" else int(match.group(2)), number)
        elif seen and older:
            cells[older.group(1)] = (int(older.group(2)), number)
        elif seen and cells:
            break
    if end == len(text.lines) and text.lines[-1].strip():
        raise text.cut_off("the empty line at the end")
    counted = sum(count for count, _ in cells.values())
    if not seen or counted not in (total, total + (inner or 0)):
        what = f"the report is cut off: {counted} of {total} cells of {text.lines[begin - 1]} are listed"
        raise text.fault(min(end, len(text.lines)), what, "write it again")
    return cells, modules


def _of_json(text: Text) -> tuple[Modules, str]:
    tree = text.json()
    modules: Modules = {}
    listed = tree.get("modules")
    for name, module in (listed if isinstance(listed, dict) else {}).items():
        if not isinstance(module, dict):
            raise text.fault(text.line_of(name), f"module {_plain(name)} is no object", "write it again")
        sections = [module.get(key) for key in ("num_cells_by_type", "num_submodules_by_type")]
        cells = {
            kind: (_count(text, kind, count), text.line_of(name))
            for section in sections
            if isinstance(section, dict)
            for kind, count in section.items()
        }
        modules[name] = cells
    version = re.match(r"Yosys (\S+)", str(tree.get("creator", "")))
    return modules, version.group(1) if version else ""


def _count(text: Text, kind: str, count: Any) -> int:
    if isinstance(count, dict):
        hint = "write it with stat -json alone, or as text"
        raise text.fault(text.line_of(kind), "counts inner modules twice: the JSON of stat -hierarchy", hint)
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= 10**9:
        raise text.fault(text.line_of(kind), f"the number of {_plain(kind)} is no count", "write it again")
    return count


def _places(text: Text, modules: Modules, top: str) -> tuple[Inside, ...]:
    """The resources of each place of the design by itself: its cells, times its instances."""
    own = {name: _own(cells, modules) for name, cells in modules.items()}
    places: dict[tuple[str, ...], dict[str, Reading]] = {}
    stack: list[tuple[str, int, tuple[str, ...]]] = [(top, 1, ())]
    for _ in range(_MOST_PLACES):
        if not stack:
            return tuple(Inside(path, used) for path, used in places.items())
        name, times, path = stack.pop()
        places[path] = added(places.get(path, {}), own[name], times)
        if len(path) > _DEEPEST:
            break
        stack += [
            (kind, times * count, (*path, _plain(kind)))
            for kind, (count, _) in modules[name].items()
            if kind in modules and count
        ]
    raise text.fault(0, "has modules that contain themselves, or too many", "write it again")


def _own(cells: Mapping[str, tuple[int, int]], modules: Modules) -> dict[str, Reading]:
    """The resources of a module without the modules inside it. Pins and buffers count as none."""
    used: dict[str, Reading] = {}
    for kind, (count, line) in cells.items():
        counts = next((counts for pattern, counts in COUNTED if pattern.fullmatch(kind)), Counts())
        if kind not in modules and count:
            amounts = {name: Reading(count * each, line) for name, each in asdict(counts).items() if each}
            used = added(used, amounts)
    return used


YOSYS = Tool(
    "Yosys",
    marks=(_TITLE, r"^\s*(?:[\d-]+ +)?(?:[\d-]+ cells$|Number of cells:)"),
    keys=("num_cells_by_type", "modules"),
    kinds=(Kind("", _stat, stage=Stage.SYNTHESISED),),
)
