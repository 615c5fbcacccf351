"""Reports of Vivado: ``report_utilization`` (also ``-hierarchical``), ``report_timing_summary``, ``report_power``."""

from __future__ import annotations

import re
from collections.abc import Mapping

from codesign.hardware.calibrate.reports.record import ClockReading, Inside, Reading, Report, Stage, added
from codesign.hardware.calibrate.reports.text import Row, Text

_HEAD = r"^\|\s*{}\s*:\s*(.*?)\s*$"

USED: Mapping[str, tuple[str, float]] = {
    "Slice LUTs": ("lut4", 1.0),
    "CLB LUTs": ("lut4", 1.0),
    "Slice Registers": ("flip_flops", 1.0),
    "CLB Registers": ("flip_flops", 1.0),
    "Slice": ("slices", 1.0),
    "CLB": ("slices", 1.0),
    "RAMB36/FIFO": ("block_rams", 2.0),
    "RAMB18": ("block_rams", 1.0),
    "DSPs": ("multipliers", 1.0),
}
"""Rows of a flat report: the resource, and how many of it one counts as."""

COLUMNS: Mapping[str, tuple[str, float]] = {
    "Total LUTs": ("lut4", 1.0),
    "FFs": ("flip_flops", 1.0),
    "RAMB36": ("block_rams", 2.0),
    "RAMB18": ("block_rams", 1.0),
    "DSP48 Blocks": ("multipliers", 1.0),
    "DSP Blocks": ("multipliers", 1.0),
    "DSPs": ("multipliers", 1.0),
}
"""Columns of a report by hierarchy."""

_STAGES = {"postrout": Stage.ROUTED, "routed": Stage.ROUTED, "synth": Stage.SYNTHESISED, "opted": Stage.SYNTHESISED}
"""Words in the state of a design, or in the name of the file of a report."""

_NETS = {"unplaced": Stage.SYNTHESISED, "estimated": Stage.PLACED, "routed": Stage.ROUTED}
"""The words of a path on the delay of a net: one that is not routed makes the whole path so."""


def is_report(text: Text) -> bool:
    """True if Vivado wrote it."""
    return text.find(r"^\|\s*Tool Version\s*:\s*Vivado") is not None


def read(text: Text) -> Report:
    """A report of Vivado.

    Raises:
        SpecError: it is cut off, or is another kind of report.
    """
    version = re.sub(r"^Vivado v\.?", "", text.value(_HEAD.format("Tool Version"))).split(" ")[0]
    part = text.value(_HEAD.format("Device"))
    speed = text.value(_HEAD.format("Speed File")).split(" ")[0]
    stage = _stage(text)
    used: dict[str, Reading] = {}
    hierarchy: tuple[Inside, ...] = ()
    clocks: tuple[ClockReading, ...] = ()
    static = dynamic = power_clock = None
    if text.has("Utilization Design Information"):
        _check_sections(text)
        if text.find(r"^\d+\. Utilization by Hierarchy"):
            used, hierarchy = _hierarchy(text)
        else:
            used = _flat(text)
    elif text.has("Design Timing Summary"):
        clocks = _clocks(text)
    elif text.has("Total On-Chip Power (W)"):
        _check_sections(text)
        static, dynamic, power_clock = _power(text)
    else:
        hint = "report_utilization, report_timing_summary and report_power are read"
        raise text.fault(1, "is another report of Vivado", hint)
    return Report(
        file=text.file,
        digest=text.digest,
        tool="Vivado",
        version=version,
        stage=stage,
        date=text.value(_HEAD.format("Date")),
        top=text.value(_HEAD.format("Design")),
        part=part + (speed if speed and not part.endswith(speed) else ""),
        used=used,
        hierarchy=hierarchy,
        clocks=clocks,
        static=static,
        dynamic=dynamic,
        power_clock=power_clock,
    )


def _stage(text: Text) -> Stage:
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


def _flat(text: Text) -> dict[str, Reading]:
    used: dict[str, Reading] = {}
    column = 1
    for row in _all_rows(text):
        if "Used" in row.cells:
            column = row.cells.index("Used")
        name = row.cells[0].rstrip("*")
        if name not in USED or len(row.cells) <= column:
            continue
        resource, factor = USED[name]
        _add(used, resource, text.reading(row.cells[column], row.line, factor), once=resource != "block_rams")
    if "lut4" not in used:
        raise text.fault(0, "has no row Slice LUTs or CLB LUTs", "write it with report_utilization")
    return used


def _all_rows(text: Text) -> list[Row]:
    rows: list[Row] = []
    for number, line in enumerate(text.lines, 1):
        stripped = line.strip()
        if stripped.startswith("|") and stripped.endswith("|") and len(stripped) > 1:
            rows.append(Row(tuple(cell.strip() for cell in stripped[1:-1].split("|")), number))
    return rows


def _add(used: dict[str, Reading], resource: str, reading: Reading, *, once: bool = False) -> None:
    """Add a reading to its resource; ``once``: the first one counts, as later tables repeat it."""
    if resource not in used:
        used[resource] = reading
    elif not once:
        used[resource] = Reading(used[resource].value + reading.value, used[resource].line)


def _hierarchy(text: Text) -> tuple[dict[str, Reading], tuple[Inside, ...]]:
    """The totals of the top, and what each place has by itself.

    An instance with others inside has a row "(name)" for what is its own. A row without others inside is all its own.
    """
    found = text.find(r"^\|\s*Instance\s*\|\s*Module\s*\|")
    if found is None:
        raise text.fault(0, "has no table of instances", "write it with report_utilization -hierarchical")
    head, *listed = list(text.rows(found[0], "|"))
    rows = [row for row in listed if len(row.cells) == len(head.cells)]
    if not rows:
        raise text.fault(0, "has no instance", "write it with report_utilization -hierarchical")
    indents = [_indent(text.lines[row.line - 1]) for row in rows]
    places: dict[tuple[str, ...], dict[str, Reading]] = {}
    around: list[tuple[int, str]] = []
    for index, row in enumerate(rows):
        own = row.cells[0].startswith("(")
        around = [each for each in around if each[0] < indents[index]]
        if not own:
            around.append((indents[index], row.cells[1]))
        if own or index + 1 == len(rows) or indents[index + 1] <= indents[index]:
            path = tuple(module for _, module in around[1:])
            places[path] = added(places.get(path, {}), _columns(text, head, row))
    return _columns(text, head, rows[0]), tuple(Inside(path, used) for path, used in places.items())


def _indent(line: str) -> int:
    """The indent of the first cell of a row: deeper instances are indented further."""
    cell = line.strip().removeprefix("|")
    return len(cell) - len(cell.lstrip())


def _columns(text: Text, head: Row, row: Row) -> dict[str, Reading]:
    used: dict[str, Reading] = {}
    for name, cell in zip(head.cells, row.cells, strict=True):
        if name in COLUMNS:
            resource, factor = COLUMNS[name]
            _add(used, resource, text.reading(cell.split("(")[0], row.line, factor))
    return used


def _clocks(text: Text) -> tuple[ClockReading, ...]:
    """Of each clock: 1 / (period less worst slack), with its worst negative slack inside of its domain."""
    summary, inside = _section(text, "Clock Summary"), _section(text, "Intra Clock Table")
    if text.find(r"^\| Inter Clock Table") is None:
        raise text.cut_off("the Inter Clock Table")
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
    return tuple(clocks)


def _section(text: Text, title: str) -> list[Row]:
    """The rows of a table of the timing summary: cells are parted by spaces, its head is underlined."""
    found = text.find(rf"^\| {title}\s*$")
    if found is None:
        raise text.cut_off(f"the {title}")
    underlined = text.find(r"^\s*-+(\s+-+)+\s*$", found[0] + 3)
    if underlined is None:
        raise text.cut_off(f"the {title}")
    rows: list[Row] = []
    for number, line in enumerate(text.lines[underlined[0] :], underlined[0] + 1):
        if not line.strip():
            return rows
        rows.append(Row(tuple(line.split()), number))
    raise text.cut_off(f"the end of the {title}")


def _power(text: Text) -> tuple[Reading, Reading, float | None]:
    """Static and dynamic power (W), and the clock (Hz) of the analysis where it has one."""
    rows = _all_rows(text)
    watts = {
        row.cells[0].rstrip("*"): text.reading(row.cells[1], row.line)
        for row in rows
        if len(row.cells) == 2 and row.cells[0].rstrip("*") in ("Dynamic (W)", "Device Static (W)")
    }
    if len(watts) < 2:
        raise text.fault(0, "has no row Dynamic (W) and Device Static (W)", "write it with report_power")
    at = next((index for index, row in enumerate(rows) if row.cells[-1].startswith("Constraint (ns)")), None)
    periods = []
    for row in rows[at + 1 :] if at is not None else ():
        if len(row.cells) != 3 or not re.fullmatch(r"[\d.]+", row.cells[-1]):
            break
        periods.append(text.number(row.cells[-1], row.line))
    clock = 1e9 / periods[0] if len(periods) == 1 and periods[0] > 0 else None
    return watts["Device Static (W)"], watts["Dynamic (W)"], clock
