"""The choice of the next user of a shared resource, where several request it in the same picosecond.

SimPy handles the events of one picosecond in the order in which they were scheduled. That order follows from how the
code is written and not from urgency. So an idle line is not given to the first request. The most urgent priority, 0,
gets it at once. The others wait for the end of the picosecond, the more urgent before the less urgent: what a control
message causes within the picosecond comes before any plan, and what a plan causes comes before any side task.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from typing import Any

import simpy
from simpy.events import EventPriority

from codesign.ground.errors import RunError

MOST_URGENT = 0
"""The priority that never waits for the end of the picosecond: no request can be more urgent."""

_LAST = 2
"""SimPy handles its own events of a picosecond at the priorities 0 and 1."""


class _EndOfMoment(simpy.Event):
    """Happens in this picosecond, after all events that are more urgent than ``priority`` and what they cause."""

    def __init__(self, environment: simpy.Environment, priority: int, then: Callable[[], None]) -> None:
        super().__init__(environment)
        self._ok, self._value = True, None
        self.callbacks = [lambda _: then()]
        environment.schedule(self, EventPriority(_LAST + priority))


class Arbiter:
    """Decides at the end of the picosecond which request is served.

    Args:
        environment: the simulation.
        best: returns the priority of the most urgent request that can be served now, None without one.
        serve: serves that request.
    """

    def __init__(
        self, environment: simpy.Environment, best: Callable[[], int | None], serve: Callable[[], None]
    ) -> None:
        self._environment, self._best, self._serve = environment, best, serve
        self._due: int | None = None

    def choose(self) -> None:
        """Serve the most urgent request: at once where none can be more urgent, otherwise at its turn."""
        best = self._best()
        if best is None:
            return
        if best <= MOST_URGENT:
            self._serve()
        elif self._due is None or best < self._due:
            self._due = best
            _EndOfMoment(self._environment, best, partial(self._decide, best))

    def _decide(self, priority: int) -> None:
        if self._due == priority:
            self._due = None
        best = self._best()
        if best is not None and best <= priority:
            self._serve()
        else:
            self.choose()


def checked_priority(priority: int, where: str) -> int:
    """``priority`` as it is, once checked.

    Raises:
        RunError: it is below ``MOST_URGENT``.
    """
    if priority < MOST_URGENT:
        raise RunError(f"priority {priority}", where, f"the most urgent is {MOST_URGENT}")
    return priority


class Turns:
    """A resource with one user at a time, such as an FPGA. The most urgent request is next, then the oldest."""

    def __init__(self, environment: simpy.Environment, name: str) -> None:
        self._environment, self._name = environment, name
        self._taken = False
        self._requests = 0
        self._waiting: list[tuple[int, int, simpy.Event]] = []
        self._arbiter = Arbiter(environment, self._most_urgent, self._serve)

    @contextmanager
    def turn(self, priority: int) -> Generator[simpy.Event, Any, None]:
        """A turn. The caller waits for the event; the turn lasts from then to the end of the ``with`` block.

        Raises:
            RunError: see ``checked_priority``.
        """
        granted = self._environment.event()
        request = (checked_priority(priority, self._name), self._requests, granted)
        self._requests += 1
        self._waiting.append(request)
        self._arbiter.choose()
        try:
            yield granted
        finally:
            if request in self._waiting:
                self._waiting.remove(request)
            else:
                self._taken = False
                self._arbiter.choose()

    def _most_urgent(self) -> int | None:
        return None if self._taken or not self._waiting else min(self._waiting)[0]

    def _serve(self) -> None:
        first = min(self._waiting)
        self._waiting.remove(first)
        self._taken = True
        first[2].succeed()
