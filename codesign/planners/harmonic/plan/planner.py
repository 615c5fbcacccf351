"""Harmonic control as a ``Planner``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.ground.models import TaskParameters
from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.arguments import MAX_BLOCKS
from codesign.planners.harmonic.plan.fixed_point import Field, limbs_needed
from codesign.planners.harmonic.plan.layout import plane_bytes
from codesign.planners.harmonic.plan.parameters import (
    MAX_PRECISION,
    DecideParameters,
    DetectParameters,
    LowerBoundParameters,
    Pockets,
    RelaxParameters,
    Start,
    Stop,
    Termination,
)
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.relax import HarmonicPlan, relax, stage_cost
from codesign.planners.harmonic.plan.trajectory import DEFAULT_STEP, Ascent, Rule
from codesign.planners.interface import (
    LOWER_BOUND,
    Cell,
    LoadParameters,
    MapWork,
    Path,
    Planner,
    Policy,
    Problem,
    Quality,
    by_sides,
    cell_of,
    judge_arrival,
    judge_paths,
)
from codesign.planners.job import Flow, Job
from codesign.planners.map_flood import CELL_KERNEL, MAP_KERNEL, WALL_KERNEL, beside_walls

FILL = "fill pockets"
"""The work of the sender, in records and terms."""


def sent_map(problem: Problem, parameters: RelaxParameters) -> NDArray[np.bool_]:
    """The free cells of the map as it is sent to the planner: bool, rows × columns.

    With ``pockets: filled`` the sender turns pockets into obstacles. No value of any other cell depends on that.
    """
    if parameters.pockets is Pockets.KEPT:
        return problem.free
    return reachable(problem.free, problem.goals)


def run_arguments(problem: Problem, parameters: RelaxParameters) -> dict[str, Any]:
    """The arguments of ``relax`` and ``work`` for a problem, on the map that is sent."""
    return {
        "free": sent_map(problem, parameters),
        "goals": problem.goals,
        "block": parameters.block_shape(*problem.shape),
        "iterations": parameters.iterations,
        "schedule": parameters.precisions,
        "termination": parameters.termination,
        "stop_without_local_maxima": parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
        "promote_after": parameters.promote_after,
    }


def fill_work(problem: Problem, parameters: RelaxParameters) -> tuple[MapWork, ...]:
    """The work of the sender that fills the pockets: a flood from the goals; none where it sends the map as it is.

    The flood pops every cell with a path to a goal once. What it leaves is sent as an obstacle.
    """
    if parameters.pockets is Pockets.KEPT:
        return ()
    reached = sent_map(problem, parameters)
    walls = int((reached & beside_walls(problem.free)).sum())
    return (
        MapWork(FILL, MAP_KERNEL, problem.free.size),
        MapWork(FILL, CELL_KERNEL, int(reached.sum())),
        MapWork(FILL, WALL_KERNEL, walls),
    )


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


CELL_BITS = 2
"""A cell of the map on its way to the planner: free, obstacle or goal."""

DIRECTION_BITS = POSE_BITS = 64
"""Two components of 32 bits."""

VALUES_AT_ONCE = 3
"""Fields of 64-bit limbs in memory at the same time: the last one, the current one, and the one handed on."""

FOLLOWING_BYTES = 32
"""Bytes a cell for the map, its labels, and the directions up the field."""

BOUND_BYTES = 1800
"""Bytes a cell for the sparse factors and the long integers of a lower bound; see ``warm_start.MAX_UNKNOWNS``."""

_ascents: WeakKeyDictionary[HarmonicPlan, tuple[str, Ascent]] = WeakKeyDictionary()


class Harmonic(Planner):
    """Block-synchronous harmonic control.

    Tasks: ``load``, ``lower_bound`` (where it is mapped), ``relax`` with ``detect``, ``decide``.
    """

    name = "harmonic"
    description = "A potential without local maxima, relaxed block by block at rising precision; Girau et al. 2008"
    planning_task = "relax"
    tasks: Mapping[str, type[TaskParameters]] = {
        "load": LoadParameters,
        "lower_bound": LowerBoundParameters,
        "relax": RelaxParameters,
        "detect": DetectParameters,
        "decide": DecideParameters,
    }
    policies: tuple[Policy, ...] = ("restart", "lower_bound", "continue")

    def check(self, job: Job[Problem, RelaxParameters]) -> tuple[str, str] | None:
        """The number of equal blocks is required to be possible for the map, and not too large; a start has its task.

        A block larger than the map is a partial block: its rest is obstacle.
        """
        problem, parameters = job.problem, job.parameters
        if parameters.start is Start.LOWER_BOUND and job.mapped and LOWER_BOUND not in job.mapped:
            return "start", f"lower_bound is made by task {LOWER_BOUND}, which no component is given"
        height, width = parameters.block_shape(*problem.shape)
        if parameters.blocks is not None:
            parted = -(-problem.rows // height), -(-problem.columns // width)
            if parted != parameters.blocks:
                wanted = f"{parameters.blocks[0]} × {parameters.blocks[1]}"
                size = f"{problem.rows} × {problem.columns}"
                sentence = f"{wanted} equal blocks do not part a map of {size} cells: blocks of {height} × {width} "
                return "blocks", f"{sentence}nodes make {parted[0]} × {parted[1]}, or {parted[0] * parted[1]}"
        count = parameters.block_count(*problem.shape)
        if count > MAX_BLOCKS:
            key = "block" if parameters.block is not None else "blocks"
            return key, f"{count:,} blocks of {height} × {width} nodes, more than {MAX_BLOCKS:,}"
        return None

    def plans_for_start(self, _job: Job[Problem, RelaxParameters], /) -> bool:
        """The field leads from every cell."""
        return False

    def answer_class(self, _job: Job[Problem, RelaxParameters], _start: Cell, /) -> str:
        """A decision takes as long at one cell as at another."""
        return "decision"

    def arrival_changes(self, job: Job[Problem, RelaxParameters]) -> dict[str, dict[str, dict[str, Any]]]:
        """More bits in the last stage, up to sixteen times as many; the sound end of a stage."""
        parameters = job.parameters
        last = parameters.precisions[-1]
        # Doublings, with a value between each two.
        ends = sorted({min(last * factor // 2, MAX_PRECISION) for factor in (3, 4, 6, 8, 12, 16, 24, 32)} - {last})
        changes: dict[str, dict[str, dict[str, Any]]] = {
            "schedule": {f"end at {end} bits": {"schedule": [*parameters.precisions, end]} for end in ends}
        }
        if parameters.termination is not Termination.SOUND:
            changes["termination"] = {"sound": {"termination": "sound"}}
        return changes

    def reachable(self, job: Job[Problem, RelaxParameters]) -> NDArray[np.bool_]:
        """A value spreads to the four neighbours of its cell."""
        return by_sides(job.problem)

    def map_work(self, job: Job[Problem, RelaxParameters]) -> tuple[MapWork, ...]:
        """A flood of the map where the sender fills pockets."""
        return fill_work(job.problem, job.parameters)

    def plan(self, job: Job[Problem, RelaxParameters]) -> HarmonicPlan:
        """Relax the field without a clock.

        Raises:
            InputError: the schedule is still left to a search.
        """
        if job.parameters.to_find:
            raise InputError("the best schedule is not known yet", "schedule", "bind platform and workload")
        return relax(**run_arguments(job.problem, job.parameters), record_visits=False)

    def flows(self, job: Job[Problem, RelaxParameters]) -> tuple[Flow, ...]:
        """The map, two bits a cell; a start and the field, p + 1 bits a cell at the last precision; a direction.

        The relaxation exchanges the flags of ``detect`` itself: see ``Exchange``.
        """
        parameters = job.parameters
        return self._flows(job.problem, parameters, parameters.precisions[-1])

    def flows_after(self, job: Job[Problem, RelaxParameters]) -> tuple[Flow, ...]:
        """The same as ``flows``, with the field at the precision of the plan: it may stop before the last one."""
        return self._flows(job.problem, job.parameters, job.plan.precision)

    def _flows(self, problem: Problem, parameters: RelaxParameters, reached: int) -> tuple[Flow, ...]:
        cells = problem.free.size
        return (
            Flow("load", "relax", "map", CELL_BITS * cells),
            Flow("load", "lower_bound", "map", CELL_BITS * cells),
            Flow("lower_bound", "relax", "start", cells * (parameters.precisions[-1] + 1)),
            Flow("relax", "decide", "field", cells * (reached + 1)),
            Flow("load", "decide", "pose", POSE_BITS),
            Flow("decide", "command", "direction", DIRECTION_BITS),
        )

    def memory(self, job: Job[Problem, RelaxParameters]) -> int:
        """Bit planes of all blocks and of the visited one, values in 64-bit limbs, and directions.

        Measured within a fifth on maps of 2^16 to 2^22 cells at 15 to 1023 bits, in blocks of 64 × 64 or as one.
        """
        problem, parameters = job.problem, job.parameters
        cells, precision = problem.free.size, parameters.precisions[-1]
        block = parameters.block_shape(*problem.shape)
        planes = precision * plane_bytes(problem.shape, block)
        values = VALUES_AT_ONCE * 8 * limbs_needed(precision) * cells
        bounds = BOUND_BYTES * cells if "lower_bound" in job.mapped else 0
        return planes + values + FOLLOWING_BYTES * cells + bounds

    def memory_levers(self, job: Job[Problem, RelaxParameters]) -> list[str]:
        """Fewer bits; and smaller blocks, as the visited block is kept several times."""
        problem = job.problem
        large = job.parameters.block_count(*problem.shape) < 8
        return ["a schedule that ends at fewer bits", *(["smaller blocks"] if large else [])]

    def quality(self, problem: Problem, plan: HarmonicPlan) -> Quality:
        """The quality of paths up the field."""
        return quality(problem, plan.field, from_below=plan.from_below)

    def identity(self, plan: HarmonicPlan) -> str:
        """The digest of the final field."""
        return plan.field.digest()

    def figures(self, plan: HarmonicPlan) -> dict[str, Any]:
        """The stages and the final precision; the fault of a field that did not settle."""
        stages = [{"stage": index, "cycles": stage.cycles, **asdict(stage)} for index, stage in enumerate(plan.stages)]
        figures: dict[str, Any] = {"stages": stages, "precision": plan.precision}
        return figures | ({"details": {"fault": plan.fault}} if plan.fault else {})

    def trajectory(self, problem: Problem, plan: HarmonicPlan, start: Cell) -> Path:
        """The path of a robot that follows the decision module from ``start``."""
        path = _ascent(problem, plan).follow(start)
        return path.points, path.arrived

    def start_of(self, plan: HarmonicPlan) -> Field:
        """The field."""
        return plan.field

    def path_from(self, problem: Problem, plan: HarmonicPlan, start: tuple[float, float]) -> Path:
        """The path of the guarded robot from a position: decided at the closest cell at every step (section 5.3)."""
        if cell_of(problem, start) is None:
            return np.array([start], np.float64), False
        path = _ascent(problem, plan).follow(start)
        return path.points, path.arrived


def _ascent(problem: Problem, plan: HarmonicPlan) -> Ascent:
    """The ascent of the field of a plan, made once for all positions."""
    entry = _ascents.get(plan)
    if entry is None or entry[0] != problem.map_digest:
        entry = _ascents[plan] = problem.map_digest, Ascent(plan.field, problem.free, problem.goals)
    return entry[1]


PLANNER = Harmonic()
