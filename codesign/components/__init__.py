"""SimPy components of a platform: FPGA, block RAM, processor and link, on clocks that never drift.

Simulated time is integer picoseconds from 0. Components take plain values and emit records to listeners; they
know neither specs nor traces. Importing this package imports SimPy: import it where a simulation begins.

Granularity. A component that computes could make one event of every visit, or run ahead to
``environment.peek()``, the next moment at which anything else can happen, and make one event of all visits
that end by then. Both give the same records at the same times in the same order, because (1) nobody else acts
before the horizon, so nobody could tell, (2) every unit takes at least one cycle, and (3) among events at one
time SimPy keeps the order in which they were scheduled, and the event at the horizon was scheduled before
ours in both cases. What is rejected: a fixed quantum, as in loosely timed SystemC TLM-2.0, which is faster to
write and inexact.
"""

from codesign.components.block_ram import BlockRam, choose_shape
from codesign.components.clock import ClockDomain
from codesign.components.component import Component
from codesign.components.fpga import Fpga, Granularity, PhaseUse, PreemptedError
from codesign.components.link import Bus
from codesign.components.processor import Processor

__all__ = [
    "BlockRam",
    "Bus",
    "ClockDomain",
    "Component",
    "Fpga",
    "Granularity",
    "PhaseUse",
    "PreemptedError",
    "Processor",
    "choose_shape",
]
