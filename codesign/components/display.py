"""A display with a VGA timing. Its reads from a memory are in closed form over any span of time."""

from __future__ import annotations

from collections.abc import Sequence

import simpy

from codesign.components.block_ram import Scan, ScannedMemory
from codesign.components.component import ClockDomain, Component
from codesign.ground.records import Listener
from codesign.ground.units import PICOSECONDS_PER_SECOND

VGA = Scan(columns=640, rows=480, total_columns=800, total_rows=525)
"""640 × 480 at 60 Hz, with a pixel clock of 25.175 MHz. The industry's timing (assumed, from memory)."""

SVGA_65 = Scan(columns=800, rows=600, total_columns=1344, total_rows=806)
"""800 × 600 visible pixels, a 65-MHz clock and 60 ± 1 Hz, as printed by Vacariu et al. (2008), section 3.1.1. No usual
timing of 800 × 600 has all three. Assumed: the totals of 1024 × 768 at 60 Hz, which has that clock, with borders."""


class VgaDisplay(Component):
    """A display that reads ``scan`` from ``memory`` from time 0. It makes no events.

    ``memory`` None: the display has its own copy and delays no other user. Where a design drives both ports of a block
    RAM, the display takes a port from it (see ``Fpga``). Of an external memory, it takes the beginning of each line.

    ``busy`` is the time of the visible pixels, ps.

    Raises:
        RunError: the memory has a display already, or this one would take every cycle of the memory.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        scan: Scan,
        *,
        memory: ScannedMemory | None = None,
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        self.clock = clock
        self.scan = scan
        self.memory = memory
        self._claims = memory.scanned_by(scan, clock) if memory is not None else None

    def accesses(self, begin: int, end: int) -> int:
        """Words that are requested from ``begin`` (ps, included) to ``end`` (excluded)."""
        first, last = (self.clock.cycle_at_or_after(time) for time in (begin, end))
        return self.scan.requests_before(last) - self.scan.requests_before(first)

    @property
    def frames(self) -> int:
        """Frames scanned to their end, blanking included."""
        return self.clock.cycles_by(self.now) // self.scan.pixels_a_frame

    @property
    def starved(self) -> int:
        """Words that the memory delivered too late, in lines that were scanned to their end."""
        missing = self.scan.words_a_line - (self._claims.words if self._claims else self.scan.words_a_line)
        return missing * self.scan.lines_before(self.clock.cycles_by(self.now))

    @property
    def port_cycles(self) -> int:
        """Cycles of the memory's clock that the display took so far; 0 where it has its own copy."""
        if self._claims is None or self.memory is None:
            return 0
        return self._claims.between(0, self.memory.clock.cycles_by(self.now))

    @property
    def port_share(self) -> float:
        """The display's share of the memory's cycles so far, 0 to 1."""
        cycles = self.memory.clock.cycles_by(self.now) if self.memory is not None else 0
        return self.port_cycles / cycles if cycles else 0.0

    @property
    def busy(self) -> int:
        """Picoseconds of visible pixels so far."""
        visible = Scan(self.scan.columns, self.scan.rows, self.scan.total_columns, self.scan.total_rows)
        pixels = visible.requests_before(self.clock.cycles_by(self.now))
        return pixels * PICOSECONDS_PER_SECOND // self.clock.hz
