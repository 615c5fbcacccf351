"""The quality of a potential for a robot that follows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import Problem, Quality, judge_arrival, judge_paths
from codesign.planners.relaxation.plan.parameters import DEFAULT_METHOD, Boundary, Method
from codesign.planners.relaxation.plan.run import End
from codesign.planners.relaxation.plan.search import Search
from codesign.planners.relaxation.plan.solve import Solution, solve

MOST_TRIED = 1 << 17
"""Cells of the largest map on which a warning tries its proposals: a fraction of a second."""

LEAST_NORMAL = float(np.finfo(np.float64).tiny)
"""Below it doubles lose digits, 1e-308, and below 5e-324 they are 0."""

ANOTHER_PLANNER = "take planner harmonic with more bits, or wavefront"


def quality(problem: Problem, search: Search, solution: Solution) -> Quality:
    """The quality of following ``search`` over the potential of ``solution`` on ``problem``.

    ``local_maxima`` counts the cells from which no step leads on: flat areas, where neighbouring doubles are equal;
    cells that the run did not reach before its end; and cells where its errors are larger than the slope. ``warnings``
    has a sentence where cells lead nowhere, whether or not the run converged. ``wrong_cells`` does not apply: doubles
    settle at no exact value.

    Raises:
        InputError: a start is not in a free cell.
    """
    cells = search.reachable & ~search.goal
    lost = cells & ~search.arriving()
    count = int(cells.sum())
    descents = ((start, search.follow(start)) for start in problem.starts)
    paths = ((start, descent.cells if descent.arrived else None) for start, descent in descents)
    return Quality(
        local_maxima=int(search.flat().sum()),
        wrong_cells=None,
        warnings=(_warning(problem, solution, lost, count),) if lost.any() else (),
        **judge_arrival(count - int(lost.sum()), count),
        **judge_paths(problem, paths),
    )


def _warning(problem: Problem, solution: Solution, lost: NDArray[np.bool_], count: int) -> str:
    """The number of cells that lead nowhere, the cause, and the remedy."""
    nowhere = int(lost.sum())
    tenths = 1000 * nowhere // count
    share = f"{tenths / 10:g} %" if tenths else "under 0.1 %"
    cause, advice = _cause(solution, lost)
    begun = {End.CONVERGED: "converged, but ", End.STAGNATED: "stagnated: "}.get(solution.ended, "")
    return f"{begun}{nowhere:,} of {count:,} cells ({share}) lead nowhere: {cause}; {advice or _mend(problem)}"


def _cause(solution: Solution, lost: NDArray[np.bool_]) -> tuple[str, str]:
    """The cause why cells lead nowhere, and the remedy; "" where the defaults may be the remedy."""
    if solution.ended is End.LIMIT:
        return "the run met its bound on iterations", "raise max_iterations"
    if solution.method is Method.HALF_SWEEP_AM:
        return "half sweeps see a passage one cell wide as closed, and errors may exceed the slope", ""
    if solution.boundary is Boundary.HIGH_WALLS:
        return "next to 1 doubles lie 1e-16 apart, and far cells differ by less", ""
    if max(solution.omega or 1.0, solution.r or 1.0) > 1.0:
        shown = "" if solution.r is None else f", r = {solution.r:g}"
        cause = f"over-relaxation (ω = {solution.omega:g}{shown}) leaves errors larger than the potential of far rooms"
        return cause, ""
    return _cause_without_over_relaxation(solution, lost)


def _cause_without_over_relaxation(solution: Solution, lost: NDArray[np.bool_]) -> tuple[str, str]:
    wall, _ = solution.boundary.values
    depth = float(np.abs(solution.potential[lost] - wall).min())
    by_tolerance = solution.method is not Method.DIRECT and solution.checks == 0
    if by_tolerance and depth == 0.0:
        return "the run ended before values came to far cells", ""
    if depth < LEAST_NORMAL:
        return "far potentials are below the least double of full precision", ""
    return "neighbouring doubles are equal, or differ by less than the error", ""


def _mend(problem: Problem) -> str:
    """The remedy: the defaults, else the direct solver, else another planner; tried on this map if it is small."""
    defaults = "leave method, omega, r, tolerance and boundary out"
    if problem.free.size > MOST_TRIED:
        return f"{defaults}, or {ANOTHER_PLANNER}"
    for method, advice in (
        (DEFAULT_METHOD, defaults),
        (Method.DIRECT, "take method direct, and leave omega, r, tolerance and boundary out"),
    ):
        tried = solve(problem.free, problem.goals, method=method)
        search = Search(tried.potential, problem.free, problem.goals)
        if not (search.reachable & ~search.arriving()).any():
            return f"{advice}: then every cell of this map leads to a goal"
    return f"{ANOTHER_PLANNER}: on this map neither the defaults nor method direct lead from every cell"
