"""What a potential is worth to a robot that follows it."""

from __future__ import annotations

from codesign.planners.interface import Problem, Quality
from codesign.planners.relaxation.search import Search
from codesign.planners.ways import judge_ways, share_of


def quality(problem: Problem, search: Search) -> Quality:
    """The quality of following ``search`` on ``problem``.

    ``local_maxima`` counts the cells from which no step leads on: flat areas, where neighbouring doubles are equal, or
    cells that the run ended too early for. ``wrong_cells`` does not apply: doubles settle at no exact value.

    Raises:
        InputError: a start is not in a free cell.
    """
    cells = search.reachable & ~search.goal
    count = int(cells.sum())
    found = ((start, search.follow(start)) for start in problem.starts)
    ways = ((start, way.cells if way.arrived else None) for start, way in found)
    return Quality(
        reachable_cells=count,
        planned_cells=count,
        local_maxima=int(search.flat().sum()),
        share_reaching_goal=share_of(int((search.arriving() & cells).sum()), count),
        wrong_cells=None,
        **judge_ways(problem, ways),
    )
