"""Reports of Gowin EDA: place and route (``.rpt.txt``), timing (``_tr_content.html``) and power (``.power.html``)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from html.parser import HTMLParser

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Row, Text

MULTIPLIERS: Mapping[str, float] = {
    "MULT9X9": 0.5,
    "MULT18X18": 1.0,
    "MULTALU18X18": 1.0,
    "MULTADDALU18X18": 2.0,
    "MULT36X36": 4.0,
    "MULTALU36X18": 2.0,
    "MULT27X36": 2.0,
    "MULT12X12": 0.5,
}
"""The number of multipliers of 18 × 18 bits that each macro of a DSP block counts as."""

_RESOURCES = {"Register": "flip_flops", "CLS": "slices"}


def is_report(text: Text) -> bool:
    """True if Gowin EDA wrote it."""
    return text.find(r"(?:Gowin )?(?:PnR|Timing Analysis|Power Analysis) Report") is not None and text.has(
        "Gowin Semiconductor"
    )


def read(text: Text) -> Report:
    """A report of Gowin EDA.

    Raises:
        SpecError: it is cut off, or is another kind of report.
    """
    used: dict[str, Reading] = {}
    clocks: tuple[ClockReading, ...] = ()
    static = dynamic = power_clock = None
    if text.has("<html"):
        if not text.has("</html>"):
            raise text.cut_off("</html>")
        tables = _Tables(text)
        head = {row.cells[0]: row.cells[1] for rows in tables.rows.values() for row in rows if len(row.cells) == 2}
        if "Max Frequency Summary:" in tables.rows:
            clocks = _clocks(text, tables.rows["Max Frequency Summary:"])
        elif "Power Information:" in tables.rows:
            static, dynamic, power_clock = _power(text, tables.rows)
        else:
            hint = "the reports .rpt.txt, _tr_content.html and .power.html are read"
            raise text.fault(1, "is another report of Gowin EDA", hint)
    else:
        head = {match.group(1): match.group(2) for _, match in text.all(r"^\s*<([^>]+)>:\s*(.*?)\s*$")}
        used = _used(text)
    design = re.split(r"[\\/]", head.get("Design File", ""))[-1]
    return Report(
        file=text.file,
        digest=text.digest,
        tool="Gowin EDA",
        version=(head.get("Tool Version") or head.get("GOWIN Version") or head.get("GOWIN version") or "").lstrip("V"),
        stage=Stage.ROUTED,
        date=head.get("Created Time", ""),
        top=design.rpartition(".")[0],
        part=head.get("Part Number", ""),
        used=used,
        clocks=clocks,
        static=static,
        dynamic=dynamic,
        power_clock=power_clock,
    )


class _Tables(HTMLParser):
    """The tables of a page, by the heading above each: cells may be left open, as Gowin writes them."""

    def __init__(self, text: Text) -> None:
        super().__init__()
        self.rows: dict[str, list[Row]] = {}
        self._title, self._cells, self._line = "", list[str](), 0
        self._into: str | None = None
        self.feed(text.whole)
        self.close()

    def handle_starttag(self, tag: str, _attrs: object) -> None:
        """A heading, a row or a cell begins."""
        if tag in ("h1", "h2", "h3"):
            self._title, self._into = "", "title"
        elif tag == "tr":
            self._end_row()
            self._line = self.getpos()[0]
        elif tag in ("td", "th"):
            self._cells.append("")
            self._into = "cell"

    def handle_endtag(self, tag: str) -> None:
        """A heading, a cell or a table ends."""
        if tag in ("h1", "h2", "h3", "td", "th"):
            self._into = None
        if tag in ("tr", "table"):
            self._end_row()

    def handle_data(self, data: str) -> None:
        """Text of a heading or a cell."""
        if self._into == "title":
            self._title += data.strip()
        elif self._into == "cell" and self._cells:
            self._cells[-1] += data.strip()

    def _end_row(self) -> None:
        if self._cells:
            self.rows.setdefault(self._title, []).append(Row(tuple(self._cells), self._line))
        self._cells = []


def _used(text: Text) -> dict[str, Reading]:
    found = text.find(r"^\s*Resources\s*\|\s*Usage")
    if found is None:
        raise text.cut_off("the Resource Usage Summary")
    end = text.find(r"^\s*=+\s*$", found[0])
    if end is None:
        raise text.cut_off("the end of the Resource Usage Summary")
    used: dict[str, Reading] = {}
    above, memories, multipliers = "", 0.0, 0.0
    lines = {"BSRAM": 0, "DSP": 0}
    for number, line in enumerate(text.lines[found[0] + 1 : end[0] - 1], found[0] + 2):
        name, bar, cell = (part.strip() for part in line.partition("|"))
        amount = re.match(r"[\d,.]+", cell)
        if not bar or amount is None:
            continue
        if not name.startswith("--"):
            above = name
            if name in _RESOURCES:
                used[_RESOURCES[name]] = text.reading(amount.group(), number)
            if name in lines:
                lines[name] = number
            continue
        count = text.reading(amount.group(), number)
        macro = name.lstrip("-")
        if macro.startswith("LUT,ALU"):
            used["lut4"] = count
        elif above == "BSRAM":
            memories += count.value
        elif above == "DSP":
            multipliers += count.value * MULTIPLIERS.get(macro, 0.0)
    if "lut4" not in used:
        raise text.fault(found[0], "has no row LUT,ALU", "name the report .rpt.txt of place and route")
    used["block_rams"] = Reading(memories, lines["BSRAM"])
    used["multipliers"] = Reading(multipliers, lines["DSP"])
    return used


def _clocks(text: Text, rows: list[Row]) -> tuple[ClockReading, ...]:
    clocks = []
    for row in rows:
        if len(row.cells) < 4 or not row.cells[0].isdigit():
            continue
        constraint, fmax = (cell.partition("(MHz)")[0] for cell in row.cells[2:4])
        hertz = text.number(constraint, row.line) * 1e6
        clocks.append(ClockReading(row.cells[1], text.reading(fmax, row.line, 1e6), hertz))
    return tuple(clocks)


def _power(text: Text, tables: Mapping[str, list[Row]]) -> tuple[Reading, Reading, float | None]:
    named = {row.cells[0]: row for row in tables["Power Information:"] if len(row.cells) == 2}
    watts = []
    for name in ("Quiescent Power (mW)", "Dynamic Power (mW)"):
        if name not in named:
            raise text.cut_off(name)
        watts.append(text.reading(named[name].cells[1], named[name].line, 1e-3))
    domains = [
        row
        for row in tables.get("Power By Clock Domain:", ())
        if len(row.cells) == 3 and re.fullmatch(r"[\d.]+", row.cells[-1])
    ]
    clock = text.number(domains[0].cells[1], domains[0].line) * 1e6 if len(domains) == 1 else None
    return watts[0], watts[1], clock
