"""Who is next on what serves one at a time, where several ask for it in the same picosecond.

SimPy handles the events of one picosecond in the order in which they were scheduled, which follows from how the code
is written and says nothing of urgency. So an idle line is not simply given to the first who asks. The most urgent
priority, 0, has it at once. The others wait for the end of the picosecond, the more urgent before the less: what a
control message causes within the picosecond comes before any plan, and what a plan causes before any side task.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from typing import Any

import simpy
from simpy.events import EventPriority

from codesign.errors import RunError

MOST_URGENT = 0
"""The priority that waits for nobody: nothing more urgent can come within the picosecond."""

_LAST = 2
"""SimPy handles its own events of a picosecond at the priorities 0 and 1."""


class _EndOfMoment(simpy.Event):
    """Happens in this picosecond, after all that is more urgent than ``priority``, and after what that causes."""

    def __init__(self, environment: simpy.Environment, priority: int, then: Callable[[], None]) -> None:
        super().__init__(environment)
        self._ok, self._value = True, None
        self.callbacks = [lambda _: then()]
        environment.schedule(self, EventPriority(_LAST + priority))


class Chooser:
    """Decides at the end of the picosecond whom to serve.

    Args:
        environment: the simulation.
        best: the priority of the most urgent that waits and can be served now; None where nobody can.
        serve: serve that one.
    """

    def __init__(
        self, environment: simpy.Environment, best: Callable[[], int | None], serve: Callable[[], None]
    ) -> None:
        self._environment, self._best, self._serve = environment, best, serve
        self._due: int | None = None

    def choose(self) -> None:
        """Serve the most urgent that waits: at once where nothing can be more urgent, or else when its turn comes."""
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
    """``priority``, where it is one.

    Raises:
        RunError: it is below ``MOST_URGENT``.
    """
    if priority < MOST_URGENT:
        raise RunError(f"priority {priority}", where, f"the most urgent is {MOST_URGENT}")
    return priority


class Turns:
    """What one user at a time has to itself, as an FPGA: the most urgent is next, then who asked first."""

    def __init__(self, environment: simpy.Environment, name: str) -> None:
        self._environment, self._name = environment, name
        self._taken = False
        self._asked = 0
        self._waiting: list[tuple[int, int, simpy.Event]] = []
        self._chooser = Chooser(environment, self._most_urgent, self._serve)

    @contextmanager
    def turn(self, priority: int) -> Generator[simpy.Event, Any, None]:
        """A turn from when its event, which the caller waits for, happens, up to the end of the ``with`` block.

        Raises:
            RunError: see ``checked_priority``.
        """
        granted = self._environment.event()
        waits = (checked_priority(priority, self._name), self._asked, granted)
        self._asked += 1
        self._waiting.append(waits)
        self._chooser.choose()
        try:
            yield granted
        finally:
            if waits in self._waiting:
                self._waiting.remove(waits)
            else:
                self._taken = False
                self._chooser.choose()

    def _most_urgent(self) -> int | None:
        return None if self._taken or not self._waiting else min(self._waiting)[0]

    def _serve(self) -> None:
        first = min(self._waiting)
        self._waiting.remove(first)
        self._taken = True
        first[2].succeed()
