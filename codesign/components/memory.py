"""An external memory (SRAM or DRAM): one access at a time, with latency, rows, refresh and a queue of users."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any

import numpy as np
import simpy

from codesign.components.component import ClockDomain
from codesign.components.scan import Claims, Scan, ScannedMemory
from codesign.ground.errors import RunError
from codesign.ground.records import BROKEN_OFF, ENDED, Listener, TaskRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.planners.external_memory import ExternalMemoryLaw, Traffic


class ExternalMemory(ScannedMemory):
    """A memory with one port, with the costs of ``law``.

    Users queue, first come first served. Each access or run of words begins at an edge of the memory's clock. A display
    that reads the memory (``scanned_by``) is served first. It fetches a line at a time, from the beginning of the line,
    and interrupts the work of other users.

    A design on an FPGA that uses the memory (``Fpga.use``) drives it alone, on the design's clock. It stalls while the
    display is served. No other user is accepted then.

    ``accesses``: words that were read, written, and moved by a design, without the display's words.
    ``queued``: time that users waited for others and for the edge, ps.
    """

    def __init__(
        self, environment: simpy.Environment, name: str, law: ExternalMemoryLaw, listeners: Sequence[Listener] = ()
    ) -> None:
        super().__init__(environment, name, ClockDomain(law.hz), listeners)
        self.law = law
        self.accesses = {"read": 0, "write": 0, "design": 0}
        self.allotted: dict[str, int] = {}
        self.queued = 0
        self._turn = simpy.Resource(environment, capacity=1)
        self._shared = False

    @property
    def bits_left(self) -> int:
        """Bits that are not allotted."""
        return self.law.capacity - sum(self.allotted.values())

    def allocate(self, name: str, bits: int) -> None:
        """Allot ``bits`` bits, rounded up to words, to ``name``.

        Raises:
            RunError: fewer bits are left, ``bits`` is not positive, or ``name`` has bits already.
        """
        if bits < 1 or name in self.allotted:
            raise RunError(f"{bits} bits for {name!r}", self.name, "allot a positive number once for each name")
        whole = -(-bits // self.law.width) * self.law.width
        if whole > self.bits_left:
            raise RunError(
                f"{name} needs {whole} bits, {self.bits_left} of {self.law.capacity} are left",
                self.name,
                "take a memory with a larger capacity, or a smaller map",
            )
        self.allotted[name] = whole

    def share(self, clock: ClockDomain) -> None:
        """Take over the clock of the design that uses the memory; see ``Fpga.use``."""
        if self._shared or self.claims is not None or self.now:
            raise RunError(
                "a design is attached too late, or is the second one",
                self.name,
                "attach one design, before any display and before the run begins",
            )
        if clock.hz > self.law.hz:
            raise RunError(
                f"a design at {clock.hz} Hz beside a memory at {self.law.hz} Hz",
                self.name,
                "the two share one clock: lower that of the FPGA",
            )
        self._shared = True
        self.clock = clock

    def book(self, traffic: Traffic) -> None:
        """Book the traffic of a design after it is done. The cycles of a display are booked separately."""
        self._busy += int(traffic.cycles.sum()) * PICOSECONDS_PER_SECOND // self.clock.hz
        self.accesses["design"] += int(traffic.words.sum())

    def random_cycles(self, accesses: int) -> int:
        """Cycles of ``accesses`` random accesses of a single user."""
        return self.law.random_cycles(accesses)

    def sequential_cycles(self, words: int) -> int:
        """Cycles of ``words`` words in order of a single user."""
        return self.law.sequential_cycles(words)

    def read(self, words: int, *, sequential: bool, task: str = "read") -> Generator[simpy.Event, Any, int]:
        """Process generator: read ``words`` words, in order or at random. Returns the time of the end, ps.

        Its ``TaskRecord`` is written when it ends, with its cycles, including those lost to the display. An
        interruption frees the memory, and the record says "broken off".

        Raises:
            RunError: no words.
        """
        return (yield from self._serve("read", words, sequential, task))

    def write(self, words: int, *, sequential: bool, task: str = "write") -> Generator[simpy.Event, Any, int]:
        """Process generator: write ``words`` words. See ``read``."""
        return (yield from self._serve("write", words, sequential, task))

    def _serve(self, kind: str, words: int, sequential: bool, task: str) -> Generator[simpy.Event, Any, int]:
        if words < 1:
            raise RunError(f"a {kind} of {words} words", self.name, "give at least one")
        if self._shared:
            raise RunError(f"a {kind} beside a design that drives the memory", self.name, "let the design do it")
        work = self.sequential_cycles(words) if sequential else self.random_cycles(words)
        requested = self.now
        with self._turn.request() as turn:
            yield turn
            first = self.clock.cycle_at_or_after(self.now)
            begin = self.clock.edge(first)
            if begin > self.now:
                yield self.environment.timeout(begin - self.now)
            self.queued += begin - requested
            self._work_begins(first)
            last = self._end(first, work)
            try:
                with self._working():
                    yield self.environment.timeout(self.clock.edge(last) - begin)
            except simpy.Interrupt:
                self._emit_task(task, begin, self.clock.cycles_by(self.now) - first, BROKEN_OFF)
                raise
            finally:
                self._work_ends(self.clock.cycle_at_or_after(self.now))
        self.accesses[kind] += words
        self._emit_task(task, begin, last - first, ENDED)
        return self.now

    def _emit_task(self, task: str, begin: int, cycles: int, outcome: str) -> None:
        if self.wants(TaskRecord):
            self.emit(TaskRecord(begin, self.name, task, self.now, cycles, outcome))

    def _end(self, first: int, work: int) -> int:
        if self.claims is None:
            return first + work
        return int(self.claims.ends(first, np.array([work], np.int64))[0])

    def _claims_of(self, scan: Scan, pixel_clock: ClockDomain) -> Claims:
        """One burst a line, of the most words that arrive before the next line begins (by bisection)."""
        budget = Claims.line_cycles(scan, pixel_clock, self.clock)
        words, most = 0, scan.words_a_line
        while words < most:
            middle = (words + most + 1) // 2
            fits = self.sequential_cycles(middle) <= budget
            words, most = (middle, most) if fits else (words, middle - 1)
        burst = self.sequential_cycles(words)
        return Claims(scan, pixel_clock, self.clock, burst=burst, words=words)
