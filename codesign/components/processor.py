"""A processor, such as a robot's host or a PC, described by the cost of one unit of each kernel."""

from __future__ import annotations

from bisect import insort
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import simpy

from codesign.components.component import ClockDomain, Component
from codesign.components.fpga import PreemptedError
from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.records import BROKEN_OFF, ENDED, PREEMPTED, UNFINISHED, Listener, TaskRecord
from codesign.laws.acts import KernelLaw


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
    ) -> None:
        super().__init__(environment, name, listeners)
        if cores < 1:
            raise InputError(f"{cores} cores", f"{name}.cores", "give at least 1")
        self.clock = clock
        self.costs = dict(costs)
        self.cores = cores
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
        return int(KernelLaw(self.costs[kernel]).ticks(units))

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
            raise self._abandon(job, kernel, units, interrupt.cause) from None
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

    def _abandon(self, job: _Job, kernel: str, units: int, cause: object) -> PreemptedError:
        self._leave(job)
        if not job.begun:
            return PreemptedError(cause, self.now, None, 0, 0)
        self._emit_stretch(job, ENDED if job.served == job.duration else BROKEN_OFF)
        cost = self.costs[kernel]
        done = job.served // cost if cost else units
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
