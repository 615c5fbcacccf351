"""The base class of planners, and their problem.

A planner maps arrays to arrays, exactly and without a clock. A ``PlugIn`` registers it. A planner of a user plugs in
the same way. The figures of the quality of plans stand here too; all grid planners share the figures of paths.
"""

from __future__ import annotations

import hashlib
import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple, Self, TypedDict

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from codesign.ground.figures import described
from codesign.ground.memo import Memo
from codesign.ground.models import SpecModel, Task, TaskParameters
from codesign.maps.reach import clearance, distance_octile, reachable
from codesign.planners.job import Flow, Job

# The quality of plans, as planners judge it.


@dataclass(frozen=True)
class Quality:
    """The quality of a plan.

    A plan need not cover every cell that leads to a goal: a wave is stopped, a search ends. Shares and local maxima
    count over the cells that it covers, ``planned_cells``. The plan says nothing about the other cells. A figure that
    does not apply to the planner is None. A length is None where no start arrives. A ratio is below 1 where a
    continuous path is shorter than the shortest path on the grid.
    """

    reachable_cells: Annotated[
        int, Field(description="free cells that the planner's own moves lead to a goal, goals left out")
    ]
    planned_cells: Annotated[
        int,
        Field(
            title="reachable cells that the plan covers",
            description="reachable cells that the plan covers: fewer where a wave was stopped, or a search ended,"
            " before it came to all of them",
        ),
    ]
    local_maxima: Annotated[
        int | None, Field(title="covered cells with no way up (local maxima)", description=described("local_maxima"))
    ]
    share_reaching_goal: Annotated[
        float | None,
        Field(title="share of covered cells that reach the goal", description=described("share_reaching_goal")),
    ]
    starts: Annotated[int, Field(description="starts tried")]
    starts_arrived: Annotated[int, Field(description="starts from which following the plan arrived")]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="length of the path over that of the shortest 8-connected path that cuts no corner; mean over"
            " the starts that arrived and that such a path joins to a goal",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    clearance_mean: Annotated[float | None, Field(title="clearance, mean", description=described("clearance_mean"))]
    clearance_least: Annotated[
        float | None,
        Field(title="clearance, least", description="the same, least, cells", json_schema_extra={"unit": "cells"}),
    ]
    wrong_cells: Annotated[int | None, Field(title="cells with a wrong value", description=described("wrong_cells"))]
    turning_mean: Annotated[
        float | None,
        Field(title="turning, mean", description=described("turning_mean"), json_schema_extra={"unit": "deg"}),
    ] = None
    optimal_length_mean: Annotated[
        float | None,
        Field(
            title="shortest path by the .scen file, mean",
            description="length of the shortest 8-connected path by the .scen file that goals and starts are from, mean"
            " over the starts, cells",
        ),
    ] = None
    optimal_length_error: Annotated[
        float | None,
        Field(
            title="shortest path against the .scen file, at most",
            description="difference of the shortest 8-connected path on this map and that length, the largest over the"
            " starts, cells: 0.005 or less on the map of the file",
        ),
    ] = None
    cells_leading_nowhere: Annotated[
        int | None,
        Field(
            title="cells that lead nowhere", description="planned cells from which following the plan does not arrive"
        ),
    ] = None
    warnings: Annotated[tuple[str, ...], Field(description="facts that qualify these figures, each with a remedy")] = ()


@dataclass(frozen=True)
class RobotsQuality:
    """The quality of the paths of several robots."""

    robots: Annotated[int, Field(description="robots")]
    robots_arrived: Annotated[int, Field(description="robots that reached their targets")]
    updates: Annotated[
        int,
        Field(
            title="updates of the velocities",
            description="updates of the velocities, until all arrived or the run was given up",
        ),
    ]
    collisions: Annotated[int, Field(title="pairs of robots that collided", description=described("collisions"))]
    closest_approach: Annotated[float, Field(description=described("closest_approach"))]
    time_to_targets_s: Annotated[
        float | None,
        Field(
            title="time until the last arrived, by the robots' clock",
            description=described("time_to_targets_s", "; None where none did"),
        ),
    ]
    velocity_changes: Annotated[
        int, Field(title="changes of velocity", description="updates at which a robot left the velocity it had")
    ]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="length of the path driven over that of the straight line, mean over the robots that arrived",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    shortfall: Annotated[
        str | None,
        Field(
            description="the robots that did not arrive, with the reason, or the value that left its word; None where"
            " all arrived"
        ),
    ] = None
    remedy: Annotated[
        str | None,
        Field(
            description="parameters with which a trial run brought all robots to their targets; None where no trial did"
        ),
    ] = None


Cell = tuple[int, int]
"""(row, column), from 0 at the top left."""

Path = tuple[NDArray[np.float64], bool]
"""A path: its points, float64 n × 2 (row, column) in cells, and whether it arrives."""

Policy = Literal["restart", "lower_bound", "continue"]
"""The way in which a planner replans when the map has changed.

- ``restart``: from nothing, as for the first plan.
- ``lower_bound``: from the result of the task ``lower_bound``, which is nowhere above the answer. The answer is the
  same.
- ``continue``: from the values of the last plan (``Planner.start_of``).
"""

BYTES_A_CELL = 64
"""Bytes of memory for each cell, for a planner that declares none. Assumed."""

LOAD, COMMAND = "load", "command"
"""Tasks that the flows of every planner may name besides its own: the source of the map, and the sink of the answer."""

MAP, POSE = "map", "pose"
"""The flow with the map, and the flow that asks for a decision at a pose; see ``Planner.flows``."""

LOWER_BOUND = "lower_bound"
"""The task that computes a start for policy ``lower_bound``. It runs only where it is mapped."""


@dataclass(frozen=True)
class MapChange:
    """The cells of a map that change: ``blocked`` become obstacles, ``freed`` become free."""

    blocked: tuple[Cell, ...] = ()
    freed: tuple[Cell, ...] = ()


@dataclass(frozen=True, eq=False)
class Problem:
    """One planning problem.

    - ``free``: bool array, rows × columns. ``resolution``: metres a cell, or None if the map declares none.
    - ``goals`` and ``starts``: (row, column) pairs on free cells. One request for a path comes from the first start.
      The others are requests of their own (``asked_from``). A design is sized for all of them.
    - ``task``: what is asked; of ``replan`` with the ``change``.

    The map may be cropped. A planner counts rows and columns from the first cell that is left, users from the whole
    map's. ``corner``: (row, column) of the first cell in the whole map; ``named`` takes a cell there. ``origin``:
    (x, y, yaw) of the lower left corner of what is left, or None.

    ``unknown``: bool, rows × columns, of the cells that the source of the map calls unknown, or None. No planner asks.

    ``reach``: the share of the free cells of the whole map from which a path across the sides of cells leads to a goal,
    or None. No planner asks.

    ``optimal_lengths``: of each start, the shortest 8-connected path by a ``.scen`` file, cells; empty without one.
    """

    free: NDArray[np.bool_]
    goals: tuple[tuple[int, int], ...]
    starts: tuple[tuple[int, int], ...]
    resolution: float | None = None
    task: Task = Task.PATH
    change: MapChange | None = None
    corner: Cell = (0, 0)
    origin: tuple[float, float, float] | None = None
    optimal_lengths: tuple[float, ...] = ()
    unknown: NDArray[np.bool_] | None = None
    reach: float | None = None

    def named(self, cell: Cell) -> Cell:
        """A cell as users count it, in the whole map."""
        return cell[0] + self.corner[0], cell[1] + self.corner[1]

    @property
    def rows(self) -> int:
        """Rows of the map."""
        return int(self.free.shape[0])

    @property
    def columns(self) -> int:
        """Columns of the map."""
        return int(self.free.shape[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return self.rows, self.columns

    @cached_property
    def digest(self) -> str:
        """SHA-256 over map, goals and starts: equal problems have equal digests, in every process."""
        text = f"{self.map_digest}{self.starts}{self.task}{self.change}"
        return hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def map_digest(self) -> str:
        """SHA-256 over map and goals: all that a plan depends on where it serves every start."""
        text = f"{self.free.shape}{self.goals}{self.resolution}"
        return hashlib.sha256(text.encode() + np.packbits(self.free).tobytes()).hexdigest()

    def asked_from(self, start: Cell) -> Self:
        """The same problem with ``start`` as its first: the request that comes from there."""
        starts = (start, *(each for each in self.starts if each != start))
        lengths = dict(zip(self.starts, self.optimal_lengths, strict=False))
        return replace(self, starts=starts, optimal_lengths=tuple(lengths[each] for each in starts if each in lengths))

    @cached_property
    def changed(self) -> Self:
        """The problem after its change, with the change back; the problem itself where it has none."""
        if self.change is None:
            return self
        free = self.free.copy()
        for cell in self.change.blocked:
            free[cell] = False
        for cell in self.change.freed:
            free[cell] = True
        back = MapChange(blocked=self.change.freed, freed=self.change.blocked)
        return replace(self, free=free, change=back)


_TASK_TEXTS = {
    Task.PATH: "one plan serves every start, and each start waits for its own answer",
    Task.FIELD: "the plan leads to a goal from every cell, and the component that decides receives it",
    Task.REPLAN: "a new plan of the whole changed map serves every start",
}


class MapWork(NamedTuple):
    """Work on the map before it is sent: ``what`` it is, in ``units`` of a ``kernel`` of its sender, a processor."""

    what: str
    kernel: str
    units: int


class LoadParameters(TaskParameters):
    """The task ``load``, which brings the map to the planner, has nothing to choose."""


class Planner(ABC):
    """A planner: its name, its tasks with their parameters, and its computation.

    - ``name``: its name in YAML. ``description``: one line for ``hwsw list``, without a full stop.
    - ``planning_task``: the task that computes the plan. Every mapping places it.
    - ``problem_model``: the model of a workload's problem, with a method ``problem()``; None: a map with goals and
      starts.
    - ``policies``: its replan policies; the first is the default.
    - ``answers_no_way``: True where "no path from this start" is an answer, not a fault.
    - ``fields_a_stage``: how many fields of one double a cell the records of one stage hold. A plan without stages
      (``TaskParameters.precisions``) counts as one.

    A method that is called before planning takes a ``Job``. A method about a plan takes the problem and the plan, or
    the plan alone.
    """

    name: str
    description: str
    planning_task: str
    problem_model: type[SpecModel] | None = None
    policies: tuple[Policy, ...] = ("restart",)
    answers_no_way: bool = False
    fields_a_stage: int = 1

    @property
    @abstractmethod
    def tasks(self) -> Mapping[str, type[TaskParameters]]:
        """The tasks that a workload may map, each with the model that checks its parameters."""

    def check(self, _job: Job[Any, Any], /) -> tuple[str, str] | None:
        """The reason why these parameters do not suit this problem, as (key, sentence). By default None: they do.

        The key is a parameter of the planning task, or a key of the problem (``starts``, ``goals``).
        """
        return None

    def check_drive(self, _job: Job[Any, Any], /) -> tuple[str, str, str] | None:
        """The reason why the planner cannot drive, as (key of the planning task, sentence, hint). By default None."""
        return None

    def task_text(self, task: Task) -> str:
        """The work of the planner for a task, without a full stop. ``check`` refuses a task that it cannot do."""
        return _TASK_TEXTS[task]

    def plans_for_start(self, _job: Job[Any, Any], /) -> bool:
        """True if the plan depends on the first start, so that each start is simulated. By default it does."""
        return True

    def answer_class(self, _job: Job[Any, Any], start: Cell, /) -> Hashable:
        """Starts of one class are answered from ``job.plan`` in the same time. By default each is its own class."""
        return start

    def arrival_changes(self, _job: Job[Any, Any], /) -> Mapping[str, Mapping[str, Mapping[str, Any]]]:
        """Changes of the planning task that may let more starts arrive, in the order in which to try them.

        By parameter, then by the value in words: the raw parameters to change. By default there are none.
        """
        return {}

    @abstractmethod
    def reachable(self, job: Job[Any, Any]) -> NDArray[np.bool_]:
        """The cells that this planner's own moves lead to a goal: bool rows × columns, goals included.

        A run with another cell as a start is refused before it plans. The answer does not depend on the starts of the
        problem. ``paths.by_sides`` answers for a planner that moves across the sides of cells, or diagonally without
        cutting a corner.
        """

    def memory(self, job: Job[Any, Any]) -> int:
        """Bytes at the peak of a run: the problem, the plan, and the memory of planning and of judging the plan.

        ``job.mapped`` names all tasks that take part. By default 64 bytes a cell. Assumed: the most that a planner of
        this package with values of one word takes.
        """
        return BYTES_A_CELL * job.problem.free.size if isinstance(job.problem, Problem) else 0

    def memory_levers(self, _job: Job[Any, Any], /) -> list[str]:
        """Changes that take less memory, besides a smaller map, such as "smaller blocks". By default none."""
        return []

    def map_work(self, _job: Job[Any, Any], /) -> tuple[MapWork, ...]:
        """The work of the component that sends the map, done before each plan. By default none.

        A processor without the cost of a kernel is refused. An FPGA that sends the map takes no time for it; a note
        of the result says so.
        """
        return ()

    @abstractmethod
    def plan(self, job: Job[Any, Any]) -> Any:
        """The plan, computed without a clock: the same that ``work`` of an architecture returns."""

    @abstractmethod
    def flows(self, job: Job[Any, Any]) -> tuple[Flow, ...]:
        """The flows between tasks, by name, for one plan and one answer; sizes are above 0.

        Senders and receivers are names of ``tasks``, or ``load`` and ``command``. Flows of tasks that do not run
        (``lower_bound`` where it is not mapped) are listed too.

        A flow "map" goes to the task that plans: its time bounds the time of every design from below. A flow "pose"
        goes to the task that decides at every control turn of a drive. The first plan takes the start
        from the map. Without such a flow, the answer is the whole path, sent once a plan.
        """

    def flows_after(self, job: Job[Any, Any]) -> tuple[Flow, ...]:
        """``flows`` with the sizes that follow from ``job.plan``; messages after the plan have these sizes."""
        return self.flows(job)

    def horizon(self, _job: Job[Any, Any], /) -> float | None:
        """Cells of the path that one answer holds. By default None: the answer holds the whole path."""
        return None

    @abstractmethod
    def quality(self, problem: Any, plan: Any) -> Quality | RobotsQuality:
        """The quality of the plan."""

    @abstractmethod
    def identity(self, plan: Any) -> str:
        """A text that is equal for equal plans: their quality is then computed once."""

    def figures(self, _plan: Any, /) -> dict[str, Any]:
        """Fields of a result that depend on this planner: ``stages``, ``precision``, ``details``."""
        return {}

    def field_of(self, _plan: Any, /) -> tuple[str, str, NDArray[np.float64]] | None:
        """The field of a plan as (name, unit, float64 rows × columns), for traces. By default None: there is none.

        See ``records.FieldRecord``. A planner with records of its own for its field returns None.
        """
        return None

    def start_of(self, _plan: Any, /) -> Any:
        """The values that ``Job.start`` may continue from under policy ``continue``. By default None."""
        return None

    @abstractmethod
    def trajectory(self, problem: Any, plan: Any, start: Any) -> Path:
        """The path from ``start``: float64 n × 2 (row, column) in cells, and whether it arrives."""

    def path_from(self, _problem: Any, _plan: Any, start: tuple[float, float], /) -> Path:
        """The path from a position, (row, column) in cells, that need not be the middle of a cell.

        As ``trajectory``: points float64 n × 2, ``start`` first, and whether it arrives. Where the plan holds no path
        from there (the closest cell is an obstacle or was never reached), the answer is ``start`` alone, and False.
        That is also the default, for a planner that never drives. The method computes nothing that the plan does not
        hold: a path from elsewhere needs another plan.
        """
        return np.array([start], np.float64), False


_of_maps = Memo(max_bytes=64 * 2**20)
"""The data that all plans on one map share. Larger maps are computed each time."""


class PathsQuality(TypedDict):
    """The fields of ``Quality`` that depend on paths alone."""

    starts: int
    starts_arrived: int
    path_length_ratio_mean: float | None
    path_length_ratio_worst: float | None
    clearance_mean: float | None
    clearance_least: float | None
    turning_mean: float | None


def corner_cut(cuts: bool) -> tuple[str, str, str] | None:
    """``Planner.check_drive`` of a planner whose paths may cut corners."""
    text = "a path that cuts corners may lead between two obstacles, where no robot can drive"
    return ("corner_cutting", text, "set corner_cutting: false") if cuts else None


def judge_paths(problem: Problem, paths: Iterable[tuple[Cell, NDArray[Any] | None]]) -> PathsQuality:
    """Lengths, clearances and turning of the paths from some starts.

    Args:
        problem: the map and its goals.
        paths: each start with the points of its path, n × 2 (row, column) in cells; None where it does not arrive.

    A length is compared with the shortest 8-connected path without corner cutting. A start on a goal has no ratio. The
    mean clearance weights every piece of a path by its length.
    """
    tried = list(paths)
    arrived = [(start, points) for start, points in tried if points is not None]
    ratios: list[float] = []
    along = length = turning = 0.0
    least: list[float] = []
    if arrived:
        shortest, room = _of_maps.get(
            ("paths", problem.map_digest),
            lambda: (distance_octile(problem.free, problem.goals), clearance(problem.free)),
        )
        for start, points in arrived:
            steps = np.diff(points, axis=0)
            pieces = np.sqrt((steps**2).sum(axis=1))
            cells = np.floor(points + 0.5).astype(np.int64)
            at_points = room[cells[:, 0], cells[:, 1]]
            along += float((pieces * (at_points[:-1] + at_points[1:]) / 2.0).sum())
            length += float(pieces.sum())
            least.append(float(at_points.min()))
            headings = np.arctan2(*steps[pieces > 0.0].T)
            turning += float(np.abs((np.diff(headings, prepend=headings[:1]) + np.pi) % (2 * np.pi) - np.pi).sum())
            if 0.0 < shortest[start] < np.inf:
                ratios.append(float(pieces.sum()) / float(shortest[start]))
    return PathsQuality(
        starts=len(tried),
        starts_arrived=len(arrived),
        path_length_ratio_mean=float(np.mean(ratios)) if ratios else None,
        path_length_ratio_worst=max(ratios, default=None),
        clearance_mean=along / length if length > 0.0 else None,
        clearance_least=min(least, default=None),
        # Rounded, so that a right angle is 90 on every processor.
        turning_mean=round(math.degrees(turning) / len(arrived), 6) if arrived else None,
    )


def by_sides(problem: Problem) -> NDArray[np.bool_]:
    """``Planner.reachable`` of planners that move across the sides of cells, or diagonally without cutting a corner."""
    key = "by sides", problem.map_digest
    return _of_maps.get(key, lambda: reachable(problem.free, problem.goals)).copy()


def judge_search(
    problem: Problem, cells: NDArray[np.bool_], covered: Any, followed: Iterable[tuple[Cell, Path]]
) -> Quality:
    """The quality of a plan that leads to a goal from each cell that it covers.

    Args:
        problem: the map and its goals.
        cells: bool, rows × columns: ``Planner.reachable``. It is changed: goals are left out.
        covered: an index of the cells that the plan covers.
        followed: each start with its path.
    """
    cells[tuple(np.array(problem.goals).T)] = False
    planned = int(cells[covered].sum())
    paths = ((start, points if arrived else None) for start, (points, arrived) in followed)
    return Quality(
        local_maxima=0,
        wrong_cells=0,
        **judge_arrival(planned, planned, int(cells.sum())),
        **judge_paths(problem, paths),
    )


class ArrivalQuality(TypedDict):
    """The fields of ``Quality`` that depend on the number of arriving cells."""

    reachable_cells: int
    planned_cells: int
    cells_leading_nowhere: int
    share_reaching_goal: float | None


def judge_arrival(arriving: int, planned: int, reachable: int | None = None) -> ArrivalQuality:
    """Figures of a plan that covers ``planned`` of the ``reachable`` cells: ``arriving`` of them lead to a goal.

    By default the plan covers all reachable cells. The share is None where the plan covers no cell.

    >>> judge_arrival(3, 4, 8)
    {'reachable_cells': 8, 'planned_cells': 4, 'cells_leading_nowhere': 1, 'share_reaching_goal': 0.75}
    """
    return ArrivalQuality(
        reachable_cells=planned if reachable is None else reachable,
        planned_cells=planned,
        cells_leading_nowhere=planned - arriving,
        share_reaching_goal=arriving / planned if planned else None,
    )


def cell_of(problem: Problem, position: tuple[float, float]) -> Cell | None:
    """The free cell that a position, (row, column) in cells, lies in; None outside of the map or in an obstacle."""
    row, column = (math.floor(value + 0.5) for value in position)
    inside = 0 <= row < problem.rows and 0 <= column < problem.columns
    return (row, column) if inside and bool(problem.free[row, column]) else None


def from_position(
    position: tuple[float, float], cells: NDArray[np.integer], free: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """The path along the middles of ``cells``, n × 2, n ≥ 1, from a position in the first of them: float64 m × 2.

    It goes straight to the middle of the second cell, so that a robot that gets a new path at every position does not
    turn back. Where that would cut the corner of an obstacle, it goes through the middle of the first cell.
    """
    here = np.array([position], np.float64)
    middles = cells.astype(np.float64)
    if len(cells) == 1:
        return here if np.array_equal(here[0], middles[0]) else np.concatenate([here, middles])
    (row, column), (down, right) = cells[0], cells[1] - cells[0]
    clear = bool(free[row + down, column] and free[row, column + right])
    return np.concatenate([here, middles[1:] if clear or np.array_equal(here[0], middles[0]) else middles])
