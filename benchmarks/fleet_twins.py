"""The events of a fleet alone, in plain SimPy and in desmod: a barrier an update, a line with a FIFO, a display.

No domain logic: how many cycles each robot takes is given, nothing is counted, checked or told. Both end when
``codesign``'s own fleet with the same numbers does, which the benchmark sees to.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

import simpy
from desmod.component import Component
from desmod.queue import Queue
from desmod.simulation import SimEnvironment

Events = Generator[simpy.Event, Any, None]


@dataclass(frozen=True)
class Pattern:
    """``cycles[update][robot]``; times in ps: of a clock cycle, of of ``baud`` bits a second.

    ``load``: when the first update begins. ``characters``, ``fifo``: of a message, and of what the sender may leave
    behind. ``render``: of a frame on the display, ps.
    """

    cycles: list[list[int]]
    cycle: int
    baud: int
    characters: int
    fifo: int
    load: int
    render: int

    def span(self, characters: int) -> int:
        """So many characters of ten bits each, ps."""
        return -(-characters * 10 * 10**12 // self.baud)


def count_events(environment: simpy.Environment) -> int:
    """Run until nothing more happens; how many events that was."""
    events = 0
    while environment.peek() != float("inf"):
        environment.step()
        events += 1
    return events


class PlainFleet:
    """Processes of functions, and stores between them."""

    def __init__(self, pattern: Pattern) -> None:
        self.environment = simpy.Environment()
        self.pattern = pattern
        self.start, self.barrier = self.environment.event(), self.environment.event()
        self.deciding = 0
        self.line, self.display = simpy.Store(self.environment), simpy.Store(self.environment)
        for robot in range(len(pattern.cycles[0])):
            self.environment.process(self.robot(robot))
        for process in (self.updates(), self.carry(), self.show()):
            self.environment.process(process)

    def updates(self) -> Events:
        yield self.environment.timeout(self.pattern.load)
        for update in range(len(self.pattern.cycles)):
            start, self.start = self.start, self.environment.event()
            self.barrier, self.deciding = self.environment.event(), len(self.pattern.cycles[0])
            start.succeed(update)
            yield self.barrier
            taken = self.environment.event()
            yield self.line.put(taken)
            yield taken

    def robot(self, robot: int) -> Events:
        cycle = self.pattern.cycle
        while True:
            update = yield self.start
            wait = -self.environment.now % cycle
            if wait:
                yield self.environment.timeout(wait)
            yield self.environment.timeout(self.pattern.cycles[update][robot] * cycle)
            self.deciding -= 1
            if not self.deciding:
                self.barrier.succeed()

    def carry(self) -> Events:
        pattern = self.pattern
        held, whole = pattern.span(pattern.characters - pattern.fifo - 1), pattern.span(pattern.characters)
        while True:
            taken = yield self.line.get()
            yield self.environment.timeout(held)
            taken.succeed()
            yield self.environment.timeout(whole - held)
            yield self.display.put(None)

    def show(self) -> Events:
        while True:
            yield self.display.get()
            yield self.environment.timeout(self.pattern.render)


class Robot(Component):
    base_name = "robot"
    needs = ("starts", "decided", "pattern")

    def __init__(self, parent: Component, index: int) -> None:
        super().__init__(parent, index=index)
        self.add_connections(*self.needs)
        self.add_process(self.decide)

    def decide(self) -> Events:
        cycle = self.pattern.cycle
        while True:
            update = yield self.starts[self.index].get()
            wait = -self.env.now % cycle
            if wait:
                yield self.env.timeout(wait)
            yield self.env.timeout(self.pattern.cycles[update][self.index] * cycle)
            yield self.decided.put(None)


class Board(Component):
    """The loop of updates."""

    base_name = "board"
    needs = ("starts", "decided", "line", "pattern")

    def __init__(self, parent: Component) -> None:
        super().__init__(parent)
        self.add_connections(*self.needs)
        self.add_process(self.updates)

    def updates(self) -> Events:
        yield self.env.timeout(self.pattern.load)
        for update in range(len(self.pattern.cycles)):
            for start in self.starts:
                yield start.put(update)
            for _ in self.starts:
                yield self.decided.get()
            taken = self.env.event()
            yield self.line.put(taken)
            yield taken


class SerialLine(Component):
    base_name = "line"
    needs = ("line", "display", "pattern")

    def __init__(self, parent: Component) -> None:
        super().__init__(parent)
        self.add_connections(*self.needs)
        self.add_process(self.carry)

    def carry(self) -> Events:
        pattern = self.pattern
        held, whole = pattern.span(pattern.characters - pattern.fifo - 1), pattern.span(pattern.characters)
        while True:
            taken = yield self.line.get()
            yield self.env.timeout(held)
            taken.succeed()
            yield self.env.timeout(whole - held)
            yield self.display.put(None)


class Screen(Component):
    base_name = "screen"
    needs = ("display", "pattern")

    def __init__(self, parent: Component) -> None:
        super().__init__(parent)
        self.add_connections(*self.needs)
        self.add_process(self.show)

    def show(self) -> Events:
        while True:
            yield self.display.get()
            yield self.env.timeout(self.pattern.render)


class DesmodFleet(Component):
    """Components with connections, and desmod's queues between them."""

    base_name = ""

    def __init__(self, pattern: Pattern) -> None:
        self.environment = SimEnvironment({})
        super().__init__(parent=None, env=self.environment)
        self.pattern = pattern
        robots = len(pattern.cycles[0])
        self.starts = [Queue(self.environment) for _ in range(robots)]
        self.decided, self.line, self.display = (Queue(self.environment) for _ in range(3))
        self.parts = [Board(self), SerialLine(self), Screen(self), *(Robot(self, index) for index in range(robots))]
        self.elaborate()

    def connect_children(self) -> None:
        for part in self.parts:
            for name in part.needs:
                self.connect(part, name)
