"""A processor: a robot's host or a PC, known by what one unit of each kernel costs it."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from typing import Any

import simpy

from codesign.components.clock import ClockDomain
from codesign.components.component import Component
from codesign.errors import RunError, choose_hint
from codesign.records import Listener, TaskRecord


class Processor(Component):
    """One core that runs one task at a time, in the order in which they were asked for.

    ``costs``: picoseconds for one unit of each named kernel. ``clock`` only tells how many cycles that came
    to; a processor's tasks do not wait for an edge.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        costs: Mapping[str, int],
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        self.clock = clock
        self.costs = dict(costs)
        self._turn = simpy.Resource(environment, capacity=1)

    def duration(self, kernel: str, units: int) -> int:
        """Picoseconds that ``units`` units of ``kernel`` take.

        Raises:
            RunError: the processor has no cost for ``kernel``, or ``units`` is negative.
        """
        if kernel not in self.costs:
            raise RunError(
                f"no cost is given for kernel {kernel!r}",
                f"{self.name}.costs",
                choose_hint(kernel, self.costs),
            )
        if units < 0:
            raise RunError(f"{units} units of {kernel}", self.name, "give 0 or more")
        return self.costs[kernel] * units

    def execute(self, kernel: str, units: int, task: str | None = None) -> Generator[simpy.Event, Any, int]:
        """Process generator: run ``units`` units of ``kernel``; returns the time of the end, ps.

        Its ``TaskRecord`` (named ``task``, or else ``kernel``) is emitted at the end; its cycles are those
        that had begun by then, so a part of a cycle counts as one.

        Raises:
            RunError: see ``duration``.
        """
        duration = self.duration(kernel, units)
        with self._turn.request() as turn:
            yield turn
            begin = self.now
            with self._working():
                yield self.environment.timeout(duration)
            if self.listening:
                self.emit(
                    TaskRecord(
                        time=begin,
                        source=self.name,
                        task=task or kernel,
                        end=self.now,
                        cycles=self.clock.cycle_at_or_after(duration),
                    )
                )
        return self.now
