"""Quantities are text with a unit at the edges and exact numbers inside. Also: the edges of a clock.

A quantity is a decimal number and an accepted unit, case-sensitive: ``150 MHz``, ``42.088 ns``, ``5 Mb/s`` (megabits: b
is a bit, B a byte). A bare number is refused, and so is a unit in the wrong case. Inside, time is integer picoseconds,
frequency integer Hz, data integer bits, and data rate integer bits a second. All other quantities are exact fractions
(``Fraction``) of the SI unit.

Rejected: libraries. One reads ``5 Mb/s`` as megabarn, another reads ``1 mhz`` as 0.001.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from types import MappingProxyType

from codesign.ground.errors import InputError

PICOSECONDS_PER_SECOND = 10**12

MAX_FREQUENCY = PICOSECONDS_PER_SECOND
"""Hz: one edge a picosecond. Above it two edges would coincide."""

_QUANTITY = re.compile(
    r"(?P<number>[+-]?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,3})?)(?P<space> *)(?P<unit>(?:[^0-9.,+-].*)?)", re.S
)
_MAX_TEXT = 64
_NON_FINITE = re.compile(r"[+-]?\.?(inf(inity)?|nan)\b", re.I)


class Dimension(StrEnum):
    """The dimension of a quantity."""

    TIME = "time"
    FREQUENCY = "frequency"
    DATA = "data"
    DATA_RATE = "data rate"
    POWER = "power"
    ENERGY = "energy"
    LENGTH = "length"
    CURRENT = "current"
    VOLTAGE = "voltage"
    SPEED = "speed"
    ACCELERATION = "acceleration"
    TURN_RATE = "turn rate"
    MONEY = "price"
    RATE = "rate"


@dataclass(frozen=True)
class Scale:
    """The notation of a dimension and the number inside.

    - ``base``: the unit of the number inside. ``whole``: it is an integer.
    - ``units``: accepted units and their size in ``base``, smallest first.
    - ``most``: the largest accepted value in ``base``. ``zero``: True if 0 is accepted.
    - ``example``: a quantity as a user writes it.
    """

    base: str
    whole: bool
    units: Mapping[str, Fraction]
    most: Fraction
    zero: bool
    example: str


def _scale(base: str, units: str, most: str, example: str, *, whole: bool = False, zero: bool = True) -> Scale:
    """``units``: each with its size in ``base``, such as ``ns 1e3``."""
    words = units.split()
    sizes = {unit: Fraction(size) for unit, size in zip(words[::2], words[1::2], strict=True)}
    return Scale(base, whole, MappingProxyType(sizes), Fraction(most), zero, example)


_DEGREE = Fraction(math.pi) / 180
"""Radians, with pi as the nearest double, exactly."""

SCALES: Mapping[Dimension, Scale] = MappingProxyType(
    {
        # 1000 h in ps stays below 2^63.
        Dimension.TIME: _scale(
            "ps", "ps 1 ns 1e3 us 1e6 µs 1e6 ms 1e9 s 1e12 min 60e12 h 3600e12", "3.6e18", "10 us", whole=True
        ),
        Dimension.FREQUENCY: _scale(
            "Hz", "Hz 1 kHz 1e3 MHz 1e6 GHz 1e9", str(MAX_FREQUENCY), "150 MHz", whole=True, zero=False
        ),
        Dimension.DATA: _scale(
            "b",
            f"b 1 B 8 kb 1e3 kB 8e3 KiB {8 * 2**10} Mb 1e6 MB 8e6 MiB {8 * 2**20} GiB {8 * 2**30}",
            "1e18",
            "64 KiB",
            whole=True,
        ),
        Dimension.DATA_RATE: _scale(
            "b/s",
            "b/s 1 B/s 8 kb/s 1e3 kB/s 8e3 Mb/s 1e6 MB/s 8e6 Gb/s 1e9 GB/s 8e9",
            "1e18",
            "5 Mb/s",
            whole=True,
            zero=False,
        ),
        Dimension.POWER: _scale("W", "pW 1e-12 nW 1e-9 uW 1e-6 µW 1e-6 mW 1e-3 W 1 kW 1e3", "1e9", "1.5 W"),
        Dimension.ENERGY: _scale("J", "pJ 1e-12 nJ 1e-9 uJ 1e-6 µJ 1e-6 mJ 1e-3 J 1 kJ 1e3", "1e12", "20 mJ"),
        Dimension.LENGTH: _scale("m", "um 1e-6 µm 1e-6 mm 1e-3 cm 1e-2 m 1 km 1e3", "1e9", "5 cm"),
        Dimension.CURRENT: _scale("A", "uA 1e-6 µA 1e-6 mA 1e-3 A 1", "1e6", "20 mA"),
        Dimension.VOLTAGE: _scale("V", "uV 1e-6 µV 1e-6 mV 1e-3 V 1 kV 1e3", "1e6", "1.2 V"),
        Dimension.SPEED: _scale("m/s", "mm/s 1e-3 cm/s 1e-2 km/h 5/18 m/s 1", "1e6", "0.5 m/s"),
        Dimension.ACCELERATION: _scale(
            "m/s^2", "mm/s^2 1e-3 mm/s² 1e-3 cm/s^2 1e-2 cm/s² 1e-2 m/s^2 1 m/s² 1", "1e6", "0.5 m/s^2"
        ),
        Dimension.TURN_RATE: _scale("rad/s", f"deg/s {_DEGREE} rad/s 1", "1e6", "90 deg/s"),
        Dimension.MONEY: _scale("USD", "USD 1", "1e9", "249 USD"),
        # Of plans that are asked for, not of a clock.
        Dimension.RATE: _scale("Hz", "mHz 1e-3 Hz 1 kHz 1e3 MHz 1e6 GHz 1e9", "1e6", "10 Hz", zero=False),
    }
)
"""The scale of every dimension of specs."""


def parse_quantity(text: str, dimension: Dimension) -> int | Fraction:
    """The exact quantity of ``text``, in the base unit of ``dimension``.

    An ``int`` for time (ps), frequency (Hz), data (bits) and data rate (bits/s), a ``Fraction`` for the rest.

    >>> parse_quantity("42.088 ns", Dimension.TIME)
    42088
    >>> parse_quantity("5 Mb/s", Dimension.DATA_RATE)
    5000000

    Raises:
        InputError: no number, no unit, an unknown unit, a negative or too large number, 0 where it is not accepted, or
            a fraction of the smallest unit (1.5 ps).
    """
    scale = SCALES[dimension]
    shown = repr(text if len(text) <= _MAX_TEXT else text[:_MAX_TEXT] + "...")
    example = f"write a number and a unit, such as {scale.example}"
    if _NON_FINITE.match(text.strip()):
        raise InputError(f"{shown} is not a finite {dimension}", hint=example)
    match = _QUANTITY.fullmatch(text.strip(" "))
    if match is None or len(text) > _MAX_TEXT:
        raise InputError(f"{shown} is not {_with_article(dimension)}", hint=example)
    unit = match["unit"].replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")
    if not unit:
        raise InputError(f"{shown} has no unit", hint=f"{example}; {_accepted(scale)}")
    if unit not in scale.units:
        raise InputError(f"{shown} has no unit of {dimension}", hint=_unit_hint(unit, scale))
    value = Fraction(match["number"]) * scale.units[unit]
    if value < 0:
        raise InputError(f"{shown} is negative", hint=f"{_with_article(dimension)} is at least 0")
    if value == 0 and not scale.zero:
        raise InputError(f"{shown} is zero", hint=f"{_with_article(dimension)} is above 0")
    if value > scale.most:
        raise InputError(f"{shown} is too large", hint=f"at most {format_exact(scale.most, dimension)}")
    if not scale.whole:
        return value
    if value.denominator != 1:
        raise InputError(
            f"{shown} is not a whole number of {scale.base}", hint=f"round it to {scale.base}, the resolution here"
        )
    return int(value)


def _with_article(dimension: Dimension) -> str:
    words = "amount of data" if dimension is Dimension.DATA else str(dimension)
    return f"{'an' if words[0] in 'ae' else 'a'} {words}"


def _accepted(scale: Scale) -> str:
    return f"accepted units: {', '.join(unit for unit in scale.units if unit.isascii())}"


def _unit_hint(unit: str, scale: Scale) -> str:
    alike = [accepted for accepted in scale.units if accepted.lower() == unit.lower()]
    if alike:
        return f"did you mean {' or '.join(alike)}? {_accepted(scale)}"
    return _accepted(scale)


def format_exact(value: int | Fraction, dimension: Dimension) -> str:
    """The shortest exact text of a value. ``parse_quantity`` returns the same number for it.

    The unit is the largest one in which the value is at least 1 and has at most six decimals; otherwise the base unit.

    >>> format_exact(33_333_333, Dimension.FREQUENCY), format_exact(42088, Dimension.TIME)
    ('33.333333 MHz', '42.088 ns')

    Raises:
        InputError: the value has no finite decimal form.
    """
    scale = SCALES[dimension]
    exact = Fraction(value)
    for unit, size in reversed(_printed_units(scale)):
        decimal = _decimal(exact / size, 6)
        if exact >= size and decimal is not None:
            return f"{decimal} {unit}"
    decimal = _decimal(exact, 40)
    if decimal is None:
        raise InputError(f"{value} has no finite decimal form")
    return f"{decimal} {scale.base}"


def _printed_units(scale: Scale) -> list[tuple[str, Fraction]]:
    # Minutes, hours and powers of two are read but not printed: decimal prefixes are easier to compare.
    return [(unit, size) for unit, size in scale.units.items() if unit.isascii() and unit not in {"min", "h"}]


def _decimal(value: Fraction, most_digits: int) -> str | None:
    for digits in range(most_digits + 1):
        scaled = value * 10**digits
        if scaled.denominator == 1:
            whole, rest = divmod(int(scaled), 10**digits)
            return f"{whole}.{rest:0{digits}d}" if digits else str(whole)
    return None


def format_quantity(value: float | Fraction, dimension: Dimension, digits: int = 4) -> str:
    """A value for people, with ``digits`` significant digits and a fitting unit.

    >>> format_quantity(0.000123456, Dimension.ENERGY)
    '123.5 uJ'
    """
    units = shown_units(dimension)
    if not value:
        return f"0 {SCALES[dimension].base}"
    chosen = units[0]
    for unit, size in units:
        if abs(Fraction(f"{float(value / size):.{digits - 1}e}")) >= 1:
            chosen = unit, size
    return f"{_significant(float(value / chosen[1]), digits)} {chosen[0]}"


def shown_units(dimension: Dimension) -> list[tuple[str, Fraction]]:
    """The units that ``format_quantity`` chooses from, smallest first, and their sizes in the base unit."""
    return [(unit, size) for unit, size in _printed_units(SCALES[dimension]) if "i" not in unit]


def _significant(value: float, digits: int) -> str:
    rounded = f"{value:.{digits}g}"
    return f"{float(rounded):.0f}" if "e" in rounded and abs(value) >= 1 else rounded


def format_time(picoseconds: int) -> str:
    """A duration for people.

    >>> format_time(1_250_000_000)
    '1.25 ms'
    """
    return format_quantity(Fraction(picoseconds), Dimension.TIME)


def format_frequency(hertz: float) -> str:
    """A frequency for people.

    >>> format_frequency(150_000_000)
    '150 MHz'
    """
    return format_quantity(hertz, Dimension.FREQUENCY)


def format_power(watts: float) -> str:
    """A power for people."""
    return format_quantity(watts, Dimension.POWER)


def format_energy(joules: float) -> str:
    """An energy for people."""
    return format_quantity(joules, Dimension.ENERGY)


def format_data(bits: int) -> str:
    """A number of bits for people, in decimal units of bits or bytes."""
    return format_quantity(bits, Dimension.DATA)


def format_count(count: int) -> str:
    """A whole number with separated thousands.

    >>> format_count(67584)
    '67,584'
    """
    return f"{count:,}"


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """A number with its noun, in the singular for 1.

    >>> counted(1, "event"), counted(2000, "event"), counted(2, "local maximum", "local maxima")
    ('1 event', '2,000 events', '2 local maxima')
    """
    return f"{format_count(count)} {noun if count == 1 else plural or noun + 's'}"


def edge(cycles: int, hertz: int) -> int:
    """The time of clock edge number ``cycles``, ps: ceil(cycles · 10^12 / hertz), from absolute counts.

    No periods are summed, so nothing drifts: at 150 MHz a cycle is 6666.67 ps, and every third edge is exact.
    Edge 0 is at time 0.

    >>> [edge(cycles, 150_000_000) for cycles in range(4)]
    [0, 6667, 13334, 20000]
    """
    return -(-cycles * PICOSECONDS_PER_SECOND // hertz)


def cycles_by(picoseconds: int, hertz: int) -> int:
    """The number of the last edge at or before a time: the inverse of ``edge``.

    ``cycles_by(edge(n, hertz), hertz) == n`` for every clock up to ``MAX_FREQUENCY``.

    >>> cycles_by(19_999, 150_000_000), cycles_by(20_000, 150_000_000)
    (2, 3)
    """
    return picoseconds * hertz // PICOSECONDS_PER_SECOND
