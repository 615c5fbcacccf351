"""An FPGA runs the steps of an architecture style on a clock, one visit at a time or as far ahead as is exact.

Its external memory (SRAM or DRAM) and the processor beside it stand here too.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, TypeVar

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components.block_ram import PORTS, BlockRam, Claims, Scan, ScannedMemory
from codesign.components.component import ClockDomain, Component
from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.records import BROKEN_OFF, ENDED, PREEMPTED, UNFINISHED, Listener, TaskRecord
from codesign.ground.units import PICOSECONDS_PER_SECOND, edge
from codesign.laws.acts import UNDISTURBED, KernelLaw
from codesign.planners.external_memory import ExternalMemoryLaw, Traffic
from codesign.planners.styles import MemoryStep, Step

# An external memory (SRAM or DRAM): one access at a time, with latency, rows, refresh and a queue of users.


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
            what = f"{name} needs {whole} bits, {self.bits_left} of {self.law.capacity} are left"
            raise RunError(what, self.name, "take a memory with a larger capacity, or a smaller map")
        self.allotted[name] = whole

    def share(self, clock: ClockDomain) -> None:
        """Take over the clock of the design that uses the memory; see ``Fpga.use``."""
        if self._shared or self.claims is not None or self.now:
            what = "a design is attached too late, or is the second one"
            raise RunError(what, self.name, "attach one design, before any display and before the run begins")
        if clock.hz > self.law.hz:
            what = f"a design at {clock.hz} Hz beside a memory at {self.law.hz} Hz"
            raise RunError(what, self.name, "the two share one clock: lower that of the FPGA")
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
            what = f"a unit of phase {step.phase!r} takes {int(cycles.min())} cycles"
            hint = "every unit of a step takes at least one cycle; leave out units that do nothing"
            raise RunError(what, self.name, hint)
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


@dataclass(slots=True, eq=False)
class _Job:
    """A task that runs or waits; times in ps.

    ``served``: its time on a core so far, without the stretch since ``since`` where it ``runs``. ``told``: the part of
    it that records tell of. ``begun``: it was on a core. ``resume``: the event that it waits for while it does not run.
    """

    priority: int
    number: int
    requested: int
    duration: int
    task: str
    served: int = 0
    told: int = 0
    runs: bool = False
    since: int = 0
    begun: bool = False
    resume: simpy.Event | None = None
    key: tuple[int, int] = field(init=False)

    def __post_init__(self) -> None:
        self.key = (self.priority, self.number)


class Processor(Component):
    """``cores`` equal cores that run one task each: the most urgent tasks first, then the oldest requests.

    A task of a lower ``priority`` preempts one of a higher priority at once. The preempted task goes on later without
    loss, before later tasks of its own priority. Switching takes no time (assumed). Tasks of equal priority never
    preempt each other.

    ``costs``: picoseconds for one unit of each named kernel. ``clock`` only converts these times into cycles: a
    processor's tasks do not wait for an edge.

    ``waited``: the sum of the time in which tasks were ready and not on a core, ps, over tasks that ended or were
    interrupted. ``busy``: the time in which at least one core worked. ``core_busy``: the sum over the cores.

    Rejected: SimPy's ``PreemptiveResource``. It preempts by an interruption of the process, which cannot be called
    back. Where a task is interrupted and a more urgent one runs in the same picosecond, the second interruption would
    reach the process after it had left the processor.

    Raises:
        InputError: fewer than one core.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        costs: Mapping[str, int],
        listeners: Sequence[Listener] = (),
        *,
        cores: int = 1,
        pace: int = UNDISTURBED,
    ) -> None:
        super().__init__(environment, name, listeners)
        if cores < 1:
            raise InputError(f"{cores} cores", f"{name}.cores", "give at least 1")
        self.clock = clock
        self.costs = dict(costs)
        self.cores = cores
        self.pace = pace
        self.waited = 0
        self._ended_core_busy = 0
        self._requests = 0
        self._jobs: list[_Job] = []

    @property
    def core_busy(self) -> int:
        """Picoseconds of work of all cores together, including work in progress."""
        return self._ended_core_busy + sum(self._served(job) for job in self._jobs)

    def duration(self, kernel: str, units: int) -> int:
        """Picoseconds that ``units`` units of ``kernel`` take.

        Raises:
            RunError: the processor has no cost for ``kernel``, or ``units`` is negative.
        """
        if kernel not in self.costs:
            raise RunError(
                f"no cost is given for kernel {kernel!r}", f"{self.name}.costs", choose_hint(kernel, self.costs)
            )
        if units < 0:
            raise RunError(f"{units} units of {kernel}", self.name, "give 0 or more")
        law = KernelLaw(self.costs[kernel], self.pace)
        return edge(law.ticks(units), law.rate())

    def execute(
        self, kernel: str, units: int, task: str | None = None, priority: int = 0
    ) -> Generator[simpy.Event, Any, int]:
        """Process generator: run ``units`` units of ``kernel``. Returns the time of the end, ps.

        Each stretch on a core has a ``TaskRecord`` (named ``task``, otherwise ``kernel``): "preempted", where a more
        urgent task took the core, and the last one with the outcome of the task. So the records of a core never
        overlap. The cycles of all stretches together are the cycles of the work that had begun: a part of a cycle
        counts as one.

        Raises:
            PreemptedError: the process was interrupted from outside. ``units`` and ``cycles`` (whole ones) count what
                was done; ``phase`` is None if the task had not begun. The task is not resumed. It leaves a
                record of the part that was served, as "broken off" unless that is all of it.
            RunError: see ``duration``.
        """
        job = _Job(priority, self._requests, self.now, self.duration(kernel, units), task or kernel)
        self._requests += 1
        insort(self._jobs, job, key=lambda waiting: waiting.key)
        self._assign_cores()
        try:
            # One timeout for each stretch of work, never cancelled: the process checks its progress when it wakes.
            while (rest := job.duration - self._served(job)) or not job.begun:
                if job.runs:
                    yield self.environment.timeout(rest)
                else:
                    job.resume = self.environment.event()
                    yield job.resume
        except simpy.Interrupt as interrupt:
            raise self._abandon(job, units, interrupt.cause) from None
        self._leave(job)
        self._emit_stretch(job, ENDED)
        return self.now

    def _served(self, job: _Job) -> int:
        return job.served + (self.now - job.since if job.runs else 0)

    def _assign_cores(self) -> None:
        """Put the first jobs in order on the cores, and stop the others."""
        for index, job in enumerate(self._jobs[: self.cores + 1]):
            if index < self.cores and not job.runs:
                self._start(job)
            elif index == self.cores and job.runs:
                self._stop(job)
                # A task that is done at this moment leaves by itself, and one that has only begun has done nothing.
                if job.told < job.served < job.duration:
                    self._emit_stretch(job, PREEMPTED)

    def _start(self, job: _Job) -> None:
        self._begin_work()
        job.runs, job.since, job.begun = True, self.now, True
        if job.resume is not None:
            job.resume.succeed()
            job.resume = None

    def _stop(self, job: _Job) -> None:
        job.served = self._served(job)
        job.runs = False
        self._end_work()

    def _leave(self, job: _Job) -> None:
        if job.runs:
            self._stop(job)
        self._jobs.remove(job)
        self._ended_core_busy += job.served
        self.waited += self.now - job.requested - job.served
        self._assign_cores()

    def _abandon(self, job: _Job, units: int, cause: object) -> PreemptedError:
        self._leave(job)
        if not job.begun:
            return PreemptedError(cause, self.now, None, 0, 0)
        self._emit_stretch(job, ENDED if job.served == job.duration else BROKEN_OFF)
        done = job.served * units // job.duration if job.duration else units
        return PreemptedError(cause, self.now, job.task, done, self.clock.cycles_by(job.served))

    def _emit_stretch(self, job: _Job, outcome: str) -> None:
        """Write the record of the latest stretch; of length 0 for a task that ends off a core."""
        served = self._served(job)
        if self.wants(TaskRecord):
            cycles = self.clock.cycle_at_or_after(served) - self.clock.cycle_at_or_after(job.told)
            begin = self.now - (served - job.told)
            self.emit(TaskRecord(begin, self.name, job.task, self.now, cycles, outcome))
        job.told = served

    def _report_unfinished(self) -> None:
        for job in self._jobs:
            if job.begun:
                self._emit_stretch(job, UNFINISHED)
