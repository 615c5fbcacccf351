"""Links carry messages. Each message is delivered, dropped with a reason, or still in flight."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Sequence
from typing import Any, ClassVar, TypedDict

import simpy

from codesign.components.arbiter import checked_priority
from codesign.components.channel import Channel, Message
from codesign.components.component import ClockDomain, Component
from codesign.components.delivery import ABANDONED, LINK_DOWN, Delivery, DeliveryOutcome
from codesign.components.link_faults import LinkErrors, Luck, Outages, damage_probability, wrong_bits
from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.records import Listener, MessageRecord
from codesign.ground.units import edge
from codesign.laws import Law


class LinkOptions(TypedDict, total=False):
    """The options of every link; see ``Link``."""

    between: Sequence[str]
    errors: LinkErrors | None
    outages: Sequence[tuple[int, int | None]]
    listeners: Sequence[Listener]


class Link(Component):
    """A link carries messages in order, with errors, outages and an account of them. Its law says what each takes.

    ``between``: the names of its ends; where it is given, messages of other components are refused. Each of two ends
    has a line of its own (full duplex); more than two share one (half duplex).

    A kind of link whose law is all that is new about it needs no class of its own.

    Order. A sender's messages arrive in the order of their requests, urgent ones first. A lower ``priority`` is more
    urgent, and 0 is the most urgent. A message on the wire is never broken off for another. Of the messages that are
    requested in one picosecond the most urgent is first, whatever the order of the requests. A message that was lost
    or found damaged is sent again after the timeout. Later messages of its sender wait for it; the messages of other
    senders do not (stop and wait). Late messages may be overtaken.

    Outages. A message that would begin in an outage waits for its end; where the outage has no end, the message is
    dropped at once. A message that is on the wire when an outage begins is cut off there. It counts as damaged, with
    or without a checksum.

    The account. ``sent == delivered + sum(dropped.values()) + in_flight`` holds at all times:

    - ``sent``, ``delivered``, ``in_flight``: messages. ``dropped``: messages given up, by reason.
    - ``bits``: delivered, without framing and checksum.
    - ``retransmissions``: attempts beyond the first of each message. ``late``: messages that arrived late.
    - ``undetected``: messages delivered with wrong bits; ``unnoticed``: the same by name of the message.
    - ``queued``, ``transferred``: the sums over all messages that are delivered or dropped, ps.

    ``busy`` is the time in which at least one line had a message on it.

    Raises:
        InputError: a value of the law is below its least value, or its clock is faster than 1 THz.
    """

    options: ClassVar[tuple[str, ...]] = ()
    """Keys of the spec that the law does not know, and the component does."""

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        law: Law,
        *,
        between: Sequence[str] = (),
        errors: LinkErrors | None = None,
        outages: Sequence[tuple[int, int | None]] = (),
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        self._check_least(*((key, getattr(law, key), least) for key, least in law.least.items()))
        self.law = law
        self._rate = law.rate()
        self.clock = ClockDomain(self._rate) if law.aligned else None
        self.between = tuple(between)
        self.errors = errors or LinkErrors()
        self.sent = self.delivered = self.bits = self.retransmissions = self.undetected = self.late = 0
        self.queued = self.transferred = 0
        self.dropped: Counter[str] = Counter()
        self.unnoticed: Counter[str] = Counter()
        self._outages = Outages(outages)
        self._luck = Luck(self.errors, name) if self.errors.any else None
        self._lines: dict[str, Channel] = {}
        self._open: set[int] = set()

    @property
    def in_flight(self) -> int:
        """Messages that are neither delivered nor dropped yet."""
        return len(self._open)

    def ticks(self, bits: int) -> int:
        """Ticks of the law that one attempt of a message of ``bits`` bits takes, its checksum included.

        Raises:
            RunError: the message is empty.
        """
        self._check_bits(bits)
        return int(self.law.ticks(bits + self.errors.checksum_bits))

    def duration(self, bits: int) -> int:
        """Picoseconds that one attempt takes on an idle link without faults, from tick 0."""
        return edge(self.ticks(bits), self._rate)

    def _one_line(self) -> bool:
        """True if all senders share one line."""
        return len(self.between) > 2

    def send(
        self, sender: str, receiver: str, name: str, bits: int, priority: int = 0
    ) -> Generator[simpy.Event, Any, Delivery]:
        """Process generator: carry a message and wait until it is delivered or dropped.

        Its ``MessageRecord`` is emitted at that time. An interruption frees the link, drops the message as
        "abandoned", and is passed on to the caller.

        Raises:
            RunError: the message is empty, its sender or receiver is no end of the link, or its priority is below 0.
        """
        return (yield from self._carry(self._accept(sender, receiver, name, bits, priority)))

    def post(
        self, sender: str, receiver: str, name: str, bits: int, priority: int = 0
    ) -> Generator[simpy.Event, Any, simpy.Process]:
        """Process generator: carry a message, and wait only until the link has taken it over.

        Returns a process; its value will be the ``Delivery``. An interruption while the sender waits drops the message
        as "abandoned". Later, an interruption of the returned process does the same.

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

    def _new_line(self) -> Channel:
        return Channel(self.environment)

    def _line(self, sender: str) -> Channel:
        key = "" if self._one_line() else sender
        if key not in self._lines:
            self._lines[key] = self._new_line()
        return self._lines[key]

    def _next_begin(self) -> int:
        """The time at which a transfer can begin, ps. On a link with a clock that is a clock edge."""
        return self.now if self.clock is None else self.clock.next_edge(self.now)

    def _wire_bits(self, message: Message) -> int:
        return message.bits + self.errors.checksum_bits

    def _end(self, message: Message) -> int:
        """The time at which a transfer that begins now will end, ps. Called once for each attempt."""
        if self.clock is None:
            return self.now + self.duration(message.bits)
        first = self.clock.cycle_at_or_after(self.now)
        return self.clock.edge(first + self.ticks(message.bits))

    def _damaged(self, message: Message) -> float:
        """The probability that an attempt arrives with wrong bits."""
        return damage_probability(self._wire_bits(message), self.errors.bit_error_rate)

    def _missed(self, message: Message) -> float:  # noqa: ARG002  (a link with parity uses it)
        """The probability that damage is not detected, given that an attempt is damaged."""
        return 2.0**-self.errors.checksum_bits

    def _wrong_bits(self, message: Message) -> tuple[int, ...]:
        """Wrong bits of the message, where its last attempt is damaged and the damage is not detected."""
        assert self._luck is not None, "only a link with errors damages messages"
        random = self._luck.of(message.number, message.attempts)
        return wrong_bits(random, message.bits, self.errors.bit_error_rate)

    def _hold(self, message: Message) -> Generator[simpy.Event, Any, None]:
        """Process generator: wait until the sender may go on, at the end of the first attempt."""
        if not message.first_over:
            message.free = self.environment.event()
            yield message.free

    def _check_bits(self, bits: int) -> None:
        if bits < 1:
            raise RunError(f"a message of {bits} bits", self.name, "send at least one bit, or no message at all")

    def _check_least(self, *limits: tuple[str, int, int]) -> None:
        """Refuse a parameter below its least value. ``limits``: name, value and least value of each."""
        for key, value, least in limits:
            if value < least:
                raise InputError(f"{key} of {value}", f"{self.name}.{key}", f"give at least {least}")

    def _accept(self, sender: str, receiver: str, name: str, bits: int, priority: int) -> Message:
        self._check_bits(bits)
        for end in (sender, receiver):
            if self.between and end not in self.between:
                raise RunError(f"{end!r} is no end of this link", self.name, choose_hint(end, self.between))
        checked_priority(priority, self.name)
        luck = [] if self._luck is None else self._luck.draw()
        message = Message(self.sent, sender, receiver, name, bits, priority, self.now, luck, self.now)
        self.sent += 1
        self._open.add(message.number)
        self._line(sender).enter(message)
        self._sample(sender)
        return message

    def _sample(self, sender: str) -> None:
        """The messages that are not over, and the words in the FIFO of ``sender``, have changed."""
        samples = self._samples
        if samples is not None:
            now = self.now
            samples.level(now, "queue", "messages", len(self._open))
            words = self._fifo_words(sender)
            if words is not None:
                samples.level(now, f"fifo.{sender}", "words", words)

    def _fifo_words(self, sender: str) -> int | None:  # noqa: ARG002  (a link with FIFOs uses it)
        """The words in the FIFO of a sender; None: it has none."""
        return None

    def _carry_alone(self, message: Message) -> Generator[simpy.Event, Any, Delivery]:
        try:
            return (yield from self._carry(message))
        except simpy.Interrupt:
            return self._delivery(message, ABANDONED)

    def _carry(self, message: Message) -> Generator[simpy.Event, Any, Delivery]:
        """Process generator: try until the message is delivered or given up, then close its account."""
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

    def _attempts(self, message: Message, line: Channel) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: attempts until one succeeds (None) or none is left (the reason)."""
        while True:
            failure = yield from self._cross(message, line)
            message.end_first_attempt()
            if failure is None and message.luck:
                failure = self._fate(message)
            if failure is None or (failure == LINK_DOWN and self._stays_down()):
                return failure
            if self.errors.retries:
                line.rest(message)
                yield self.environment.timeout(self.errors.timeout)
            if message.attempts > self.errors.retries:
                times = f"{message.attempts} attempt{'s' * (message.attempts > 1)}"
                return failure if failure == LINK_DOWN else f"{failure} after {times}"
            line.resume(message)

    def _fate(self, message: Message) -> str | None:
        """The reason for which the attempt that just ended failed. None if the receiver accepts the message."""
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

    def _stays_down(self) -> bool:
        outage = self._outages.at(self.now)
        return outage is not None and outage.end is None

    def _cross(self, message: Message, line: Channel) -> Generator[simpy.Event, Any, str | None]:
        """Process generator: one attempt, from the queue to the last bit. Returns why it failed, or None."""
        while True:
            yield from line.wait_turn(message)
            granted = self.now
            if not (yield from self._wait_up()):
                return LINK_DOWN
            if self.now == granted:
                break
            # The arbiter chooses when a message can begin and not earlier: a more urgent one may have arrived since.
            line.contend_again(message)
            if line.holder is message:
                break
        self._begin(message)
        end = self._end(message)
        line.signal_change(message.sender)
        self._sample(message.sender)
        cut = self._outages.between(self.now, end)
        yield from self._on_wire(message, end if cut is None else cut.begin)
        return None if cut is None else LINK_DOWN

    def _wait_up(self) -> Generator[simpy.Event, Any, bool]:
        """Process generator: wait for an edge at which the link is up. False where it stays down."""
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
        """Process generator: book the time on the wire until ``until`` (ps) or until the event ``other``."""
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
        outcome = DeliveryOutcome.DELIVERED if reason is None else DeliveryOutcome.DROPPED
        queued = self.now - message.requested - message.transferred
        damaged = reason is None and self._arrived_damaged(message)
        wrong = self._wrong_bits(message) if damaged else ()
        return Delivery(self.now, outcome, reason, message.attempts, queued, message.transferred, damaged, wrong)

    def _close(self, message: Message, reason: str | None) -> Delivery:
        """Book the end of a message, and emit its record."""
        delivery = self._delivery(message, reason)
        self._open.remove(message.number)
        self._sample(message.sender)
        self.queued += delivery.queued
        self.transferred += delivery.transferred
        if reason is None:
            self.delivered += 1
            self.bits += message.bits
            self.undetected += delivery.damaged
            self.unnoticed[message.name] += delivery.damaged
        else:
            self.dropped[reason] += 1
        if self.wants(MessageRecord):
            self.emit(
                MessageRecord(
                    time=message.requested,
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


class Ideal(Link):
    """A link without delay, for what is not studied and for checks. It counts every message.

    It is never busy. Errors and outages behave as on every link. Each sender has a line of its own.
    """

    def _one_line(self) -> bool:
        return False
