"""Searches: which designs of a space to evaluate, where the space is too large to evaluate all of them.

A search asks for designs and is told what came of them. All searches have one interface, so that they are compared at
the same number of evaluations. Designs are numbers of the enumeration of the decisions (``Space.values``).
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from codesign.errors import InputError, choose_hint
from codesign.exploration.constraints import Flags, Floats

if TYPE_CHECKING:
    from codesign.exploration.bounds import Bounds
    from codesign.exploration.space import Space

MOST_SEED = 2**32 - 1
"""The greatest seed that every generator of random numbers takes."""

_MOST_SHUFFLED = 2**20


@dataclass(frozen=True)
class Problem:
    """What is searched.

    - ``decisions``: the space of the designs. ``objectives``: their names; ``maximise``: of each, whether more is
      better. ``limits``: the names of the amounts by which a design may break a limit.
    - ``bounds``: gives bounds of the objectives over boxes of axes; None where no law is known.
    """

    decisions: Space
    objectives: tuple[str, ...]
    maximise: tuple[bool, ...]
    limits: tuple[str, ...]
    bounds: Bounds | None = None


class Search(Protocol):
    """Says which designs to evaluate next.

    Every design that is asked for is told of, in the same order, before the next ones are asked for. The same seed and
    the same answers give the same questions.
    """

    name: str
    endless: bool
    """Whether a budget has to end it, as it would go on until it has asked for every design."""

    @property
    def complete(self) -> bool:
        """Whether every design was asked for or excluded."""

    @property
    def excluded(self) -> Sequence[ExcludedBox]:
        """The boxes that were proved to hold no design of the front; most searches prove nothing."""

    @property
    def batch(self) -> int:
        """How many designs the search asks for at once, where it may choose."""

    def ask(self, count: int) -> list[int]:
        """At most so many designs; one may be known already. Empty: the search is at its end."""

    def tell(self, designs: Sequence[int], objectives: Floats, excess: Floats) -> None:
        """What came of the designs that were asked for.

        Args:
            designs: as they were asked for.
            objectives: float64, designs × objectives; NaN: a design that lacks a figure, or is not feasible.
            excess: float64, designs × limits: the amount by which a limit is broken, relative to it; 0: it is kept.
                NaN: the design failed.
        """


@dataclass(frozen=True)
class ExcludedBox:
    """A box of designs that holds none of the front, though not all of them were evaluated.

    - ``part``: the number of the box of the space (``Space.boxes``) that it is a part of. ``low``, ``high``: of each
      axis of that box, the places of its values there: from ``low`` to before ``high``.
    - ``bound``: by name, the least value over the box of each objective, or of the figure of a constraint (the greatest
      of one that is maximised); None where another reason excludes it. ``by``: the evaluated design that dominates the
      bound, strictly better in one objective; None: another reason.
    - ``why``: ``dominated``; ``fit``: no design of it fits, or too few starts arrive; ``clock``: the clock of all is
      above its limit; ``constraint NAME``: the bound breaks it; ``lacks NAME``: no design of it has this figure.
    """

    part: int
    low: tuple[int, ...]
    high: tuple[int, ...]
    bound: Mapping[str, float] | None
    by: int | None
    why: str

    @property
    def designs(self) -> int:
        """How many designs are in the box."""
        return math.prod(high - low for low, high in zip(self.low, self.high, strict=True))

    def axes(self, decisions: Space) -> dict[str, tuple[Any, ...]]:
        """The values of each axis that exists in the box."""
        own = decisions.boxes[self.part].axes
        return {
            axis: tuple(decisions.axes[axis][number] for number in numbers[low:high])
            for (axis, numbers), low, high in zip(own.items(), self.low, self.high, strict=True)
        }


@dataclass(eq=False)
class Trace:
    """What a search did.

    - ``name``, ``seed``: of the search. ``designs``: those that it evaluated, each once, in their order.
    - ``repeated``: how often it asked for one again; that costs nothing.
    - ``excluded``: see ``Search.excluded``. ``ended``: why it ended; ``proved``: no other design is on the front.
    """

    name: str
    seed: int
    designs: list[int] = field(default_factory=list)
    repeated: int = 0
    excluded: tuple[ExcludedBox, ...] = ()
    ended: str = ""
    proved: bool = False


@dataclass(frozen=True, eq=False)
class Searched:
    """What searches made of a space: the chosen one first, then random search beside it.

    ``simulated``: how many simulations they took together. ``kept``: points that were found in the store.
    """

    traces: tuple[Trace, ...]
    simulated: int
    kept: int

    @property
    def excluded(self) -> tuple[ExcludedBox, ...]:
        """The boxes that the chosen search excluded."""
        return self.traces[0].excluded

    @property
    def proved(self) -> bool:
        """Whether the chosen search proved the front."""
        return self.traces[0].proved


class RandomSearch:
    """Designs drawn at random, each at most once, all alike."""

    name = "random"
    batch = 50
    endless = True
    excluded: tuple[ExcludedBox, ...] = ()

    def __init__(self, problem: Problem, seed: int) -> None:
        self._generator = random.Random(seed)
        self._size = len(problem.decisions)
        self._asked: set[int] = set()
        # A short list is shuffled; of a long one, hardly any draw was drawn before.
        self._order: list[int] | None = None
        if self._size <= _MOST_SHUFFLED:
            self._order = self._generator.sample(range(self._size), self._size)

    @property
    def complete(self) -> bool:
        """Whether all designs were drawn."""
        return len(self._asked) == self._size

    def ask(self, count: int) -> list[int]:
        """Designs that were not asked for before; fewer where no others are left."""
        if self._order is not None:
            begin = len(self._asked)
            drawn = self._order[begin : begin + count]
            self._asked.update(drawn)
            return drawn
        drawn = []
        while len(drawn) < min(count, self._size - len(self._asked)):
            design = self._generator.randrange(self._size)
            if design not in self._asked:
                self._asked.add(design)
                drawn.append(design)
        return drawn

    def tell(self, designs: Sequence[int], objectives: Floats, excess: Floats) -> None:
        """Nothing is learned."""


def _nsga2(problem: Problem, seed: int) -> Search:
    from codesign.exploration.search_optuna import nsga2

    return nsga2(problem, seed)


def _tpe(problem: Problem, seed: int) -> Search:
    from codesign.exploration.search_optuna import tpe

    return tpe(problem, seed)


def _bound(problem: Problem, seed: int) -> Search:
    from codesign.exploration.search_bound import BoundSearch

    del seed  # nothing is drawn
    return BoundSearch(problem)


SEARCHES: Mapping[str, Callable[[Problem, int], Search]] = {
    "nsga2": _nsga2,
    "tpe": _tpe,
    "random": RandomSearch,
    "bound": _bound,
}
"""Every search by its name: what makes one for a problem and a seed."""


def check_search(name: str, seed: int) -> None:
    """Refuse a search that does not exist, and a seed that is none.

    Raises:
        InputError: with the nearest name.
    """
    if name not in SEARCHES:
        raise InputError(f"there is no search {name}", "search", choose_hint(name, SEARCHES))
    if not 0 <= seed <= MOST_SEED:
        raise InputError(f"{seed} is no seed", "seed", f"give a whole number from 0 to {MOST_SEED}")


def search_of(name: str, problem: Problem, seed: int) -> Search:
    """A search by its name.

    Raises:
        InputError: there is none of this name; it needs a package that is not installed; or nothing to search.
    """
    check_search(name, seed)
    if len(problem.decisions) < 2:
        what = "there is nothing to search: the workload has one design"
        raise InputError(what, "search", "give an axis a second value")
    return SEARCHES[name](problem, seed)


def comparable(objectives: Floats, excess: Floats) -> Flags:
    """Which designs keep every limit and have every objective."""
    return np.asarray((excess <= 0).all(axis=1) & ~np.isnan(objectives).any(axis=1))
