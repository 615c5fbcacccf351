"""Which runs of the relaxation lead from everywhere, and what they take.

The defaults were chosen in view of the two shipped maps and of one goal on each real map. Held out: the goals that are
drawn here on the real maps, and all generated maps but the labyrinth. Real maps are read from ``shared/maps`` beside
the repository; where they are absent, the others stand alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.maps import OccupancyGrid, reachable
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.paper.measures import GOAL, floor_plan
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE
from codesign.planners.relaxation.plan.parameters import RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER

REAL = Path(__file__).parents[1].parent / "shared" / "maps"
REAL_MAPS = {
    "arena": "movingai/dao/arena.map",
    "Berlin": "movingai/cities/Berlin_0_256.map",
    "16room": "movingai/rooms/16room_000.map",
    "maze512-32": "movingai/mazes/maze512-32-0.map",
    "maze-128-2": "movingai/mapf/maze-128-128-2.map",
    "warehouse": "movingai/mapf/warehouse-10-20-10-2-1.map",
    "random-64": "movingai/mapf/random-64-64-20.map",
    "room-64": "movingai/mapf/room-64-64-16.map",
    "empty-32": "movingai/mapf/empty-32-32.map",
    "nav2 depot": "ros/nav2/depot.yaml",
    "turtlebot3": "ros/turtlebot3/map.yaml",
    "lse_arena": "ros/willow/lse_arena.yaml",
}
GENERATED: dict[str, Callable[[], OccupancyGrid]] = {
    "rooms 180×240": lambda: maps.rooms(180, 240, room=(17, 23), door=2, seed=11, extra_doors=0.2),
    "maze 100×140": lambda: maps.maze(100, 140, corridor=3, wall=1, seed=12, loops=0.1),
    "random 150×150": lambda: maps.random_obstacles(150, 150, density=0.35, seed=13, size=2),
    "spiral 60×60": lambda: maps.spiral(60, 60, corridor=4, wall=1),
}
GOALS, STARTS = 3, 64
GOALS_SEED = 8
MOST_ITERATIONS = 20_000
"""A run to the tolerance is cut here, so that this benchmark ends."""

TO_TOLERANCE: dict[str, Any] = {
    "tolerance": PUBLISHED_TOLERANCE,
    "boundary": "low_goal",
    "max_iterations": MOST_ITERATIONS,
}
CANDIDATES: dict[str, dict[str, Any]] = {
    "default": {},
    "gs, by descents": {"method": "gs"},
    "direct": {"method": "direct"},
    "gs to 1e-15": {"method": "gs", **TO_TOLERANCE},
    **{f"sor {omega} to 1e-15": {"method": "sor", "omega": omega, **TO_TOLERANCE} for omega in (1.2, 1.5, 1.8, 1.95)},
    "am 1.5 to 1e-15": {"method": "am", "omega": 1.5, **TO_TOLERANCE},
    "am 1.97 to 1e-15": {"method": "am", "omega": 1.97, **TO_TOLERANCE},
    "mam 1.975, 1.92 to 1e-15": {"method": "mam", "omega": 1.975, "r": 1.92, **TO_TOLERANCE},
}


def cases() -> Iterator[tuple[str, NDArray[np.bool_], list[tuple[int, int]]]]:
    """Maps with their goals, which are drawn except on the shipped maps."""
    labyrinth = maps.maze(72, 132, corridor=6, wall=1, loops=0.15, seed=1).free
    yield "labyrinth", labyrinth, [(3, 128)]
    yield "floor plan", floor_plan(), [GOAL]
    for name, make in GENERATED.items():
        free = make().free
        yield name, free, goals_of(free)
    for name, file in REAL_MAPS.items():
        if (REAL / file).is_file():
            free = maps.read_map(REAL / file).free
            yield name, free, goals_of(free)


def goals_of(free: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Goals from which at least half of the free cells can be reached."""
    random, cells, found = np.random.default_rng(GOALS_SEED), np.argwhere(free), []
    while len(found) < GOALS:
        row, column = (int(value) for value in cells[random.integers(len(cells))])
        if 2 * reachable(free, [(row, column)]).sum() >= free.sum():
            found.append((row, column))
    return found


def run() -> list[dict[str, str]]:
    """A row for each map and candidate; figures over several goals are the worst of them."""
    for chosen in CANDIDATES.values():
        _worst(np.ones((9, 9), np.bool_), [(4, 4)], chosen)  # compiles the kernels
    rows = []
    for map_name, free, goals in cases():
        for name, chosen in CANDIDATES.items():
            rows.append({"map": map_name, "run": name, **_worst(free, goals, chosen)})
    return rows


def _worst(free: NDArray[np.bool_], goals: list[tuple[int, int]], chosen: dict[str, Any]) -> dict[str, str]:
    parameters = RelaxParameters.model_validate(chosen)
    shares, lost, iterations, seconds, ratios, clearances = [], [], [], [], [], []
    for goal in goals:
        cells = np.argwhere(reachable(free, [goal]))
        picked = cells[np.random.default_rng(2).integers(0, len(cells), STARTS)]
        problem = Problem(free, (goal,), tuple((int(row), int(column)) for row, column in picked))
        # The processor's time: other work beside this changes it less than it changes the time that passes.
        began = time.process_time()
        plan = PLANNER.plan(Job(problem, parameters))
        seconds.append(time.process_time() - began)
        quality = PLANNER.quality(problem, plan)
        shares.append(quality.share_reaching_goal or 0.0)
        lost.append(quality.cells_leading_nowhere or 0)
        iterations.append(plan.solution.iterations)
        ratios.append(quality.path_length_ratio_mean or np.nan)
        clearances.append(quality.clearance_mean or np.nan)
    return {
        "share that arrives": f"{np.floor(1000 * min(shares)) / 10:g} %",
        "cells that lead nowhere": f"{max(lost):,}",
        "iterations": f"{max(iterations):,}",
        "ms": f"{1e3 * max(seconds):.3g}",
        "path length ratio": f"{np.nanmean(ratios):.3f}",
        "clearance": f"{np.nanmean(clearances):.3g}",
    }
