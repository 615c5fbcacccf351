"""Simulated times of planners on a host against direct measurements of the same work, on real maps.

The costs of the host are measured in the same run, as ``hwsw calibrate host`` measures them. Both sides hold planning
and the answer on one core: all tasks are on the host, so no link takes part and the map is loaded in no time. A direct
time is processor time of the planner's own code for the same starts, compiled before: the median of several runs, less
what Python takes on a map of two cells. Harmonic control is timed node after node, as its style counts.
Maps are read from ``shared/maps`` beside the repository.
"""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import fmean, median
from typing import Any

import numpy as np

import codesign
from codesign import maps
from codesign.ground.figures import Figure
from codesign.ground.models import Task
from codesign.hardware.calibrate.host_costs import measure_host
from codesign.inputs import Platform
from codesign.maps import reachable
from codesign.planners.harmonic.styles.node_kernels import relax_nodes
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.system import catalog
from codesign.system.scenarios.run import bind

REAL = Path(__file__).parents[1].parent / "shared" / "maps"
REAL_MAPS = {
    "city 256²": "movingai/cities/Berlin_0_256.map",
    "maze 512²": "movingai/mazes/maze512-32-0.map",
    "game 49²": "movingai/dao/arena.map",
    "narrow maze 128²": "movingai/mapf/maze-128-128-2.map",
    "warehouse 63×161": "movingai/mapf/warehouse-10-20-10-2-1.map",
    "SLAM, cropped": "ros/turtlebot3/map.yaml",
}
HELD_OUT = {"rooms 512²": "movingai/rooms/16room_000.map", "depot, cropped": "ros/nav2/depot.yaml"}
"""The least-squares fits of docs/laws.md left these maps out."""

STARTS, RUNS, SECONDS = 12, 9, 1.0
CALIBRATION_SECONDS = 6.0
BOUND = 1.5


@dataclass(frozen=True, eq=False)
class Case:
    """A planner on the host, its planning task, and the declared task."""

    planner: str
    parameters: Mapping[str, Any]
    task: Task = Task.PATH
    remark: str = ""

    @property
    def label(self) -> str:
        """The planner in words."""
        return ", ".join(text for text in (self.planner, self.remark, f"task {self.task}") if text)


CASES = (
    Case("breadth_first", {"style": "software"}),
    Case("breadth_first", {"style": "software"}, Task.FIELD),
    Case("wavefront", {"style": "software"}),
    Case("wavefront", {"style": "software", "paths": "safe"}, remark="safe"),
    Case("wavefront", {"style": "software"}, Task.FIELD),
    Case("relaxation", {"style": "sequential", "method": "am"}, remark="am"),
    Case("relaxation", {"style": "sequential", "method": "gs"}, remark="gs"),
    Case("relaxation", {"style": "sequential", "method": "direct"}, remark="direct"),
    Case("harmonic", {"style": "software", "blocks": [1, 1], "iterations": 1_000_000, "schedule": [15, 31]}),
)


def platform_of(costs: Mapping[str, float]) -> dict[str, Any]:
    """A platform of one host with these costs, s a unit of each kernel."""
    host = {
        "type": "processor",
        "clock": "1 GHz",
        "power": {"busy": "10 W", "idle": "2 W"},
        "costs": {name: f"{round(cost * 1e12)} ps" for name, cost in costs.items()},
    }
    return {"kind": "platform", "name": "here", "components": {"pc": host}, "roles": {"host": "pc"}}


def workload_of(case: Case, problem: Mapping[str, Any]) -> dict[str, Any]:
    """The planner of ``case`` on the host."""
    task = catalog.planner(case.planner).planning_task
    return {
        "kind": "workload",
        "name": "here",
        "planner": case.planner,
        "problem": {**problem, "task": case.task.value, "arrive": 0},
        "mapping": {task: {"component": "host", **case.parameters}},
    }


def questions() -> Iterator[tuple[str, dict[str, Any]]]:
    """The problem of each map, with a goal and starts drawn."""
    for name, file in (REAL_MAPS | HELD_OUT).items():
        if not (REAL / file).is_file():
            print(f"{name} is left out: {file} is absent")
            continue
        free = maps.read_map(REAL / file).free
        random, cells = np.random.default_rng(10), np.argwhere(free)
        goal = random.choice(cells).tolist()
        while 2 * reachable(free, [goal]).sum() < free.sum():
            goal = random.choice(cells).tolist()
        starts = random.choice(np.argwhere(reachable(free, [goal])), STARTS, replace=False)
        crop = "free" if file.startswith("ros/") else "none"
        spec = {"file": str(REAL / file), "crop": crop}
        yield name, {"map": spec, "goals": [goal], "starts": starts.tolist()}


def timed(calls: Sequence[Callable[[], object]]) -> list[float]:
    """The median processor time of each call, s. Kernels are compiled before.

    The calls take turns: a processor that repeats one search over a small map learns its branches by heart.
    """
    times: list[list[float]] = [[] for _ in calls]
    while not times[0] or (len(times[0]) < RUNS and sum(map(sum, times)) < SECONDS):
        for call, each in zip(calls, times, strict=True):
            begin = time.thread_time()
            call()
            each.append(time.thread_time() - begin)
    return [median(each) for each in times]


def direct(case: Case, job: Job[Any, Any]) -> float:
    """Processor time of the planner's own code, s: plan and answer, the mean over the starts."""
    planner, problem = catalog.planner(case.planner), job.problem
    problems = [problem]
    if planner.plans_for_start(job):
        problems = [replace(problem, starts=(start,)) for start in problem.starts]
    calls = [partial(asked, case, job, each) for each in problems]
    return fmean(timed(calls)) - _call(case, job)


def asked(case: Case, job: Job[Any, Any], problem: Problem) -> object:
    """The plan, and the path from its first start. A decision of harmonic control is far below a microsecond."""
    if case.planner == "harmonic":
        return relax_nodes(problem.free, problem.goals, job.parameters.precisions)
    planner = catalog.planner(case.planner)
    plan = planner.plan(replace(job, problem=problem))
    return plan if case.task is Task.FIELD else planner.trajectory(problem, plan, problem.starts[0])


def _call(case: Case, job: Job[Any, Any]) -> float:
    """What Python takes besides the kernels: the same on a map of two cells, s."""
    tiny = replace(job.problem, free=np.ones((1, 2), np.bool_), goals=((0, 0),), starts=((0, 1),))
    call = partial(asked, case, job, tiny)
    call()
    return timed([call])[0]


def bit_planes(job: Job[Any, Any]) -> float:
    """Processor time of the planner of harmonic control itself, s."""
    return timed([partial(catalog.planner("harmonic").plan, job)])[0]


def run() -> list[dict[str, str]]:
    """A row for each planner and map, then the least, median and worst ratio of each planner."""
    before = measure_host(CALIBRATION_SECONDS).costs
    cases = [(name, case, problem) for name, problem in questions() for case in CASES]
    measured = []
    for name, case, problem in cases:
        measured.append(_measured(case, problem, before))
        print(f"{name}, {case.label}: {1e3 * measured[-1][0]:.4g} ms measured", flush=True)
    after = measure_host(CALIBRATION_SECONDS).costs
    costs = {name: (figure.value + after[name].value) / 2 for name, figure in before.items()}
    drift = max(abs(after[name].value / figure.value - 1) for name, figure in before.items())
    print(f"the cost that differed most before and after: by {100 * drift:.0f} %")
    platform, rows, ratios = codesign.load_platform(platform_of(costs)), [], defaultdict(list)
    for (name, case, problem), (seconds, planes) in zip(cases, measured, strict=True):
        simulated = _simulated(case, problem, platform)
        ratios[case].append(simulated / seconds)
        note = f"bit planes take {1e3 * planes:.4g} ms" if planes else "held out" if name in HELD_OUT else ""
        rows.append(_row(case.label, name, f"{1e3 * simulated:.4g}", f"{1e3 * seconds:.4g}", simulated / seconds, note))
    for case, values in ratios.items():
        spread = f"{min(values):.2f} to {max(values):.2f}, median {median(values):.2f}"
        worst = max(values, key=lambda value: abs(math.log(value)))
        rows.append(_row(case.label, "all", "", "", worst, spread))
    return rows


def _row(planner: str, name: str, simulated: str, measured: str, ratio: float, note: str) -> dict[str, str]:
    outside = "" if 1 / BOUND <= ratio <= BOUND else " (outside)"
    return {
        "planner": planner,
        "map": name,
        "simulated, ms": simulated,
        "measured, ms": measured,
        "ratio": f"{ratio:.2f}{outside}",
        "note": note,
    }


def _measured(case: Case, problem: Mapping[str, Any], costs: Mapping[str, Figure]) -> tuple[float, float]:
    """The direct time, and for harmonic control that of its bit planes, else 0; s."""
    platform = codesign.load_platform(platform_of({name: figure.value for name, figure in costs.items()}))
    job = bind(platform, codesign.load_workload(workload_of(case, problem))).job
    return direct(case, job), bit_planes(job) if case.planner == "harmonic" else 0.0


def _simulated(case: Case, problem: Mapping[str, Any], platform: Platform) -> float:
    task = codesign.simulate(platform, workload_of(case, problem)).task
    assert task is not None, "every point is simulated"
    assert task.plan_time_mean_s is not None, "every start is answered"
    return task.plan_time_mean_s
