"""SimPy components of a platform: FPGA, block RAM, processor and link, on clocks that never drift.

Simulated time is integer picoseconds from 0. Components take plain values and emit records to listeners; they
know neither specs nor traces. A name of this package loads its module, and SimPy, when it is first asked for.

Granularity. A component that computes can make one event of each visit. Or it can run ahead to the horizon,
``environment.peek()``, the next time at which anything else can happen, and make one event of all visits that end no
later. Both give the same records at the same times in the same order, for three reasons. (1) Nothing else acts before
the horizon, so nothing can observe the difference. (2) Every unit takes at least one cycle. (3) Among events at one
time SimPy keeps the order in which they were scheduled, and in both cases the event at the horizon was scheduled
before ours. Rejected: a fixed quantum, as in loosely timed SystemC TLM-2.0. It is simpler, and inexact.
"""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
