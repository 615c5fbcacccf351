"""Every search by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from codesign.errors import InputError
from codesign.exploration.search import Problem, Search
from codesign.exploration.search_bound import BoundSearch
from codesign.exploration.search_optuna import nsga2, tpe
from codesign.exploration.search_random import RandomSearch
from codesign.inputs.searching import Searching

SEARCHES: Mapping[str, Callable[[Problem, Searching], Search]] = {
    "nsga2": nsga2,
    "tpe": tpe,
    "random": lambda problem, searching: RandomSearch(problem, searching.seed),
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
