"""The numbers that laws are written over: whole numbers, arrays, and sums of monomials of named inputs.

A law uses ``+``, ``*``, ``/`` and ``ceil_div`` alone. Whole numbers and arrays have these operations; ``Sum`` gives
them to symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from codesign.laws.monomial import Monomial

Number = Any
"""A whole number, an int64 array or a ``Sum``. A law gives the kind of number that it is asked with."""


@dataclass(frozen=True)
class Sum:
    """A sum of products of inputs: what a law gives where its inputs are symbols.

    >>> width, clock = symbol("width"), symbol("clock")
    >>> ((ceil_div(100, width) + 3) / clock).at({"width": 32, "clock": 2.0})
    3.5

    Raises:
        TypeError: an operation has no sum of monomials as its result.
    """

    monomials: tuple[Monomial, ...]

    def at(self, values: Mapping[str, Any]) -> Any:
        """Its value where each input has the given one."""
        return sum(each.at(values) for each in self.monomials)

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of its inputs, each once."""
        return tuple(dict.fromkeys(name for each in self.monomials for name in each.inputs))

    def direction(self, name: str) -> int | None:
        """1 where the sum rises with an input, -1 where it falls, 0 without it; None where its parts differ.

        Amounts and inputs are at least 0.
        """
        signs = {_direction(each, name) for each in self.monomials} - {0}
        return None if len(signs) > 1 or None in signs else next(iter(signs), 0)

    def __add__(self, other: Number) -> Sum:
        return Sum(self.monomials + as_sum(other).monomials)

    def __mul__(self, other: Number) -> Sum:
        factors = as_sum(other).monomials
        return Sum(tuple(_product(one, factor) for one in self.monomials for factor in factors))

    def __truediv__(self, other: Number) -> Sum:
        (divisor,) = as_sum(other).monomials
        if divisor.divide:
            raise TypeError("one over a quotient is no monomial")
        inverse = Monomial(1, {name: -power for name, power in divisor.powers.items()})
        # A whole amount stays one where it can: 1 is left out.
        parts = [
            each if divisor.amount == 1 else replace(each, amount=each.amount / divisor.amount)
            for each in self.monomials
        ]
        return Sum(tuple(_product(each, inverse) for each in parts))

    def __radd__(self, other: Number) -> Sum:
        return as_sum(other) + self

    def __rmul__(self, other: Number) -> Sum:
        return as_sum(other) * self

    def __rtruediv__(self, other: Number) -> Sum:
        return as_sum(other) / self


def symbol(name: str) -> Sum:
    """An input as a number."""
    return Sum((Monomial(1, {name: 1}),))


def ceil_div(total: Number, unit: Number) -> Number:
    """ceil(total / unit). Of symbols: a whole number, or a quotient of it, divided by one input.

    >>> ceil_div(100, 32), ceil_div(ceil_div(100, symbol("width")), symbol("burst")).at({"width": 32, "burst": 3})
    (4, 2.0)
    """
    if isinstance(unit, Sum):
        return Sum((_quotient(total, unit),))
    return -(-total // unit)


def as_sum(number: Number) -> Sum:
    """A number as a sum: one without inputs is a monomial of its own."""
    return number if isinstance(number, Sum) else Sum((Monomial(number, {}),))


def _quotient(total: Number, unit: Sum) -> Monomial:
    """ceil(ceil(n / a) / b) = ceil(n / (a · b)) for whole numbers, so a quotient of a quotient is one quotient."""
    (divisor,) = unit.monomials
    if (divisor.amount, *divisor.powers.values()) != (1, 1) or divisor.divide:
        raise TypeError("a quotient by anything but one input is no monomial")
    (name,) = divisor.powers
    if not isinstance(total, Sum):
        return Monomial(1, {}, total, (name,))
    (quotient,) = total.monomials
    if quotient.amount != 1 or quotient.powers or not quotient.divide:
        raise TypeError("a quotient of anything but a whole number or a quotient is no monomial")
    return replace(quotient, by=(*quotient.by, name))


def _product(one: Monomial, other: Monomial) -> Monomial:
    if one.divide and other.divide:
        raise TypeError("a product of two quotients is no monomial")
    powers = dict(one.powers)
    for name, power in other.powers.items():
        powers[name] = powers.get(name, 0) + power
    kept = {name: power for name, power in powers.items() if power}
    by = one if one.divide else other
    # A whole amount stays one: 1 is left out.
    amount = one.amount if other.amount == 1 else other.amount if one.amount == 1 else one.amount * other.amount
    return Monomial(amount, kept, by.divide, by.by)


def _direction(each: Monomial, name: str) -> int | None:
    power = each.powers.get(name, 0)
    sign = (power > 0) - (power < 0)
    if name not in each.by or sign < 0:
        return -1 if name in each.by else sign
    return None if sign else -1
