"""A circuit is simulated on its stream: what it reports, and the cycles of each phase.

All simulators follow the contract of ``planners.circuits``: outputs are sampled just before a rising edge, inputs
change after it, and the edge after the one that takes ``start`` is cycle 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench_runs import icarus, verilator
from codesign.hardware.rtl.design import work_of
from codesign.hardware.rtl.native import cxxrtl
from codesign.hardware.rtl.runs import Progress, Run, Waves, silent
from codesign.planners.circuits import Circuit, Expected

Backend = Callable[[Circuit, Expected, Waves | None, Progress], Run]

BACKENDS: Mapping[str, Backend] = {"cxxrtl": cxxrtl, "icarus": icarus, "verilator": verilator}
"""Every simulator by its name, the default first."""

AUTO = "auto"
"""The simulator that is the fastest for the size of the design, of those that are installed."""

_LARGE = 10**8
"""Above this number of elements times cycles Verilator is the faster one: measured, see docs/rtl.md."""

MOST_ELEMENTS = 10_000
"""A larger array would take hours to compile: the time grows faster than the number of its elements."""


def simulate(
    circuit: Circuit,
    expected: Expected,
    backend: str = "cxxrtl",
    waves: Waves | None = None,
    progress: Progress = silent,
) -> Run:
    """Run a circuit until it is done, or until it has run for much longer than expected.

    Raises:
        MissingToolError: the simulator or a compiler is not installed; the hint has the command that installs it.
        RunError: the array is too large, the Verilog cannot be compiled, or a tool does not end in time.
        InputError: there is no such backend.
    """
    if backend == AUTO:
        large = work_of(circuit, expected) > _LARGE
        backend = "verilator" if large and tools.command_of("verilator") else "cxxrtl"
        if large and backend == "cxxrtl":
            install = tools.TOOLS["verilator"].install
            progress(f"a large array: Verilator simulates it several times as fast ({install})", 0, 0)
    if circuit.elements > MOST_ELEMENTS:
        raise RunError(
            f"{circuit.top} has {circuit.elements:,} elements: simulators compile arrays of up to {MOST_ELEMENTS:,}",
            None,
            "verify a smaller design, such as one with a smaller map or smaller blocks",
        )
    if backend not in BACKENDS:
        raise InputError(f"there is no simulator {backend!r}", "backend", choose_hint(backend, BACKENDS))
    return BACKENDS[backend](circuit, expected, waves, progress)
