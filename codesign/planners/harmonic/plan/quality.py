"""The quality of a field for a robot: arrivals, lengths of paths, and distances to walls."""

from __future__ import annotations

from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.decision import Rule
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.relax import stage_cost
from codesign.planners.harmonic.plan.trajectory import DEFAULT_STEP, Ascent
from codesign.planners.interface import Problem, Quality, by_sides, judge_arrival, judge_paths

_CONSECUTIVE_ITERATIONS = 64
_converged = Memo(max_bytes=64 * 2**20)


def quality(
    problem: Problem,
    field: Field,
    *,
    rule: Rule | str = Rule.TRIANGLE,
    step: float = DEFAULT_STEP,
    from_below: bool = True,
) -> Quality:
    """The quality of ``field`` on ``problem``. It depends on nothing else, so it may be kept by their digests.

    ``share_reaching_goal`` belongs to the cell-by-cell ascent. The guarded robot (``trajectory.Ascent``) takes
    the paths, from ``problem.starts``. A start on a goal counts as arrived and has no ratio. The mean clearance weights
    every piece of a path by its length.

    ``wrong_cells``: 0 where the run was sound and its values began below. There may be some where the published
    termination ended a stage early, or where the values began above (not ``from_below``), as after an earlier plan.

    Raises:
        MapError: a goal is unusable. InputError: a start is not in a free cell, or another argument is unusable.
    """
    ascent = Ascent(field, problem.free, problem.goals, rule=rule, step=step)
    cells = by_sides(problem) & ~ascent.goal
    trajectories = ((start, ascent.follow(start)) for start in problem.starts)
    paths = ((start, trajectory.points if trajectory.arrived else None) for start, trajectory in trajectories)
    return Quality(
        local_maxima=int((cells & (ascent.best < 0)).sum()),
        wrong_cells=wrong_cells(problem, field, from_below=from_below),
        **judge_arrival(int((ascent.climbs_to_goal() & cells).sum()), int(cells.sum())),
        **judge_paths(problem, paths),
    )


def wrong_cells(problem: Problem, field: Field, *, from_below: bool = True) -> int | None:
    """The number of cells with a value other than the least fixed point at the precision of the field.

    A run from below that ended early is still below that fixed point. So relaxing it further leads there (monotone
    from below), with a single sweep where nothing is wrong. A run from above may have settled at another fixed point.
    So the least one is computed anew from a lower bound; None where the map is too large for that. It is one field for
    all runs on a map at one precision, so it is kept.
    """
    key = problem.map_digest, field.precision
    try:
        settled = _converged.get(key, lambda: _least_fixed_point(problem, field, from_below))
    except InputError:
        if from_below:
            raise
        return None
    return int((settled.limbs != field.limbs).any(axis=2).sum())


def _least_fixed_point(problem: Problem, field: Field, from_below: bool) -> Field:
    """Raises InputError: a run that began above, on a map that is too large for bounds."""
    if not from_below:
        return converged_field(problem.free, problem.goals, field.precision)
    _, settled = stage_cost(
        problem.free, problem.goals, field, field.precision, block=problem.shape, iterations=_CONSECUTIVE_ITERATIONS
    )
    return settled
