"""Scenario ``drive``, as the system asks for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from codesign.ground.errors import Fault
from codesign.ground.memo import Memo
from codesign.inputs import Platform, Workload
from codesign.inputs.exploration import MISSION_OBJECTIVES
from codesign.planners.interface import Planner
from codesign.planners.task_graph import Flow
from codesign.system.bind import System
from codesign.system.build import Machine
from codesign.system.results.result import Power, Result
from codesign.system.scenario import Draft, LeverProgress, ProgressOfMission
from codesign.system.scenarios.drive.faults import drive_faults, faults_of_robot
from codesign.system.scenarios.drive.levers import with_levers
from codesign.system.scenarios.drive.mission import drive
from codesign.system.scenarios.drive.progress import outlook
from codesign.system.scenarios.drive.summary import result_fields
from codesign.system.scenarios.drive.tasks import KERNELS, MOVE, SENSE, drive_flows, drive_of, robot_of
from codesign.system.scenarios.scenario import Scenario


class DriveScenario(Scenario):
    """One robot senses, plans, drives, discovers and plans again."""

    type = "drive"
    begins_anywhere = True
    asks_again = True
    # Assumed: what a robot believes and what is true, each with its distances, and the plan that it follows.
    bytes_a_cell = 64
    component_types: ClassVar[Mapping[str, tuple[str, ...]]] = {SENSE: ("robot",), MOVE: ("robot",)}
    objectives = MISSION_OBJECTIVES

    def instead(self, planner: Planner) -> str | None:
        """Drives are for planners on maps."""
        return None if planner.problem_model is None else "fleet"

    def faults(self, workload: Workload, planner: Planner, problem: Any) -> list[Fault]:
        """See ``faults.drive_faults``."""
        return drive_faults(workload, planner, problem)

    def faults_on(self, draft: Draft) -> list[Fault]:
        """See ``faults.faults_of_robot``."""
        return faults_of_robot(draft.platform, draft.workload, draft.problem)

    def places(self, draft: Draft) -> Mapping[str, str]:
        """The robot senses and moves."""
        name, _ = robot_of(draft.platform, draft.workload)
        return {SENSE: name, MOVE: name}

    def flows(self, draft: Draft, places: Mapping[str, str], _planned: Sequence[Flow]) -> Sequence[Flow]:
        """Scans, commands, what was seen, and frames for a display."""
        return drive_flows(draft, places)

    def kernels(self, _draft: Draft, _places: Mapping[str, str]) -> Mapping[str, str]:
        """The kernel of each task of a turn."""
        return KERNELS

    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, progress: ProgressOfMission | None
    ) -> dict[str, Any]:
        """The figures of the first plan, and of the mission."""
        return result_fields(machine, drive(machine, memo, progress), boards, memo)

    def outlook(self, workload: Workload) -> str | None:
        """See ``progress.outlook``."""
        return outlook(drive_of(workload))

    def with_levers(
        self,
        result: Result,
        system: System,
        run: Callable[[Platform, Workload], Result],
        progress: LeverProgress | None,
    ) -> Result:
        """See ``levers.with_levers``."""
        return with_levers(result, system, run, progress)
