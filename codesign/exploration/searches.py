"""Every search by its name, and the one that draws at random."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence

from codesign.errors import InputError
from codesign.exploration.constraints import Floats
from codesign.exploration.search import ExcludedBox, Problem, Search
from codesign.exploration.search_bound import BoundSearch
from codesign.exploration.search_optuna import nsga2, tpe
from codesign.inputs.searching import Searching

_MOST_SHUFFLED = 2**20


class RandomSearch:
    """Designs drawn at random, each at most once, all alike."""

    name = "random"
    batch = 50
    endless = True
    excluded: tuple[ExcludedBox, ...] = ()

    def __init__(self, problem: Problem, searching: Searching) -> None:
        self._generator = random.Random(searching.seed)
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


SEARCHES: Mapping[str, Callable[[Problem, Searching], Search]] = {
    "nsga2": nsga2,
    "tpe": tpe,
    "random": RandomSearch,
    "bound": lambda problem, _searching: BoundSearch(problem),
}
"""Every search by its name (``Searching.sampler``): what makes one for a problem and options."""


def search_of(searching: Searching, problem: Problem) -> Search:
    """The search that is asked for.

    Raises:
        InputError: it needs a package that is not installed; or nothing to search.
    """
    if len(problem.decisions) < 2:
        what = "there is nothing to search: the workload has one design"
        raise InputError(what, "search", "give an axis a second value")
    return SEARCHES[searching.sampler](problem, searching)
