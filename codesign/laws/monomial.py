"""A product of powers of inputs, at any values and inside the intervals of its inputs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from codesign.ground.figures import Figure
from codesign.ground.memo import Same

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
