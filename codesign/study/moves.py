"""A design with one thing moved: each lever of a reason by itself, and each step of a run to the next value."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Literal, get_args, get_origin

from codesign.ground.errors import CodesignError
from codesign.ground.figures import ResultFigure, label, named
from codesign.ground.memo import Memo
from codesign.ground.models import TaskParameters
from codesign.ground.progress import Show, doing, silent
from codesign.inputs import Platform, Workload, design_point, list_parts, load_part
from codesign.planners.interface import Problem
from codesign.planners.job import Lever
from codesign.study.constraints import figure_of
from codesign.system.bind import System
from codesign.system.explanation import Moved
from codesign.system.outcome import fit_system
from codesign.system.problem_map import grid_of
from codesign.system.results.result import Reason, Result
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.drive.levers import drive_levers
from codesign.system.trials import MOST_TRIED, Trials

MOST_RUNS = 40
"""Most runs for one explanation."""

NOT_TRIED = "not tried: it has no single value"
_STEP = 2


@dataclass
class Bench:
    """Runs a design with axes moved.

    - ``own``: the result of the design. ``objectives``: what results are compared by.
    - ``judged``: adds the constraints to a result.
    - ``show``: is told how many runs were made.
    """

    platform: Platform
    workload: Workload
    own: Result
    objectives: Sequence[ResultFigure]
    judged: Callable[[Result], Result]
    memo: Memo = field(default_factory=Memo)
    show: Show = silent
    runs: int = 0
    _results: dict[str, Result | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.grid = grid_of(self.workload)
        self.system = bind(self.platform, self.workload, grid=self.grid)

    @property
    def cheap(self) -> str:
        """The reason for which no run is made; "" if runs are cheap."""
        problem = self.system.problem
        if self.own.mission is not None or self.workload.scenario.type != "plan_once":
            return "a drive or a fleet takes too long to be run for each lever"
        if isinstance(problem, Problem) and problem.free.size > MOST_TRIED:
            return f"levers are tried on maps of at most {MOST_TRIED:,} cells"
        return ""

    def moved(
        self, what: str, setting: Mapping[str, Any], reason: Reason | None = None, before: Any = None, after: Any = None
    ) -> Moved:
        """The design with these axes set.

        ``reason``: that it is a lever for. ``before``, ``after``: as a reader is shown them.
        """
        why = self.cheap
        outcome = self._run(setting) if not why else f"not tried: {why}"
        if after is None:
            after = next(iter(setting.values())) if len(setting) == 1 else dict(setting)
        if isinstance(outcome, str):
            return Moved(what=what, before=before, after=after, note=outcome)
        goes = None if reason is None else not any(_same(reason, other) for other in outcome.reasons)
        return compared(self.own, outcome, self.objectives).model_copy(
            update={"what": what, "before": before, "after": after, "goes": goes}
        )

    def _run(self, setting: Mapping[str, Any]) -> Result | str:
        key = repr(sorted(setting.items()))
        if key not in self._results:
            if self.runs >= MOST_RUNS:
                return f"not tried: at most {MOST_RUNS} runs"
            self.runs += 1
            doing(self.show, f"levers and next values: run {self.runs}")
            self._results[key] = self._tried(setting)
        return self._results[key]

    def _tried(self, setting: Mapping[str, Any]) -> Result | str:
        try:
            moved = design_point(self.platform, self.workload, setting, "lever: ")
            grid = self.grid if moved[1].problem is self.workload.problem else None
            return self.judged(simulate(*moved, memo=self.memo, grid=grid))
        except CodesignError as wrong:
            return f"refused: {str(wrong).partition(chr(10))[0]}"


def _same(reason: Reason, other: Reason) -> bool:
    return (reason.kind, reason.name) == (other.kind, other.name)


def compared(own: Result, other: Result, objectives: Sequence[ResultFigure]) -> Moved:
    """Another result against the result of the design, by the objectives."""
    figures = {figure: figure_of(other, figure) for figure in objectives}
    both = own.feasible and other.feasible
    gains, losses = gains_of({figure: figure_of(own, figure) for figure in objectives if both}, figures)
    return Moved(
        what="",
        feasible=other.feasible,
        out=tuple(label(reason.name) for reason in other.reasons),
        figures={figure.name: value for figure, value in figures.items()},
        better=gains,
        worse=losses,
    )


def gains_of(
    own: Mapping[ResultFigure, float | None],
    other: Mapping[ResultFigure, float | None],
    maximise: Callable[[ResultFigure], bool] = lambda figure: figure.maximise,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The figures in which ``other`` is better than ``own``, and those in which it is worse; by name.

    A figure that one of the two does not have tells nothing.
    """
    better: list[str] = []
    worse: list[str] = []
    for figure, value in own.items():
        there = other[figure]
        if value is None or there is None or value == there:
            continue
        (better if (there > value) is maximise(figure) else worse).append(figure.name)
    return tuple(better), tuple(worse)


def levers_for(bench: Bench, reason: Reason) -> tuple[Moved, ...]:
    """Each lever of a reason by itself: those that make the design feasible first, then those that end the reason."""
    if reason.kind == "constraint":
        tried = [
            bench.moved(axis, {axis: value}, reason, before, after) for axis, value, before, after in _steps(bench)
        ]
    else:
        tried = [
            Moved(what=text, note=NOT_TRIED) if setting is None else bench.moved(text, setting, reason)
            for text, setting in _settings(bench, reason)
        ]
    return tuple(sorted(tried, key=lambda each: (not each.feasible, not each.goes, bool(each.note))))


def _settings(bench: Bench, reason: Reason) -> Iterator[tuple[str, dict[str, Any] | None]]:
    """Each lever of a reason in words, and the axes that it sets; None where it has no single value."""
    system, task = bench.system, bench.system.planner.planning_task
    if reason.kind == "clock" and bench.own.clock is not None:
        most = math.floor(bench.own.clock.limit.value / 1e6)
        yield f"clock: {most} MHz", {f"{system.component}.clock": f"{most} MHz"}
    elif reason.kind == "quality":
        for key, values in system.planner.arrival_changes(system.job).items():
            trials = Trials(system)
            served = ((value, trials.trial(changes)) for value, changes in values.items())
            value = next((value for value, trial in served if trial is not None and trial.serves), "")
            value = value or list(values)[-1]
            yield f"{task}.{key}: {value}", {f"{task}.{name}": raw for name, raw in values[value].items()}
    declared = _declared(system)
    for text in reason.levers:
        lever = next((each for each in declared if text.startswith(each.text)), None)
        if lever is not None:
            yield from _of_lever(bench, reason, lever, text)
        elif reason.kind in ("resource", "bound", "mapping"):
            yield text, None


def _declared(system: System) -> list[Lever]:
    """The levers that the style gives, the longest text first."""
    demand = system.architecture.demand(system.job)
    levers = [lever for each in demand.levers.values() for lever in each]
    levers += [lever for bound in demand.bounds for lever in bound.levers]
    return sorted(levers, key=lambda lever: -len(lever.text))


def _of_lever(bench: Bench, reason: Reason, lever: Lever, text: str) -> Iterator[tuple[str, dict[str, Any] | None]]:
    system, task = bench.system, bench.system.planner.planning_task
    if lever.changes or lever.axes:
        yield text, {f"{task}.{key}": value for key, value in lever.changes.items()} | dict(lever.axes)
    elif lever.parameter == "part":
        part = _next_part(system, reason)
        if part is None:
            yield f"{text}; none of those that ship", None
        else:
            yield f"part: {part}, the smallest that ships", {f"{system.component}.part": part}
    elif lever.parameter.endswith(".component"):
        others = [name for name, spec in system.platform.components.items() if spec.plans and name != system.component]
        for name in others:
            yield f"{lever.parameter}: {name}", {lever.parameter: name}
        if not others:
            yield text, None
    else:
        yield text, None


def _next_part(system: System, reason: Reason) -> str | None:
    """The part with the fewest slices that the design fits, of its own family first; else one that ends the reason."""
    present = system.part
    family = "" if present is None else present.family
    parts = [part for part in map(load_part, list_parts()) if part != present]
    parts.sort(key=lambda part: (part.family != family, part.resources["slices"].value, part.full_name))
    helpful = None
    for part in parts:
        reasons = fit_system(replace(system, part=part)).reasons
        if not reasons:
            return part.full_name
        if helpful is None and not any(_same(reason, other) for other in reasons):
            helpful = part.full_name
    return helpful


def steps_of(bench: Bench) -> tuple[Moved, ...]:
    """The design of a run with each clock, cost, rate and parameter moved by a step, those that are better first."""
    if bench.own.mission is not None:
        return _of_mission(bench.own)
    if bench.cheap:
        return ()
    moved = [
        bench.moved(axis, {axis: value}, before=before, after=after) for axis, value, before, after in _steps(bench)
    ]
    return ranked(each for each in moved if not each.note)


def ranked(neighbours: Any) -> tuple[Moved, ...]:
    """Neighbours that are better first: feasible ones, those that gain something and lose nothing, the most gains.

    Of equals the best by the first objective.
    """

    def rank(each: Moved) -> tuple[bool, bool, int, int, float]:
        losses = (
            (-value if named(name).maximise else value) for name, value in each.figures.items() if value is not None
        )
        gained = len(each.worse) - len(each.better)
        return not each.feasible, not each.dominates, gained, len(each.worse), next(losses, math.inf)

    return tuple(sorted(neighbours, key=rank))


def _of_mission(own: Result) -> tuple[Moved, ...]:
    """The levers of a mission, which its run has tried."""
    mission = own.mission
    assert mission is not None, "the caller looks"
    before = {"mission_time_s": mission.mission_time_s, "mission_energy_j": mission.energy.mission_energy_j}
    moved = []
    for run in mission.levers or ():
        after = {"mission_time_s": run.mission_time_s, "mission_energy_j": run.mission_energy_j}
        known = {name: value for name, value in after.items() if value is not None}
        moved.append(
            Moved(
                what=run.path,
                before=run.before,
                after=run.after,
                feasible=run.reached,
                figures=dict(after),
                better=tuple(name for name, value in known.items() if value < before[name]),
                worse=tuple(name for name, value in known.items() if value > before[name]),
                note=run.refused or ("" if run.reached else run.ended or ""),
            )
        )
    return ranked(moved)


def _steps(bench: Bench) -> Iterator[tuple[str, Any, Any, Any]]:
    """The axis of each step, its raw value, and the values before and after as a reader is shown them."""
    for lever in drive_levers(bench.system, bench.own):
        if not lever.refused:
            yield lever.path, lever.value, lever.before, lever.after
    task = bench.system.planner.planning_task
    parameters = bench.system.parameters[task]
    unused = set(parameters.unused(bench.system.external is not None))
    raw = parameters.model_dump(mode="json")
    for name, info in type(parameters).model_fields.items():
        if name in unused or raw[name] is None:
            continue
        for value in _other_values(raw[name], info.annotation, parameters):
            yield f"{task}.{name}", value, raw[name], value


def _other_values(value: Any, annotation: Any, parameters: TaskParameters) -> list[Any]:
    """The values one step beside a parameter's value: half and double of a number or a shape, the other words."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [each for each in (value // _STEP, value * _STEP) if each > 0]
    if isinstance(value, list) and parameters.precisions and value == list(parameters.precisions):
        return [value[:-1]] if len(value) > 1 else []
    if isinstance(value, list) and len(value) == 2 and all(isinstance(side, int) for side in value):
        halved = [max(1, side // _STEP) for side in value]
        return [halved, [side * _STEP for side in value]]
    return [word for word in _words(annotation) if word != value] if isinstance(value, str) else []


def _words(annotation: Any) -> list[str]:
    """The words that a parameter accepts."""
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return [str(member.value) for member in annotation]
    if get_origin(annotation) is Literal:
        return [str(each) for each in get_args(annotation)]
    return [word for each in get_args(annotation) for word in _words(each)]
