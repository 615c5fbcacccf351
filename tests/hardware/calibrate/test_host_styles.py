"""Simulated host times are units times costs, and every unit that a host style counts has a probe."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import codesign
from codesign import maps
from codesign.ground.errors import SpecError
from codesign.hardware.calibrate.host_costs import all_probes
from codesign.inputs import Platform
from codesign.planners.grid_search.styles import KERNELS as GRID_KERNELS
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.styles.node_kernels import relax_nodes
from codesign.planners.styles import Step
from codesign.system import catalog
from codesign.system.scenarios.run import bind

HARMONIC = {"blocks": [2, 2], "iterations": 40, "schedule": [15, 63, 127]}
CASES: list[tuple[str, dict[str, Any], str]] = [
    ("breadth_first", {"style": "software"}, "path"),
    ("breadth_first", {"style": "software"}, "field"),
    ("breadth_first", {"style": "software_java"}, "path"),
    ("wavefront", {"style": "software"}, "path"),
    ("wavefront", {"style": "software", "paths": "safe"}, "path"),
    ("wavefront", {"style": "software"}, "field"),
    *(("relaxation", {"style": "sequential", "method": method}, "path") for method in ("am", "gs", "direct")),
    *(("relaxation", {"style": "two_core", "method": method}, "path") for method in ("am", "half_sweep_am")),
    *(("grid_search", {"method": method}, "path") for method in ("astar", "jump_point", "theta_star", "navfn")),
    ("grid_search", {"heuristic": "none"}, "field"),
    ("harmonic", HARMONIC | {"style": "software"}, "path"),
    ("harmonic", HARMONIC | {"style": "software_limbs"}, "path"),
]
NOT_TIMED = {"breadth_first_java_cell"}
"""The program of a paper, which this package does not hold."""

SIDE_KERNELS = {
    "breadth_first_map_cell",
    "breadth_first_wall_cell",
    "wavefront_map_cell",
    "wavefront_time_step",
    "relaxation_map_cell",
    "relaxation_diagonal",
    "relaxation_check_cell",
    *(kernel for kernels in GRID_KERNELS.values() for kernel in kernels),
}


def costs() -> dict[str, int]:
    """Costs in ps, all different."""
    names = sorted({*all_probes(), *NOT_TIMED})
    return {name: 1_000 + 7 * index for index, name in enumerate(names)}


def host(prices: Mapping[str, int]) -> Platform:
    processor = {
        "type": "processor",
        "clock": "1 GHz",
        "power": {"busy": "10 W", "idle": "2 W"},
        "costs": {name: f"{cost} ps" for name, cost in prices.items()},
    }
    return codesign.load_platform({"kind": "platform", "name": "here", "components": {"pc": processor}})


def workload(planner: str, parameters: Mapping[str, Any], task: str) -> dict[str, Any]:
    problem = {
        "map": {"generate": "rooms", "rows": 24, "columns": 32, "room": [11, 15], "door": 3, "seed": 5},
        "goals": [[2, 2]],
        "starts": [[20, 28]],
        "task": task,
        "arrive": 0,
    }
    mapping = {catalog.planner(planner).planning_task: {"component": "pc", **parameters}}
    return {"kind": "workload", "name": "here", "planner": planner, "problem": problem, "mapping": mapping}


def steps_of(platform: Platform, question: Mapping[str, Any]) -> tuple[str, list[Step]]:
    system = bind(platform, codesign.load_workload(dict(question)))
    job, left_out = system.job, set()
    if question["problem"]["task"] == "field":
        left_out = {"track", "search", "decide"} - {system.planner.planning_task}
    inside = None if job.inside is None else job.inside - left_out
    return system.architecture.kernel, list(system.architecture.work(replace(job, inside=inside)))


def priced(kernel: str, steps: list[Step], prices: Mapping[str, int]) -> int:
    """Picoseconds of the steps: units times costs."""
    return sum(prices[step.kernel or kernel] * int(step.cycles.sum()) for step in steps)


@pytest.mark.parametrize(("planner", "parameters", "task"), CASES, ids=str)
def test_the_simulated_time_is_units_times_costs(planner: str, parameters: dict[str, Any], task: str) -> None:
    prices = costs()
    platform, question = host(prices), workload(planner, parameters, task)
    result = codesign.simulate(platform, question)
    assert result.task is not None
    assert result.task.plan_time_mean_s is not None
    expected = priced(*steps_of(platform, question), prices)
    assert round(result.task.plan_time_mean_s * 1e12) == expected > 0


def test_every_kernel_of_a_host_style_has_a_probe() -> None:
    prices, counted = costs(), Counter[str]()
    platform = host(prices)
    for planner, parameters, task in CASES:
        kernel, steps = steps_of(platform, workload(planner, parameters, task))
        counted.update(step.kernel or kernel for step in steps)
    styles = [*catalog.architectures().values(), *catalog.task_styles().values()]
    kernels = {style.kernel for style in styles if style.kernel} | set(counted)
    assert kernels - NOT_TIMED <= set(all_probes())
    assert set(counted) >= SIDE_KERNELS


@pytest.mark.parametrize(("planner", "parameters", "task"), CASES, ids=str)
def test_a_kernel_without_a_cost_is_a_fault(planner: str, parameters: dict[str, Any], task: str) -> None:
    """None counts as zero: without the cost of any kernel that a run counts in, there is no run."""
    question = workload(planner, parameters, task)
    kernel, steps = steps_of(host(costs()), question)
    for left_out in {step.kernel or kernel for step in steps}:
        platform = host({name: cost for name, cost in costs().items() if name != left_out})
        with pytest.raises(SpecError, match=f"pc has no cost of kernel {left_out}, which"):
            codesign.simulate(platform, question)


@pytest.mark.parametrize("seed", range(4))
def test_the_plain_loop_is_the_relaxation(seed: int) -> None:
    """The field bit for bit. The planner counts one iteration more a stage, of the sweep that sees no change."""
    free = maps.random_obstacles(23, 31, density=0.25, seed=seed).free
    goal = tuple(int(value) for value in np.argwhere(free)[7])
    plan = relax(free, [goal], block=free.shape, iterations=1 << 20, schedule=(15, 31, 60))
    field, iterations = relax_nodes(free, [goal], (15, 31, 60))
    assert (plan.values == field).all()
    assert [stage.iterations - 1 for stage in plan.stages] == iterations
