"""What every planner offers, and what it is given.

A planner is arrays in, arrays out, exact, without a clock. A ``PlugIn`` registers it; a user's own planner plugs in the
same way.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from codesign.figures import described
from codesign.models import SpecModel, TaskParameters
from codesign.planners.job import Job
from codesign.planners.task_graph import Flow

Cell = tuple[int, int]
"""(row, column), from 0 at the top left."""

Policy = Literal["restart", "lower_bound", "continue"]
"""What a planner does when the map has changed.

- ``restart``: it plans as if for the first time.
- ``lower_bound``: from a start that the task ``lower_bound`` makes, nowhere above the answer, which is the same.
- ``continue``: from the values that the last plan left (``Planner.start_of``).
"""

BYTES_A_CELL = 64
"""Memory that a planner is taken to need for a cell, where it does not say. Assumed."""

LOAD, COMMAND = "load", "command"
"""Tasks that every planner's flows may name beside its own: who holds the map, and who wants the answer."""

POSE = "pose"
"""The flow that asks for a decision at a pose; see ``Planner.flows``."""

LOWER_BOUND = "lower_bound"
"""The task that makes a start for policy ``lower_bound``; it is done where it is mapped."""


@dataclass(frozen=True, eq=False)
class Problem:
    """One planning problem.

    ``free``: bool array, rows × columns. ``goals`` and ``starts``: (row, column) pairs on free cells. ``resolution``:
    metres a cell, or None where the map does not say.
    """

    free: NDArray[np.bool_]
    goals: tuple[tuple[int, int], ...]
    starts: tuple[tuple[int, int], ...]
    resolution: float | None = None

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
        import hashlib

        text = f"{self.free.shape}{self.goals}{self.starts}{self.resolution}"
        return hashlib.sha256(text.encode() + np.packbits(self.free).tobytes()).hexdigest()


@dataclass(frozen=True)
class Quality:
    """What a plan is worth.

    A plan need not cover every cell that leads to a goal: a wave is stopped, a search ends. Shares and local maxima
    count over the cells that it covers, ``planned_cells``; nothing is known of the others, which are neither good nor
    bad. A figure that does not apply to the planner is None, and so is a length where no start arrives. A ratio is
    below 1 where a continuous way beats the grid.
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
        int | None,
        Field(title="covered cells with no way up (local maxima)", description=described("local_maxima")),
    ]
    share_reaching_goal: Annotated[
        float | None,
        Field(
            title="share of covered cells that reach the goal", description=described("share_reaching_goal")
        ),
    ]
    starts: Annotated[int, Field(description="starts tried")]
    starts_arrived: Annotated[int, Field(description="starts from which following the plan arrived")]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="way over the shortest 8-connected way, corners not cut; mean over the starts that arrived"
            " and that such a way joins to a goal",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    clearance_mean: Annotated[
        float | None, Field(title="clearance, mean", description=described("clearance_mean"))
    ]
    clearance_least: Annotated[
        float | None,
        Field(
            title="clearance, least",
            description="the same, least, cells",
            json_schema_extra={"unit": "cells"},
        ),
    ]
    wrong_cells: Annotated[
        int | None, Field(title="cells with a wrong value", description=described("wrong_cells"))
    ]
    cells_leading_nowhere: Annotated[
        int | None,
        Field(
            title="cells that lead nowhere",
            description="planned cells from which following the plan does not arrive",
        ),
    ] = None
    warnings: Annotated[
        tuple[str, ...], Field(description="what a reader of these figures must know, and what would mend it")
    ] = ()


@dataclass(frozen=True)
class RobotsQuality:
    """What the paths of several robots are worth."""

    robots: Annotated[int, Field(description="robots")]
    robots_arrived: Annotated[int, Field(description="robots that reached their targets")]
    updates: Annotated[
        int,
        Field(
            title="updates of the velocities",
            description="updates of the velocities, until all arrived or the run was given up",
        ),
    ]
    collisions: Annotated[
        int, Field(title="pairs of robots that collided", description=described("collisions"))
    ]
    closest_approach: Annotated[float, Field(description=described("closest_approach"))]
    time_to_targets_s: Annotated[
        float | None,
        Field(
            title="time until the last arrived, by the robots' clock",
            description=described("time_to_targets_s", "; None where none did"),
        ),
    ]
    velocity_changes: Annotated[
        int,
        Field(title="changes of velocity", description="updates at which a robot left the velocity it had"),
    ]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="way driven over the straight line, mean over the robots that arrived",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    shortfall: Annotated[
        str | None,
        Field(
            description="which robots did not arrive and why, or what left its word; None where all arrived"
        ),
    ] = None
    remedy: Annotated[
        str | None,
        Field(
            description="parameters with which all robots arrive, as tried; None where none of those tried does"
        ),
    ] = None


class LoadParameters(TaskParameters):
    """The task ``load``, which brings the map to the planner, has nothing to choose."""


class Planner(ABC):
    """A planner: its name, the parameters it takes, and what it does with them.

    - ``name``: its name in YAML. ``description``: one line for ``hwsw list``, without a full stop.
    - ``planning_task``: the task that every mapping must place: the one that computes the plan.
    - ``problem_model``: the model of a workload's problem, with a method ``problem()``; None: a map with goals and
      starts.
    - ``policies``: the replan policies it knows; the first is the default.
    - ``answers_no_way``: True where a start from which no path leads to a goal is an answer, not a fault.
    - ``fields_a_stage``: fields of a double a cell that the records of one stage hold. A plan without stages
      (``TaskParameters.precisions``) counts as one.

    A method that is asked before there is a plan takes a ``Job``. A method that is asked of a plan takes the problem
    and the plan, or the plan alone.
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
        """The tasks a workload may map, each with the model that its parameters are checked against."""

    def check(self, _job: Job[Any, Any], /) -> tuple[str, str] | None:
        """What keeps these parameters from this problem, as (key, sentence). By default None: nothing does.

        The key is a parameter of the planning task, or a key of the problem (``starts``, ``goals``).
        """
        return None

    def check_drive(self, _job: Job[Any, Any], /) -> tuple[str, str, str] | None:
        """What keeps the planner from a drive, as (key of the planning task, sentence, hint). By default None."""
        return None

    @abstractmethod
    def reachable(self, job: Job[Any, Any]) -> NDArray[np.bool_]:
        """The cells that this planner's own moves lead to a goal: bool rows × columns, goals included.

        A run that names another cell as a start is refused before it plans. The starts of the problem do not matter.
        ``paths.by_sides`` is the answer of a planner that moves across the sides of cells, or diagonally without
        cutting a corner.
        """

    def memory(self, job: Job[Any, Any]) -> int:
        """Bytes at the peak of a run: those of the problem, the plan, what makes it, and what judges it.

        ``job.mapped`` names all tasks that take part. By default 64 bytes a cell, assumed: as much as the most that
        ours take whose values are one word.
        """
        return BYTES_A_CELL * job.problem.free.size if isinstance(job.problem, Problem) else 0

    def memory_levers(self, _job: Job[Any, Any], /) -> list[str]:
        """What takes less memory, besides a smaller map, as in "smaller blocks". By default nothing."""
        return []

    @abstractmethod
    def plan(self, job: Job[Any, Any]) -> Any:
        """The answer alone, without a clock: what ``work`` of an architecture ends in, drained."""

    @abstractmethod
    def flows(self, job: Job[Any, Any]) -> tuple[Flow, ...]:
        """What flows between tasks, by name, for one plan and one answer; sizes are above 0.

        Senders and receivers are names of ``tasks``, or ``load`` and ``command``. Flows of tasks that are not done
        (``lower_bound`` where it is not mapped) are listed all the same.

        A flow "pose" goes to the task that a drive asks for a decision at every control turn; the first plan knows the
        start from the map. Without one, the answer is the whole path, sent once a plan.
        """

    def flows_after(self, job: Job[Any, Any]) -> tuple[Flow, ...]:
        """``flows`` with the sizes that are known once ``job.plan`` is made; messages after it have these."""
        return self.flows(job)

    def horizon(self, _job: Job[Any, Any], /) -> float | None:
        """Cells of path that one answer holds, beyond which a robot is not led. By default None: all that it needs."""
        return None

    @abstractmethod
    def quality(self, problem: Any, plan: Any) -> Quality | RobotsQuality:
        """What that answer is worth."""

    @abstractmethod
    def identity(self, plan: Any) -> str:
        """A text that is equal for equal answers: their quality is then computed once."""

    def figures(self, _plan: Any, /) -> dict[str, Any]:
        """The fields of a result that only this plan can fill: ``stages``, ``precision``, ``details``."""
        return {}

    def field_of(self, _plan: Any, /) -> tuple[str, str, NDArray[np.float64]] | None:
        """The field of a plan as (name, unit, float64 rows × columns), for traces. By default None: there is none.

        See ``records.FieldRecord``. A planner that writes its field by records of its own has none here.
        """
        return None

    def start_of(self, _plan: Any, /) -> Any:
        """The values that ``Job.start`` may continue from under policy ``continue``. By default None."""
        return None

    @abstractmethod
    def trajectory(self, problem: Any, plan: Any, start: Any) -> tuple[NDArray[np.float64], bool]:
        """The path from ``start``: float64 n × 2 (row, column) in cells, and whether it arrives."""

    def path_from(
        self, _problem: Any, _plan: Any, start: tuple[float, float], /
    ) -> tuple[NDArray[np.float64], bool]:
        """The path from a position, (row, column) in cells, that need not be the middle of a cell.

        As ``trajectory``: points float64 n × 2, ``start`` first, and whether it arrives. Where the plan knows no path
        from there (the closest cell is an obstacle or was never reached), ``start`` alone, and False: the default, of
        a planner that plans for no drive. It computes nothing that the plan does not hold: a path from elsewhere takes
        another plan.
        """
        return np.array([start], np.float64), False
