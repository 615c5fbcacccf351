"""Units of products and quotients: the powers of the base units in them, which arithmetic checks and makes."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from types import MappingProxyType

from codesign.units import PICOSECONDS_PER_SECOND, SCALES, Dimension

Powers = tuple[tuple[str, Fraction], ...]
"""Base unit and its power, which is not 0, by the name of the unit; empty of a plain number."""

NUMBER: Powers = ()

_POWERS: Mapping[Dimension, Mapping[str, int]] = MappingProxyType(
    {
        Dimension.TIME: {"s": 1},
        Dimension.FREQUENCY: {"s": -1},
        Dimension.DATA: {"b": 1},
        Dimension.DATA_RATE: {"b": 1, "s": -1},
        Dimension.POWER: {"J": 1, "s": -1},
        Dimension.ENERGY: {"J": 1},
        Dimension.LENGTH: {"m": 1},
        Dimension.CURRENT: {"A": 1},
        Dimension.VOLTAGE: {"J": 1, "s": -1, "A": -1},
        Dimension.SPEED: {"m": 1, "s": -1},
        Dimension.ACCELERATION: {"m": 1, "s": -2},
        Dimension.TURN_RATE: {"rad": 1, "s": -1},
        Dimension.MONEY: {"USD": 1},
        Dimension.RATE: {"s": -1},
    }
)
_OWN: Mapping[str, tuple[Fraction, Powers]] = MappingProxyType(
    {
        "1": (Fraction(1), NUMBER),
        "%": (Fraction(1, 100), NUMBER),
        "bits": (Fraction(1), (("b", Fraction(1)),)),
        "cells": (Fraction(1), (("cells", Fraction(1)),)),
    }
)
"""Units of figures that no quantity of a spec has, and the percent."""


def times(left: Powers, right: Powers, sign: int = 1) -> Powers:
    """The powers of a product; with ``sign`` -1, of a quotient."""
    powers = dict(left)
    for unit, power in right:
        powers[unit] = powers.get(unit, Fraction(0)) + sign * power
    return tuple(sorted((unit, power) for unit, power in powers.items() if power))


def raised(powers: Powers, power: Fraction) -> Powers:
    """The powers of a power; of a square root with 1/2."""
    return tuple((unit, each * power) for unit, each in powers if power)


@cache
def known_units() -> Mapping[str, tuple[Fraction, Powers]]:
    """The size in base units, and the powers, of every unit that has one word or one sign in it."""
    units = dict(_OWN)
    for dimension, scale in SCALES.items():
        powers = tuple(sorted((unit, Fraction(power)) for unit, power in _POWERS[dimension].items()))
        per_base = PICOSECONDS_PER_SECOND if dimension is Dimension.TIME else 1
        units |= {unit: (size / per_base, powers) for unit, size in scale.units.items()}
    return MappingProxyType(units)


def unit_text(powers: Powers) -> str:
    """A unit as people write it: the unit of a quantity where one fits, else its base units.

    >>> unit_text((("J", Fraction(1)), ("s", Fraction(1)))), unit_text((("J", Fraction(1)), ("s", Fraction(-1))))
    ('J s', 'W')
    >>> unit_text((("J", Fraction(1, 2)), ("s", Fraction(-2))))
    'J^(1/2) / s^2'
    """
    bases = {scale.base for dimension, scale in SCALES.items() if dimension is not Dimension.TIME}
    named = {powers: unit for unit, (size, powers) in known_units().items() if size == 1 and unit in bases}
    if powers in named or not powers:
        return named.get(powers, "1")
    above = [_power_text(unit, power) for unit, power in powers if power > 0]
    below = [f"/ {_power_text(unit, -power)}" for unit, power in powers if power < 0]
    return " ".join([*above, *below])


def _power_text(unit: str, power: Fraction) -> str:
    """A unit and its power, as an expression reads it behind a number."""
    if power == 1:
        return unit
    return f"{unit}^{power}" if power.denominator == 1 else f"{unit}^({power})"
