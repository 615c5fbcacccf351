"""Scenario ``plan_once``: the map is sent, the planner works, the answer comes back."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from typing import Any

from codesign.memo import Memo
from codesign.records import TrajectoryRecord
from codesign.results.result import Power
from codesign.scenarios.records import tell_field, tell_map
from codesign.system.build import Machine
from codesign.system.chain import Answer, plan_chain
from codesign.system.outcome import plan_fields, use_fields
from codesign.system.scenario import ProgressOfMission, Scenario
from codesign.system.terms import plan_terms

TRACED_TRAJECTORIES = 16


class PlanOnceScenario(Scenario):
    """One plan, from a map that does not change."""

    type = "plan_once"

    def run(
        self,
        machine: Machine,
        boards: Mapping[str, Power],
        memo: Memo | None,
        _progress: ProgressOfMission | None,
    ) -> dict[str, Any]:
        """The figures of the plan."""
        answer = plan_once(machine, memo)
        terms = {"terms": plan_terms(machine, answer.ledger, boards)}
        return plan_fields(machine, answer, memo) | use_fields(machine, boards) | terms


def plan_once(machine: Machine, memo: Memo | None) -> Answer:
    """Make one plan, and record it for listeners.

    Raises:
        LostMessageError: a message of it was lost.
    """
    system, problem = machine.system, machine.system.problem
    tell_map(machine, problem.free, problem.resolution)
    answers: list[Answer] = []

    def mission() -> Generator[Any, Any, None]:
        answers.append((yield from plan_chain(machine, problem, memo=memo)))

    machine.environment.process(mission())
    machine.environment.run()
    answer = answers[0]
    if machine.listening:
        tell_field(machine, answer.plan)
        for start in problem.starts[:TRACED_TRAJECTORIES]:
            points, arrived = system.planner.trajectory(problem, answer.plan, start)
            machine.tell(TrajectoryRecord(machine.now, "robot", points, arrived))
    return answer
