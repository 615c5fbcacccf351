"""The output of nextpnr: its ``--report`` as JSON, and its log.

Neither names the part, the version or the top: the design is named beside it, by its manifest or by the user.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from codesign.hardware.calibrate.reports.record import ClockReading, Reading, Report, Stage
from codesign.hardware.calibrate.reports.text import Text
from codesign.hardware.calibrate.reports.yosys import load_json

USED: Mapping[str, tuple[str, float]] = {
    "TRELLIS_COMB": ("lut4", 1.0),
    "TRELLIS_FF": ("flip_flops", 1.0),
    "DP16KD": ("block_rams", 1.0),
    "MULT18X18D": ("multipliers", 1.0),
    "LUT4": ("lut4", 1.0),
    "ALU": ("lut4", 1.0),
    "DFF": ("flip_flops", 1.0),
    "BSRAM": ("block_rams", 1.0),
    "MULT18X18": ("multipliers", 1.0),
    "MULTALU18X18": ("multipliers", 1.0),
    "MULT9X9": ("multipliers", 0.5),
    "MULT36X36": ("multipliers", 4.0),
    "ICESTORM_LC": ("lut4", 1.0),
    "ICESTORM_RAM": ("block_rams", 1.0),
    "ICESTORM_DSP": ("multipliers", 1.0),
}
"""Kinds of sites: the resource, and how many of it one counts as. A logic cell of an iCE40 counts as its LUT."""

FAMILIES = {"TRELLIS_COMB": "ECP5", "ICESTORM_LC": "iCE40", "BSRAM": "GW"}
"""Sites that only one family has: how its name begins."""

_FREQUENCY = r"Max frequency for clock\s+'(.*)':\s+([\d.]+) MHz \((?:PASS|FAIL) at ([\d.]+) MHz\)"


def is_report(text: Text) -> bool:
    """True if nextpnr wrote it."""
    if text.whole.lstrip().startswith("{"):
        return '"fmax"' in text.whole and '"utilization"' in text.whole
    return text.find(r"^(?:Info: )?Device utilisation:") is not None


def read(text: Text) -> Report:
    """A report or a log of nextpnr.

    Raises:
        SpecError: it is cut off or no JSON.
    """
    counts, clocks = _of_json(text) if text.whole.lstrip().startswith("{") else _of_log(text)
    used: dict[str, Reading] = {}
    for kind, reading in counts.items():
        if kind in USED:
            resource, factor = USED[kind]
            before = used.get(resource, Reading(0.0, reading.line))
            used[resource] = Reading(before.value + factor * reading.value, before.line)
    if "lut4" not in used:
        hint = "designs for ECP5, Gowin and iCE40 are read"
        raise text.fault(0, "has no kind of LUT that is known", hint)
    return Report(
        file=text.file,
        digest=text.digest,
        tool="nextpnr",
        version="",
        stage=Stage.ROUTED,
        family=next((family for site, family in FAMILIES.items() if site in counts), ""),
        used=used,
        clocks=clocks,
    )


def _line_of(text: Text, name: str) -> int:
    found = text.find(re.escape(f'"{name}"'))
    return found[0] if found else 1


def _of_json(text: Text) -> tuple[dict[str, Reading], tuple[ClockReading, ...]]:
    tree = load_json(text)
    counts = {
        kind: Reading(_number(text, kind, sites, "used"), _line_of(text, kind))
        for kind, sites in _mapping(text, tree, "utilization").items()
    }
    clocks = []
    for name, clock in _mapping(text, tree, "fmax").items():
        fmax = Reading(_number(text, name, clock, "achieved") * 1e6, _line_of(text, name))
        clocks.append(ClockReading(clock_name(name), fmax, _number(text, name, clock, "constraint") * 1e6))
    return counts, tuple(clocks)


def _mapping(text: Text, tree: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = tree.get(key)
    if not isinstance(value, dict):
        raise text.fault(_line_of(text, key), f"{key} is no object", "write the report again")
    return value


def _number(text: Text, name: str, entry: Any, key: str) -> float:
    value = entry.get(key) if isinstance(entry, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1e9:
        raise text.fault(_line_of(text, name), f"{key} of {name} is no number", "write the report again")
    return float(value)


def _of_log(text: Text) -> tuple[dict[str, Reading], tuple[ClockReading, ...]]:
    """The sites, and of each clock the last frequency, which the routed design has."""
    if not text.has("Program finished normally"):
        raise text.cut_off("'Program finished normally'")
    begin = text.find(r"^(?:Info: )?Device utilisation:")
    assert begin is not None, "is_report asks for it"
    counts: dict[str, Reading] = {}
    for number, line in enumerate(text.lines[begin[0] :], begin[0] + 1):
        match = re.match(r"^(?:Info:)?\s+(\w+):\s+(\d+)/\s*\d+\s+\d+%\s*$", line)
        if match is None:
            break
        counts[match.group(1)] = text.reading(match.group(2), number)
    clocks: dict[str, ClockReading] = {}
    for number, match in text.all(_FREQUENCY):
        name = clock_name(match.group(1))
        fmax = text.reading(match.group(2), number, 1e6)
        clocks[name] = ClockReading(name, fmax, text.number(match.group(3), number) * 1e6)
    return counts, tuple(clocks.values())


def clock_name(net: str) -> str:
    """The clock as the design names it.

    >>> clock_name("$glbnet$clk$TRELLIS_IO_IN"), clock_name("clk_IBUF_O")
    ('clk', 'clk_IBUF_O')
    """
    name = net.removeprefix("$glbnet$")
    return name.removesuffix("$TRELLIS_IO_IN")
