"""Reports of synthesis and place-and-route tools, read into one record: ``read_report``.

The tool is recognised by the content of a file, never by its name.

The parsers of edalize (0.6.8: Vivado, ISE, Quartus) give tables without the head of a report, without lines and without
power, and need pandas and pyparsing. So these readers are our own; a test holds them against the ones of edalize.
"""

from __future__ import annotations

from pathlib import Path

from codesign.ground.errors import SpecError
from codesign.hardware.calibrate.reports.engine import (
    YOSYS,
    ClockReading,
    Reading,
    Report,
    Stage,
    Text,
    Tool,
    read_text,
)
from codesign.hardware.calibrate.reports.tools import GOWIN, ISE, LATTICE, NEXTPNR, QUARTUS, VIVADO

TOOLS: tuple[Tool, ...] = (VIVADO, ISE, QUARTUS, LATTICE, GOWIN, YOSYS, NEXTPNR)
"""Every tool whose reports are read."""

_NAMES = ("Vivado", "Xilinx", "Quartus", "Lattice", "Gowin", "GOWIN", "Yosys", "nextpnr")

__all__ = ["TOOLS", "ClockReading", "Reading", "Report", "Stage", "read_report"]


def read_report(path: Path) -> Report:
    """One report file.

    Raises:
        SpecError: it is no report that a reader knows, is cut off or is in another language; with the line.
    """
    text = read_text(path, str(path))
    tool = next((tool for tool in TOOLS if tool.wrote(text)), None)
    if tool is None:
        raise _unknown(text)
    report = tool.read(text)
    if not report.used and not report.clocks and report.dynamic is None:
        raise text.fault(0, "has no resource, no clock and no power", "name another report of the run")
    return report


def _unknown(text: Text) -> SpecError:
    hint = f"reports of {', '.join(tool.name for tool in TOOLS)} are read, as text or JSON"
    named = next((name for name in _NAMES if name in text.whole), None)
    foreign = next((number for number, line in enumerate(text.lines, 1) if _is_foreign(line)), None)
    if named is not None and foreign is not None:
        what = f"mentions {named} in another language than English"
        return text.fault(foreign, what, "write the report in English: run the tool with LANG=C")
    if named is not None:
        return text.fault(1, f"mentions {named}, and is cut off or another kind of file", hint)
    return text.fault(1, "is no report that is known", hint)


def _is_foreign(line: str) -> bool:
    """True if most letters of a line are not English ones."""
    letters = [mark for mark in line if mark.isalpha()]
    return sum(mark > "\x7f" for mark in letters) * 2 > len(letters)
