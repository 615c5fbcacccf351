"""Links carry messages. Each message is delivered, dropped with a reason, or still in flight."""

from __future__ import annotations

import math
import zlib
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, TypedDict

import numpy as np
import simpy

from codesign.components.channel import Channel, Message, checked_priority
from codesign.components.component import ClockDomain, Component
from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.records import Listener, MessageRecord
from codesign.ground.units import edge
from codesign.laws import Law

# The faults of a link: random errors on the wire from a seed, and outages.

MAX_RETRIES = 1000
"""Most retransmissions of a message. The random numbers of all of them are drawn at once, see ``Luck``."""


@dataclass(frozen=True)
class LinkErrors:
    """Errors of a link. Each message and each attempt is independent of the others.

    - ``bit_error_rate``: probability that a bit arrives wrong. ``checksum_bits``: sent with every message. The checksum
      misses a damaged message with probability 2^-checksum_bits, so with 0 bits every damaged message is accepted.
    - ``drop``: probability that a message is lost.
    - ``retries``: how often a message that was lost or found damaged is sent again, each time ``timeout`` ps after the
      end of the previous attempt. Acknowledgements take no time on the link.
    - ``late_share``: probability that a message arrives ``late_delay`` ps after its last bit left the link.
    - ``seed``: seeds the link's stream of random numbers, together with the name of the link.

    Raises:
        InputError: a probability outside of 0 to 1, a negative number, or more than ``MAX_RETRIES`` retries.
    """

    bit_error_rate: float = 0.0
    checksum_bits: int = 0
    retries: int = 0
    timeout: int = 0
    drop: float = 0.0
    late_share: float = 0.0
    late_delay: int = 0
    seed: int = 0

    def __post_init__(self) -> None:
        for key in ("bit_error_rate", "drop", "late_share"):
            value = getattr(self, key)
            if not 0 <= value <= 1:
                raise InputError(f"{key} of {value}", f"errors.{key}", "a probability is from 0 to 1")
        for key in ("checksum_bits", "retries", "timeout", "late_delay", "seed"):
            value = getattr(self, key)
            if value < 0:
                raise InputError(f"{key} of {value}", f"errors.{key}", "give 0 or more")
        if self.retries > MAX_RETRIES:
            raise InputError(f"{self.retries} retries", "errors.retries", f"give at most {MAX_RETRIES}")

    @property
    def any(self) -> bool:
        """True if any error is possible. A checksum alone harms no message."""
        return bool(self.bit_error_rate or self.drop or self.late_share)


def damage_probability(bits: int, bit_error_rate: float) -> float:
    """The probability that at least one of ``bits`` bits arrives wrong: 1 - (1 - bit_error_rate)^bits."""
    if bit_error_rate >= 1:
        return 1.0 if bits else 0.0
    return -math.expm1(bits * math.log1p(-bit_error_rate))


def parity_miss(frames: int, frame_bits: int, bit_error_rate: float) -> float:
    """The probability that parity misses a message, given that it is damaged.

    A message has ``frames`` frames of ``frame_bits`` bits, the parity bit included. Parity misses it where each frame
    has an even number of wrong bits. With r = (1 - p)^n for no wrong bit in a frame of n bits, and e for two, four, ...
    wrong bits, that is ((r + e)^frames - r^frames) / P(damaged). The terms of e are summed separately, so that small
    rates do not cancel out.

    >>> parity_miss(1, 2, 0.5)  # of 00 01 10 11 three are damaged, and parity misses one
    0.3333333333333333
    """
    if bit_error_rate >= 1:
        return float(frame_bits % 2 == 0)
    right = (1 - bit_error_rate) ** frame_bits
    even = sum(
        math.comb(frame_bits, wrong) * bit_error_rate**wrong * (1 - bit_error_rate) ** (frame_bits - wrong)
        for wrong in range(2, frame_bits + 1, 2)
    )
    damaged = damage_probability(frames * frame_bits, bit_error_rate)
    if not damaged or not right:
        return 0.0
    return right**frames * math.expm1(frames * math.log1p(even / right)) / damaged


class Luck:
    """The stream of random numbers of one link.

    Every message draws the same count of numbers at its request, for all the attempts that it may have. So the fate of
    message n depends on the seed and on n alone, not on the speed of the link or on other events.
    """

    def __init__(self, errors: LinkErrors, link: str) -> None:
        self._shape = (errors.retries + 1, 4)
        self._stream = errors.seed, zlib.crc32(link.encode())
        self._random = np.random.Generator(np.random.PCG64(self._stream))

    def draw(self) -> list[list[float]]:
        """One list of four numbers in [0, 1) for each attempt: lost, damaged, missed by the check, late."""
        drawn: list[list[float]] = self._random.random(self._shape).tolist()
        return drawn

    def of(self, message: int, attempt: int) -> np.random.Generator:
        """A stream for one attempt of message number ``message``: draws from it change no other message."""
        return np.random.Generator(np.random.PCG64((*self._stream, message, attempt)))


def wrong_bits(random: np.random.Generator, bits: int, bit_error_rate: float) -> tuple[int, ...]:
    """The bits of ``bits`` that arrive wrong, given that at least one does. Each is wrong at ``bit_error_rate``.

    The step from one wrong bit to the next is geometric. The first lies within the message: its index is
    floor(log(1 - u P(damaged)) / log(1 - p)) with u uniform in [0, 1).
    """
    if bit_error_rate >= 1:
        return tuple(range(bits))
    places = []
    share = random.random() * damage_probability(bits, bit_error_rate)
    place = min(int(math.log1p(-share) / math.log1p(-bit_error_rate)), bits - 1)
    while place < bits:
        places.append(place)
        place += int(random.geometric(bit_error_rate))
    return tuple(places)


def wrong_behind_parity(
    random: np.random.Generator, frames: int, frame_bits: int, bit_error_rate: float
) -> tuple[tuple[int, int], ...]:
    """The pairs (frame, bit in the frame) that arrive wrong, given that some do and that parity detects none.

    In every frame an even number of its ``frame_bits`` bits is then wrong, the parity bit included.
    """
    counts = np.arange(0, frame_bits + 1, 2)
    weights = np.array([math.comb(frame_bits, int(count)) for count in counts], float)
    if bit_error_rate >= 1:
        weights[:-1] = 0.0
    else:
        weights *= (bit_error_rate / (1 - bit_error_rate)) ** counts
    weights /= weights.sum()
    # The share of frames with two or more wrong bits, among frames with an even number of them.
    harmed = 1.0 - weights[0] if bit_error_rate >= 1 else float(weights[1:].sum())
    wrong: list[tuple[int, int]] = []
    for frame in wrong_bits(random, frames, harmed) if harmed else ():
        count = int(random.choice(counts[1:], p=weights[1:] / weights[1:].sum()))
        places = sorted(random.choice(frame_bits, count, replace=False).tolist())
        wrong += [(frame, place) for place in places]
    return tuple(wrong)


@dataclass(frozen=True)
class Outage:
    """A link is down from ``begin`` to before ``end`` (ps). None: the outage does not end."""

    begin: int
    end: int | None


class Outages:
    """The outages of one link, in order. Outages that meet are merged.

    ``spans``: (from, to) in ps each, ``to`` None for an outage that does not end.

    Raises:
        InputError: an outage that begins before time 0 or ends before it began.
    """

    def __init__(self, spans: Sequence[tuple[int, int | None]] = ()) -> None:
        merged: list[Outage] = []
        for begin, end in sorted(spans, key=lambda span: span[0]):
            if begin < 0 or (end is not None and end <= begin):
                raise InputError(f"an outage from {begin} ps to {end} ps", "outages", "let it end after it began")
            last = merged[-1] if merged else None
            if last is None or (last.end is not None and last.end < begin):
                merged.append(Outage(begin, end))
            elif last.end is not None and (end is None or end > last.end):
                merged[-1] = Outage(last.begin, end)
        self._outages = merged
        self._begins = [outage.begin for outage in merged]

    def at(self, time: int) -> Outage | None:
        """The outage at ``time``, if any."""
        index = bisect_right(self._begins, time) - 1
        if index < 0:
            return None
        outage = self._outages[index]
        return outage if outage.end is None or time < outage.end else None

    def between(self, begin: int, end: int) -> Outage | None:
        """The first outage that begins after ``begin`` and before ``end``, if any."""
        index = bisect_right(self._begins, begin)
        if index == len(self._outages) or self._begins[index] >= end:
            return None
        return self._outages[index]


# The end of a message on a link.

ABANDONED = "abandoned"
"""The reason of a message that was dropped because its sender was interrupted."""

LINK_DOWN = "link down"
"""The reason of a message that was dropped because of an outage."""


class DeliveryOutcome(StrEnum):
    """The end of a message."""

    DELIVERED = "delivered"
    DROPPED = "dropped"


@dataclass(frozen=True)
class Delivery:
    """The end of a message, and the account of its time (ps).

    - ``time``: when it was delivered or given up. ``reason``: why it was dropped; None if it was delivered.
    - ``attempts``: how often it was on the wire.
    - ``transferred``: the time on the wire, all attempts together. ``queued``: all other time since the request: the
      wait for the line, an edge, a timeout, the end of an outage, or a late arrival.
    - ``damaged``: it was delivered with wrong bits that were not detected. ``wrong``: the indices of the wrong bits of
      the message itself, from 0, in order, without the bits of its checksum and its frames.
    """

    time: int
    outcome: DeliveryOutcome
    reason: str | None
    attempts: int
    queued: int
    transferred: int
    damaged: bool = False
    wrong: tuple[int, ...] = ()


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
