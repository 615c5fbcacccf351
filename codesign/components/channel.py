"""A line carries one message at a time, and chooses the next one.

SimPy handles the events of one picosecond in the order in which they were scheduled. That order follows from how the
code is written and not from urgency. So an idle line is not given to the first request. The most urgent priority, 0,
gets it at once. The others wait for the end of the picosecond, the more urgent before the less urgent: what a control
message causes within the picosecond comes before any plan, and what a plan causes comes before any side task.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from typing import Any

import simpy
from simpy.events import EventPriority

from codesign.ground.errors import RunError

# The choice of the next user of a shared resource, where several request it in the same picosecond.

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


_KEY = attrgetter("key")


@dataclass(slots=True, eq=False)
class Message:
    """A message in flight on a link; times in ps.

    - ``number``: its index among all messages of the link. ``luck``: see ``link_faults.Luck``.
    - ``requested``: when it was given to the link. ``ready_since``: since when it can be on the wire.
    - ``ready``: False while it waits for its timeout. ``turn``: the event that it waits for in the queue.
    - ``attempts``: how often it was on the wire. ``begin``: the first time. ``transferred``: the total time.
    - ``first_over``: whether its first attempt is over. ``free``: the event that its poster waits for until then.
    - ``released``: whether its sender has gone on. ``left``: whether the message has left its line.
    """

    number: int
    sender: str
    receiver: str
    name: str
    bits: int
    priority: int
    requested: int
    luck: list[list[float]]
    ready_since: int
    ready: bool = True
    turn: simpy.Event | None = None
    attempts: int = 0
    begin: int | None = None
    transferred: int = 0
    first_over: bool = False
    free: simpy.Event | None = None
    released: bool = False
    left: bool = False
    key: tuple[int, int] = field(init=False)

    def __post_init__(self) -> None:
        self.key = (self.priority, self.number)

    def end_first_attempt(self) -> None:
        """Release a poster that waits for the end of the first attempt."""
        self.first_over = True
        if self.free is not None and not self.free.triggered:
            self.free.succeed()


class Channel:
    """Carries one message at a time, its ``holder``.

    The messages of one sender are carried one after another, urgent ones first (a lower ``priority``), then in the
    order of their requests. While a message waits for its timeout, the later ones of its sender wait too, but no other
    sender does (stop and wait). Among senders the most urgent message is next, then the sender that
    was served longest ago (see ``count_service``), then the oldest. The order of requests within a picosecond puts no
    less urgent message first: see ``arbiter``.
    """

    def __init__(self, environment: simpy.Environment) -> None:
        self.environment = environment
        self.holder: Message | None = None
        self._queues: dict[str, list[Message]] = {}
        self._served: dict[str, int] = {}
        self._services = 0
        self._changed: dict[str, simpy.Event] = {}
        self._contender: simpy.Event | None = None
        self._arbiter = Arbiter(environment, self._most_urgent, self._serve)

    def enter(self, message: Message) -> None:
        """Queue a new message."""
        insort(self._queues.setdefault(message.sender, []), message, key=lambda queued: queued.key)
        self._settle()

    def wait_turn(self, message: Message) -> Generator[simpy.Event, Any, None]:
        """Process generator: wait until ``message`` holds the line."""
        if self.holder is not message:
            message.turn = self.environment.event()
            yield message.turn

    def rest(self, message: Message) -> None:
        """Take the holder off the line until its timeout. It keeps its place among its sender's messages."""
        message.ready = False
        self.holder = None
        self.signal_change(message.sender)
        self._settle()

    def resume(self, message: Message) -> None:
        """Let a message that rested be on the wire again."""
        message.ready = True
        message.ready_since = int(self.environment.now)
        self._settle()

    def leave(self, message: Message) -> None:
        """Remove a message in any state, and serve the next one. Does nothing where it has left already."""
        if message.left:
            return
        message.left = True
        self._queues[message.sender].remove(message)
        if self.holder is message:
            self.holder = None
        self.signal_change(message.sender)
        self._settle()

    def count_service(self, message: Message) -> None:
        """Count a service of the sender of ``message``: among equals the other senders are next."""
        self._services += 1
        self._served[message.sender] = self._services

    def contend_again(self, message: Message) -> None:
        """Let the holder contend again with the messages that wait."""
        assert self.holder is message, "only the holder can contend again"
        self.holder = None
        self._settle()

    def contested(self, message: Message) -> bool:
        """True if a message waits that may be next before the holder ``message`` is done."""
        return any(
            queue[0] is not message and queue[0].ready and queue[0].priority <= message.priority
            for queue in self._queues.values()
            if queue
        )

    def contender(self) -> simpy.Event:
        """An event that happens when the line becomes contested for its holder."""
        self._contender = self.environment.event()
        return self._contender

    def changed(self, sender: str) -> simpy.Event:
        """An event that happens when a message of ``sender`` begins, rests or leaves."""
        if sender not in self._changed:
            self._changed[sender] = self.environment.event()
        return self._changed[sender]

    def signal_change(self, sender: str) -> None:
        """Trigger the event of ``changed(sender)``."""
        event = self._changed.pop(sender, None)
        if event is not None:
            event.succeed()

    def queue(self, sender: str) -> list[Message]:
        """The messages of ``sender`` that have not left, in order."""
        return self._queues.get(sender, [])

    def _settle(self) -> None:
        """Give an idle line to the next message, or signal the holder that another one waits."""
        if self.holder is None:
            self._contender = None
            self._arbiter.choose()
        elif self._contender is not None and self.contested(self.holder):
            self._contender.succeed()
            self._contender = None

    def _heads(self) -> list[Message]:
        return [queue[0] for queue in self._queues.values() if queue and queue[0].ready]

    def _most_urgent(self) -> int | None:
        return None if self.holder is not None else min((head.priority for head in self._heads()), default=None)

    def _serve(self) -> None:
        self.holder = min(self._heads(), key=self._rank if self._served else _KEY)
        if self.holder.turn is not None:
            self.holder.turn.succeed()
            self.holder.turn = None

    def _rank(self, message: Message) -> tuple[int, int, int]:
        return message.priority, self._served.get(message.sender, 0), message.number
