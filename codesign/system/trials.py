"""Levers that change the plan are tried: whether the design then fits, and how many starts then arrive."""

from __future__ import annotations

import json
import math
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from codesign.ground.errors import CodesignError
from codesign.ground.figures import label
from codesign.ground.memo import Memo
from codesign.ground.models import TaskParameters
from codesign.inputs.problem import ProblemSpec
from codesign.planners.interface import Problem, Quality
from codesign.planners.job import Job, Lever
from codesign.planners.styles import Step
from codesign.system.bind import System, planner_code, planner_steps
from codesign.system.outcome import fit_system
from codesign.system.results.result import Reason

MOST_TRIED = 2**17
"""Cells of the largest map on which levers are tried: about as long as a run of the design."""


@dataclass(frozen=True)
class Arrivals:
    """Starts that can arrive by the planner's own moves, those that do, and those that have to."""

    able: int
    arrived: int
    needed: int

    @property
    def serve(self) -> bool:
        """True if enough starts arrive."""
        return self.arrived >= self.needed

    def __str__(self) -> str:
        return f"{self.arrived} of {self.able} starts arrive"


def arrivals_of(system: System, problem: Problem, quality: Any) -> Arrivals | None:
    """The arrivals by a plan on ``problem``; None of a planner with a problem of its own."""
    spec = system.workload.problem
    if not isinstance(quality, Quality) or not isinstance(spec, ProblemSpec):
        return None
    with planner_code(system.planner):
        reach = system.planner.reachable(Job(problem, system.planning))
    able = sum(bool(reach[start]) for start in problem.starts)
    return Arrivals(able, quality.starts_arrived, math.ceil(spec.arrive * able - 1e-9))


def arrival_reason(arrivals: Arrivals | None) -> Reason | None:
    """The reason against a plan by which too few starts arrive; None where enough do."""
    if arrivals is None or arrivals.serve:
        return None
    return Reason.over("quality", "starts arrived", arrivals.arrived, arrivals.needed, "")


@dataclass(frozen=True)
class Trial:
    """A design with some parameters changed. ``short``: of what it is short of, in words; empty where it fits."""

    arrivals: Arrivals | None
    short: tuple[str, ...]

    @property
    def serves(self) -> bool:
        """True if the design fits and its plan serves."""
        return not self.short and (self.arrivals is None or self.arrivals.serve)

    def __str__(self) -> str:
        fits = f"does not fit ({', '.join(self.short)})" if self.short else "fits"
        if self.arrivals is None:
            return fits
        joint = ", and" if self.arrivals.serve is not bool(self.short) else ", but"
        return f"{fits}{joint} {self.arrivals}"


class Trials:
    """Tries changes of the planning task's parameters on one system; work in common is done once."""

    def __init__(self, system: System) -> None:
        self.system, self._memo = system, Memo()
        self._trials: dict[str, Trial | None] = {}

    def levers(self, levers: Iterable[Lever]) -> tuple[str, ...]:
        """The levers in words: those that serve first, then those that change no plan, then those that do not serve."""
        texts = []
        for lever in levers:
            trial = self.trial(lever.changes) if lever.changes else None
            text = lever.text if trial is None else f"{lever.text}: {trial}"
            texts.append((1 if trial is None else 0 if trial.serves else 2, text))
        return tuple(text for _, text in sorted(texts, key=lambda each: each[0]))

    def for_arrivals(self) -> tuple[str, ...]:
        """The changes that would let enough starts arrive, in words."""
        system, task = self.system, self.system.planner.planning_task
        with planner_code(system.planner):
            ways = system.planner.arrival_changes(system.job)
        if not self._small:
            large = "not tried on a map of this size"
            return tuple(f"{task}.{key}: {', '.join(values)} ({large})" for key, values in ways.items())
        return tuple(self._best_of(f"{task}.{key}", values) for key, values in ways.items())

    def _best_of(self, name: str, values: Mapping[str, Mapping[str, Any]]) -> str:
        """The first value by which enough starts arrive, or else the last one that was tried."""
        text = ""
        for value, changes in values.items():
            trial = self.trial(changes)
            if trial is None:
                continue
            text = f"{name}: {value}: {trial}"
            if trial.arrivals is not None and trial.arrivals.serve:
                return text
        return text or f"{name}: {', '.join(values)} (refused on this map)"

    @property
    def _small(self) -> bool:
        problem = self.system.problem
        return isinstance(problem, Problem) and problem.free.size <= MOST_TRIED

    def trial(self, changes: Mapping[str, Any]) -> Trial | None:
        """The design with raw parameters changed; None where it is refused, or the map too large for a trial."""
        if not self._small:
            return None
        key = json.dumps(changes, sort_keys=True)
        if key not in self._trials:
            self._trials[key] = self._tried(changes)
        return self._trials[key]

    def _tried(self, changes: Mapping[str, Any]) -> Trial | None:
        system = self.system
        try:
            moved = _moved(system, changes)
            short = tuple(label(reason.name) for reason in fit_system(moved).reasons)
            problem = system.problem.changed
            job = replace(moved.job, problem=problem, memo=self._memo, detail=False)
            with planner_code(system.planner):
                if system.planner.check(job) is not None:
                    return None
            plan = _end_of(planner_steps(system.planner, system.architecture.work(job)))
            with planner_code(system.planner):
                quality = system.planner.quality(problem, plan)
        except (CodesignError, ValueError):
            return None
        return Trial(arrivals_of(moved, problem, quality), short)


def _end_of(steps: Generator[Step, None, Any]) -> Any:
    """The plan that steps lead to, without a clock."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value


def _moved(system: System, changes: Mapping[str, Any]) -> System:
    """The system with parameters of its planning task changed."""
    task = system.planner.planning_task
    mapped = system.workload.mapping[task]
    raw = {**mapped.parameters.model_dump(mode="json"), **changes}
    parameters: TaskParameters = type(mapped.parameters).model_validate(raw)
    parameters = system.architecture.settled(parameters)
    mapping = {**system.workload.mapping, task: mapped.model_copy(update={"parameters": parameters})}
    workload = system.workload.model_copy(update={"mapping": mapping})
    return replace(system, workload=workload, parameters={**system.parameters, task: parameters})
