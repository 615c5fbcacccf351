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

from codesign.components.block_ram import BlockRam, WriteMode, choose_shape
from codesign.components.bus import Arbitration, Bus
from codesign.components.clock import ClockDomain
from codesign.components.component import Component
from codesign.components.display import Display
from codesign.components.fpga import Fpga, Granularity, PhaseUse, PreemptedError
from codesign.components.ideal import Ideal
from codesign.components.link import ABANDONED, LINK_DOWN, Delivery, Link, Outcome
from codesign.components.link_faults import LinkErrors
from codesign.components.memory import ExternalMemory
from codesign.components.processor import Processor
from codesign.components.robot import Robot
from codesign.components.scan import Scan
from codesign.components.serial import Parity, Serial

__all__ = [
    "ABANDONED",
    "LINK_DOWN",
    "Arbitration",
    "BlockRam",
    "Bus",
    "ClockDomain",
    "Component",
    "Delivery",
    "Display",
    "ExternalMemory",
    "Fpga",
    "Granularity",
    "Ideal",
    "Link",
    "LinkErrors",
    "Outcome",
    "Parity",
    "PhaseUse",
    "PreemptedError",
    "Processor",
    "Robot",
    "Scan",
    "Serial",
    "WriteMode",
    "choose_shape",
]
