"""The faults of a link: random errors on the wire from a seed, and outages."""

from __future__ import annotations

import math
import zlib
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from codesign.ground.errors import InputError

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
