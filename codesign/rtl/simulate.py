"""A circuit is simulated on its stream: what it reports, and the cycles of each phase.

All simulators follow the contract of ``planners.circuits``: outputs are sampled just before a rising edge, inputs
change after it, and the edge after the one that takes ``start`` is cycle 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.planners.circuits import Circuit
from codesign.rtl.native import cxxrtl
from codesign.rtl.runs import Run, Waves

Backend = Callable[[Circuit, int, Waves | None], Run]


BACKENDS: Mapping[str, Backend] = {"cxxrtl": cxxrtl}
"""Every simulator by its name, the default first."""


def simulate(circuit: Circuit, bound: int, backend: str = "cxxrtl", waves: Waves | None = None) -> Run:
    """Run a circuit until it is done, at most ``bound`` cycles.

    Raises:
        MissingToolError: the simulator or a compiler is not installed; the hint has the command that installs it.
        RunError: the Verilog cannot be compiled.
        KeyError: there is no such backend.
    """
    return BACKENDS[backend](circuit, bound, waves)
