"""Constraints of a family's tools: the clock of the design point. No pin is invented."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from codesign.part import Part
from codesign.units import PICOSECONDS_PER_SECOND

VIVADO = frozenset({"Artix-7", "Zynq-7000", "Zynq UltraScale+"})
ISE = frozenset({"Virtex-II", "Virtex-II Pro", "Virtex-4", "Spartan-3E"})
GOWIN = frozenset({"GW1N", "GW2A"})


@dataclass(frozen=True)
class Building:
    """How a design is built: ``tools`` of its family, constraints by file name, and what nextpnr calls the part."""

    tools: str
    files: Mapping[str, str]
    size: str = ""
    grade: str = ""


def building(part: Part, hertz: int, top: str) -> Building:
    """What the tools of the part's family take for a clock in Hz."""
    # Rounded down to whole picoseconds: a tool that meets the constraint meets the clock.
    period = f"{PICOSECONDS_PER_SECOND // hertz / 1000:.3f}"
    sdc = f"create_clock -name clk -period {period} [get_ports {{clk}}]\n"
    if part.family in VIVADO:
        return Building("vivado", {f"{top}.xdc": sdc})
    if part.family in ISE:
        text = f'NET "clk" TNM_NET = "clk";\nTIMESPEC "TS_clk" = PERIOD "clk" {period} ns HIGH 50 %;\n'
        return Building("ise", {f"{top}.ucf": text})
    if part.family == "ECP5":
        text = f'FREQUENCY PORT "clk" {hertz / 1e6:.6f} MHZ;\n'
        size = part.name.partition("-")[2].rstrip("F") + "k"
        return Building("ecp5", {f"{top}.lpf": text}, size, part.speed_grade.lstrip("-"))
    if part.family in GOWIN:
        pins = '// Pins are for the board, as in: IO_LOC "clk" NUMBER;\n'
        return Building("gowin", {f"{top}.sdc": sdc, f"{top}.cst": pins})
    return Building("other", {f"{top}.sdc": sdc})
