"""How often the nets of a circuit toggle, counted in a simulation: what dynamic power is proportional to.

Dynamic power is the sum over all nets of toggles a second times the energy of one. Vivado's reports take 12.5 toggles
in 100 edges of the clock where nobody says otherwise. Two of them, of an A* array on the XC7Z020-1 at 100 MHz (Mucha,
Scechura 2023), give the energy of a toggle: dynamic power of the fabric over the outputs of LUT and flip-flops, at that
rate.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from codesign.files import passing
from codesign.planners.circuits import CircuitStyle
from codesign.planners.job import Job
from codesign.rtl.runs import Waves
from codesign.rtl.simulate import simulate

TYPICAL = 0.125
"""Toggles a net and edge of the clock that tools take by default."""


@dataclass(frozen=True)
class PowerReport:
    """A public report: ``dynamic`` power of the fabric in W at ``clock`` Hz, on LUT, flip-flops and slices."""

    dynamic: float
    clock: float
    luts: int
    flip_flops: int
    slices: int

    @property
    def toggle_energy(self) -> float:
        """J a toggle of an output of a LUT or a flip-flop, wires and clock tree with it."""
        return self.dynamic / (self.clock * TYPICAL * (self.luts + self.flip_flops))


REPORTS = (
    PowerReport(0.070, 100e6, 12_403, 18_391, 7_847),
    PowerReport(0.084, 100e6, 17_372, 25_373, 9_709),
)
"""Mucha and Scechura 2023, two sizes of an A* array on the XC7Z020-1, by Vivado."""


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


def activity(style: CircuitStyle, job: Job[Any, Any], first: int, last: int) -> Activity:
    """The activity of a design point from cycle ``first`` to ``last`` of its run.

    Raises:
        MissingToolError: pyosys or a C++ compiler is not installed.
        RunError: the Verilog cannot be compiled.
    """
    with passing(Path(tempfile.mkdtemp(prefix="hwsw-activity-"))) as folder:
        file = folder / "waves.vcd"
        simulate(style.circuit(job), style.expected(job), waves=Waves(file, first, last))
        with file.open(encoding="utf-8") as lines:
            return count_toggles(lines)


_VARIABLE = re.compile(r"\$var \w+ (\d+) (\S+) (\S+)")
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
