"""A shared parallel bus, such as PCI."""

from __future__ import annotations

from collections.abc import Generator
from enum import StrEnum
from typing import Any, Unpack

import simpy

from codesign.components.channel import Channel, Message
from codesign.components.component import ClockDomain
from codesign.components.delivery import LINK_DOWN
from codesign.components.link import Link, LinkOptions


class Arbitration(StrEnum):
    """When the bus is granted anew: after a whole message, or after a burst.

    - ``message``: a message that began is carried to its end. Then the most urgent message is next, then the oldest.
    - ``burst``: after every burst the most urgent message is next, and senders of equal priority take turns (round
      robin). A message that arrives during a burst, up to the picosecond of its end, takes part in the next choice.
    """

    MESSAGE = "message"
    BURST = "burst"


class Bus(Link):
    """A shared parallel bus, half duplex: a message of w words takes ceil(w / burst) × setup + w clock cycles.

    - ``width``: bits a word, one word a clock cycle. ``burst_words``: the longest run of words between two set-ups.
    - ``setup_cycles``: arbitration and address cycles before every burst.
    - ``arbitration``: the cycles of a message are the same with either. Bursts need no event each: a message that is
      alone is carried in one event, and stops at the end of a burst when another message arrives.

    Each message begins at a clock edge. The bus has no buffer, so the sender of ``post`` waits for the end of its first
    transfer.

    Raises:
        InputError: a parameter is below its least value.
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
        arbitration: Arbitration = Arbitration.MESSAGE,
        **options: Unpack[LinkOptions],
    ) -> None:
        super().__init__(environment, name, shared=True, **options)
        self._check_least(
            ("width", width, 1), ("setup_cycles", setup_cycles, 0), ("burst_words", burst_words, 1)
        )
        self.clock = clock
        self.width = width
        self.setup_cycles = setup_cycles
        self.burst_words = burst_words
        self.arbitration = Arbitration(arbitration)

    def cycles(self, bits: int) -> int:
        """Clock cycles that a message of ``bits`` bits takes, its checksum included.

        Raises:
            RunError: the message is empty.
        """
        self._check_bits(bits)
        return self._cycles(self._words(bits + self.errors.checksum_bits))

    def duration(self, bits: int) -> int:
        """Picoseconds of ``cycles(bits)`` from edge 0."""
        return self.clock.duration(self.cycles(bits))

    def _words(self, bits: int) -> int:
        return -(-bits // self.width)

    def _cycles(self, words: int) -> int:
        return -(-words // self.burst_words) * self.setup_cycles + words

    def _next_begin(self) -> int:
        return self.clock.next_edge(self.now)

    def _end(self, message: Message) -> int:
        first = self.clock.cycle_at_or_after(self.now)
        return self.clock.edge(first + self.cycles(message.bits))

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
        words = self._words(self._wire_bits(message))
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
        """Whether an outage began since the attempt did, at ``since`` (ps; None: it has not begun)."""
        return since is not None and self._outages.between(since, self.now + 1) is not None

    def _run_bursts(
        self, message: Message, line: Channel, words: int
    ) -> Generator[simpy.Event, Any, int | None]:
        """Process generator: bursts until the message ends, or another message may be next.

        Returns the words that were carried, or None where an outage cut them off.
        """
        first = self.clock.cycle_at_or_after(self.now)
        planned = min(words, self.burst_words) if line.contested(message) else words
        end, cut = self._end_and_cut(first, planned)
        yield from self._on_wire(message, cut or end, line.contender)
        if self.now < (cut or end):
            planned = min(words, self._bursts_until(first, self.now) * self.burst_words)
            end, cut = self._end_and_cut(first, planned)
            yield from self._on_wire(message, cut or end)
        return planned if cut is None else None

    def _end_and_cut(self, first: int, words: int) -> tuple[int, int | None]:
        """The end of ``words`` words from edge ``first``, and the begin of an outage before it, if any, ps."""
        end = self.clock.edge(first + self._cycles(words))
        outage = self._outages.between(self.clock.edge(first), end)
        return end, None if outage is None else outage.begin

    def _bursts_until(self, first: int, time: int) -> int:
        """How many bursts from edge ``first`` began before ``time`` (ps)."""
        passed = self.clock.cycle_at_or_after(time) - first
        return -(-passed // (self.setup_cycles + self.burst_words))
