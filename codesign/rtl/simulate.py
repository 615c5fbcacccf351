"""A circuit is simulated on its stream: what it reports, and the cycles of each phase.

All simulators follow the contract of ``planners.circuits``: outputs are sampled just before a rising edge, inputs
change after it, and the edge after the one that takes ``start`` is cycle 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.errors import InputError, choose_hint
from codesign.planners.circuits import Circuit, Expected
from codesign.rtl.bench_runs import icarus, verilator
from codesign.rtl.native import cxxrtl
from codesign.rtl.runs import Run, Waves

Backend = Callable[[Circuit, Expected, Waves | None], Run]

BACKENDS: Mapping[str, Backend] = {"cxxrtl": cxxrtl, "icarus": icarus, "verilator": verilator}
"""Every simulator by its name, the default first."""


def simulate(
    circuit: Circuit, expected: Expected, backend: str = "cxxrtl", waves: Waves | None = None
) -> Run:
    """Run a circuit until it is done, or until it has run for much longer than expected.

    Raises:
        MissingToolError: the simulator or a compiler is not installed; the hint has the command that installs it.
        RunError: the Verilog cannot be compiled.
        InputError: there is no such backend.
    """
    if backend not in BACKENDS:
        raise InputError(f"there is no simulator {backend!r}", "backend", choose_hint(backend, BACKENDS))
    return BACKENDS[backend](circuit, expected, waves)
