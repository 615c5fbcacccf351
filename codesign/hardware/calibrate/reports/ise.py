"""Reports of ISE: map (``.mrp``), place and route (``.par``), XST (``.syr``), TRACE (``.twr``), XPower (``.pwr``)."""

from __future__ import annotations

import re
from collections.abc import Mapping

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Text

USED: Mapping[str, tuple[str, float]] = {
    "Slice LUTs": ("lut4", 1.0),
    "4 input LUTs": ("lut4", 1.0),
    "Slice Registers": ("flip_flops", 1.0),
    "Slice Flip Flops": ("flip_flops", 1.0),
    "occupied Slices": ("slices", 1.0),
    "Slices": ("slices", 1.0),
    "FIFO16/RAMB16s": ("block_rams", 1.0),
    "RAMB16s": ("block_rams", 1.0),
    "RAMB16BWEs": ("block_rams", 1.0),
    "RAMB16BWERs": ("block_rams", 1.0),
    "RAMB8BWERs": ("block_rams", 0.5),
    "Block RAMs": ("block_rams", 1.0),
    "BRAMs": ("block_rams", 1.0),
    "BlockRAM/FIFO": ("block_rams", 2.0),
    "RAMB18E1/FIFO18E1s": ("block_rams", 1.0),
    "RAMB36E1/FIFO36E1s": ("block_rams", 2.0),
    "MULT18X18s": ("multipliers", 1.0),
    "MULT18X18SIOs": ("multipliers", 1.0),
    "DSP48s": ("multipliers", 1.0),
    "DSP48As": ("multipliers", 1.0),
    "DSP48A1s": ("multipliers", 1.0),
    "DSP48Es": ("multipliers", 1.0),
    "DSP48E1s": ("multipliers", 1.0),
}
"""The words after ``Number of``: the resource, and how many of it one counts as."""

_HEAD = r"Release (\S+)\s*-?\s*(?:Map|par|xst|Trace|XPower Analyzer)\b"
_PERIOD = re.compile(r"([\d.]+) *(ps|ns|us|MHz|kHz|GHz)\b")
_NS = {"ps": 1e-3, "ns": 1.0, "us": 1e3}
_HZ = {"kHz": 1e3, "MHz": 1e6, "GHz": 1e9}


def is_report(text: Text) -> bool:
    """True if a tool of ISE wrote it."""
    return text.find(_HEAD) is not None and text.has("Xilinx")


def read(text: Text) -> Report:
    """A report of ISE.

    Raises:
        SpecError: it is cut off, or is another kind of report.
    """
    used: dict[str, Reading] = {}
    clocks: tuple[ClockReading, ...] = ()
    static = dynamic = None
    stage = Stage.PLACED
    if text.has("Supply Power (mW)"):
        stage = Stage.ROUTED
        static, dynamic = _power(text)
    elif text.find(r"^Release \S+ Trace"):
        _whole(text, "Analysis completed")
        stage, clocks = Stage.ROUTED, _clocks(text)
        if text.find(r"\w_map\.ncd"):
            stage = Stage.SYNTHESISED
    elif text.find(r"^Release \S+ - xst"):
        _whole(text, "Total REAL time to Xst completion")
        stage, used, clocks = Stage.SYNTHESISED, _used(text), _estimate(text)
    elif text.find(r"^Release \S+ par"):
        _whole(text, "PAR done!")
        stage, used = Stage.ROUTED, _used(text)
    elif text.has("Xilinx Mapping Report File"):
        _whole(text, "Section 1 - Errors")
        used = _used(text)
    else:
        raise text.fault(1, "is another report of ISE", "reports .mrp, .par, .syr, .twr and .pwr are read")
    return Report(
        file=text.file,
        digest=text.digest,
        tool="ISE",
        version=text.value(_HEAD),
        stage=stage,
        date=text.value(r"^(?:Mapped Date|Date)\s*:\s*(.*)$") or text.value(r"^Analysis completed (.*)$"),
        top=_top(text),
        part=_part(text),
        used=used,
        clocks=clocks,
        static=static,
        dynamic=dynamic,
        notes=("XST estimates the clock before placement",) if stage == Stage.SYNTHESISED else (),
    )


def _whole(text: Text, end: str) -> None:
    if not text.has(end):
        raise text.cut_off(repr(end))


def _top(text: Text) -> str:
    return (
        text.value(r"Mapping Report File for Design '(.*)'")
        or text.value(r"^\s*Top Module Name\s*:\s*(\S+)")
        or text.value(r'^\s*"(\S+)" is an NCD')
        or text.value(r"^Design(?: file)?\s*:\s*(\S+?)(?:_map)?\.ncd")
    )


def _part(text: Text) -> str:
    selected = text.value(r"^\s*(?:Selected Device|Part)\s*:\s*(\S+)")
    if selected:
        return selected
    device = text.value(r"^Target Device\s*:\s*(\S+)")
    if device:
        return device + text.value(r"^Target Package\s*:\s*(\S+)") + text.value(r"^Target Speed\s*:\s*(\S+)")
    found = text.find(r"^Device,package,speed:\s*(\w+),(\w+),(?:\w+,)?(-\w+)")
    found = found or text.find(r"NCD, version \S+, device (\w+), package (\w+), speed (-\w+)")
    return "".join(found[1].groups()) if found else ""


def _used(text: Text) -> dict[str, Reading]:
    """The counts of the design summary: each name once, as reports repeat them."""
    named: dict[str, Reading] = {}
    for line, match in text.all(r"^\s*(?:Total )?Number of (\S.*?)\s*:?\s+([\d,]+)(?:\s+out of\b.*|\s*)$"):
        name = match.group(1)
        # The total of LUT of Virtex-4 and older counts those that only route.
        if name in USED and (name not in named or match.group().lstrip().startswith("Total")):
            named[name] = text.reading(match.group(2), line, USED[name][1])
    if "occupied Slices" in named:
        named.pop("Slices", None)
    used: dict[str, Reading] = {}
    for name, reading in named.items():
        resource = USED[name][0]
        before = used.get(resource)
        used[resource] = reading if before is None else Reading(before.value + reading.value, before.line)
    if "lut4" not in used:
        raise text.fault(0, "has no number of LUT", "name the report of map, place and route or XST")
    return used


def _clocks(text: Text) -> tuple[ClockReading, ...]:
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
    if clocks:
        return tuple(clocks)
    found = text.find(r"^\s*Minimum period:\s*([\d.]+)ns\{1\}")
    if found is None:
        raise text.fault(0, "has no minimum period", "give the clock a period constraint")
    period = _above_zero(text, found[1].group(1), found[0])
    return (ClockReading("design", Reading(1e9 / period, found[0])),)


def _hertz(text: Text, given: re.Match[str], line: int) -> float:
    value = _above_zero(text, given.group(1), line)
    unit = given.group(2)
    return value * _HZ[unit] if unit in _HZ else 1e9 / (value * _NS[unit])


def _above_zero(text: Text, written: str, line: int) -> float:
    value = text.number(written, line)
    if value <= 0:
        raise text.fault(line, f"a period of {written}", "check the constraint")
    return value


def _estimate(text: Text) -> tuple[ClockReading, ...]:
    found = text.find(r"^\s*Minimum period:\s*([\d.]+)ns \(Maximum Frequency")
    if found is None:
        return ()
    period = _above_zero(text, found[1].group(1), found[0])
    return (ClockReading("design", Reading(1e9 / period, found[0])),)


def _power(text: Text) -> tuple[Reading, Reading]:
    """Static and dynamic power, W."""
    found = text.find(r"^\s*\|\s*Supply Power \(mW\)\s*\|\s*([\d.,]+)\s*\|\s*([\d.,]+)\s*\|\s*([\d.,]+)\s*\|")
    if found is None:
        raise text.cut_off("the Power Supply Summary")
    line, match = found
    return text.reading(match.group(3), line, 1e-3), text.reading(match.group(2), line, 1e-3)
