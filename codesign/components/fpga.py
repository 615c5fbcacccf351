"""An FPGA runs the steps of an architecture style on a clock, one visit at a time or as far ahead as is exact."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components.block_ram import PORTS, BlockRam
from codesign.components.component import ClockDomain, Component
from codesign.components.memory import ExternalMemory
from codesign.ground.errors import RunError
from codesign.ground.records import BROKEN_OFF, UNFINISHED, Listener, TaskRecord
from codesign.planners.styles import MemoryStep, Step

T = TypeVar("T")

MAX_STEP_CYCLES = 2**62
"""Most cycles of a step, and most cycles since time 0. 64-bit sums hold them with a margin."""


class Granularity(StrEnum):
    """The number of simulation events that a component makes of its work. The results are the same.

    - ``visit``: one event for each indivisible unit (a visit). Slow; the reference.
    - ``run_ahead``: one event for all units that end no later than the next time at which anything else can happen.
    """

    VISIT = "visit"
    RUN_AHEAD = "run_ahead"


@dataclass(frozen=True)
class PhaseUse:
    """The use of one phase so far: its clock cycles, and their picoseconds."""

    cycles: int = 0
    busy: int = 0


class PreemptedError(Exception):
    """The work was interrupted (``simpy.Interrupt``) before its end.

    - ``cause``: the cause that the interrupter gave. ``time``: of the interruption, ps.
    - ``phase``: the phase of the current step; None if the first step had not begun.
    - ``units``: units of that step that had ended at ``time`` or before; they are done. The unit in progress is lost.
    - ``cycles``: whole clock cycles since that step began, also the cycles of the lost unit.

    The generator of the steps is left open, so that the caller can continue the plan or close it.
    """

    def __init__(self, cause: object, time: int, phase: str | None, units: int, cycles: int) -> None:
        super().__init__(cause, time, phase, units, cycles)
        self.cause = cause
        self.time = time
        self.phase = phase
        self.units = units
        self.cycles = cycles


class Fpga(Component):
    """An FPGA with one clock, which executes one task at a time.

    ``phases`` books the cycles and the picoseconds of every phase, in the order of its first step. ``block_ram``
    represents all block RAMs of the design, which are driven alike: the addresses of each step are booked on its ports.
    Where a display takes one of the ports that a step drives, the design stalls for that cycle, and the step takes one
    cycle more. The same holds where a display takes ``external``, the memory on the pins, during a step that uses it.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        listeners: Sequence[Listener] = (),
        block_ram: BlockRam | None = None,
    ) -> None:
        super().__init__(environment, name, listeners)
        self.clock = clock
        self.block_ram = block_ram
        self.external: ExternalMemory | None = None
        self.phases: dict[str, PhaseUse] = {}
        self._step: tuple[Step, int] | None = None

    def use(self, memory: ExternalMemory) -> None:
        """Attach a memory on the pins to the design. Both have the design's clock from now on.

        Raises:
            RunError: the design's clock is faster than the memory's, the memory has a design or a display
                already, or time has passed.
        """
        memory.share(self.clock)
        self.external = memory

    def execute(
        self, steps: Generator[Step, None, T], granularity: Granularity = Granularity.RUN_AHEAD
    ) -> Generator[simpy.Event, Any, T]:
        """Process generator: run ``steps`` back to back from the next clock edge. Returns what they return.

        A step's record is written when the step ends. Both granularities give the same records at the same simulated
        times in the same order. A step that is broken off leaves a ``TaskRecord`` of its phase.

        Raises:
            PreemptedError: the process was interrupted.
            RunError: the FPGA is executing another task, or a unit of a step takes less than one cycle.
        """
        cycle = self.clock.cycle_at_or_after(self.now)
        wait = self.clock.edge(cycle) - self.now
        if wait:
            try:
                yield self.environment.timeout(wait)
            except simpy.Interrupt as interrupt:
                raise PreemptedError(interrupt.cause, self.now, None, 0, 0) from None
        with self._working():
            while True:
                try:
                    step = next(steps)
                except StopIteration as end:
                    return end.value  # type: ignore[no-any-return]
                cycle = yield from self._run(step, cycle, granularity)

    def _run(self, step: Step, first: int, granularity: Granularity) -> Generator[simpy.Event, Any, int]:
        """Process generator: run one step from edge ``first``. Returns the edge at which it ends."""
        ends = self._unit_ends(step, first)
        self._step = step, first
        done = 0
        try:
            while done < len(ends):
                # A unit is never cut at the horizon: half of a unit has no effect that anything could observe.
                done = max(done + 1, self._units_before_others(ends, granularity))
                yield self.environment.timeout(self.clock.edge(int(ends[done - 1])) - self.now)
        except simpy.Interrupt as interrupt:
            now = self.clock.cycles_by(self.now)
            units = int(np.searchsorted(ends, now, side="right"))
            self._book(step, first, now, self.now, units)
            self._step = None
            if units == len(ends):
                self._emit_step(step, first, now)
            else:
                self._emit_part(step, first, BROKEN_OFF)
            raise PreemptedError(interrupt.cause, self.now, step.phase, units, now - first) from None
        last = int(ends[-1]) if len(ends) else first
        self._book(step, first, last, self.clock.edge(last), len(ends))
        self._step = None
        self._emit_step(step, first, last)
        return last

    def _unit_ends(self, step: Step, first: int) -> NDArray[np.int64]:
        """The edge at which each unit of ``step`` ends, int64."""
        cycles = np.asarray(step.cycles, dtype=np.int64)
        if cycles.size and int(cycles.min()) < 1:
            # With a unit of no time, the order of events would depend on the granularity.
            raise RunError(
                f"a unit of phase {step.phase!r} takes {int(cycles.min())} cycles",
                self.name,
                "every unit of a step takes at least one cycle; leave out units that do nothing",
            )
        if float(cycles.sum(dtype=np.float64)) + first > MAX_STEP_CYCLES:
            raise RunError(f"phase {step.phase!r} runs beyond 2^62 cycles", self.name, "make the problem smaller")
        work = np.cumsum(cycles, dtype=np.int64)
        inside = self.block_ram.claims if self.block_ram and step.ram_addresses >= PORTS else None
        outside = self.external.claims if self.external and isinstance(step, MemoryStep) else None
        if inside is not None and outside is not None:
            raise RunError(
                f"two displays stall phase {step.phase!r}", self.name, "let one of them read a copy of its own"
            )
        claims = inside or outside
        return np.asarray(first + work, np.int64) if claims is None else claims.ends(first, work)

    def _units_before_others(self, ends: NDArray[np.int64], granularity: Granularity) -> int:
        """The number of units that end no later than the next event of another process; 0 if units run one by one."""
        if granularity is Granularity.VISIT:
            return 0
        horizon = self.environment.peek()
        if horizon == simpy.core.Infinity:
            return len(ends)
        edge = min(self.clock.cycles_by(int(horizon)), int(ends[-1]))
        return int(np.searchsorted(ends, edge, side="right"))

    def _book(self, step: Step, first: int, last: int, end: int, units: int) -> None:
        use = self.phases.get(step.phase, PhaseUse())
        busy = use.busy + end - self.clock.edge(first)
        self.phases[step.phase] = PhaseUse(use.cycles + last - first, busy)
        if self.block_ram is not None and step.ram_addresses and last > first:
            self.block_ram.stream(first, last - first, step.ram_addresses)
        if self.external is not None and isinstance(step, MemoryStep):
            self.external.book(step.traffic.part(0, units))

    def _emit_step(self, step: Step, first: int, last: int) -> None:
        if step.record is not None and self.wants(step.makes):
            self.emit(step.record(self.clock.edge(first), self.clock.edge(last), self.name))

    def _emit_part(self, step: Step, first: int, outcome: str) -> None:
        """Emit the part that is done of a step that began at edge ``first``."""
        if step.record is not None and self.wants(TaskRecord):
            begin, cycles = self.clock.edge(first), self.clock.cycles_by(self.now) - first
            self.emit(TaskRecord(begin, self.name, step.phase, self.now, cycles, outcome))

    def _report_unfinished(self) -> None:
        if self._step is not None:
            self._emit_part(*self._step, UNFINISHED)
