"""Links: what messages cross, and what becomes of each: delivered, dropped with a reason, or still in flight."""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import simpy

from codesign.components.component import Component
from codesign.components.line import Line, Message
from codesign.components.link_faults import LinkErrors, Luck, Outages, damage_probability, wrong_bits
from codesign.components.moment import checked_priority
from codesign.errors import RunError, choose_hint
from codesign.records import Listener, MessageRecord

ABANDONED = "abandoned"
"""Why a message was dropped whose sender was interrupted."""

LINK_DOWN = "link down"
"""Why a message was dropped that an outage kept from its receiver."""


class Outcome(StrEnum):
    """What became of a message."""

    DELIVERED = "delivered"
    DROPPED = "dropped"


@dataclass(frozen=True)
class Delivery:
    """What became of a message, and where its time went (ps).

    - ``time``: when it was delivered or given up. ``reason``: why it was dropped, None where it was delivered.
    - ``attempts``: how often it was on the wire.
    - ``transferred``: the time on the wire, all attempts together. ``queued``: all other time since it was asked
      for: for the line, an edge, a timeout, the end of an outage, or a late arrival.
    - ``damaged``: it was delivered with wrong bits that nobody noticed. ``wrong``: those of them that are the
      message's own, from 0, in order; bits of its checksum and its frames are not among them.
    """

    time: int
    outcome: Outcome
    reason: str | None
    attempts: int
    queued: int
    transferred: int
    damaged: bool = False
    wrong: tuple[int, ...] = ()


class Link(Component):
    """What all links share: order, errors, outages and the account of messages.

    ``between``: the names of its ends; messages of others are refused, where it is given. ``shared``: all senders
    share one line (half duplex), or else each has its own (full duplex).

    A sender's messages arrive in the order in which they were asked for, the urgent ones first (a lower
    ``priority``, of which 0 is the most urgent; nothing on the wire is broken off). Of messages that are asked for
    in the same picosecond the most urgent goes first, whoever asks first. A message that was lost or found damaged
    is sent again after the timeout (stop and wait: later ones of its sender wait, others do not). Late messages may
    be overtaken.

    Outages. A message that would begin in an outage waits for its end, and is dropped at once where there is
    none. One that is on the wire when an outage begins is cut off there and counts as damaged, checksum or not.

    The account, of which ``sent == delivered + sum(dropped.values()) + in_flight`` holds at every moment:

    - ``sent``, ``delivered``, ``in_flight``: messages. ``dropped``: those given up, by reason.
    - ``bits``: delivered, without framing and checksum.
    - ``retransmissions``: attempts beyond the first of each message. ``late``: messages that came late.
    - ``undetected``: messages delivered with wrong bits; ``unnoticed``: the same by the messages' names.
    - ``queued``, ``transferred``: the sums over all messages that are delivered or dropped, ps.

    ``busy`` is the time in which at least one line had a message on it.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        *,
        shared: bool = False,
        between: Sequence[str] = (),
        errors: LinkErrors | None = None,
        outages: Sequence[tuple[int, int | None]] = (),
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        self.between = tuple(between)
        self.errors = errors or LinkErrors()
        self.sent = self.delivered = self.bits = self.retransmissions = self.undetected = self.late = 0
        self.queued = self.transferred = 0
        self.dropped: Counter[str] = Counter()
        self.unnoticed: Counter[str] = Counter()
        self._shared = shared
        self._outages = Outages(outages)
        self._luck = Luck(self.errors, name) if self.errors.any else None
        self._lines: dict[str, Line] = {}
        self._open: set[int] = set()

    @property
    def in_flight(self) -> int:
        """Messages that are neither delivered nor dropped yet."""
        return len(self._open)

    @abstractmethod
    def duration(self, bits: int) -> int:
        """Picoseconds on the wire of one attempt of a message of ``bits`` bits on an idle, sound link."""

    def send(
        self, sender: str, receiver: str, name: str, bits: int, priority: int = 0
    ) -> Generator[simpy.Event, Any, Delivery]:
        """Process generator: carry a message and wait for what becomes of it.

        Its ``MessageRecord`` is emitted then. An interruption frees the link, drops the message as
        "abandoned", and goes on to the caller.

        Raises:
            RunError: the message is empty, its sender or receiver is no end of the link, or its priority is below 0.
        """
        return (yield from self._carry(self._accept(sender, receiver, name, bits, priority)))

    def post(
        self, sender: str, receiver: str, name: str, bits: int, priority: int = 0
    ) -> Generator[simpy.Event, Any, simpy.Process]:
        """Process generator: carry a message, and wait only until the link has taken it over.

        Returns a process whose value will be the ``Delivery``. An interruption while the sender waits drops the
        message as "abandoned"; afterwards, interrupting the process that was returned does.

        Raises:
            RunError: see ``send``.
        """
        message = self._accept(sender, receiver, name, bits, priority)
        carrier = self.environment.process(self._carry_alone(message))
        try:
            yield from self._hold(message)
        except simpy.Interrupt:
            if carrier.is_alive:
                carrier.interrupt(ABANDONED)
            raise
        message.released = True
        return carrier

    def _new_line(self) -> Line:
        return Line(self.environment)

    def _line(self, sender: str) -> Line:
        key = "" if self._shared else sender
        if key not in self._lines:
            self._lines[key] = self._new_line()
        return self._lines[key]

    def _next_begin(self) -> int:
        """When a transfer can begin, ps: at a clock edge, where the link has a clock."""
        return self.now

    def _wire_bits(self, message: Message) -> int:
        return message.bits + self.errors.checksum_bits

    def _end(self, message: Message) -> int:
        """When a transfer that begins now ends, ps; called once for each attempt."""
        return self.now + self.duration(message.bits)

    def _damaged(self, message: Message) -> float:
        """The probability that an attempt arrives with wrong bits."""
        return damage_probability(self._wire_bits(message), self.errors.bit_error_rate)

    def _missed(self, message: Message) -> float:  # noqa: ARG002  (a link with parity looks at it)
        """The probability that nobody notices, given that an attempt is damaged."""
        return 2.0**-self.errors.checksum_bits

    def _wrong_bits(self, message: Message) -> tuple[int, ...]:
        """Bits of the message that are wrong, where its last attempt is damaged and nobody notices."""
        assert self._luck is not None, "damage is a matter of luck"
        random = self._luck.of(message.number, message.attempts)
        return wrong_bits(random, message.bits, self.errors.bit_error_rate)

    def _hold(self, message: Message) -> Generator[simpy.Event, Any, None]:
        """Process generator: wait until the sender need not care any more: the end of the first attempt."""
        if not message.first_over:
            message.free = self.environment.event()
            yield message.free

    def _accept(self, sender: str, receiver: str, name: str, bits: int, priority: int) -> Message:
        if bits < 1:
            raise RunError(
                f"a message of {bits} bits", self.name, "send at least one bit, or no message at all"
            )
        for end in (sender, receiver):
            if self.between and end not in self.between:
                raise RunError(f"{end!r} is no end of this link", self.name, choose_hint(end, self.between))
        checked_priority(priority, self.name)
        luck = [] if self._luck is None else self._luck.draw()
        message = Message(self.sent, sender, receiver, name, bits, priority, self.now, luck, self.now)
        self.sent += 1
        self._open.add(message.number)
        self._line(sender).enter(message)
        return message

    def _carry_alone(self, message: Message) -> Generator[simpy.Event, Any, Delivery]:
        try:
            return (yield from self._carry(message))
        except simpy.Interrupt:
            return self._delivery(message, ABANDONED)

    def _carry(self, message: Message) -> Generator[simpy.Event, Any, Delivery]:
        """Try until the message is delivered or given up; then close its account."""
        line = self._line(message.sender)
        try:
            reason = yield from self._attempts(message, line)
            line.leave(message)
            late = reason is None and bool(message.luck) and self._is_late(message)
            if late:
                yield self.environment.timeout(self.errors.late_delay)
        except simpy.Interrupt:
            line.leave(message)
            self._close(message, ABANDONED)
            raise
        if reason is None:
            self.late += late
        return self._close(message, reason)

    def _attempts(self, message: Message, line: Line) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: attempts until one succeeds (None) or no more are left (the reason)."""
        while True:
            failure = yield from self._cross(message, line)
            message.end_first_attempt()
            if failure is None and message.luck:
                failure = self._fate(message)
            if failure is None or (failure == LINK_DOWN and self._down_for_good()):
                return failure
            if self.errors.retries:
                line.rest(message)
                yield self.environment.timeout(self.errors.timeout)
            if message.attempts > self.errors.retries:
                times = f"{message.attempts} attempt{'s' * (message.attempts > 1)}"
                return failure if failure == LINK_DOWN else f"{failure} after {times}"
            line.back(message)

    def _fate(self, message: Message) -> str | None:
        """What the attempt that just ended came to: None where the receiver takes it for good."""
        lost, damaged, _, _ = message.luck[message.attempts - 1]
        if lost < self.errors.drop:
            return "lost"
        return "damaged" if damaged < self._damaged(message) and not self._is_missed(message) else None

    def _is_missed(self, message: Message) -> bool:
        return message.luck[message.attempts - 1][2] < self._missed(message)

    def _is_late(self, message: Message) -> bool:
        return message.luck[message.attempts - 1][3] < self.errors.late_share

    def _arrived_damaged(self, message: Message) -> bool:
        return bool(message.luck) and message.luck[message.attempts - 1][1] < self._damaged(message)

    def _down_for_good(self) -> bool:
        outage = self._outages.at(self.now)
        return outage is not None and outage.end is None

    def _cross(self, message: Message, line: Line) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: one attempt, from the queue to the last bit; returns why it failed, or None."""
        while True:
            yield from line.wait_turn(message)
            granted = self.now
            if not (yield from self._wait_up()):
                return LINK_DOWN
            if self.now == granted:
                break
            # The choice falls when a message can begin, not before: a more urgent one may have come meanwhile.
            line.give_way(message)
            if line.holder is message:
                break
        self._begin(message)
        end = self._end(message)
        line.tell_change(message.sender)
        cut = self._outages.between(self.now, end)
        yield from self._on_wire(message, end if cut is None else cut.begin)
        return None if cut is None else LINK_DOWN

    def _wait_up(self) -> Generator[simpy.Event, Any, bool]:
        """Process generator: wait for an edge at which the link is up; False where it is down for good."""
        while True:
            outage = self._outages.at(self.now)
            begin = self._next_begin() if outage is None else outage.end
            if begin is None:
                return False
            if begin == self.now:
                return True
            yield self.environment.timeout(begin - self.now)

    def _begin(self, message: Message) -> None:
        message.attempts += 1
        if message.begin is None:
            message.begin = self.now
        else:
            self.retransmissions += 1

    def _on_wire(
        self, message: Message, until: int, other: Callable[[], simpy.Event] | None = None
    ) -> Generator[simpy.Event, Any, None]:
        """Process generator: book the time on the wire until ``until`` (ps), or until ``other`` happens."""
        begin = self.now
        if until == begin:
            return
        with self._working(alone=False):
            try:
                rest = self.environment.timeout(until - begin)
                yield rest if other is None else rest | other()
            finally:
                message.transferred += self.now - begin

    def _delivery(self, message: Message, reason: str | None) -> Delivery:
        outcome = Outcome.DELIVERED if reason is None else Outcome.DROPPED
        queued = self.now - message.asked - message.transferred
        damaged = reason is None and self._arrived_damaged(message)
        wrong = self._wrong_bits(message) if damaged else ()
        return Delivery(
            self.now, outcome, reason, message.attempts, queued, message.transferred, damaged, wrong
        )

    def _close(self, message: Message, reason: str | None) -> Delivery:
        """Book what became of a message, and tell it."""
        delivery = self._delivery(message, reason)
        self._open.remove(message.number)
        self.queued += delivery.queued
        self.transferred += delivery.transferred
        if reason is None:
            self.delivered += 1
            self.bits += message.bits
            self.undetected += delivery.damaged
            self.unnoticed[message.name] += delivery.damaged
        else:
            self.dropped[reason] += 1
        if self.listening:
            self.emit(
                MessageRecord(
                    time=message.asked,
                    source=self.name,
                    sender=message.sender,
                    receiver=message.receiver,
                    name=message.name,
                    bits=message.bits,
                    begin=self.now if message.begin is None else message.begin,
                    end=self.now,
                    outcome=delivery.outcome.value,
                    reason=reason,
                    attempts=message.attempts,
                    damaged=delivery.damaged,
                )
            )
        return delivery
