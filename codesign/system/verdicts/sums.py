"""The margin between sums of products of inputs: its least value over a box, and where one input changes its sign.

The greatest value of a difference is computed in three steps. An input that moves all its products towards the same
side takes that end. Of the rest, inputs that appear together form a group. Where a group is linear in each input by
itself, with 1/x put for x where it divides, its greatest value lies at a corner. Whole numbers in a quotient that is
rounded up are tried one by one. Other groups are bounded product by product: the bound holds, but may not be reached.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import chain
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.figures import Figure
from codesign.laws import Monomial
from codesign.system.results.result import Result
from codesign.system.results.terms import is_edges

MOST_CORNERS = 1 << 16
"""Most combinations of values that are tried for inputs that appear together."""
MOST_WHOLE = 1024
"""Most values of one whole number that are tried."""
GRID = 257
"""Values at which a change of sign is looked for where no closed form gives it."""
ROUNDING = 1e-12
"""The share of its parts below which what remains of a difference is a rounding error."""

Sum = tuple[Monomial, ...]


class Input(NamedTuple):
    """One input, wherever it appears. Two results share it where all of this is the same.

    ``platform``: "" for a figure of a part or a law.
    """

    platform: str
    name: str
    value: float
    low: float
    high: float

    @property
    def measurable(self) -> bool:
        """True if it is a figure that somebody can measure, and not known yet."""
        return self.low < self.high and not is_edges(self.name)


class Bound(NamedTuple):
    """The least or the greatest value: reached where ``exact``, else a bound that holds."""

    value: float
    exact: bool


class Inputs:
    """The inputs of several results under names that are one only where the input is one."""

    def __init__(self) -> None:
        self.by_id: dict[str, Input] = {}
        self.figures: dict[str, Figure] = {}
        self._ids: dict[tuple[Input, int], str] = {}
        self._results: list[Result] = []

    def sums(self, result: Result, figure: str) -> tuple[Sum, ...]:
        """The sums that a figure of a result is the greatest of; none where it is no sum of terms."""
        if result.terms is None:
            return ()
        ids = {name: self._id(result, name, each) for name, each in result.terms.inputs.items()}
        return tuple(
            tuple(
                Monomial(
                    each.amount,
                    {ids[name]: power for name, power in each.powers.items()},
                    each.divide,
                    tuple(ids[name] for name in each.by),
                )
                for each in plan
            )
            for plan in _plans(result, figure)
        )

    def _id(self, result: Result, name: str, figure: Figure) -> str:
        """The name of an input. Figures of parts and laws are the same on every platform."""
        platform = "" if " " in name and not is_edges(name) else result.platform
        each = Input(platform, name, float(figure.value), *map(float, figure.interval))
        key = each, self._chain(result) if is_edges(name) else -1
        if key not in self._ids:
            self._ids[key] = identity = f"{len(self._ids)} {name}"
            self.by_id[identity], self.figures[identity] = each, figure
        return self._ids[key]

    def _chain(self, result: Result) -> int:
        """The first result with the same terms: only then the waits for edges are the same at any values."""
        same = (number for number, other in enumerate(self._results) if other.terms == result.terms)
        number = next(same, len(self._results))
        if number == len(self._results):
            self._results.append(result)
        return number


def _plans(result: Result, figure: str) -> tuple[Sum, ...]:
    assert result.terms is not None, "asked of a result with terms"
    if figure != "power":
        return result.terms.plans(figure)
    of_design = (draw for draw in result.terms.draws if draw.where == result.component and draw.when != "waiting")
    return (tuple(of_design),) if result.power is not None else ()


class Difference(ABC):
    """The excess of one side over the other, as a function of inputs."""

    inputs: Mapping[str, Input]

    @property
    @abstractmethod
    def reversed(self) -> Difference:
        """The same with the sides exchanged."""

    @property
    @abstractmethod
    def names(self) -> Iterable[str]:
        """The inputs that it depends on, in the order of their appearance."""

    @abstractmethod
    def at(self, values: Mapping[str, Any] | None = None) -> Any:
        """The margin where inputs have the given values (numbers or arrays), all others their own."""

    @abstractmethod
    def least(self) -> Bound:
        """The least margin inside all intervals."""

    def varying(self) -> tuple[str, ...]:
        """The inputs with an interval, in the order of their first appearance."""
        each = dict.fromkeys(self.names)
        return tuple(name for name in each if self.inputs[name].low < self.inputs[name].high)

    def swing(self, name: str) -> float:
        """The difference of the margin between the ends of one input's interval."""
        each = self.inputs[name]
        return float(abs(self.at({name: each.high}) - self.at({name: each.low})))

    def flip(self, name: str) -> float | None:
        """The value of one input nearest to its own at which the margin changes its sign; None: not in its interval."""
        each = self.inputs[name]
        below, above = (np.linspace(each.value, end, GRID) for end in (each.low, each.high))
        return min(
            (flip for side in (below, above) if (flip := self._bisected(name, side)) is not None),
            key=lambda flip: abs(flip - each.value),
            default=None,
        )

    def _bisected(self, name: str, side: NDArray[np.float64]) -> float | None:
        holds = np.broadcast_to(self.at({name: side}) >= 0, side.shape)
        changes = np.flatnonzero(holds != holds[0])
        if not len(changes):
            return None
        near, far = float(side[changes[0] - 1]), float(side[changes[0]])
        for _ in range(100):
            middle = (near + far) / 2
            near, far = (middle, far) if (self.at({name: middle}) >= 0) == holds[0] else (near, middle)
        return far


@dataclass(frozen=True)
class Margin(Difference):
    """The excess of the greatest of ``theirs`` over the greatest of ``ours``."""

    ours: tuple[Sum, ...]
    theirs: tuple[Sum, ...]
    inputs: Mapping[str, Input]

    @property
    def reversed(self) -> Margin:
        """The same with the sides exchanged."""
        return Margin(self.theirs, self.ours, self.inputs)

    def at(self, values: Mapping[str, Any] | None = None) -> Any:
        """The margin where inputs have the given values (numbers or arrays), all others their own."""
        full = {name: each.value for name, each in self.inputs.items()} | dict(values or {})
        return greatest_of(self.theirs, full) - greatest_of(self.ours, full)

    def least(self) -> Bound:
        """The least margin inside all intervals.

        With several sums on a side it is a bound: one of theirs must exceed each of ours everywhere by itself.
        """
        excess = [min(_greatest((*one, *_negated(other)), self.inputs) for other in self.theirs) for one in self.ours]
        worst = max(excess)
        several = len(self.ours) > 1 or len(self.theirs) > 1
        return Bound(-worst.value, worst.exact and not several)

    @property
    def names(self) -> Iterable[str]:
        """The inputs of all monomials."""
        return chain.from_iterable(each.inputs for plan in (*self.ours, *self.theirs) for each in plan)

    def flip(self, name: str) -> float | None:
        """The value of one input nearest to its own at which the margin changes its sign; None: not in its interval."""
        each, monomials = self.inputs[name], list(chain.from_iterable((*self.ours, *self.theirs)))
        if any(name in one.by for one in monomials):
            return self._first_flip(name, _whole_numbers(each) or ())
        exponents = {one.powers[name] for one in monomials if name in one.powers}
        if len(self.ours) == len(self.theirs) == 1 and len(exponents) == 1:
            return self._root(name, exponents.pop())
        return super().flip(name)

    def _root(self, name: str, power: int) -> float | None:
        """The root of a margin c + d · x^power, by c and d at two values of x^power."""
        each = self.inputs[name]
        ends = each.low, each.high
        (low, high), margins = ((end**power for end in ends), [float(self.at({name: end})) for end in ends])
        if margins[0] == margins[1] or (margins[0] < 0) == (margins[1] < 0):
            return None
        share = margins[0] / (margins[0] - margins[1])
        return float((low + share * (high - low)) ** (1 / power))

    def _first_flip(self, name: str, values: Iterable[float]) -> float | None:
        holds = self.at() >= 0
        nearest = sorted(values, key=lambda value: abs(value - self.inputs[name].value))
        return next((value for value in nearest if (self.at({name: value}) >= 0) != holds), None)


def greatest_of(sums: Sequence[Sum], values: Mapping[str, Any]) -> Any:
    """The greatest of several sums where inputs have these values."""
    totals = [sum(each.at(values) for each in plan) for plan in sums]
    return reduce(np.maximum, totals)


def _negated(plan: Sum) -> Sum:
    return tuple(Monomial(-each.amount, each.powers, each.divide, each.by) for each in plan)


def _greatest(plan: Sum, inputs: Mapping[str, Input]) -> Bound:
    """The greatest value of a sum inside the intervals of its inputs."""
    values = {name: each.value for name, each in inputs.items() if each.low == each.high}
    rest = _folded(plan, values)
    while ends := _ends(rest, values, inputs):
        values |= ends
        rest = _folded(rest, values)
    bounds = [_greatest_at_corners(group, values, inputs) for group in _groups(rest, values)]
    return Bound(math.fsum(bound.value for bound in bounds), all(bound.exact for bound in bounds))


def _folded(plan: Sum, values: Mapping[str, float]) -> Sum:
    """The same sum with the known inputs in the amounts, and one monomial for each product of the others."""
    sums: dict[Any, tuple[float, float, Monomial]] = {}
    for each in plan:
        left = {name: power for name, power in each.powers.items() if name not in values}
        inner = Monomial(each.amount, {name: power for name, power in each.powers.items() if name in values})
        divide, by = each.divide, each.by
        if all(name in values for name in by):
            inner, divide, by = Monomial(each.amount, inner.powers, each.divide, each.by), 0, ()
        amount = float(inner.at(values))
        key = frozenset(left.items()), divide, by
        total, size, _ = sums.get(key, (0.0, 0.0, None))
        sums[key] = total + amount, size + abs(amount), Monomial(total + amount, left, divide, by)
    return tuple(each for total, size, each in sums.values() if abs(total) > ROUNDING * size)


def _ends(plan: Sum, values: Mapping[str, float], inputs: Mapping[str, Input]) -> dict[str, float]:
    """The end of its interval for each input that moves all monomials towards the same side."""
    moves = [(name, (power > 0) == (each.amount > 0)) for each in plan for name, power in each.powers.items()]
    moves += [(name, each.amount < 0) for each in plan for name in each.by]
    directions = map_reduce(moves, itemgetter(0), itemgetter(1), set)
    return {
        name: inputs[name].high if sides == {True} else inputs[name].low
        for name, sides in directions.items()
        if len(sides) == 1 and name not in values
    }


def _groups(plan: Sum, values: Mapping[str, float]) -> list[Sum]:
    """The monomials apart by the inputs that they share."""
    groups: list[tuple[set[str], list[Monomial]]] = []
    for each in plan:
        names, members = set(each.inputs) - set(values), [each]
        apart = []
        for others, monomials in groups:
            if others & names:
                names, members = names | others, monomials + members
            else:
                apart.append((others, monomials))
        groups = [*apart, (names, members)]
    return [tuple(members) for _, members in groups]


def _greatest_at_corners(group: Sum, values: Mapping[str, float], inputs: Mapping[str, Input]) -> Bound:
    names = [name for name in dict.fromkeys(chain.from_iterable(each.inputs for each in group)) if name not in values]
    candidates = [_candidates(group, name, inputs[name]) for name in names]
    corners = math.prod(len(each or ()) for each in candidates)
    if any(each is None for each in candidates) or corners > MOST_CORNERS:
        return Bound(math.fsum(_most(each, values, inputs) for each in group), False)
    grids = np.meshgrid(*(np.array(each, np.float64) for each in candidates), indexing="ij")
    full = {**values, **{name: grid.ravel() for name, grid in zip(names, grids, strict=True)}}
    return Bound(float(np.max(sum(each.at(full) for each in group))), True)


def _candidates(group: Sum, name: str, each: Input) -> tuple[float, ...] | None:
    """The values of an input among which the greatest sum of a group lies; None where there are too many."""
    if any(name in one.by for one in group):
        return _whole_numbers(each)
    exponents = {one.powers[name] for one in group if name in one.powers}
    return (each.low, each.high) if len(exponents) == 1 else None


def _whole_numbers(each: Input) -> tuple[float, ...] | None:
    few = each.high - each.low < MOST_WHOLE
    return tuple(map(float, range(int(each.low), int(each.high) + 1))) if few else None


def _most(each: Monomial, values: Mapping[str, float], inputs: Mapping[str, Input]) -> float:
    """The greatest value of one monomial."""
    full = dict(values)
    for name in each.inputs:
        if name not in values:
            rises = (each.powers.get(name, -1) > 0) == (each.amount > 0)
            full[name] = inputs[name].high if rises else inputs[name].low
    return float(each.at(full))
