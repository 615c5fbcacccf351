"""The questions of binding to the scenario that a workload names. Each scenario answers from its room."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from codesign.ground.errors import Fault
from codesign.ground.figures import ResultFigure
from codesign.inputs import Platform, Workload
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.interface import Planner, Problem
from codesign.planners.job import Flow, Job
from codesign.planners.styles import Architecture


@dataclass(frozen=True)
class MissionProgress:
    """The progress of a drive. It ends at ``limit`` or ``most_events`` at the latest.

    ``time``, ``limit``: ps. ``events``, ``most_events``: each turn counts for its scan and its path too. ``turns``: of
    the control loop.
    """

    time: int
    limit: int
    events: int
    most_events: int
    turns: int

    @property
    def share(self) -> float:
        """The share of the longest possible drive that is over, 0 to 1."""
        return min(max(self.time / max(self.limit, 1), self.events / self.most_events), 1.0)


ProgressOfMission = Callable[[MissionProgress], None]

LeverProgress = Callable[[int, int, str], None]
"""Takes how many levers are done, of how many, and which comes next."""


@dataclass(frozen=True, eq=False)
class Draft:
    """A design point before its tasks are placed.

    ``scenario``, ``planner``: those that the workload names. ``architecture``: the style of the planning task.
    """

    platform: Platform
    workload: Workload
    scenario: ScenarioRules
    planner: Planner
    architecture: Architecture
    problem: Problem

    @property
    def planning(self) -> Any:
        """The parameters of the planning task."""
        return self.workload.mapping[self.planner.planning_task].parameters

    @property
    def job(self) -> Job[Any, Any]:
        """The job that planner and style are asked about."""
        return Job(self.problem, self.planning)


class ScenarioRules:
    """One kind of scenario: what it checks, and what it adds to a design point.

    An object holds nothing of a workload, so that one serves them all. Its model and its tasks stand in
    ``inputs.scenario``; ``type`` is their name there.

    Attributes:
        begins_anywhere: a start may have no path to a goal; the scenario itself reports that. Otherwise such a start
            is a fault of the workload.
        asks_again: the planner's decisions are asked for again and again, also those inside the planning component.
            A processor then needs a cost of them.
        bytes_a_cell: memory that a run takes for each cell of the map, besides the planner's memory.
        component_types: the types of component that can do a task of the scenario, by task, if they are others than
            ``fpga`` and ``processor``.
        objectives: of an exploration that names none.
    """

    type: ClassVar[str]
    begins_anywhere: ClassVar[bool] = False
    asks_again: ClassVar[bool] = False
    bytes_a_cell: ClassVar[int] = 0
    component_types: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    objectives: ClassVar[tuple[ResultFigure, ...]] = DEFAULT_OBJECTIVES

    def instead(self, _planner: Planner, /) -> str | None:
        """The scenario to take where this one is not for the planner; None: this one is for it."""
        return None

    def faults(self, _workload: Workload, _planner: Planner, _problem: Any, /) -> list[Fault]:
        """Every fault of the scenario that is known without a platform."""
        return []

    def faults_on(self, _draft: Draft, /) -> list[Fault]:
        """Every fault of the scenario on a platform. Called where ``faults`` found none, before tasks are placed."""
        return []

    def places(self, _draft: Draft, /) -> Mapping[str, str]:
        """The default components of its tasks, by task.

        By default ``load`` and ``command`` are on the component that asks for the plan, and all others on the one that
        plans. Called where ``faults_on`` found none.
        """
        return {}

    def flows(self, _draft: Draft, _places: Mapping[str, str], _planned: Sequence[Flow], /) -> Sequence[Flow]:
        """The flows that the scenario adds. By default none.

        It takes the draft, the component of each task that is done, and the flows of the planner.
        """
        return ()

    def kernels(self, _draft: Draft, _places: Mapping[str, str], /) -> Mapping[str, str]:
        """The kernel that each task of its own is counted in where a processor does it. By default none."""
        return {}
