"""The numbers that laws are written over: whole numbers, arrays, and sums of monomials of named inputs.

A law uses ``+``, ``*``, ``/`` and ``ceil_div`` alone. Whole numbers and arrays have these operations; ``Sum`` gives
them to symbols.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from codesign.ground.figures import Figure
from codesign.ground.memo import Same

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


Interval = tuple[float, float]


def power_of(value: Any, power: int) -> Any:
    """A whole power, by products alone: of a number and of an array to the same last bit. 0 to a negative one: inf."""
    product: Any = 1.0
    for _ in range(abs(power)):
        product = product * value
    if power >= 0:
        return product
    if isinstance(product, float):
        return float(1.0 / product) if product else math.copysign(math.inf, product)
    with np.errstate(divide="ignore"):
        return np.divide(1.0, product)


@dataclass(frozen=True)
class Monomial:
    """``amount`` times powers of inputs, times a quotient that is rounded up, where it has one.

    >>> Monomial(2.0, {"clock": -1, "setup": 1}, 10, ("width",)).at({"clock": 4.0, "setup": 3.0, "width": 4.0})
    4.5
    """

    amount: Annotated[float, Field(description="the factor that is no input")]
    powers: Annotated[dict[str, int], Field(description="the exponent of each input, by name")]
    divide: Annotated[
        int, Field(description="divided by the product of the inputs in by, rounded up; 0: no factor")
    ] = 0
    by: Annotated[tuple[str, ...], Field(description="names of inputs; see divide")] = ()

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of its inputs, each once."""
        return tuple(dict.fromkeys((*self.powers, *self.by)))

    def at(self, values: Mapping[str, Any]) -> Any:
        """Its value where each input has the given one: a number, or an array where the inputs are arrays."""
        product: Any = self.amount
        for name, power in self.powers.items():
            product = product * power_of(values[name], power)
        if self.divide:
            product = product * quotient_of(self, values)
        return product

    def bounds(self, inputs: Mapping[str, Figure]) -> Interval:
        """The least and the greatest value inside the intervals of the inputs."""
        return Ends(inputs).of(self, key_of(self))


class Ends:
    """The least and the greatest value of monomials inside the intervals of inputs. Each factor is computed once."""

    def __init__(self, inputs: Mapping[str, Figure]) -> None:
        self._inputs = inputs
        self._factors: dict[tuple[str, int], Interval] = {}
        self._monomials: dict[Any, Interval] = {}
        self._sums: dict[Any, Interval] = {}

    def of_sum(self, plan: Iterable[Monomial]) -> Interval:
        """The bounds of a sum."""
        plan = tuple(plan)
        key = tuple(map(key_of, plan))
        if key not in self._sums:
            low: Any = 0.0
            high: Any = 0.0
            for monomial, own in zip(plan, key, strict=True):
                least, most = self.of(monomial, own)
                low, high = low + least, high + most
            self._sums[key] = low, high
        return self._sums[key]

    def of(self, monomial: Monomial, key: Any) -> Interval:
        """The bounds of a monomial. ``key``: see ``key_of``."""
        if key not in self._monomials:
            low: Any = monomial.amount
            high: Any = monomial.amount
            for name, power in monomial.powers.items():
                factor = self._factor(name, power)
                low, high = low * factor[0], high * factor[1]
            if monomial.divide:
                falls = {name: monomial.powers.get(name, -1) < 0 for name in monomial.by}
                low = low * quotient_of(monomial, {name: self._end(name, falls[name]) for name in falls})
                high = high * quotient_of(monomial, {name: self._end(name, not falls[name]) for name in falls})
            self._monomials[key] = low, high
        return self._monomials[key]

    def _factor(self, name: str, power: int) -> Interval:
        if (name, power) not in self._factors:
            falls = power < 0
            ends = power_of(self._end(name, falls), power), power_of(self._end(name, not falls), power)
            self._factors[name, power] = ends
        return self._factors[name, power]

    def _end(self, name: str, high: bool) -> Any:
        return self._inputs[name].interval[high]


def key_of(monomial: Monomial) -> Any:
    """The key of all that its bounds depend on besides the inputs."""
    amount = monomial.amount
    own = Same(amount) if isinstance(amount, np.ndarray) else amount
    return own, tuple(monomial.powers.items()), monomial.divide, monomial.by


def quotient_of(monomial: Monomial, values: Mapping[str, Any]) -> Any:
    """The quotient of a monomial, rounded up, of a number as of an array."""
    quotient = monomial.divide / math.prod((values[name] for name in monomial.by), start=1.0)
    return -(-quotient // 1)
