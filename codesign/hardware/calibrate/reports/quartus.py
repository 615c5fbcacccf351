"""Reports of Quartus.

The fitter writes ``.fit.rpt`` and ``.fit.summary``, the timing analyzer ``.sta.rpt``, the power analyzer ``.pow.rpt``
and ``.pow.summary``. Block RAMs are as on the part: M9K, M10K or M20K. A part of today has no LUT of four inputs:
its ALUT count as LUT.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Text

USED: Mapping[str, str] = {
    "Total combinational functions": "lut4",
    "Combinational ALUT usage for logic": "lut4",
    "Total registers": "flip_flops",
    "Dedicated logic registers": "flip_flops",
    "Total RAM Blocks": "block_rams",
    "M9Ks": "block_rams",
    "M10K blocks": "block_rams",
    "M20K blocks": "block_rams",
    "Total DSP Blocks": "multipliers",
    "Embedded Multiplier 9-bit elements": "multipliers",
}
"""The resource of each name, the one to prefer first."""

_HALF = ("Embedded Multiplier 9-bit elements",)
"""Two of them make one multiplier of 18 × 18 bits."""

_VERSION = r"Quartus (?:Prime|II).*?Version\s*[:;]?\s*(?:Version\s+)?(\d[\w.]*)"
_KINDS = ("Fitter", "Timing Analyzer", "TimeQuest Timing Analyzer", "Power Analyzer", "PowerPlay Power Analyzer")


_SNAPSHOTS = {"synthesized": Stage.SYNTHESISED, "planned": Stage.SYNTHESISED, "placed": Stage.PLACED}
"""The stage of a design that Quartus Prime Pro analysed the timing of; without the row it is the final one."""


def is_report(text: Text) -> bool:
    """True if Quartus wrote it."""
    kinds = "|".join(_KINDS)
    return text.find(_VERSION) is not None and text.find(rf"^(?:{kinds}) (?:report for|Status\s*:)") is not None


def read(text: Text) -> Report:
    """A report of Quartus.

    Raises:
        SpecError: it is cut off, its run failed, or it is another kind of report.
    """
    _check_contents(text)
    named = _named(text)
    for name in ("Fitter Status", "Power Analyzer Status", "PowerPlay Power Analyzer Status"):
        if name in named and not named[name][0].startswith("Successful"):
            value, line = named[name]
            raise text.fault(line, f"{name}: {value}", "name the report of a run that was successful")
    used: dict[str, Reading] = {}
    clocks: tuple[ClockReading, ...] = ()
    static = dynamic = None
    snapshot = text.value(r"^; *Snapshot *; *(\w+)").lower()
    if text.find(r"^Fitter (?:report for|Status\s*:)"):
        used = _used(text, named)
    elif text.has("Core Dynamic Thermal Power Dissipation"):
        dynamic = _watts(text, named, "Core Dynamic Thermal Power Dissipation")
        static = _watts(text, named, "Core Static Thermal Power Dissipation")
    elif text.find(r"Timing Analyzer report for"):
        clocks = _clocks(text)
    else:
        hint = "the reports .fit.rpt, .fit.summary, .sta.rpt, .pow.rpt and .pow.summary are read"
        raise text.fault(1, "is another report of Quartus", hint)
    return Report(
        file=text.file,
        digest=text.digest,
        tool="Quartus",
        version=text.value(_VERSION),
        stage=next((stage for word, stage in _SNAPSHOTS.items() if word in snapshot), Stage.ROUTED),
        date=text.value(r"^(\w{3} \w{3} +\d+ [\d:]+ \d{4})") or text.value(r"Successful - (.*?)\s*;?$"),
        top=named.get("Top-level Entity Name", named.get("Revision Name", ("", 0)))[0],
        part=named.get("Device", named.get("Device Name", ("", 0)))[0],
        used=used,
        clocks=clocks,
        static=static,
        dynamic=dynamic,
    )


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
    for line, match in text.all(r"^(?:;\s*(\S[^;]*?)\s*;\s*([^;]*?)\s*;|([A-Z][^:;]*?)\s*:\s*(.*?))\s*$"):
        name = match.group(1) or match.group(3)
        named.setdefault(name.strip(" -"), ((match.group(2) or match.group(4) or "").strip(), line))
    for line, match in text.all(r"^ +([A-Z][^:;]*?)\s*:\s*(.*?)\s*$"):
        named.setdefault(match.group(1), (match.group(2), line))
    return named


def _used(text: Text, named: Mapping[str, tuple[str, int]]) -> dict[str, Reading]:
    used: dict[str, Reading] = {}
    for name, resource in USED.items():
        if name in named and resource not in used:
            value, line = named[name]
            scale = 0.5 if name in _HALF else 1.0
            used[resource] = text.reading(value.split("/")[0], line, scale)
    for name in ("Total registers", "Total PLLs"):
        if name not in named:
            raise text.cut_off(name)
    return used


def _clocks(text: Text) -> tuple[ClockReading, ...]:
    """The slowest Fmax of each clock over all models, with its constraint."""
    constraints: dict[str, float] = {}
    found = text.find(r"^; Clocks\s*;")
    if found is None:
        raise text.cut_off("the table Clocks")
    rows = [row for row in text.rows(found[0] + 1, ";") if len(row.cells) > 3]
    column = rows[0].cells.index("Frequency") if rows and "Frequency" in rows[0].cells else 0
    for row in rows[1:]:
        match = re.fullmatch(r"([\d.]+) MHz", row.cells[min(column, len(row.cells) - 1)])
        if match:
            constraints[row.cells[0]] = text.number(match.group(1), row.line) * 1e6
    slowest: dict[str, Reading] = {}
    for title, _ in text.all(r"^; .*Fmax Summary\s*;"):
        for row in text.rows(title + 1, ";"):
            match = re.fullmatch(r"([\d.]+) MHz", row.cells[0]) if len(row.cells) >= 3 else None
            if match is None:
                continue
            fmax = text.reading(row.cells[1].split(" ")[0], row.line, 1e6)
            if row.cells[2] not in slowest or fmax.value < slowest[row.cells[2]].value:
                slowest[row.cells[2]] = fmax
    if not slowest:
        raise text.fault(0, "has no Fmax Summary", "name the report .sta.rpt of the timing analyzer")
    return tuple(ClockReading(name, fmax, constraints.get(name)) for name, fmax in slowest.items())


def _watts(text: Text, named: Mapping[str, tuple[str, int]], name: str) -> Reading:
    if name not in named:
        raise text.cut_off(name)
    value, line = named[name]
    number, _, unit = value.partition(" ")
    return text.reading(number, line, 1e-3 if unit == "mW" else 1.0)
