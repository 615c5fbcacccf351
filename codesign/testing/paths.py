"""Rules of a planner on maps: which cells lead to a goal, which paths it gives, and their quality."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.planners.quality import Quality
from codesign.testing.case import Case, Rule, on_maps, require, rule


def _dense(points: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Points along the path, ``samples`` for each piece of it."""
    return np.concatenate([np.linspace(a, b, samples) for a, b in pairwise(points)] or [points])


def _cell(point: NDArray[np.float64]) -> tuple[int, int]:
    row, column = (int(value) for value in np.floor(point + 0.5))
    return row, column


def _is_path(points: Any, begin: tuple[float, float]) -> None:
    require(points.dtype == np.float64, f"a path has points of {points.dtype}, not float64")
    require(points.ndim == 2 and points.shape[1] == 2, f"a path has shape {points.shape}, not n × 2")
    require(tuple(points[0]) == begin, f"a path from {begin} begins at {tuple(points[0].tolist())}")


@rule(on_maps)
def reachable_cells_lead_to_a_goal(case: Case) -> None:
    """``reachable`` covers the goals, free cells only, and every start from which a path arrives."""
    problem = case.problem
    reachable: Any = case.planner.reachable(case.job)
    require(
        reachable.dtype == np.bool_ and reachable.shape == problem.free.shape,
        f"reachable gives {reachable.dtype} {reachable.shape}, not bool {problem.free.shape}",
    )
    require(all(reachable[goal] for goal in problem.goals), "reachable leaves out a goal")
    require(not (reachable & ~problem.free).any(), "reachable covers an obstacle")
    for start in problem.starts:
        arrived = case.planner.trajectory(problem, case.plan, start)[1]
        require(reachable[start] or not arrived, f"a path from {start} arrives, but reachable leaves the cell out")


@rule(on_maps)
def quality_is_of_this_problem(case: Case) -> None:
    """Counts of ``quality`` are within the problem's counts, and its figures agree with each other."""
    problem = case.problem
    quality = case.planner.quality(problem, case.plan)
    assert isinstance(quality, Quality), "quality of a map is a Quality"
    reachable = int(case.planner.reachable(case.job).sum()) - len(problem.goals)
    require(
        quality.reachable_cells == reachable,
        f"quality counts {quality.reachable_cells} reachable cells, reachable gives {reachable} besides the goals",
    )
    for name, count, most in (
        ("planned_cells", quality.planned_cells, quality.reachable_cells),
        ("wrong_cells", quality.wrong_cells, quality.reachable_cells),
        ("starts_arrived", quality.starts_arrived, quality.starts),
    ):
        require(count is None or 0 <= count <= most, f"{name} is {count}, beyond 0 to {most}")
    share = quality.share_reaching_goal
    require(share is None or 0.0 <= share <= 1.0, f"share_reaching_goal is {share}")
    if share is not None and quality.local_maxima is not None:
        require(
            (quality.local_maxima == 0) == (share == 1.0),
            f"{quality.local_maxima} local maxima, but a share of {share} that reaches a goal",
        )
    require(quality.starts == len(problem.starts), f"quality tries {quality.starts} starts of {len(problem.starts)}")
    if quality.starts_arrived:
        mean, worst = quality.path_length_ratio_mean, quality.path_length_ratio_worst
        require(mean is not None and worst is not None, "starts arrive, but no ratio of lengths is given")
        assert mean is not None
        assert worst is not None
        require(worst >= mean > 0.9, f"path length ratios {mean} (mean) and {worst} (worst) cannot be")
        room, least = quality.clearance_mean, quality.clearance_least
        require(room is not None and least is not None, "starts arrive, but no clearance is given")
        assert room is not None
        assert least is not None
        require(room >= least >= 1.0, f"clearances {room} (mean) and {least} (least) cannot be")


@rule(on_maps)
def trajectories_stay_in_free_space(case: Case) -> None:
    """Every point of a path lies in a free cell, and a path arrives if and only if it ends at a goal."""
    planner, problem = case.planner, case.problem
    arrivals = 0
    for start in problem.starts:
        points, arrived = planner.trajectory(problem, case.plan, start)
        _is_path(points, (float(start[0]), float(start[1])))
        # Points between the samples count too: ten steps between each pair.
        cells = np.floor(_dense(points, 11) + 0.5).astype(int)
        require(problem.free[cells[:, 0], cells[:, 1]].all(), f"the path from {start} leaves free space")
        require(
            arrived == (_cell(points[-1]) in problem.goals),
            f"the path from {start} says {arrived} for its arrival, and ends in cell {_cell(points[-1])}",
        )
        arrivals += arrived
    counted: Any = planner.quality(problem, case.plan)
    require(arrivals == counted.starts_arrived, f"{arrivals} paths arrive, quality counts {counted.starts_arrived}")


@rule(on_maps)
def paths_from_any_position_keep_to_free_cells(case: Case) -> None:
    """``path_from`` begins at the position, agrees with ``trajectory`` in the middle of a cell, and ends at a goal."""
    planner, problem = case.planner, case.problem
    random = np.random.Generator(np.random.PCG64(3))
    for start in problem.starts[:12]:
        middle, arrived = planner.path_from(problem, case.plan, (float(start[0]), float(start[1])))
        for off in random.uniform(-0.49, 0.49, (8, 2)):
            position = (start[0] + float(off[0]), start[1] + float(off[1]))
            points, there = planner.path_from(problem, case.plan, position)
            _is_path(points, position)
            require(there == arrived, f"a path from {position} arrives: {there}; from its cell: {arrived}")
            dense = _dense(points, 41)
            cells = np.floor(dense + 0.5).astype(int)
            # The corner of an obstacle lies on the edge of a cell: only points inside of an obstacle count.
            inside = np.abs(dense - cells).max(axis=1) < 0.5 - 1e-9
            free = problem.free[cells[inside, 0], cells[inside, 1]].all()
            require(free, f"the path from {position} leaves free space")
            require(
                not there or _cell(points[-1]) in problem.goals,
                f"the path from {position} arrives at {_cell(points[-1])}, which is no goal",
            )
        if arrived:
            other = planner.trajectory(problem, case.plan, start)[0]
            same = middle.shape == other.shape and np.allclose(middle, other)
            require(same, f"path_from and trajectory give two paths from {start}")


@rule(on_maps)
def no_path_from_where_no_robot_can_be(case: Case) -> None:
    """From an obstacle and from outside of the map, ``path_from`` gives the position alone, and False."""
    obstacles = [(float(row), float(column)) for row, column in np.argwhere(~case.problem.free)[:1]]
    for position in (*obstacles, (-3.0, 2.0), (2.0, 1e6)):
        points, arrived = case.planner.path_from(case.problem, case.plan, position)
        require(
            points.tolist() == [list(position)] and not arrived,
            f"path_from gives a path from {position}, where no robot can be",
        )


RULES: tuple[Rule, ...] = (
    reachable_cells_lead_to_a_goal,
    quality_is_of_this_problem,
    trajectories_stay_in_free_space,
    paths_from_any_position_keep_to_free_cells,
    no_path_from_where_no_robot_can_be,
)
