"""What all components share: a name, listeners, and the account of the time they were busy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import simpy

from codesign.errors import RunError
from codesign.records import Listener, Record, UtilisationRecord


class Component:
    """Something of a platform that does work or holds data.

    ``name`` is the source of its records. ``listeners`` take them; with none, no record is ever built
    (subclasses ask ``listening`` first). ``environment`` must start at time 0 and is only ever given whole
    picoseconds.
    """

    def __init__(self, environment: simpy.Environment, name: str, listeners: Sequence[Listener] = ()) -> None:
        self.environment = environment
        self.name = name
        self._listeners = tuple(listeners)
        self._busy = 0
        self._busy_since = 0
        self._under_way = 0

    @property
    def now(self) -> int:
        """The simulated time, ps."""
        return int(self.environment.now)

    @property
    def listening(self) -> bool:
        """Whether anybody listens: no record need be built otherwise."""
        return bool(self._listeners)

    def emit(self, record: Record) -> None:
        """Hand ``record`` to every listener, in the order in which they were given."""
        for listener in self._listeners:
            listener(record)

    @property
    def busy(self) -> int:
        """Picoseconds in which at least one piece of work was under way; never more than ``now``."""
        return self._busy + (self.now - self._busy_since if self._under_way else 0)

    def utilisation(self) -> UtilisationRecord:
        """How busy the component was from time 0 to now."""
        return UtilisationRecord(time=self.now, source=self.name, busy=self.busy, span=self.now)

    def report_end(self) -> None:
        """Emit the tasks under way, as unfinished, and ``utilisation()``: called once, at the end of a run."""
        if self.listening:
            self._tell_unfinished()
            self.emit(self.utilisation())

    def _tell_unfinished(self) -> None:
        """Emit a record of each task under way that is told as a record; most components have none."""

    @contextmanager
    def _working(self, *, alone: bool = True) -> Iterator[None]:
        """Book the simulated time spent inside as busy; time in which several are inside is booked once.

        Raises:
            RunError: ``alone``, and the component works already.
        """
        if alone and self._under_way:
            raise RunError(
                f"{self.name} was given work while it was working",
                self.name,
                "wait for the end of the first task, or map the second to another component",
            )
        self._begin_work()
        try:
            yield
        finally:
            self._end_work()

    def _begin_work(self) -> None:
        """One piece of work more is under way."""
        if not self._under_way:
            self._busy_since = self.now
        self._under_way += 1

    def _end_work(self) -> None:
        """One piece of work less is under way."""
        self._under_way -= 1
        if not self._under_way:
            self._busy += self.now - self._busy_since
