"""Scenario ``plan_once``: the map is sent, the planner works, the answer comes back; for each start or every cell."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from codesign.ground.memo import Memo
from codesign.ground.models import Task
from codesign.ground.records import TrajectoryRecord
from codesign.inputs import Platform, Workload
from codesign.inputs.components import MemoryComponent
from codesign.inputs.map_spec import FileMap
from codesign.inputs.problem import ProblemSpec
from codesign.planners.interface import Problem
from codesign.system.bind import System
from codesign.system.build import Machine
from codesign.system.chain import Answer
from codesign.system.energy import energy_of, watts_of
from codesign.system.outcome import plan_fields, times_until, use_fields
from codesign.system.results.ledger import Ledger
from codesign.system.results.result import Power, Result, TaskFigures, times_of
from codesign.system.results.terms import Terms
from codesign.system.scenario import LeverProgress, ProgressOfMission
from codesign.system.scenarios.requests import requests_of
from codesign.system.scenarios.scenario import Scenario, tell_field, tell_map
from codesign.system.terms import open_terms, plan_terms
from codesign.system.trials import Arrivals, Trials, arrival_reason, arrivals_of

TRACED_TRAJECTORIES = 16

ROBOTS = "all robots plan together, until each has arrived or the run is given up"


class PlanOnceScenario(Scenario):
    """One plan for each request. The map changes for task ``replan`` alone, between two plans."""

    type = "plan_once"

    def run(
        self, machine: Machine, boards: Mapping[str, Power], memo: Memo | None, _progress: ProgressOfMission | None
    ) -> dict[str, Any]:
        """The figures of the task, of the first start's plan, and of the quality for all starts."""
        system, problem = machine.system, machine.system.problem
        tell_map(machine, problem.free, problem.resolution)
        requests = requests_of(machine, {name: watts_of(power) for name, power in boards.items()}, memo)
        first = requests.first
        _tell_answer(machine, first.answer)
        fields = plan_fields(machine, first.answer, memo) | use_fields(machine, boards)
        fields |= {"time": times_until(first.before), "energy": energy_of(system, requests.joules)}
        fields["terms"] = _terms(machine, first.before.ledger, requests.ledgers, boards)
        arrivals = arrivals_of(system, first.answer.problem, fields["quality"])
        times = times_of([request.answer.parts for request in requests.all])
        fields["task"] = task_figures(system, arrivals, times)
        short = arrival_reason(arrivals)
        return fields if short is None else {**fields, "feasible": False, "reasons": (short,)}

    def with_levers(
        self,
        result: Result,
        system: System,
        _run: Callable[[Platform, Workload], Result],
        _progress: LeverProgress | None,
    ) -> Result:
        """The result with what would let enough starts arrive, each change tried."""
        if not any(reason.kind == "quality" for reason in result.reasons):
            return result
        levers = Trials(system).for_arrivals()
        reasons = tuple(
            reason.model_copy(update={"levers": levers}) if reason.kind == "quality" else reason
            for reason in result.reasons
        )
        return result.model_copy(update={"reasons": reasons})


def _terms(machine: Machine, first: Ledger, requests: Sequence[Ledger], boards: Mapping[str, Power]) -> Terms:
    """The terms of the plans. A memory works a share of the time in which the FPGA that plans does."""
    system = machine.system
    shares = {
        name: machine.by_name[name].busy / machine.planning_component.busy
        for name in system.platform.of(MemoryComponent)
        if machine.planning_component.busy
    }
    return open_terms(machine, (first, *requests)) or plan_terms(system, system, first, requests, boards, shares=shares)


def _tell_answer(machine: Machine, answer: Answer) -> None:
    """Record the plan and some of its paths for listeners."""
    if not machine.listening:
        return
    problem = answer.problem
    tell_field(machine, answer.plan)
    for start in problem.starts[:TRACED_TRAJECTORIES]:
        points, arrived = machine.system.planner.trajectory(problem, answer.plan, start)
        machine.tell(TrajectoryRecord(machine.now, "robot", points, arrived))


def task_figures(system: System, arrivals: Arrivals | None, times: Mapping[str, Any]) -> TaskFigures:
    """The task, and its times (``times_of``)."""
    problem, spec = system.problem, system.workload.problem
    if not isinstance(problem, Problem) or not isinstance(spec, ProblemSpec):
        return TaskFigures(task="robots", text=ROBOTS, starts=1, question=problem.digest, **times)
    change = problem.change
    changed = None if change is None else len(change.blocked) + len(change.freed)
    asked = replace(problem, starts=tuple(sorted(problem.starts)), goals=tuple(sorted(problem.goals)))
    return TaskFigures(
        task=problem.task.value,
        text=system.planner.task_text(problem.task),
        map=_map_text(spec, problem),
        question=hashlib.sha256(asked.digest.encode()).hexdigest()[:16],
        starts=len(problem.starts),
        reach=problem.reach,
        changed_cells=changed if problem.task is Task.REPLAN else None,
        arrive=arrivals.arrived / arrivals.able if arrivals is not None and arrivals.able else None,
        **times,
    )


def _map_text(spec: ProblemSpec, problem: Problem) -> str:
    """The map in words, such as ``maze of 72 × 132 cells, goal (3, 128)``."""
    what = spec.map.file if isinstance(spec.map, FileMap) else spec.map.generate
    goals = f"goal {problem.named(problem.goals[0])}" if len(problem.goals) == 1 else f"{len(problem.goals)} goals"
    return f"{what} of {problem.rows} × {problem.columns} cells, {goals}"
