"""The wavefront planner as a plug-in: the members of ``codesign.planners.interface.Planner``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError
from codesign.ground.models import Task, TaskParameters
from codesign.maps.reach import reachable
from codesign.planners.interface import (
    Cell,
    LoadParameters,
    Path,
    Planner,
    Problem,
    Quality,
    cell_of,
    corner_cut,
    from_position,
    judge_search,
)
from codesign.planners.job import Flow, Job
from codesign.planners.wavefront.plan.grid import check_cells
from codesign.planners.wavefront.plan.parameters import MAX_TILES, Course, Paths, PropagateParameters, TrackParameters
from codesign.planners.wavefront.plan.plan import (
    WavefrontPlan,
    cached_plan,
    compute_plan,
    sizing_plan,
    sizing_stops,
    waits,
)
from codesign.planners.wavefront.plan.tracking import Tracker
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits, run_wave


def quality(problem: Problem, plan: WavefrontPlan) -> Quality:
    """The quality of ``plan`` on ``problem``.

    The plan covers the cells that the wave reached before it ended. Each of them has a path, as equation 2 always finds
    a neighbour. So ``local_maxima`` is 0, and ``share_reaching_goal`` is 1 where the plan covers a cell. Cells beyond
    the wave have no path.

    Paths are tracked from the starts by the rule of the plan. A start beyond the wave of this plan is judged by the
    wave of its own request: up to a start, that wave has the same potentials as a wave to its own end. Lengths are
    octile. A path that cuts corners can be shorter than the shortest path that does not, so ratios below 1 occur. The
    mean clearance weighs every step by its length.
    """
    cells = reachable(problem.free, problem.goals, corner_cutting=plan.wave_map.neighbours.corner_cutting)
    potentials, tracker = reaching(problem, plan, problem.starts)
    followed = ((start, _followed(potentials, tracker, start)) for start in problem.starts)
    return judge_search(problem, cells, plan.potentials >= 0, followed)


def _followed(potentials: NDArray[np.int32], tracker: Tracker, start: Cell) -> Path:
    """The path from a cell; the cell alone where no wave came."""
    if potentials[start] < 0:
        return np.array([start], np.float64), False
    return tracker.follow(start).astype(np.float64), True


def reaching(problem: Problem, plan: WavefrontPlan, starts: Iterable[Cell]) -> tuple[NDArray[np.int32], Tracker]:
    """Potentials and tracker of the plan; where that wave stopped before some starts, of a wave to its own end."""
    if plan.stop_potential is None or all(plan.potentials[start] >= 0 for start in starts):
        return plan.potentials, plan.tracker
    sources = np.array(problem.goals, np.int64)
    potentials, _ = run_wave(plan.wave_map, sources, np.zeros((0, 2), np.int64))
    return potentials, Tracker(plan.wave_map, potentials, plan.obstacle_potentials)


CELL_BITS = 2
"""F and Z of a cell."""

NEXT_BITS = POSE_BITS = 64
"""A cell of the path: row and column, 32 bits each."""


class Wavefront(Planner):
    """Shortest and safe paths by a wave: tasks ``load``, ``propagate`` and ``track``."""

    name = "wavefront"
    planning_task = "propagate"
    tasks: Mapping[str, type[TaskParameters]] = {
        "load": LoadParameters,
        "propagate": PropagateParameters,
        "track": TrackParameters,
    }
    description = "shortest and safe paths by a wave of delays 2 and 3 (Möller and Paschke 1998)"

    def check(self, job: Job[Problem, PropagateParameters]) -> tuple[str, str] | None:
        """A wave that waits for a start must reach it, and the number of tiles is limited."""
        problem, parameters = job.problem, job.parameters
        if parameters.tile is not None:
            height, width = parameters.tile
            count = parameters.tile_count(*problem.shape)
            if count > MAX_TILES:
                return "tile", f"{count:,} tiles of {height} × {width} nodes, more than {MAX_TILES:,}"
        try:
            for each in dict.fromkeys((problem, problem.changed)):
                cached_plan(each, parameters, each.starts if waits(each, parameters) else ())
        except MapError as fault:
            return "stop", fault.what
        return None

    def task_text(self, task: Task) -> str:
        """A wave from the goals, until it reaches the start that asks or to its own end."""
        if task is Task.FIELD:
            return "a wave from the goals to its own end, whatever stop says, leaves a potential in every cell"
        after = " on the changed map" if task is Task.REPLAN else ""
        own = f"each start is a wave of its own{after}, from the goals until it reaches that start"
        return f"{own}; with stop: whole_map one wave serves every start"

    def plans_for_start(self, job: Job[Problem, PropagateParameters]) -> bool:
        """A wave that waits for a start ends there."""
        return waits(job.problem, job.parameters)

    def answer_class(self, job: Job[Problem, PropagateParameters], start: Cell) -> int:
        """The steps that are tracked and sent."""
        plan, parameters = job.plan, job.parameters
        most = parameters.steps if parameters.course is Course.LOCAL else None
        return -1 if plan.potentials[start] < 0 else len(plan.tracker.follow(start, most))

    def reachable(self, job: Job[Problem, PropagateParameters]) -> NDArray[np.bool_]:
        """The wave passes between two obstacles that touch at a corner where it may cut corners."""
        problem = job.problem
        return reachable(problem.free, problem.goals, corner_cutting=job.parameters.corner_cutting)

    def plan(self, job: Job[Problem, PropagateParameters]) -> WavefrontPlan:
        """Run the wave without a clock."""
        return compute_plan(job.problem, job.parameters)

    def flows(self, job: Job[Problem, PropagateParameters]) -> tuple[Flow, ...]:
        """The map, F and Z of every cell; the potentials; the path of the first start, a cell at a time.

        A local course sends its next ``steps`` cells at every pose. A complete course sends all cells of the path.
        Where the wave cannot reach a start, as in a drive that begins walled in, the sizes belong to a wave that
        does not wait for the start.
        """
        problem, parameters = job.problem, job.parameters
        stops = problem.starts[:1] if sizing_stops(problem, parameters) else ()
        cells, plan = problem.free.size, cached_plan(problem, parameters, stops)
        local = parameters.course is Course.LOCAL
        steps = parameters.steps if local else self._steps(problem, plan)
        return (
            Flow("load", "propagate", "map", CELL_BITS * cells),
            Flow("propagate", "track", "potentials", value_bits(problem, parameters) * cells),
            *([Flow("load", "track", "pose", POSE_BITS)] if local else []),
            Flow("track", "command", "way", NEXT_BITS * steps),
        )

    def check_drive(self, job: Job[Problem, PropagateParameters]) -> tuple[str, str, str] | None:
        """A robot cannot drive along a path between two obstacles that touch at a corner."""
        return corner_cut(job.parameters.corner_cutting)

    def horizon(self, job: Job[Any, PropagateParameters]) -> int | None:
        """The steps of a local course."""
        parameters = job.parameters
        return parameters.steps if parameters.course is Course.LOCAL else None

    def _steps(self, problem: Problem, plan: WavefrontPlan) -> int:
        """Steps of the path of the first start; at least 1, as a robot on the goal gets its own cell."""
        if not problem.starts or plan.potentials[problem.starts[0]] < 0:
            return 1
        return max(1, len(plan.tracker.follow(problem.starts[0])) - 1)

    def memory(self, job: Job[Problem, PropagateParameters]) -> int:
        """Measured: 56 bytes a cell on maps of 2^20 to 2^24 cells (map, distances, labels, paths)."""
        return 56 * job.problem.free.size

    def quality(self, problem: Problem, plan: WavefrontPlan) -> Quality:
        """The quality of the paths."""
        return quality(problem, plan)

    def identity(self, plan: WavefrontPlan) -> str:
        """The digest of the potentials and the rule of the paths."""
        return plan.digest

    def figures(self, plan: WavefrontPlan) -> dict[str, Any]:
        """The reach of the wave, and the width of register that it needs."""
        details: dict[str, Any] = {
            "largest_potential": plan.largest_potential,
            "reached_cells": plan.reached_cells,
            "register_bits_needed": register_bits(plan.largest_potential),
        }
        if plan.stop_potential is not None:
            details["stop_potential"] = plan.stop_potential
        return {"details": details}

    def trajectory(self, problem: Problem, plan: WavefrontPlan, start: Cell) -> Path:
        """The path from ``start`` by the rule of the plan; ``start`` alone where no wave comes.

        A start beyond the wave of this plan gets the path of a request of its own.

        Raises:
            MapError: a start outside of the map or on an obstacle.
        """
        check_cells([start], problem.free, "start")
        return _followed(*reaching(problem, plan, (start,)), start)

    def field_of(self, plan: WavefrontPlan) -> tuple[str, str, NDArray[np.float64]]:
        """The potentials, 2 a straight step unless the delays say otherwise; infinite where the wave did not come."""
        return "potential", "1", np.where(plan.potentials >= 0, plan.potentials, np.inf)

    def path_from(self, problem: Problem, plan: WavefrontPlan, start: tuple[float, float]) -> Path:
        """The path from a position, by the rule of the plan from its cell; none where the wave did not come."""
        cell = cell_of(problem, start)
        if cell is None or plan.potentials[cell] < 0:
            return np.array([start], np.float64), False
        return from_position(start, plan.tracker.follow(cell), problem.free), True


def value_bits(problem: Problem, parameters: PropagateParameters) -> int:
    """Bits of a cell that tracking reads: its register, and for safe paths also p^d."""
    bits = parameters.register_bits
    if bits is None:
        bits = register_bits(sizing_plan(problem, parameters).largest_potential)
    if parameters.paths is Paths.SAFE:
        bits += register_bits(longest_distance(problem.shape, parameters.delays))
    return bits


PLANNER = Wavefront()
