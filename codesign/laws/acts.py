"""The laws of time: how long each kind of component or link takes for one act.

An act takes a whole number of ticks: cycles of a clock, half bits of a serial line, picoseconds of a processor. Its end
is rounded up to picoseconds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Self

from codesign.ground.figures import Figure, weakest
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.laws.numbers import Number, Sum, ceil_div, symbol


@dataclass(frozen=True)
class Law(ABC):
    """The law of a kind of component or link. Each field is a key of the spec.

    A field that is a figure of the spec is a price: it moves what an act takes, and neither how many acts there are nor
    which.

    - ``aligned``: an act begins at a tick, as at the edge of a clock. Otherwise it begins at any time.
    - ``least``: the least value of a field, by name.
    """

    aligned: ClassVar[bool] = False
    least: ClassVar[Mapping[str, int]] = {}

    @abstractmethod
    def rate(self) -> Number:
        """Ticks a second."""

    @abstractmethod
    def ticks(self, amount: int) -> Number:
        """Ticks of an act: of a message of so many bits, checksum included, of cycles, or of units of a kernel."""

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
        return tuple(each.name for each in fields(cls) if isinstance(getattr(spec, each.name, None), Figure))

    @classmethod
    def directions(cls, spec: Any) -> dict[str, int]:
        """By price, 1 where an act takes as long or less as it rises, and -1 where it takes as long or more.

        A price that does neither for all acts is left out.
        """
        keys = cls.prices(spec)
        if not keys:
            return {}
        law = cls.of(spec, symbol)
        time = law.ticks(1) / law.rate()
        signs = {key: time.direction(key) for key in keys}
        return {key: -sign for key, sign in signs.items() if sign}

    @classmethod
    def lever(cls, spec: Any) -> str:
        """The price that twice as much of makes every act take half the time; "" where there is none."""
        if not cls.prices(spec):
            return ""
        rate = cls.of(spec, symbol).rate()
        return next(iter(rate.inputs), "") if isinstance(rate, Sum) else ""


@dataclass(frozen=True)
class FpgaLaw(Law):
    """A design on an FPGA: so many cycles of its clock, from an edge on."""

    aligned = True

    clock: Number

    def rate(self) -> Number:
        """The clock, Hz."""
        return self.clock

    def ticks(self, amount: int) -> int:
        """The cycles."""
        return amount


UNDISTURBED = 10**6
"""The pace of a kernel that has a core for itself, ppm."""


def pace_of(load: Figure | None, median: Figure | None, p99: Figure | None) -> Figure | None:
    """The pace of the kernels of a processor, ppm: (1 - load) / jitter. None where neither is declared.

    A plan takes its time on an undisturbed core, times jitter, over what ``load`` leaves of the core. The value is of
    the median plan, the least of the 99th percentile, and the greatest of a plan that is not delayed.
    """
    parts = [each for each in (load, median, p99) if each is not None]
    if not parts:
        return None
    taken, (low, high) = (0.0, (0.0, 0.0)) if load is None else (load.value, load.interval)
    late, latest = 1.0 if median is None else median.value, 1.0 if p99 is None else p99.interval[1]
    texts = [f"load {load.value:g}: {load.source}"] if load is not None else []
    texts += [f"jitter {late:g}, {latest:g} at the 99th percentile: {p99.source}"] if p99 is not None else []
    value, least, most = (int(UNDISTURBED * each) for each in ((1 - taken) / late, (1 - high) / latest, 1 - low))
    return Figure(value, "ppm", weakest(*(each.status for each in parts)), "; ".join(texts), least, most)


@dataclass(frozen=True)
class KernelLaw(Law):
    """A kernel on a processor: so many units of one cost each, ps of the processor's time. Its clock does not matter.

    ``pace``: picoseconds of it that the kernel gets of a microsecond; all of them on a processor that nothing disturbs.
    """

    cost: Number
    pace: Number = UNDISTURBED

    def rate(self) -> Number:
        """Picoseconds of the processor that the kernel gets in a second."""
        return PICOSECONDS_PER_SECOND // UNDISTURBED * self.pace

    def ticks(self, amount: int) -> Number:
        """Picoseconds of the processor of some units."""
        return amount * self.cost


@dataclass(frozen=True)
class BusLaw(Law):
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

    def ticks(self, amount: int) -> Number:
        """Cycles of a message."""
        return self.cycles(self.words(amount))

    def words(self, bits: int) -> Number:
        """Words of a message."""
        return ceil_div(bits, self.width)

    def cycles(self, words: Number) -> Number:
        """Cycles of some words that begin with a set-up."""
        return words + ceil_div(words, self.burst_words) * self.setup_cycles


@dataclass(frozen=True)
class SerialLaw(Law):
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

    def ticks(self, amount: int) -> int:
        """Half bits of a message, frame by frame."""
        return self.frames(amount) * self.frame_ticks

    def frames(self, bits: int) -> int:
        """Frames of a message."""
        return int(ceil_div(bits, self.data_bits))

    @property
    def frame_ticks(self) -> int:
        """Half bits of a frame."""
        return 2 * (self.start_bits + self.data_bits + (self.parity != "none")) + int(2 * self.stop_bits)


@dataclass(frozen=True)
class IdealLaw(Law):
    """No act takes any time."""

    def rate(self) -> int:
        """Any rate: no act takes a tick."""
        return 1

    def ticks(self, amount: int) -> int:  # noqa: ARG002 - see the class
        """0."""
        return 0
