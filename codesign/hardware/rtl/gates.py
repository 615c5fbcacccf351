"""A circuit as a flattened netlist of LUT of four inputs, flip-flops and memories, which the bench runs as its source.

It is of no family: adders are LUT, and so are multipliers. A simulator knows three values, a LUT only two: what is
unknown at power-up is 0 here, so that no unknown bit spreads through a LUT that does not depend on it.
"""

from __future__ import annotations

import re
from pathlib import Path

from codesign.hardware.rtl.design import sources_of, top_name, write_design
from codesign.hardware.rtl.tools import require, yosys
from codesign.planners.circuits import Circuit

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

_UNKNOWN = re.compile(r"'([hb])([0-9a-f]*x[0-9a-fx]*)")
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
    known = _UNKNOWN.sub(lambda constant: f"'{constant[1]}{constant[2].replace('x', '0')}", verilog)
    known = _REGISTER.sub(r"\1 = 0;", known)
    counters = iter(range(len(known)))

    def cleared(memory: re.Match[str]) -> str:
        name, last, i = memory[1], memory[2], f"word_{next(counters)}"
        loop = f"initial for ({i} = 0; {i} <= {last}; {i} = {i} + 1) {name} [{i}] = 0;"
        return f"{memory[0]}\n  integer {i};\n  {loop}"

    return _MEMORY.sub(cleared, known)
