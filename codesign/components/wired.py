"""The links with a wire of their own: a shared parallel bus, such as PCI, and a serial line, such as RS-232 or RS-485.

The serial line sends frames of bits at a baud rate, with a FIFO at every sender. A frame, from left to right on the
wire:

    | start bits | data bits, LSB first | parity bit, if any | stop bits |
"""

from __future__ import annotations

from collections.abc import Generator
from enum import StrEnum
from fractions import Fraction
from typing import Any, Unpack

import simpy

from codesign.components.channel import Channel, Message
from codesign.components.component import ClockDomain
from codesign.components.link import LINK_DOWN, Link, LinkOptions, damage_probability, parity_miss, wrong_behind_parity
from codesign.ground.errors import InputError
from codesign.ground.units import edge
from codesign.laws import ceil_div
from codesign.laws.acts import BusLaw, SerialLaw

# A shared parallel bus, such as PCI.


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


STOP_BITS = (Fraction(1), Fraction(3, 2), Fraction(2))
"""The accepted numbers of stop bits of a frame."""


class Parity(StrEnum):
    """The parity bit of every frame. Even and odd parity give the same figures."""

    NONE = "none"
    EVEN = "even"
    ODD = "odd"


class _SerialChannel(Channel):
    """A line that knows where the bits of its current run of frames lie.

    ``epoch``: begin of the run, ps. ``offset``: half bits of the run before the current message. ``after``: half bits
    of the run, the current message included. ``end``: the end of the last message, ps.

        epoch                 offset             after
          | earlier messages    | current message  |
    """

    def __init__(self, environment: simpy.Environment) -> None:
        super().__init__(environment)
        self.epoch = self.offset = self.after = 0
        self.end = -1


class Serial(Link):
    """A serial line; see ``SerialLaw``.

    - ``fifo_depth``: words of ``data_bits`` bits that wait at every sender, without the one on the wire. (The shift
      register of a 16550 is not part of its FIFO either.)

    Frames that follow each other without a gap end at exact multiples of half a bit after the begin of the first. Each
    end is rounded up to picoseconds by itself, so nothing drifts. After a gap frames begin at any picosecond.

    The sender of ``post`` is held until the rest of its message, and of its earlier ones, fits the FIFO. A message that
    is sent again comes from a copy outside the FIFO (assumed). The receiver reads its own FIFO in time (assumed).

    Parity detects an odd number of wrong bits in a frame. The checksum then checks what parity missed. Start and stop
    bits arrive right (assumed).

    Raises:
        InputError: a parameter is below its least value, or no serial line has such a frame.
    """

    options = ("fifo_depth",)
    law: SerialLaw

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        law: SerialLaw,
        *,
        fifo_depth: int = 16,
        **options: Unpack[LinkOptions],
    ) -> None:
        super().__init__(environment, name, law, **options)
        self._check_least(("fifo_depth", fifo_depth, 1))
        if law.stop_bits not in STOP_BITS:
            raise InputError(f"stop_bits of {law.stop_bits}", f"{name}.stop_bits", "give 1, 1.5 or 2")
        self.parity = Parity(law.parity)
        self.fifo_depth = fifo_depth
        self._word_bits = law.data_bits + (self.parity is not Parity.NONE)

    def frames(self, bits: int) -> int:
        """Frames that a message of ``bits`` bits takes, its checksum included."""
        return self.law.frames(bits + self.errors.checksum_bits)

    def _new_line(self) -> Channel:
        return _SerialChannel(self.environment)

    def _end(self, message: Message) -> int:
        line = self._line(message.sender)
        assert isinstance(line, _SerialChannel), "_new_line makes them"
        if self.now == line.end and message.ready_since < self.now:
            line.offset = line.after
        else:
            line.epoch, line.offset = self.now, 0
        line.after = line.offset + self.ticks(message.bits)
        line.end = line.epoch + edge(line.after, self._rate)
        return line.end

    def _damaged(self, message: Message) -> float:
        if self.parity is Parity.NONE:
            return super()._damaged(message)
        exposed = self.frames(message.bits) * self._word_bits
        return damage_probability(exposed, self.errors.bit_error_rate)

    def _missed(self, message: Message) -> float:
        if self.parity is Parity.NONE:
            return super()._missed(message)
        frames = self.frames(message.bits)
        return super()._missed(message) * parity_miss(frames, self._word_bits, self.errors.bit_error_rate)

    def _wrong_bits(self, message: Message) -> tuple[int, ...]:
        if self.parity is Parity.NONE:
            return super()._wrong_bits(message)
        assert self._luck is not None, "only a link with errors damages messages"
        random = self._luck.of(message.number, message.attempts)
        frames = self.frames(message.bits)
        wrong = wrong_behind_parity(random, frames, self._word_bits, self.errors.bit_error_rate)
        # The last bit of a frame is its parity. After the message come its checksum and the padding of the last frame.
        own = (frame * self.law.data_bits + place for frame, place in wrong if place < self.law.data_bits)
        return tuple(bit for bit in own if bit < message.bits)

    def _hold(self, message: Message) -> Generator[simpy.Event, Any, None]:
        line = self._line(message.sender)
        assert isinstance(line, _SerialChannel), "_new_line makes them"
        while True:
            fits = self._fits_at(message, line)
            if fits is not None and fits <= self.now:
                return
            changed = line.changed(message.sender)
            yield changed if fits is None else self.environment.timeout(fits - self.now) | changed

    def _fifo_words(self, sender: str) -> int:
        """The words that wait at a sender, as many as fit. The first word of a message on the wire has left."""
        waiting = 0
        for message in self._line(sender).queue(sender):
            if not message.first_over:
                waiting += self.frames(message.bits) - bool(message.attempts)
        return min(waiting, self.fifo_depth)

    def _fits_at(self, message: Message, line: _SerialChannel) -> int | None:
        """The time at which the rest of ``message`` will fit the FIFO, ps, if nothing else happens. None: not known."""
        if message.first_over:
            return self.now
        room = self.fifo_depth
        sending: Message | None = None
        for other in line.queue(message.sender):
            ahead = other.released or other.key <= message.key
            if not ahead or other.first_over:
                continue
            if other.attempts:
                sending = other
            else:
                room -= self.frames(other.bits)
        if room < 0:
            return None
        if sending is None:
            return self.now
        # The rest fits once so many frames of the message on the wire have begun, the last with index begun - 1.
        begun = self.frames(sending.bits) - room
        half_bits = line.offset + max(begun - 1, 0) * self.law.frame_ticks
        return line.epoch + edge(half_bits, self._rate) if begun > 0 else self.now
