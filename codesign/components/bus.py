"""A shared parallel bus, such as PCI."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from enum import StrEnum
from typing import Any

import simpy

from codesign.components.clock import ClockDomain
from codesign.components.line import Line, Message
from codesign.components.link import LINK_DOWN, Link
from codesign.components.link_faults import LinkErrors
from codesign.errors import InputError, RunError
from codesign.records import Listener


class Arbitration(StrEnum):
    """When a bus may change hands: between whole messages, or between bursts.

    - ``message``: a message that began is carried to its end; then the most urgent is next, then the oldest.
    - ``burst``: after every burst the most urgent is next, and equals take turns, sender by sender (round
      robin). One that arrives while a burst is on the bus, or at the very picosecond of its end, has part in
      the next choice.
    """

    MESSAGE = "message"
    BURST = "burst"


class Bus(Link):
    """A shared parallel bus, half duplex: a message of w words takes ceil(w / burst) × setup + w clock cycles.

    - ``width``: bits a word, one word a clock cycle. ``burst_words``: the longest run of words between two
      set-ups.
    - ``setup_cycles``: arbitration and address cycles before every burst.
    - ``arbitration``: the cycles of a message are the same with either. Bursts cost no event of their own: a
      message that is alone runs through, and stops at the end of a burst when another one comes.

    Each message begins at a clock edge. The sender of ``post`` waits until its first transfer is over: the bus
    has no buffer.

    Raises:
        InputError: a number below what has a meaning.
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
        between: Sequence[str] = (),
        errors: LinkErrors | None = None,
        outages: Sequence[tuple[int, int | None]] = (),
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(
            environment,
            name,
            shared=True,
            between=between,
            errors=errors,
            outages=outages,
            listeners=listeners,
        )
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
        self.arbitration = Arbitration(arbitration)

    def cycles(self, bits: int) -> int:
        """Clock cycles that a message of ``bits`` bits takes, its checksum included.

        Raises:
            RunError: the message is empty.
        """
        if bits < 1:
            raise RunError(
                f"a message of {bits} bits", self.name, "send at least one bit, or no message at all"
            )
        return self._cycles(self._words(bits + self.errors.checksum_bits))

    def duration(self, bits: int) -> int:
        """Picoseconds of ``cycles(bits)`` from edge 0 on."""
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

    def _cross(self, message: Message, line: Line) -> Generator[simpy.Event, Any, str | None]:
        if self.arbitration is Arbitration.MESSAGE:
            return (yield from super()._cross(message, line))
        return (yield from self._cross_in_bursts(message, line))

    def _cross_in_bursts(self, message: Message, line: Line) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: one attempt, giving way between bursts where others wait."""
        words = self._words(self._wire_bits(message))
        since: int | None = None
        while True:
            yield from line.wait_turn(message)
            if since is not None and self._outages.between(since, self.now + 1):
                return LINK_DOWN
            if not (yield from self._wait_up()):
                return LINK_DOWN
            if since is None:
                since = self.now
                self._begin(message)
            elif self._outages.between(since, self.now + 1):
                return LINK_DOWN
            done, cut = yield from self._run_bursts(message, line, words)
            if cut:
                return LINK_DOWN
            words -= done
            if done:
                line.serve(message)
            if not words:
                return None
            line.give_way(message)

    def _run_bursts(
        self, message: Message, line: Line, words: int
    ) -> Generator[simpy.Event, Any, tuple[int, bool]]:
        """Process generator: bursts until the message ends or another one may be next.

        Returns the words that were carried, and whether an outage cut them off.
        """
        first = self.clock.cycle_at_or_after(self.now)
        begin = self.now
        contested = line.contested(message)
        planned = min(words, self.burst_words) if contested else words
        end = self.clock.edge(first + self._cycles(planned))
        cut = self._outages.between(begin, end)
        end = end if cut is None else cut.begin
        yield from self._on_wire(message, end, None if contested else line.contender)
        if self.now < end:
            planned = min(words, self._bursts_until(first, self.now) * self.burst_words)
            end = self.clock.edge(first + self._cycles(planned))
            cut = self._outages.between(begin, end)
            yield from self._on_wire(message, end if cut is None else cut.begin)
        return planned, cut is not None

    def _bursts_until(self, first: int, time: int) -> int:
        """How many bursts from edge ``first`` on have begun before ``time`` (ps)."""
        passed = self.clock.cycle_at_or_after(time) - first
        return -(-passed // (self.setup_cycles + self.burst_words))
