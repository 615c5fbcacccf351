"""Links: what messages cross, one at a time, in the order in which they were asked for."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any

import simpy

from codesign.components.clock import ClockDomain
from codesign.components.component import Component
from codesign.errors import InputError, RunError
from codesign.records import Listener, MessageRecord


class Bus(Component):
    """A shared parallel bus, such as PCI: a message of w words takes ceil(w / burst) × setup + w clock
    cycles.

    - ``width``: bits a word, one word a clock cycle. ``burst_words``: the longest run of words between two
      set-ups.
    - ``setup_cycles``: arbitration and address cycles before every burst.

    Messages queue, first come first served; each begins at a clock edge. ``queued`` adds up the time that
    messages waited for others and for the edge, ps; ``messages`` and ``bits`` count what was delivered.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        *,
        width: int,
        setup_cycles: int,
        burst_words: int,
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        for key, value, least in (
            ("width", width, 1),
            ("setup_cycles", setup_cycles, 0),
            ("burst_words", burst_words, 1),
        ):
            if value < least:
                raise InputError(f"{key} of {value}", f"{name}.{key}", f"give at least {least}")
        self.clock = clock
        self.width = width
        self.setup_cycles = setup_cycles
        self.burst_words = burst_words
        self.queued = 0
        self.messages = 0
        self.bits = 0
        self._turn = simpy.Resource(environment, capacity=1)

    def cycles(self, bits: int) -> int:
        """Clock cycles that a message of ``bits`` bits takes.

        Raises:
            RunError: the message is empty.
        """
        if bits < 1:
            raise RunError(
                f"a message of {bits} bits", self.name, "send at least one bit, or no message at all"
            )
        words = -(-bits // self.width)
        return -(-words // self.burst_words) * self.setup_cycles + words

    def send(self, sender: str, receiver: str, name: str, bits: int) -> Generator[simpy.Event, Any, int]:
        """Process generator: carry a message; returns the time of its delivery, ps.

        Its ``MessageRecord`` is emitted at delivery. A message that is interrupted frees the bus and leaves
        no record.

        Raises:
            RunError: the message is empty.
        """
        cycles = self.cycles(bits)
        asked = self.now
        with self._turn.request() as turn:
            yield turn
            first = self.clock.cycle_at_or_after(self.now)
            begin = self.clock.edge(first)
            if begin > self.now:
                yield self.environment.timeout(begin - self.now)
            with self._working():
                yield self.environment.timeout(self.clock.edge(first + cycles) - begin)
            self.queued += begin - asked
            self.messages += 1
            self.bits += bits
            if self.listening:
                self.emit(
                    MessageRecord(
                        time=asked,
                        source=self.name,
                        sender=sender,
                        receiver=receiver,
                        name=name,
                        bits=bits,
                        begin=begin,
                        end=self.now,
                    )
                )
        return self.now
