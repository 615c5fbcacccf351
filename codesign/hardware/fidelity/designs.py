"""The designs that are synthesised and placed, so that laws are fitted to them and held against them.

``designs.yaml`` has them, by planner. ``python -m benchmarks.measure`` writes their rows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from codesign import maps
from codesign.ground.models import Part
from codesign.planners.circuits import Circuit, CircuitStyle
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, TaskStyle
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem, generate
from codesign.system import catalog


def free_map(rows: int, columns: int) -> Problem:
    """A map without obstacles; the goal is in a corner."""
    return Problem(np.ones((rows, columns), bool), ((0, 0),), ((rows - 1, columns - 1),))


def scattered_map(rows: int, columns: int, seed: int) -> Problem:
    """A map with a fifth of its cells obstacles: a goal near the middle, and the start that is farthest off."""
    free = maps.random_obstacles(rows, columns, density=0.2, seed=seed).free
    goal = maps.nearest_free(free, (rows // 2, columns // 2))
    assert goal is not None, "a fifth of a map leaves free cells"
    steps = maps.distance_steps(free, [goal])
    row, column = divmod(int(steps.argmax()), columns)
    return Problem(free, (goal,), ((row, column),))


_NARROW = 15
"""Below this width the words are too narrow for the robots of the paper's arena."""


def circle(robots: int, width: int) -> RobotsProblem:
    """Robots on a circle: in the paper's arena, or in one that words of ``width`` bits suffice for."""
    if width >= _NARROW:
        return generate("circle", robots)
    return generate("circle", robots, radius=0.25, speed=24.0, acceleration=96.0, arena=(15.0, 15.0))


@dataclass(frozen=True, eq=False)
class Design:
    """A design point: what it plans on, the raw parameters of the planning task, and other fields of its ``Job``.

    ``seed``: of a random map.
    """

    style: str
    parameters: Mapping[str, Any]
    problem: Callable[[], Any]
    task: str = ""
    job: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0


@dataclass(frozen=True)
class Placed:
    """A design on a part, with the seeds that it is placed with."""

    design: Design
    part: str
    seeds: Sequence[int]


def design_of(entry: Mapping[str, Any]) -> Design:
    """The design of an entry of ``designs.yaml``."""
    parameters = {name: _frozen(value) for name, value in entry.get("of", {}).items()}
    seed = entry.get("seed", 0)
    if "free" in entry:
        problem: Callable[[], Any] = partial(free_map, *entry["free"])
    elif "scattered" in entry:
        rows, columns = entry["scattered"]
        problem = partial(scattered_map, rows, columns, seed)
    else:
        problem = partial(circle, entry["robots"], parameters["width"])
    job = {"inside": frozenset(entry["inside"])} if "inside" in entry else {}
    return Design(entry["style"], parameters, problem, entry.get("task", ""), job, seed)


def _frozen(value: Any) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


@cache
def _entries() -> Mapping[str, Mapping[str, Any]]:
    listed: Mapping[str, Mapping[str, Any]] = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
    return listed


@cache
def resources(room: str) -> Sequence[Design]:
    """The designs of a room that are synthesised."""
    return tuple(map(design_of, _entries().get(room, {}).get("resources", ())))


@cache
def clocks(room: str) -> Sequence[Placed]:
    """The designs of a room that are placed."""
    listed = _entries().get(room, {}).get("clocks", ())
    return tuple(Placed(design_of(each), each["part"], range(1, each["seeds"] + 1)) for each in listed)


@cache
def activities(room: str) -> Sequence[Design]:
    """The designs of a room that toggles are counted on, on maps of ``scattered_map``."""
    return tuple(map(design_of, _entries().get(room, {}).get("activities", ())))


def circuit_of(room: str, design: Design) -> CircuitStyle:
    """The circuits of the style of a design."""
    return catalog.circuits()[room, design.style, design.task]


def job_of(room: str, design: Design, part: Part | None = None) -> Job[Any, Any]:
    """The job that circuit and laws of a design are asked about, on a part."""
    planner = catalog.planners()[room]
    parameters = planner.tasks[planner.planning_task].model_validate(design.parameters)
    if not design.task:
        parameters = catalog.architectures()[room, design.style].settled(parameters)
    return Job(design.problem(), parameters, part=part, **design.job)


def laws_of(room: str, design: Design) -> Architecture | TaskStyle:
    """The style that predicts a design."""
    if design.task:
        return catalog.task_styles()[room, design.task, "fpga", design.style]
    return catalog.architectures()[room, design.style]


def variables_of(circuit: Circuit) -> dict[str, int]:
    """The variables of a row: the whole numbers among the parameters of the top module."""
    return {name: int(value) for name, value in circuit.parameters.items() if isinstance(value, int)}


def words_of(job: Job[Any, Any], design: Design) -> str:
    """A design in a few words: its map or its robots, and the parameters that it gives, without mappings."""
    problem = job.problem
    size = "{} × {}".format(*problem.shape) if isinstance(problem, Problem) else f"{problem.count} robots"
    texts = {
        name: (" × " if name == "block" else ", ").join(map(str, value)) if isinstance(value, tuple) else str(value)
        for name, value in design.parameters.items()
        if isinstance(value, int | str | tuple)
    }
    values = (f"{name} {text}".replace("_", " ") for name, text in texts.items())
    return ", ".join((size, *values))
