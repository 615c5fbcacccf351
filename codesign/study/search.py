"""Searches: which designs of a space to evaluate, where the space is too large to evaluate all of them.

A search asks for designs and is told what came of them. All searches have one interface, so that they are compared at
the same number of evaluations. Designs are numbers of the enumeration of the decisions (``Space.values``).
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from codesign.study.constraints import Flags, Floats

if TYPE_CHECKING:
    from codesign.study.bounds import Bounds
    from codesign.study.space import Box, Space


@dataclass(frozen=True)
class Problem:
    """The problem of a search.

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
    """True if a budget has to end it, as it would go on until it has asked for every design."""

    @property
    def complete(self) -> bool:
        """True if every design was asked for or excluded."""

    @property
    def excluded(self) -> Sequence[Box]:
        """The boxes that were proved to hold no design of the front; most searches prove nothing."""

    @property
    def batch(self) -> int:
        """The number of designs that the search asks for at once, where it may choose."""

    @property
    def repeated(self) -> int:
        """The number of times that a design was suggested that had been asked for before."""

    def ask(self, count: int) -> list[int]:
        """At most so many designs, none of which was asked for before. Empty: the search is at its end."""

    def tell(self, designs: Sequence[int], objectives: Floats, excess: Floats) -> None:
        """Take the outcome of the designs that were asked for.

        Args:
            designs: as they were asked for.
            objectives: float64, designs × objectives; NaN: a design that lacks a figure, or is not feasible.
            excess: float64, designs × limits: the amount by which a limit is broken, relative to it; 0: it is kept.
                NaN: the design failed.
        """


@dataclass(eq=False)
class Trace:
    """The course of a search.

    - ``name``, ``seed``: of the search. ``designs``: the ones that it evaluated, each once, in their order.
    - ``repeated``: see ``Search.repeated``. ``excluded``: see ``Search.excluded``.
    - ``ended``: why it ended; ``proved``: no other design is on the front.
    - ``enumerated``: why all points were computed in its place, which has no ``designs`` of its own then; "": it ran.
    """

    name: str
    seed: int
    designs: list[int] = field(default_factory=list)
    repeated: int = 0
    excluded: tuple[Box, ...] = ()
    ended: str = ""
    proved: bool = False
    enumerated: str = ""


@dataclass(frozen=True, eq=False)
class Searched:
    """The result of searches of a space: the chosen one first, then random search beside it.

    ``simulated``: how many simulations they took together. ``kept``: points that were found in the store.
    """

    traces: tuple[Trace, ...]
    simulated: int
    kept: int

    @property
    def excluded(self) -> tuple[Box, ...]:
        """The boxes that the chosen search excluded."""
        return self.traces[0].excluded

    @property
    def proved(self) -> bool:
        """True if the chosen search proved the front."""
        return self.traces[0].proved


def comparable(objectives: Floats, excess: Floats) -> Flags:
    """The designs that keep every limit and have every objective."""
    return np.asarray((excess <= 0).all(axis=1) & ~np.isnan(objectives).any(axis=1))


_MOST_SHUFFLED = 2**20


class RandomSearch:
    """Designs drawn at random, each at most once, all alike."""

    name = "random"
    batch = 50
    endless = True
    repeated = 0
    excluded: tuple[Box, ...] = ()

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
        """True if all designs were drawn."""
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
