"""What a field is worth to a robot: where it leads, how long the ways are, how close to the walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.decision import Rule
from codesign.planners.harmonic.fixed_point import Field
from codesign.planners.harmonic.trajectory import DEFAULT_STEP, Ascent, Trajectory
from codesign.planners.interface import Problem, Quality

_CONSECUTIVE_ITERATIONS = 64


def quality(
    problem: Problem,
    field: Field,
    *,
    rule: Rule | str = Rule.TRIANGLE,
    step: float = DEFAULT_STEP,
) -> Quality:
    """The quality of ``field`` on ``problem``: depends on nothing else, so it may be kept by their digests.

    ``share_reaching_goal`` is that of the cell-by-cell ascent. Ways are those of the guarded robot
    (``trajectory.Ascent``) from ``problem.starts``; a start on a goal counts as arrived and has no ratio.
    The mean clearance weighs every piece of way by its length.

    ``wrong_cells`` are those that change when the field is relaxed on under sound termination: none where the
    run was sound, some where the published termination ended a stage early.

    Raises:
        MapError: a goal cannot be used. InputError: a start is not in a free cell, or another argument
            cannot be used.
    """
    from codesign.maps.reach import clearance, distance_octile, reachable

    ascent = Ascent(field, problem.free, problem.goals, rule=rule, step=step)
    cells = reachable(problem.free, problem.goals) & ~ascent.goal
    count = int(cells.sum())
    ways = [(start, ascent.follow(start)) for start in problem.starts]
    arrived = [(start, way) for start, way in ways if way.arrived]
    ratios: list[float] = []
    spans: list[tuple[float, float, float]] = []
    if arrived:
        shortest = distance_octile(problem.free, problem.goals)
        room = clearance(problem.free)
        ratios = [way.length / float(shortest[start]) for start, way in arrived if shortest[start] > 0.0]
        spans = [_clearance(way, room) for _, way in arrived]
    length = sum(span[1] for span in spans)
    return Quality(
        reachable_cells=count,
        local_maxima=int((cells & (ascent.best < 0)).sum()),
        share_reaching_goal=float((ascent.climbs_to_goal() & cells).sum() / count) if count else 1.0,
        starts=len(ways),
        starts_arrived=len(arrived),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        clearance_mean=sum(span[0] for span in spans) / length if length > 0.0 else None,
        clearance_least=min((span[2] for span in spans), default=None),
        wrong_cells=wrong_cells(problem, field),
    )


def wrong_cells(problem: Problem, field: Field) -> int:
    """Cells whose value differs from the least fixed point at the field's precision.

    A run from below that ended early is still below that fixed point, so relaxing it on leads there and nowhere else
    (monotone from below); where nothing is wrong that takes a single sweep.
    """
    from codesign.planners.harmonic.relax import stage_cost

    whole = problem.rows, problem.columns
    _, settled = stage_cost(
        problem.free, problem.goals, field, field.precision, block=whole, iterations=_CONSECUTIVE_ITERATIONS
    )
    return int((settled.limbs != field.limbs).any(axis=2).sum())


def _clearance(way: Trajectory, room: NDArray[np.float64]) -> tuple[float, float, float]:
    """Clearance summed along a way, the way's length, and the least clearance, all in cells."""
    cells = np.floor(way.points + 0.5).astype(np.int64)
    at_points = room[cells[:, 0], cells[:, 1]]
    pieces = np.sqrt((np.diff(way.points, axis=0) ** 2).sum(axis=1))
    along = float((pieces * (at_points[:-1] + at_points[1:]) / 2.0).sum())
    return along, float(pieces.sum()), float(at_points.min())
