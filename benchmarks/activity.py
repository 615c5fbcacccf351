"""The rate at which the nets of a circuit toggle, counted in a simulation: dynamic power is proportional to it.

The nets join the LUT and flip-flops of the circuit. In the Verilog of its source one net may have several names, and a
name may have nets that no gate drives.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from codesign.ground.errors import RunError
from codesign.hardware.rtl.bench_runs import Waves, icarus, scratch
from codesign.hardware.rtl.design import sources_of, top_name, write_design
from codesign.hardware.rtl.tools import require, yosys
from codesign.planners.circuits import Circuit, Expected

# A circuit as a flattened netlist of LUT of four inputs, flip-flops and memories, which the bench runs as its source.

NETLIST = "netlist.v"

_MOST_SECONDS = 1800.0
_PASSES = (
    "proc",
    "flatten",
    "opt -full",
    "wreduce",
    "peepopt",
    "opt_clean",
    "alumacc",
    "opt",
    # Memories stay what they are.
    "memory -nomap",
    "opt_clean",
    "opt -full",
    "techmap",
    "opt -fast",
    "abc -lut 4",
    "opt -fast",
    "opt_clean -purge",
    "setundef -zero -init",
    f"write_verilog -noattr {NETLIST}",
)

_UNKNOWN_BITS = re.compile(r"'([hb])([0-9a-f]*x[0-9a-fx]*)")
_REGISTER = re.compile(r"^( +reg (?:\[\d+:\d+\] )?\S+) *;", re.MULTILINE)
_MEMORY = re.compile(r"^ +reg (?:\[\d+:\d+\] )?(\S+) +\[(\d+):0\];", re.MULTILINE)


def write_gates(circuit: Circuit, folder: Path) -> str:
    """Write the netlist of a circuit and the images that it reads into ``folder``; the name of the netlist.

    Raises:
        MissingToolError: pyosys is not installed.
        RunError: Yosys refuses the Verilog.
    """
    require("pyosys")
    write_design(circuit, folder)
    script = [
        *(f"read_verilog {name}" for name in sources_of(circuit)),
        f"hierarchy -check -top {top_name(circuit)}",
        *_PASSES,
    ]
    yosys("\n".join(script) + "\n", folder, f"the gates of {circuit.top}", seconds=_MOST_SECONDS)
    path = folder / NETLIST
    path.write_text(without_unknowns(path.read_text(encoding="utf-8")), encoding="utf-8")
    return NETLIST


def without_unknowns(verilog: str) -> str:
    """A netlist of Yosys in which every register and memory begins at 0, and no constant has an unknown bit.

    >>> without_unknowns("  reg [1:0] a ;")
    '  reg [1:0] a = 0;'
    """
    known = _UNKNOWN_BITS.sub(lambda constant: f"'{constant[1]}{constant[2].replace('x', '0')}", verilog)
    known = _REGISTER.sub(r"\1 = 0;", known)
    counters = iter(range(len(known)))

    def cleared(memory: re.Match[str]) -> str:
        name, last, i = memory[1], memory[2], f"word_{next(counters)}"
        loop = f"initial for ({i} = 0; {i} <= {last}; {i} = {i} + 1) {name} [{i}] = 0;"
        return f"{memory[0]}\n  integer {i};\n  {loop}"

    return _MEMORY.sub(cleared, known)


MOST_CYCLES = 4000
"""Cycles of a run that toggles are counted in."""


@dataclass(frozen=True)
class Activity:
    """Toggles counted over ``cycles`` edges of the clock, on ``bits`` bits of nets that are no clock."""

    toggles: int
    bits: int
    cycles: int

    @property
    def rate(self) -> float:
        """Toggles a bit and edge."""
        return self.toggles / max(1, self.bits * self.cycles)


def activity(circuit: Circuit, expected: Expected, most: int = MOST_CYCLES) -> Activity:
    """The activity of a run of a circuit, on its netlist of LUT and flip-flops (``write_gates``).

    Of a run of more than ``most`` cycles, those in its middle count.

    Raises:
        MissingToolError: pyosys or Icarus is not installed.
        RunError: the Verilog cannot be compiled, or the netlist does not run.
    """
    cycles = sum(expected.cycles.values())
    first = max(0, (cycles - most) // 2)
    with scratch() as folder:
        file = folder / "waves.vcd"
        last = min(cycles, first + most) - 1
        events = icarus(circuit, expected, Waves(file, first, last), netlist=write_gates).events
        if not np.array_equal(events.value, expected.events.value[: len(events.value)]):
            raise RunError(f"the netlist of {circuit.top} reports other values than the model")
        with file.open(encoding="utf-8") as lines:
            return count_toggles(lines)


_VARIABLE = re.compile(r"\$var (?:wire|reg) (\d+) (\S+) (\S+)")
"""A net. Parameters and the counters of loops are none."""
_SCALAR, _VECTOR = re.compile(r"([01])(\S+)"), re.compile(r"b([01xz]+) (\S+)")


def count_toggles(lines: Iterable[str]) -> Activity:
    """Count the toggles of a waveform (VCD). Every ``clk`` is the clock, the first one counts the edges.

    >>> count_toggles(["$var wire 1 ! clk $end", "$var wire 2 # n $end", "1!", "b00 #", "0!", "b11 #"])
    Activity(toggles=2, bits=2, cycles=1)
    """
    widths: dict[str, int] = {}
    clocks: list[str] = []
    values: dict[str, int] = {}
    toggles = edges = 0
    for line in lines:
        if declared := _VARIABLE.match(line):
            width, code, name = declared.groups()
            widths[code] = int(width)
            if name == "clk":
                clocks.append(code)
        elif change := _SCALAR.match(line) or _VECTOR.match(line):
            text, code = change.groups()
            value = int(re.sub("[xz]", "0", text), 2)
            if code in clocks:
                edges += code == clocks[0] and value > values.get(code, 0)
            elif code in values:
                toggles += (value ^ values[code]).bit_count()
            values[code] = value
    bits = sum(width for code, width in widths.items() if code not in clocks)
    return Activity(toggles, bits, max(1, edges))
