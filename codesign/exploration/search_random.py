"""The search that draws at random."""

from __future__ import annotations

import random
from collections.abc import Sequence

from codesign.exploration.constraints import Floats
from codesign.exploration.search import ExcludedBox, Problem

_MOST_SHUFFLED = 2**20


class RandomSearch:
    """Designs drawn at random, each at most once, all alike."""

    name = "random"
    batch = 50
    endless = True
    repeated = 0
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
