"""The messages with the coordinates of all robots to the display, one an update."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Mapping
from typing import Any

from codesign.inputs.scenario import Fleet
from codesign.planners.interface import COMMAND
from codesign.system.build import SIDE, Machine
from codesign.system.place import DISPLAY, RENDER_KERNEL
from codesign.system.results.fleet import Frames, spread


def frame_receiver(scenario: Fleet, places: Mapping[str, str], component: str) -> str | None:
    """The task that takes frames of the planning ``component``: the display, or who asked. None: there are none."""
    receiver = DISPLAY if DISPLAY in places else COMMAND
    return None if scenario.report == "none" or places[receiver] == component else receiver


class FrameSender:
    """Sends frames of ``robots`` robots from the planning component to task ``receiver`` and accounts for each of them.

    ``line_ps``: the time of one frame on the slowest link of its route without errors, ps.
    """

    def __init__(self, machine: Machine, receiver: str, robots: int) -> None:
        system = machine.system
        self._machine = machine
        self._receiver = receiver
        self._robots = robots
        flows = system.placement.graph.between(system.planner.planning_task, receiver)
        self.bits = sum(flow.bits for flow in flows)
        self._name = flows[0].name
        # Where a display hangs on the pins of another component, no link is between them.
        self._hops = [
            (machine.messages.fastest(hop, self.bits), hop.sender, hop.receiver)
            for hop in machine.messages.routes.between(system.component, system.placement.places[receiver])
            if hop.links
        ]
        self.line_ps = max((link.duration(self.bits) for link, _, _ in self._hops), default=0)
        self._writer: Any = None
        self._frames = self._skipped = 0
        self._dropped: Counter[str] = Counter()
        self._ages: list[int] = []

    def offer(self) -> None:
        """Send a frame in the background, or skip it where the one before is not in the line's FIFO yet."""
        if self._writer is not None and self._writer.is_alive:
            self._frames += 1
            self._skipped += 1
        else:
            self._writer = self._machine.environment.process(self.hand_over())

    def hand_over(self) -> Generator[Any, Any, None]:
        """Process generator: send a frame, and wait until the line has taken it over."""
        self._frames += 1
        begin = self._machine.now
        if not self._hops:
            self._machine.environment.process(self._arrive(None, begin))
            return
        link, sender, receiver = self._hops[0]
        carrier = yield from link.post(sender, receiver, self._name, self.bits)
        self._machine.environment.process(self._arrive(carrier, begin))

    def _arrive(self, carrier: Any, begin: int) -> Generator[Any, Any, None]:
        """Process generator: over the further links to the receiver, which draws it."""
        if carrier is not None:
            delivery = yield carrier
            for link, sender, receiver in self._hops[1:]:
                if delivery.reason is None:
                    delivery = yield from link.send(sender, receiver, self._name, self.bits)
            if delivery.reason is not None:
                self._dropped[delivery.reason] += 1
                return
        yield from self._machine.charge(self._receiver, RENDER_KERNEL, self._robots, priority=SIDE)
        self._ages.append(self._machine.now - begin)
        self._machine.follow_up(self._receiver)

    def figures(self, step_ps: int) -> Frames:
        """The account so far; a frame is late where it is older than a time step of ``step_ps`` ps when shown."""
        dropped = dict(sorted(self._dropped.items()))
        shown = len(self._ages)
        return Frames(
            receiver=self._machine.system.placement.places[self._receiver],
            bits=self.bits,
            made=self._frames,
            skipped=self._skipped,
            dropped=dropped,
            shown=shown,
            late=sum(age > step_ps for age in self._ages),
            under_way=self._frames - self._skipped - sum(dropped.values()) - shown,
            age=spread(self._ages),
        )
