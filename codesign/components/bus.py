"""A shared parallel bus, such as PCI."""

from __future__ import annotations

from collections.abc import Generator
from enum import StrEnum
from typing import Any, Unpack

import simpy

from codesign.components.channel import Channel, Message
from codesign.components.component import ClockDomain
from codesign.components.link import LINK_DOWN, Link, LinkOptions
from codesign.laws import ceil_div
from codesign.laws.acts import BusLaw


class Arbitration(StrEnum):
    """The unit after which the bus is granted anew: a whole message, or a burst.

    - ``message``: a message that began is carried to its end. Then the most urgent message is next, then the oldest.
    - ``burst``: after every burst the most urgent message is next, and senders of equal priority take turns (round
      robin). A message that arrives during a burst, up to the picosecond of its end, takes part in the next choice.
    """

    MESSAGE = "message"
    BURST = "burst"


class Bus(Link):
    """A shared parallel bus, half duplex; see ``BusLaw``.

    ``arbitration``: the cycles of a message are the same with either. Bursts need no event each: a message that is
    alone is carried in one event, and stops at the end of a burst when another message arrives.

    Each message begins at a clock edge. The bus has no buffer, so the sender of ``post`` waits for the end of its first
    transfer.
    """

    options = ("arbitration",)
    law: BusLaw
    clock: ClockDomain

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        law: BusLaw,
        *,
        arbitration: Arbitration = Arbitration.MESSAGE,
        **options: Unpack[LinkOptions],
    ) -> None:
        super().__init__(environment, name, law, **options)
        self.arbitration = Arbitration(arbitration)

    def _one_line(self) -> bool:
        return True

    def _cross(self, message: Message, line: Channel) -> Generator[simpy.Event, Any, str | None]:
        if self.arbitration is Arbitration.MESSAGE:
            return (yield from super()._cross(message, line))
        return (yield from self._cross_in_bursts(message, line))

    def _cross_in_bursts(self, message: Message, line: Channel) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: one attempt, granted burst by burst where other messages wait.

        A message of w words, with b words a burst and s cycles of set-up:

            | s | b words | s | b words | ... | s | rest |
            ^ granted     ^ granted anew, where the line is contested
        """
        words: int = self.law.words(self._wire_bits(message))
        since: int | None = None
        while words:
            yield from line.wait_turn(message)
            if self._cut(since):
                return LINK_DOWN
            granted = self.now
            if not (yield from self._wait_up()):
                return LINK_DOWN
            if self.now > granted:
                # The arbiter chooses at the edge at which a burst begins, and not earlier.
                line.contend_again(message)
                if line.holder is not message:
                    continue
                if self._cut(since):
                    return LINK_DOWN
            if since is None:
                since = self.now
                self._begin(message)
            carried = yield from self._run_bursts(message, line, words)
            if carried is None:
                return LINK_DOWN
            words -= carried
            if carried:
                line.count_service(message)
            if words:
                line.contend_again(message)
        return None

    def _cut(self, since: int | None) -> bool:
        """True if an outage began since the attempt did, at ``since`` (ps; None: it has not begun)."""
        return since is not None and self._outages.between(since, self.now + 1) is not None

    def _run_bursts(self, message: Message, line: Channel, words: int) -> Generator[simpy.Event, Any, int | None]:
        """Process generator: bursts until the message ends, or another message may be next.

        Returns the words that were carried, or None where an outage cut them off.
        """
        first = self.clock.cycle_at_or_after(self.now)
        planned = min(words, self.law.burst_words) if line.contested(message) else words
        end, cut = self._end_and_cut(first, planned)
        yield from self._on_wire(message, cut or end, line.contender)
        if self.now < (cut or end):
            planned = min(words, self._bursts_until(first, self.now) * self.law.burst_words)
            end, cut = self._end_and_cut(first, planned)
            yield from self._on_wire(message, cut or end)
        return planned if cut is None else None

    def _end_and_cut(self, first: int, words: int) -> tuple[int, int | None]:
        """The end of ``words`` words from edge ``first``, and the begin of an outage before it, if any, ps."""
        end = self.clock.edge(first + self.law.cycles(words))
        outage = self._outages.between(self.clock.edge(first), end)
        return end, None if outage is None else outage.begin

    def _bursts_until(self, first: int, time: int) -> int:
        """The number of bursts from edge ``first`` that began before ``time`` (ps)."""
        passed = self.clock.cycle_at_or_after(time) - first
        return int(ceil_div(passed, self.law.cycles(self.law.burst_words)))
