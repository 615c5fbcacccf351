"""What a message takes on an idle line, for each kind of link.

A line counts in ticks: cycles of a bus's clock, half bits of a serial line. A message takes a whole number of them.
Its end is rounded up to picoseconds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Self

from codesign.figures import Figure
from codesign.laws.numbers import Number, Sum, ceil_div, symbol

_SOME_BITS = 1


@dataclass(frozen=True)
class LinkLaw(ABC):
    """The law of a kind of link. Each field is a key of the link's spec.

    A field that is a figure of the spec is a price: it moves what a message takes, and neither how many messages there
    are nor which.

    - ``aligned``: a message begins at a tick, as at the edge of a clock. Otherwise it begins at any time.
    - ``least``: the least value of a field, by name.
    """

    aligned: ClassVar[bool] = False
    least: ClassVar[Mapping[str, int]] = {}

    @abstractmethod
    def rate(self) -> Number:
        """Ticks a second."""

    @abstractmethod
    def ticks(self, bits: int) -> Number:
        """Ticks that a message of ``bits`` bits takes, its checksum included."""

    @classmethod
    def of(cls, spec: Any, number: Callable[[str], Number]) -> Self:
        """The law of a spec, with ``number(key)`` for each price, in the order of the fields."""
        prices = cls.prices(spec)
        names = [each.name for each in fields(cls)]
        return cls(**{name: number(name) if name in prices else getattr(spec, name) for name in names})

    @classmethod
    def whole(cls, spec: Any) -> Self:
        """The law of a spec at its declared values, as whole numbers."""
        return cls.of(spec, lambda key: int(getattr(spec, key).value))

    @classmethod
    def prices(cls, spec: Any) -> tuple[str, ...]:
        """The keys of a spec that are prices."""
        return tuple(each.name for each in fields(cls) if isinstance(getattr(spec, each.name), Figure))

    @classmethod
    def directions(cls, spec: Any) -> dict[str, int]:
        """By price, 1 where a message takes as long or less as it rises, and -1 where it takes as long or more.

        A price that does neither for all messages is left out.
        """
        law = cls.of(spec, symbol)
        time = law.ticks(_SOME_BITS) / law.rate()
        signs = {key: time.direction(key) for key in cls.prices(spec)} if isinstance(time, Sum) else {}
        return {key: -sign for key, sign in signs.items() if sign}

    @classmethod
    def lever(cls, spec: Any) -> str:
        """The price that twice as much of makes every message take half the time; "" where there is none."""
        rate = cls.of(spec, symbol).rate()
        return next(iter(rate.inputs), "") if isinstance(rate, Sum) else ""


@dataclass(frozen=True)
class BusLaw(LinkLaw):
    """A parallel bus: ceil(words / burst_words) · setup_cycles + words cycles of its clock.

    words = ceil(bits / width).
    """

    aligned = True
    least: ClassVar[Mapping[str, int]] = {"width": 1, "setup_cycles": 0, "burst_words": 1}

    clock: Number
    width: Number
    burst_words: Number
    setup_cycles: Number

    def rate(self) -> Number:
        """The clock of the bus, Hz."""
        return self.clock

    def ticks(self, bits: int) -> Number:
        """Cycles of a message."""
        return self.cycles(self.words(bits))

    def words(self, bits: int) -> Number:
        """Words of a message."""
        return ceil_div(bits, self.width)

    def cycles(self, words: Number) -> Number:
        """Cycles of some words that begin with a set-up."""
        return words + ceil_div(words, self.burst_words) * self.setup_cycles


@dataclass(frozen=True)
class SerialLaw(LinkLaw):
    """A serial line: ceil(bits / data_bits) frames that follow each other at once, in half bits of the line.

    A frame has start bits, data bits, a parity bit where there is one, and stop bits: 1, 1.5 or 2.
    """

    least: ClassVar[Mapping[str, int]] = {"baud": 1, "data_bits": 1, "start_bits": 0}

    baud: Number
    data_bits: int = 8
    start_bits: int = 1
    stop_bits: float = 1.0
    parity: str = "none"

    def rate(self) -> Number:
        """Half bits a second."""
        return 2 * self.baud

    def ticks(self, bits: int) -> int:
        """Half bits of a message, frame by frame."""
        return self.frames(bits) * self.frame_ticks

    def frames(self, bits: int) -> int:
        """Frames of a message."""
        return int(ceil_div(bits, self.data_bits))

    @property
    def frame_ticks(self) -> int:
        """Half bits of a frame."""
        return 2 * (self.start_bits + self.data_bits + (self.parity != "none")) + int(2 * self.stop_bits)


@dataclass(frozen=True)
class IdealLaw(LinkLaw):
    """A link that takes no time."""

    def rate(self) -> int:
        """Any rate: a message takes no tick."""
        return 1

    def ticks(self, bits: int) -> int:  # noqa: ARG002  (the time does not depend on the bits)
        """0, for any message."""
        return 0
