"""Reports of Lattice: map (``.mrp``) and timing (``.twr``) of Diamond and of Radiant."""

from __future__ import annotations

from collections.abc import Mapping

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Text

USED: Mapping[str, str] = {
    "registers": "flip_flops",
    "slice registers": "flip_flops",
    "SLICEs": "slices",
    "LUT4s": "lut4",
    "block RAMs": "block_rams",
    "EBRs": "block_rams",
    "DSPs": "multipliers",
}
"""The words after ``Number of``, of either tool."""

_VERSION = r"(Diamond|Radiant)(?: Software)? \(64-bit\) (\d[\w.]*)"


def is_report(text: Text) -> bool:
    """True if a tool of Lattice wrote it."""
    return text.find(_VERSION) is not None and (text.has("Lattice Mapping Report") or _is_timing(text))


def _is_timing(text: Text) -> bool:
    return text.has("Lattice TRACE Report") or text.has("Actual (all paths)") or text.has("Timing Report")


def read(text: Text) -> Report:
    """A report of Diamond or Radiant.

    Raises:
        SpecError: it is cut off.
    """
    used: dict[str, Reading] = {}
    clocks: tuple[ClockReading, ...] = ()
    if text.has("Lattice Mapping Report"):
        stage = Stage.SYNTHESISED
        used = _used(text)
    else:
        stage = Stage.SYNTHESISED if text.find(r"_map\.(?:ncd|udb)") else Stage.ROUTED
        clocks = _clocks_of_diamond(text) if text.has("Lattice TRACE Report") else _clocks_of_radiant(text)
    found = text.find(_VERSION)
    assert found is not None, "is_report asks for it"
    return Report(
        file=text.file,
        digest=text.digest,
        tool=found[1].group(1),
        version=found[1].group(2),
        stage=stage,
        date=text.value(r"^Mapped on:\s*(.*)$") or text.value(r"^(\w{3} \w{3} +\d+ [\d:]+ \d{4})"),
        top=text.value(r"for Design Module '(.*)'") or text.value(r"^(?:Design|Design name):\s*(\S+)"),
        part=_part(text),
        used=used,
        clocks=clocks,
    )


def _part(text: Text) -> str:
    device = text.value(r"^(?:Target Device|Device):\s*(\S+)")
    grade = text.value(r"^(?:Target Performance|Performance(?: Grade)?):\s*(\w+)")
    return f"{device}-{grade}" if grade.isdigit() else device


def _used(text: Text) -> dict[str, Reading]:
    if text.find(r"^\s*Number of errors:|^\s*Number of warnings:") is None:
        raise text.cut_off("the end of the Design Summary")
    used: dict[str, Reading] = {}
    for line, match in text.all(r"^\s*Number of (\S.*?):\s+([\d,]+)(?: out of\b.*|\s*)$"):
        resource = USED.get(match.group(1))
        if resource is not None and resource not in used:
            used[resource] = text.reading(match.group(2), line)
    wide = text.find(r"^\s*MULT18X18\w*\s+(\d+)\s*$")
    if wide is not None:
        used.setdefault("multipliers", text.reading(wide[1].group(1), wide[0]))
    if "lut4" not in used:
        raise text.fault(0, "has no Number of LUT4s", "name the report .mrp of map")
    return used


def _clocks_of_diamond(text: Text) -> tuple[ClockReading, ...]:
    """The rows of the report summary that have a frequency: setup; hold has times."""
    clocks: dict[str, ClockReading] = {}
    row = r'^FREQUENCY (?:NET|PORT) "([^"]+)".*\|\s*([\d.]+) MHz\|\s*([\d.]+) MHz\|'
    for line, match in text.all(row):
        fmax = text.reading(match.group(3), line, 1e6)
        constraint = text.number(match.group(2), line) * 1e6
        clocks.setdefault(match.group(1), ClockReading(match.group(1), fmax, constraint))
    if text.find(r"^Timing summary \(Setup") is None:
        raise text.cut_off("the timing summary")
    if not clocks:
        raise text.fault(0, "has no preference FREQUENCY", "give the clock a FREQUENCY preference")
    return tuple(clocks.values())


def _clocks_of_radiant(text: Text) -> tuple[ClockReading, ...]:
    """The slowest of the corners of each clock: rows ``Target`` and ``Actual (all paths)``."""
    slowest: dict[str, ClockReading] = {}
    name, target = "", None
    rows = r"From (\S+)\s*\|\s*Target\s*\|[^|]*\|\s*([\d.]+) MHz|Actual \(all paths\)\s*\|[^|]*\|\s*([\d.]+) MHz"
    for line, match in text.all(rows):
        if match.group(1):
            name, target = match.group(1), text.number(match.group(2), line) * 1e6
            continue
        clock = ClockReading(name, text.reading(match.group(3), line, 1e6), target)
        if name and (name not in slowest or clock.fmax.value < slowest[name].fmax.value):
            slowest[name] = clock
        name = ""
    if not slowest:
        raise text.cut_off("the actual frequency of a clock")
    return tuple(slowest.values())
