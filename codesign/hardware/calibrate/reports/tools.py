"""The reports of Vivado, ISE, Quartus, Diamond, Radiant, Gowin EDA and nextpnr: an entry of the table for each tool."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from typing import Any

from more_itertools import map_reduce

from codesign.hardware.calibrate.reports.engine import (
    ClockReading,
    Fields,
    Inside,
    Kind,
    Named,
    Reading,
    Row,
    Stage,
    Text,
    Tool,
    added,
    counted,
    rows,
    slowest,
)

# --- Vivado: report_utilization (also -hierarchical), report_timing_summary, report_power

_HEAD = r"^\|\s*{}\s*:\s*(.*?)\s*$"

_ROWS = {
    "lut4": ({"(Slice|CLB) LUTs": 1.0},),
    "flip_flops": ({"(Slice|CLB) Registers": 1.0},),
    "slices": ({"Slice|CLB": 1.0},),
    "block_rams": ({"RAMB36/FIFO": 2.0, "RAMB18": 1.0},),
    "multipliers": ({"DSPs": 1.0},),
}
"""Rows of a flat report."""

_COLUMNS = {
    "lut4": ({"Total LUTs": 1.0},),
    "flip_flops": ({"FFs": 1.0},),
    "block_rams": ({"RAMB36": 2.0, "RAMB18": 1.0},),
    "multipliers": ({"(DSP48 Blocks|DSP Blocks|DSPs)": 1.0},),
}
"""Columns of a report by hierarchy."""

_STAGES = {"postrout": Stage.ROUTED, "routed": Stage.ROUTED, "synth": Stage.SYNTHESISED, "opted": Stage.SYNTHESISED}
"""Words in the state of a design, or in the name of the file of a report."""

_NETS = {"unplaced": Stage.SYNTHESISED, "estimated": Stage.PLACED, "routed": Stage.ROUTED}
"""The words of a path on the delay of a net: one that is not routed makes the whole path so."""


def _vivado_head(text: Text) -> Fields:
    part = text.value(_HEAD.format("Device"))
    speed = text.value(_HEAD.format("Speed File")).split(" ")[0]
    return {
        "version": re.sub(r"^Vivado v\.?", "", text.value(_HEAD.format("Tool Version"))).split(" ")[0],
        "stage": _vivado_stage(text),
        "date": text.value(_HEAD.format("Date")),
        "top": text.value(_HEAD.format("Design")),
        "part": part + (speed if speed and not part.endswith(speed) else ""),
    }


def _vivado_stage(text: Text) -> Stage:
    """The stage that the design had come to.

    A report says it itself, or by the delays of the nets on its paths, or by the name of the file that it was written
    to. A timing summary that says nothing is of no routed design.
    """
    state = text.value(_HEAD.format("Design State")).lower()
    if not state:
        nets = [match.group(1) for _, match in text.all(r"net \(fo=\d+, (\w+)\)")]
        marks = [stage for word, stage in _NETS.items() if word in nets]
        if marks:
            return marks[0]
        state = text.value(r"^\|\s*Command\s*:.*-file\s+(\S+)").lower()
    return next((stage for word, stage in _STAGES.items() if word in state), Stage.PLACED)


def _check_sections(text: Text) -> None:
    """A section stands in the table of contents and again as a heading: the last one shows that the report is whole."""
    titles = [match.group(1) for _, match in text.all(r"^(\d+(?:\.\d+)*\.? \S.*?)\s*$")]
    if titles and titles.count(max(titles, key=_order)) < 2:
        raise text.cut_off(f"section {max(titles, key=_order)}")


def _order(title: str) -> tuple[int, ...]:
    return tuple(int(digits) for digits in title.split(" ", maxsplit=1)[0].rstrip(".").split("."))


def _flat(text: Text) -> Fields:
    _check_sections(text)
    missing = "has no row Slice LUTs or CLB LUTs", "write it with report_utilization"
    return counted(text, _flat_rows(text), _ROWS, missing)


def _flat_rows(text: Text) -> Iterator[Named]:
    column = 1
    for row in _all_rows(text):
        if "Used" in row.cells:
            column = row.cells.index("Used")
        if len(row.cells) > column:
            yield row.cells[0].rstrip("*"), row.cells[column], row.line


def _all_rows(text: Text) -> list[Row]:
    return [
        Row(tuple(cell.strip() for cell in match.group(1).split("|")), line)
        for line, match in text.all(r"^\s*\|(.*)\|\s*$")
    ]


def _hierarchy(text: Text) -> Fields:
    """The totals of the top, and what each place has by itself.

    An instance with others inside has a row "(name)" for what is its own. A row without others inside is all its own.
    """
    _check_sections(text)
    hint = "write it with report_utilization -hierarchical"
    found = text.find(r"^\|\s*Instance\s*\|\s*Module\s*\|")
    if found is None:
        raise text.fault(0, "has no table of instances", hint)
    head, *listed = list(text.rows(found[0], "|"))
    instances = [row for row in listed if len(row.cells) == len(head.cells)]
    if not instances:
        raise text.fault(0, "has no instance", hint)
    indents = [_indent(text.lines[row.line - 1]) for row in instances]
    places: dict[tuple[str, ...], Mapping[str, Reading]] = {}
    around: list[tuple[int, str]] = []
    for index, row in enumerate(instances):
        own = row.cells[0].startswith("(")
        around = [each for each in around if each[0] < indents[index]]
        if not own:
            around.append((indents[index], row.cells[1]))
        if own or index + 1 == len(instances) or indents[index + 1] <= indents[index]:
            path = tuple(module for _, module in around[1:])
            places[path] = added(places.get(path, {}), _of_row(text, head, row)["used"])
    hierarchy = tuple(Inside(path, used) for path, used in places.items())
    return {**_of_row(text, head, instances[0]), "hierarchy": hierarchy}


def _indent(line: str) -> int:
    """The indent of the first cell of a row: deeper instances are indented further."""
    cell = line.strip().removeprefix("|")
    return len(cell) - len(cell.lstrip())


def _of_row(text: Text, head: Row, row: Row) -> Fields:
    cells = zip(head.cells, row.cells, strict=True)
    return counted(text, ((name, cell.split("(")[0], row.line) for name, cell in cells), _COLUMNS)


def _vivado_clocks(text: Text) -> Fields:
    """Of each clock: 1 / (period less worst slack), with its worst negative slack inside of its domain."""
    summary, inside = _section(text, "Clock Summary"), _section(text, "Intra Clock Table")
    text.sought(r"^\| Inter Clock Table", "the Inter Clock Table")
    slacks = {row.cells[0]: row for row in inside}
    clocks = []
    for row in summary:
        # A waveform in braces has a space inside: the last two cells are period and frequency.
        if len(row.cells) < 3:
            raise text.fault(row.line, "the Clock Summary has no period", "write the report again")
        name, period = row.cells[0], text.reading(row.cells[-2], row.line).value
        slack = slacks.get(name)
        # A clock without paths of its own has no slack.
        if slack is None or len(slack.cells) < 3 or not re.fullmatch(r"-?[\d.]+", slack.cells[1]):
            continue
        least = period - text.number(slack.cells[1], slack.line)
        if period <= 0 or least <= 0:
            raise text.fault(slack.line, f"clock {name} has a slack of its whole period", "check the constraint")
        clocks.append(ClockReading(name, Reading(1e9 / least, slack.line), 1e9 / period))
    return {"clocks": tuple(clocks)}


def _section(text: Text, title: str) -> list[Row]:
    """The rows of a table of the timing summary: cells are parted by spaces, its head is underlined."""
    heading, _ = text.sought(rf"^\| {title}\s*$", f"the {title}")
    underlined, _ = text.sought(r"^\s*-+(\s+-+)+\s*$", f"the {title}", heading + 3)
    held: list[Row] = []
    for number, line in enumerate(text.lines[underlined:], underlined + 1):
        if not line.strip():
            return held
        held.append(Row(tuple(line.split()), number))
    raise text.cut_off(f"the end of the {title}")


def _vivado_power(text: Text) -> Fields:
    """Static and dynamic power, W, and the clock of the analysis, Hz, where it has one."""
    _check_sections(text)
    table = _all_rows(text)
    watts = {
        row.cells[0].rstrip("*"): text.reading(row.cells[1], row.line)
        for row in table
        if len(row.cells) == 2 and row.cells[0].rstrip("*") in ("Dynamic (W)", "Device Static (W)")
    }
    if len(watts) < 2:
        raise text.fault(0, "has no row Dynamic (W) and Device Static (W)", "write it with report_power")
    at = next((index for index, row in enumerate(table) if row.cells[-1].startswith("Constraint (ns)")), None)
    periods = []
    for row in table[at + 1 :] if at is not None else ():
        if len(row.cells) != 3 or not re.fullmatch(r"[\d.]+", row.cells[-1]):
            break
        periods.append(text.number(row.cells[-1], row.line))
    clock = 1e9 / periods[0] if len(periods) == 1 and periods[0] > 0 else None
    return {"static": watts["Device Static (W)"], "dynamic": watts["Dynamic (W)"], "power_clock": clock}


VIVADO = Tool(
    "Vivado",
    marks=(r"^\|\s*Tool Version\s*:\s*Vivado",),
    head=_vivado_head,
    kinds=(
        Kind(r"^\d+\. Utilization by Hierarchy", _hierarchy),
        Kind("Utilization Design Information", _flat),
        Kind("Design Timing Summary", _vivado_clocks),
        Kind(r"Total On-Chip Power \(W\)", _vivado_power),
    ),
    known="report_utilization, report_timing_summary and report_power",
)

# --- ISE: map (.mrp), place and route (.par), XST (.syr), TRACE (.twr), XPower (.pwr)

_ISE_USED = {
    "lut4": ({"Slice LUTs|4 input LUTs": 1.0},),
    "flip_flops": ({"Slice Registers|Slice Flip Flops": 1.0},),
    "slices": ({"occupied Slices": 1.0}, {"Slices": 1.0}),
    "block_rams": (
        {
            "FIFO16/RAMB16s|RAMB16s|RAMB16BWEs|RAMB16BWERs|Block RAMs|BRAMs|RAMB18E1/FIFO18E1s": 1.0,
            "RAMB8BWERs": 0.5,
            "BlockRAM/FIFO|RAMB36E1/FIFO36E1s": 2.0,
        },
    ),
    "multipliers": ({"MULT18X18s|MULT18X18SIOs|DSP48s|DSP48As|DSP48A1s|DSP48Es|DSP48E1s": 1.0},),
}
"""The words after ``Number of``."""

_RELEASE = r"Release (\S+)\s*-?\s*(?:Map|par|xst|Trace|XPower Analyzer)\b"
_NUMBER_OF = r"Number of (\S.*?)\s*:?\s+([\d,]+)(?:\s+out of\b.*|\s*)$"
_PERIOD = re.compile(r"([\d.]+) *(ps|ns|us|MHz|kHz|GHz)\b")
_NS = {"ps": 1e-3, "ns": 1.0, "us": 1e3}
_HZ = {"kHz": 1e3, "MHz": 1e6, "GHz": 1e9}


def _ise_head(text: Text) -> Fields:
    device = "".join(text.value(rf"^Target {name}\s*:\s*(\S+)") for name in ("Device", "Package", "Speed"))
    return {
        "version": text.value(_RELEASE),
        "date": text.value(r"^(?:Mapped Date|Date)\s*:\s*(.*)$", r"^Analysis completed (.*)$"),
        "top": text.value(
            r"Mapping Report File for Design '(.*)'",
            r"^\s*Top Module Name\s*:\s*(\S+)",
            r'^\s*"(\S+)" is an NCD',
            r"^Design(?: file)?\s*:\s*(\S+?)(?:_map)?\.ncd",
        ),
        "part": text.value(r"^\s*(?:Selected Device|Part)\s*:\s*(\S+)")
        or device
        or text.value(
            r"^Device,package,speed:\s*(\w+),(\w+),(?:\w+,)?(-\w+)",
            r"NCD, version \S+, device (\w+), package (\w+), speed (-\w+)",
        ),
    }


def _ise_used(text: Text) -> Fields:
    # The total of LUT of Virtex-4 and older counts those that only route.
    found = rows(text, r"^\s*Total " + _NUMBER_OF, r"^\s*" + _NUMBER_OF)
    return counted(text, found, _ISE_USED, ("has no number of LUT", "name the report of map, place and route or XST"))


def _trace(text: Text) -> Fields:
    mapped = text.find(r"\w_map\.ncd") is not None
    return {"clocks": _ise_clocks(text), **(_estimated() if mapped else {})}


def _xst(text: Text) -> Fields:
    return {**_ise_used(text), "clocks": _statistics(text, r" \(Maximum Frequency"), **_estimated()}


def _estimated() -> Fields:
    return {"stage": Stage.SYNTHESISED, "notes": ("XST estimates the clock before placement",)}


def _ise_clocks(text: Text) -> tuple[ClockReading, ...]:
    """Of each constraint on a period: 1 / the minimum period; without any, the clock of the design statistics."""
    clocks, name, constraint = [], "", None
    for line, match in text.all(
        r'^Timing constraint:.*PERIOD TIMEGRP\s*(".*)?$|^"(\S+)"|^ *Minimum period is *([\d.]+)ns'
        r'|^Timing constraint: Default period analysis for net "(.*)"'
    ):
        if match.group(3):
            if name:
                fmax = Reading(1e9 / _above_zero(text, match.group(3), line), line)
                clocks.append(ClockReading(name, fmax, constraint))
            name, constraint = "", None
        elif match.group(4):
            name = match.group(4)
        elif "PERIOD TIMEGRP" in match.group():
            # The constraint may go on in the next lines, up to its semicolon.
            whole = " ".join(text.lines[line - 1 : line + 3]).split(";")[0]
            quoted = re.search(r'TIMEGRP\s*"([^"]*)"(.*)', whole)
            name = quoted.group(1) if quoted else ""
            given = _PERIOD.search(quoted.group(2).split("PHASE")[0]) if quoted else None
            constraint = _hertz(text, given, line) if given else None
    found = tuple(clocks) or _statistics(text, r"\{1\}")
    if not found:
        raise text.fault(0, "has no minimum period", "give the clock a period constraint")
    return found


def _hertz(text: Text, given: re.Match[str], line: int) -> float:
    value = _above_zero(text, given.group(1), line)
    unit = given.group(2)
    return value * _HZ[unit] if unit in _HZ else 1e9 / (value * _NS[unit])


def _above_zero(text: Text, written: str, line: int) -> float:
    value = text.number(written, line)
    if value <= 0:
        raise text.fault(line, f"a period of {written}", "check the constraint")
    return value


def _statistics(text: Text, ending: str) -> tuple[ClockReading, ...]:
    """The minimum period of the whole design, of a line with this ending."""
    found = text.find(r"^\s*Minimum period:\s*([\d.]+)ns" + ending)
    if found is None:
        return ()
    line, match = found
    return (ClockReading("design", Reading(1e9 / _above_zero(text, match.group(1), line), line)),)


def _ise_power(text: Text) -> Fields:
    row = r"^\s*\|\s*Supply Power \(mW\)\s*\|\s*([\d.,]+)\s*\|\s*([\d.,]+)\s*\|\s*([\d.,]+)\s*\|"
    line, match = text.sought(row, "the Power Supply Summary")
    return {"static": text.reading(match.group(3), line, 1e-3), "dynamic": text.reading(match.group(2), line, 1e-3)}


ISE = Tool(
    "ISE",
    marks=(_RELEASE, "Xilinx"),
    head=_ise_head,
    kinds=(
        Kind(r"Supply Power \(mW\)", _ise_power),
        Kind(r"^Release \S+ Trace", _trace, "Analysis completed"),
        Kind(r"^Release \S+ - xst", _xst, "Total REAL time to Xst completion"),
        Kind(r"^Release \S+ par", _ise_used, "PAR done!"),
        Kind("Xilinx Mapping Report File", _ise_used, "Section 1 - Errors", Stage.PLACED),
    ),
    known="reports .mrp, .par, .syr, .twr and .pwr",
)

# --- Quartus: the fitter (.fit.rpt, .fit.summary), the timing analyzer (.sta.rpt), the power analyzer (.pow.rpt,
# .pow.summary). A part of today has no LUT of four inputs: its ALUT count as LUT.

_QUARTUS_USED = {
    "lut4": ({"Total combinational functions": 1.0}, {"Combinational ALUT usage for logic": 1.0}),
    "flip_flops": ({"Total registers": 1.0}, {"Dedicated logic registers": 1.0}),
    "block_rams": ({"Total RAM Blocks": 1.0}, {"M9Ks": 1.0}, {"M10K blocks": 1.0}, {"M20K blocks": 1.0}),
    "multipliers": ({"Total DSP Blocks": 1.0}, {"Embedded Multiplier 9-bit elements": 0.5}),
}
"""Block RAMs are those of the part, M9K, M10K or M20K. Two elements of 9 bits make one multiplier of 18 × 18 bits."""

_QUARTUS = r"Quartus (?:Prime|II).*?Version\s*[:;]?\s*(?:Version\s+)?(\d[\w.]*)"
_ANALYZERS = ("Fitter", "Timing Analyzer", "TimeQuest Timing Analyzer", "Power Analyzer", "PowerPlay Power Analyzer")
_SNAPSHOTS = {"synthesized": Stage.SYNTHESISED, "planned": Stage.SYNTHESISED, "placed": Stage.PLACED}
"""The stage of a design that Quartus Prime Pro analysed the timing of; without the row it is the final one."""


def _quartus_head(text: Text) -> Fields:
    _check_contents(text)
    named = _named(text)
    for name in ("Fitter Status", "Power Analyzer Status", "PowerPlay Power Analyzer Status"):
        if name in named and not named[name][0].startswith("Successful"):
            value, line = named[name]
            raise text.fault(line, f"{name}: {value}", "name the report of a run that was successful")
    snapshot = text.value(r"^; *Snapshot *; *(\w+)").lower()
    return {
        "version": text.value(_QUARTUS),
        "stage": next((stage for word, stage in _SNAPSHOTS.items() if word in snapshot), Stage.ROUTED),
        "date": text.value(r"^(\w{3} \w{3} +\d+ [\d:]+ \d{4})", r"Successful - (.*?)\s*;?$"),
        "top": named.get("Top-level Entity Name", named.get("Revision Name", ("", 0)))[0],
        "part": named.get("Device", named.get("Device Name", ("", 0)))[0],
    }


def _check_contents(text: Text) -> None:
    """Each title of the table of contents stands above its table too: the last one shows that the report is whole."""
    contents = text.find(r"^; Table of Contents ;")
    if contents is None:
        return
    titles = []
    for line in text.lines[contents[0] + 1 :]:
        match = re.match(r"^\s*\d+\. (\S.*?)\s*$", line)
        if match is None:
            break
        titles.append(match.group(1))
    if titles and text.find(rf"^; {re.escape(titles[-1])}\s*;") is None:
        raise text.cut_off(f"section {titles[-1]}")


def _named(text: Text) -> dict[str, tuple[str, int]]:
    """The text beside each name, in tables of two columns and in summaries; the first of a name."""
    named: dict[str, tuple[str, int]] = {}
    forms = (
        r"^;\s*(\S[^;]*?)\s*;\s*([^;]*?)\s*;\s*$",
        r"^([A-Z][^:;]*?)\s*:\s*(.*?)\s*$",
        r"^ +([A-Z][^:;]*?)\s*:\s*(.*?)\s*$",
    )
    for name, value, line in rows(text, *forms):
        named.setdefault(name.strip(" -"), (value.strip(), line))
    return named


def _fitted(text: Text) -> Fields:
    named = _named(text)
    found = ((name, value.split("/")[0], line) for name, (value, line) in named.items())
    used = counted(text, found, _QUARTUS_USED)
    for name in ("Total registers", "Total PLLs"):
        if name not in named:
            raise text.cut_off(name)
    return used


def _quartus_clocks(text: Text) -> Fields:
    """The slowest Fmax of each clock over all models, with its constraint."""
    title, _ = text.sought(r"^; Clocks\s*;", "the table Clocks")
    table = [row for row in text.rows(title + 1, ";") if len(row.cells) > 3]
    column = table[0].cells.index("Frequency") if table and "Frequency" in table[0].cells else 0
    constraints = {}
    for row in table[1:]:
        match = re.fullmatch(r"([\d.]+) MHz", row.cells[min(column, len(row.cells) - 1)])
        if match:
            constraints[row.cells[0]] = text.number(match.group(1), row.line) * 1e6
    clocks = [
        ClockReading(name, text.reading(fmax.split(" ")[0], row.line, 1e6), constraints.get(name))
        for title, _ in text.all(r"^; .*Fmax Summary\s*;")
        for row in text.rows(title + 1, ";")
        if len(row.cells) >= 3 and re.fullmatch(r"[\d.]+ MHz", row.cells[0])
        for fmax, name in [row.cells[1:3]]
    ]
    if not clocks:
        raise text.fault(0, "has no Fmax Summary", "name the report .sta.rpt of the timing analyzer")
    return {"clocks": slowest(clocks)}


def _quartus_power(text: Text) -> Fields:
    named, watts = _named(text), {}
    for which in ("dynamic", "static"):
        name = f"Core {which.title()} Thermal Power Dissipation"
        if name not in named:
            raise text.cut_off(name)
        value, line = named[name]
        number, _, unit = value.partition(" ")
        watts[which] = text.reading(number, line, 1e-3 if unit == "mW" else 1.0)
    return watts


QUARTUS = Tool(
    "Quartus",
    marks=(_QUARTUS, rf"^(?:{'|'.join(_ANALYZERS)}) (?:report for|Status\s*:)"),
    head=_quartus_head,
    kinds=(
        Kind(r"^Fitter (?:report for|Status\s*:)", _fitted),
        Kind("Core Dynamic Thermal Power Dissipation", _quartus_power),
        Kind("Timing Analyzer report for", _quartus_clocks),
    ),
    known="the reports .fit.rpt, .fit.summary, .sta.rpt, .pow.rpt and .pow.summary",
)

# --- Lattice: map (.mrp) and timing (.twr) of Diamond and of Radiant

_LATTICE_USED = {
    "lut4": ({"LUT4s": 1.0},),
    "flip_flops": ({"registers": 1.0}, {"slice registers": 1.0}),
    "slices": ({"SLICEs": 1.0},),
    "block_rams": ({"block RAMs": 1.0}, {"EBRs": 1.0}),
    "multipliers": ({"DSPs": 1.0}, {r"MULT18X18\w*": 1.0}),
}
"""The words after ``Number of``, of either tool, and the macros of a DSP block."""

_LATTICE = r"(Diamond|Radiant)(?: Software)? \(64-bit\) (\d[\w.]*)"


def _lattice_head(text: Text) -> Fields:
    found = text.find(_LATTICE)
    assert found is not None, "it is a mark"
    device = text.value(r"^(?:Target Device|Device):\s*(\S+)")
    grade = text.value(r"^(?:Target Performance|Performance(?: Grade)?):\s*(\w+)")
    return {
        "tool": found[1].group(1),
        "version": found[1].group(2),
        "date": text.value(r"^Mapped on:\s*(.*)$", r"^(\w{3} \w{3} +\d+ [\d:]+ \d{4})"),
        "top": text.value(r"for Design Module '(.*)'", r"^(?:Design|Design name):\s*(\S+)"),
        "part": f"{device}-{grade}" if grade.isdigit() else device,
    }


def _mapped(text: Text) -> Fields:
    text.sought(r"^\s*Number of errors:|^\s*Number of warnings:", "the end of the Design Summary")
    found = rows(text, r"^\s*Number of (\S.*?):\s+([\d,]+)(?: out of\b.*|\s*)$", r"^\s*(MULT18X18\w*)\s+(\d+)\s*$")
    return counted(text, found, _LATTICE_USED, ("has no Number of LUT4s", "name the report .mrp of map"))


def _lattice_stage(text: Text) -> Fields:
    return {"stage": Stage.SYNTHESISED} if text.find(r"_map\.(?:ncd|udb)") else {}


def _diamond(text: Text) -> Fields:
    """The rows of the report summary that have a frequency: setup; hold has times."""
    row = r'^FREQUENCY (?:NET|PORT) "([^"]+)".*\|\s*([\d.]+) MHz\|\s*([\d.]+) MHz\|'
    clocks = []
    for line, match in text.all(row):
        name, constraint, fmax = match.groups()
        clocks.append(ClockReading(name, text.reading(fmax, line, 1e6), text.number(constraint, line) * 1e6))
    text.sought(r"^Timing summary \(Setup", "the timing summary")
    if not clocks:
        raise text.fault(0, "has no preference FREQUENCY", "give the clock a FREQUENCY preference")
    return {"clocks": slowest(clocks), **_lattice_stage(text)}


def _radiant(text: Text) -> Fields:
    """The slowest of the corners of each clock: rows ``Target`` and ``Actual (all paths)``."""
    clocks: list[ClockReading] = []
    name, target = "", None
    form = r"From (\S+)\s*\|\s*Target\s*\|[^|]*\|\s*([\d.]+) MHz|Actual \(all paths\)\s*\|[^|]*\|\s*([\d.]+) MHz"
    for line, match in text.all(form):
        if match.group(1):
            name, target = match.group(1), text.number(match.group(2), line) * 1e6
            continue
        if name:
            clocks.append(ClockReading(name, text.reading(match.group(3), line, 1e6), target))
        name = ""
    if not clocks:
        raise text.cut_off("the actual frequency of a clock")
    return {"clocks": slowest(clocks), **_lattice_stage(text)}


LATTICE = Tool(
    "Diamond, Radiant",
    marks=(_LATTICE, r"Lattice Mapping Report|Lattice TRACE Report|Actual \(all paths\)|Timing Report"),
    head=_lattice_head,
    kinds=(
        Kind("Lattice Mapping Report", _mapped, stage=Stage.SYNTHESISED),
        Kind("Lattice TRACE Report", _diamond),
        Kind("", _radiant),
    ),
)

# --- Gowin EDA: place and route (.rpt.txt), timing (_tr_content.html) and power (.power.html)

_GOWIN_USED = {
    "lut4": ({"Logic/LUT,ALU.*": 1.0},),
    "flip_flops": ({"Register": 1.0},),
    "slices": ({"CLS": 1.0},),
    "block_rams": ({"BSRAM": 0.0, "BSRAM/.*": 1.0},),
    "multipliers": (
        {
            "DSP": 0.0,
            "DSP/(MULT9X9|MULT12X12)": 0.5,
            "DSP/(MULT18X18|MULTALU18X18)": 1.0,
            "DSP/(MULTADDALU18X18|MULTALU36X18|MULT27X36)": 2.0,
            "DSP/MULT36X36": 4.0,
        },
    ),
}
"""Rows, those below another one behind a slash: as many multipliers of 18 × 18 bits as a macro of a DSP block has."""

_NONE_USED = {"block_rams": Reading(0.0, 0), "multipliers": Reading(0.0, 0)}


def _gowin_head(text: Text) -> Fields:
    if text.has("<html"):
        head = {row.cells[0]: row.cells[1] for rows in _tables(text).values() for row in rows if len(row.cells) == 2}
    else:
        head = {name: value for name, value, _ in rows(text, r"^\s*<([^>]+)>:\s*(.*?)\s*$")}
    version = head.get("Tool Version") or head.get("GOWIN Version") or head.get("GOWIN version") or ""
    return {
        "version": version.lstrip("V"),
        "date": head.get("Created Time", ""),
        "top": re.split(r"[\\/]", head.get("Design File", ""))[-1].rpartition(".")[0],
        "part": head.get("Part Number", ""),
    }


class _Tables(HTMLParser):
    """The rows of a page, with the heading above each: cells may be left open, as Gowin writes them."""

    def __init__(self, text: Text) -> None:
        super().__init__()
        self.rows: list[tuple[str, Row]] = []
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
            self.rows.append((self._title, Row(tuple(self._cells), self._line)))
        self._cells = []


def _tables(text: Text) -> Mapping[str, list[Row]]:
    if not text.has("</html>"):
        raise text.cut_off("</html>")
    return map_reduce(_Tables(text).rows, lambda each: each[0], lambda each: each[1])


def _gowin_used(text: Text) -> Fields:
    begin, _ = text.sought(r"^\s*Resources\s*\|\s*Usage", "the Resource Usage Summary")
    end, _ = text.sought(r"^\s*=+\s*$", "the end of the Resource Usage Summary", begin)
    missing = "has no row LUT,ALU", "name the report .rpt.txt of place and route"
    used = counted(text, _gowin_rows(text, begin, end), _GOWIN_USED, missing)["used"]
    return {"used": {**_NONE_USED, **used}}


def _gowin_rows(text: Text, begin: int, end: int) -> Iterator[Named]:
    """The counts between two lines: the name of a row that stands below another begins with the name of that one."""
    above = ""
    for line, match in text.all(r"^\s*(--)?(\S[^|]*?)\s*\|\s*([\d,.]+)", begin):
        if line >= end:
            return
        below, name, amount = match.groups()
        above = above if below else name
        yield f"{above}/{name}" if below else name, amount, line


def _gowin_clocks(text: Text) -> Fields:
    clocks = []
    for row in _tables(text).get("Max Frequency Summary:", ()):
        if len(row.cells) >= 4 and row.cells[0].isdigit():
            constraint, fmax = (cell.partition("(MHz)")[0] for cell in row.cells[2:4])
            hertz = text.number(constraint, row.line) * 1e6
            clocks.append(ClockReading(row.cells[1], text.reading(fmax, row.line, 1e6), hertz))
    return {"clocks": tuple(clocks)}


def _gowin_power(text: Text) -> Fields:
    tables = _tables(text)
    named = {row.cells[0]: row for row in tables.get("Power Information:", ()) if len(row.cells) == 2}
    watts: dict[str, Any] = {}
    for field, name in (("static", "Quiescent Power (mW)"), ("dynamic", "Dynamic Power (mW)")):
        if name not in named:
            raise text.cut_off(name)
        watts[field] = text.reading(named[name].cells[1], named[name].line, 1e-3)
    domains = [
        row
        for row in tables.get("Power By Clock Domain:", ())
        if len(row.cells) == 3 and re.fullmatch(r"[\d.]+", row.cells[-1])
    ]
    clock = text.number(domains[0].cells[1], domains[0].line) * 1e6 if len(domains) == 1 else None
    return {**watts, "power_clock": clock}


GOWIN = Tool(
    "Gowin EDA",
    marks=("(?:Gowin )?(?:PnR|Timing Analysis|Power Analysis) Report", "Gowin Semiconductor"),
    head=_gowin_head,
    kinds=(
        Kind("Max Frequency Summary:", _gowin_clocks),
        Kind("Power Information:", _gowin_power),
        Kind("PnR Report", _gowin_used),
    ),
    known="the reports .rpt.txt, _tr_content.html and .power.html",
)

# --- nextpnr: --report as JSON, and its log. Neither names the part, the version or the top: the design is named beside
# it, by its manifest or by the user.

_NEXTPNR_USED = {
    "lut4": ({"TRELLIS_COMB|LUT4|ALU|ICESTORM_LC": 1.0},),
    "flip_flops": ({"TRELLIS_FF|DFF": 1.0},),
    "block_rams": ({"DP16KD|BSRAM|ICESTORM_RAM": 1.0},),
    "multipliers": ({"MULT18X18D|MULT18X18|MULTALU18X18|ICESTORM_DSP": 1.0, "MULT9X9": 0.5, "MULT36X36": 4.0},),
}
"""Kinds of sites. A logic cell of an iCE40 counts as its LUT."""

FAMILIES = {"TRELLIS_COMB": "ECP5", "ICESTORM_LC": "iCE40", "BSRAM": "GW"}
"""Sites that only one family has: how its name begins."""

_FREQUENCY = r"Max frequency for clock\s+'(.*)':\s+([\d.]+) MHz \((?:PASS|FAIL) at ([\d.]+) MHz\)"


def _nextpnr(text: Text) -> Fields:
    sites, clocks = _of_json(text) if text.is_json else _of_log(text)
    used = counted(
        text, sites, _NEXTPNR_USED, ("has no kind of LUT that is known", "designs for ECP5, Gowin and iCE40 are read")
    )
    kinds = {site for site, _, _ in sites}
    family = next((family for site, family in FAMILIES.items() if site in kinds), "")
    return {**used, "clocks": clocks, "family": family}


def _of_json(text: Text) -> tuple[list[Named], tuple[ClockReading, ...]]:
    tree = text.json()
    sites = [
        (kind, repr(_count(text, kind, entry, "used")), text.line_of(kind))
        for kind, entry in _mapping(text, tree, "utilization").items()
    ]
    clocks = []
    for name, clock in _mapping(text, tree, "fmax").items():
        fmax = Reading(_count(text, name, clock, "achieved") * 1e6, text.line_of(name))
        clocks.append(ClockReading(clock_name(name), fmax, _count(text, name, clock, "constraint") * 1e6))
    return sites, tuple(clocks)


def _mapping(text: Text, tree: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = tree.get(key)
    if not isinstance(value, dict):
        raise text.fault(text.line_of(key), f"{key} is no object", "write the report again")
    return value


def _count(text: Text, name: str, entry: Any, key: str) -> float:
    value = entry.get(key) if isinstance(entry, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1e9:
        raise text.fault(text.line_of(name), f"{key} of {name} is no number", "write the report again")
    return value


def _of_log(text: Text) -> tuple[list[Named], tuple[ClockReading, ...]]:
    """The sites, and of each clock the last frequency, which the routed design has."""
    if not text.has("Program finished normally"):
        raise text.cut_off("'Program finished normally'")
    begin = text.find(r"^(?:Info: )?Device utilisation:")
    assert begin is not None, "it is the mark of a log"
    sites = []
    for number, line in enumerate(text.lines[begin[0] :], begin[0] + 1):
        match = re.match(r"^(?:Info:)?\s+(\w+):\s+(\d+)/\s*\d+\s+\d+%\s*$", line)
        if match is None:
            break
        sites.append((match.group(1), match.group(2), number))
    clocks = {}
    for number, match in text.all(_FREQUENCY):
        name = clock_name(match.group(1))
        fmax = text.reading(match.group(2), number, 1e6)
        clocks[name] = ClockReading(name, fmax, text.number(match.group(3), number) * 1e6)
    return sites, tuple(clocks.values())


def clock_name(net: str) -> str:
    """The clock as the design names it.

    >>> clock_name("$glbnet$clk$TRELLIS_IO_IN"), clock_name("clk_IBUF_O")
    ('clk', 'clk_IBUF_O')
    """
    return net.removeprefix("$glbnet$").removesuffix("$TRELLIS_IO_IN")


NEXTPNR = Tool(
    "nextpnr", marks=(r"^(?:Info: )?Device utilisation:",), keys=("fmax", "utilization"), kinds=(Kind("", _nextpnr),)
)
