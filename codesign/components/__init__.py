"""SimPy components of a platform: FPGA, block RAM, processor and link, on clocks that never drift.

Simulated time is integer picoseconds from 0. Components take plain values and emit records to listeners; they
know neither specs nor traces. Importing this package imports SimPy: import it where a simulation begins.

Granularity. A component that computes can make one event of each visit. Or it can run ahead to the horizon,
``environment.peek()``, the next time at which anything else can happen, and make one event of all visits that end no
later. Both give the same records at the same times in the same order, for three reasons. (1) Nothing else acts before
the horizon, so nothing can observe the difference. (2) Every unit takes at least one cycle. (3) Among events at one
time SimPy keeps the order in which they were scheduled, and in both cases the event at the horizon was scheduled
before ours. Rejected: a fixed quantum, as in loosely timed SystemC TLM-2.0. It is simpler, and inexact.
"""

from codesign.components.block_ram import BlockRam, WriteMode, choose_shape
from codesign.components.bus import Arbitration, Bus
from codesign.components.component import ClockDomain, Component
from codesign.components.delivery import ABANDONED, LINK_DOWN, Delivery, DeliveryOutcome
from codesign.components.display import VgaDisplay
from codesign.components.fpga import Fpga, Granularity, PhaseUse, PreemptedError
from codesign.components.link import Ideal, Link
from codesign.components.link_faults import LinkErrors
from codesign.components.memory import ExternalMemory
from codesign.components.processor import Processor
from codesign.components.robot import MobileRobot
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
    "DeliveryOutcome",
    "ExternalMemory",
    "Fpga",
    "Granularity",
    "Ideal",
    "Link",
    "LinkErrors",
    "MobileRobot",
    "Parity",
    "PhaseUse",
    "PreemptedError",
    "Processor",
    "Scan",
    "Serial",
    "VgaDisplay",
    "WriteMode",
    "choose_shape",
]
