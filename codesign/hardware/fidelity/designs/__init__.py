"""The designs that are synthesised and placed, so that laws are fitted to them and held against them.

``python -m benchmarks.measure`` writes their rows. ``designs/ROOM.py`` has the designs of a room: ``RESOURCES``, some
``Design``, ``CLOCKS``, some ``Placed``, and ``ACTIVITIES``, some ``Design``. Any may be missing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.models import Part
from codesign.planners.circuits import Circuit, CircuitStyle
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, TaskStyle
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


FEW = 1, 2, 3
"""Seeds of a design that a law is fitted to: five are for those that it is held against."""
ONE = (1,)
"""The seed of a design that takes minutes to place."""


@dataclass(frozen=True)
class Placed:
    """A design on a part, with the seeds that it is placed with."""

    design: Design
    part: str
    seeds: Sequence[int] = (1, 2, 3, 4, 5)


def resources(room: str) -> Sequence[Design]:
    """The designs of a room that are synthesised; none where the room has no module here."""
    designs: Sequence[Design] = vars(_module(room)).get("RESOURCES", ())
    return designs


def clocks(room: str) -> Sequence[Placed]:
    """The designs of a room that are placed; none where the room has no module here."""
    placed: Sequence[Placed] = vars(_module(room)).get("CLOCKS", ())
    return placed


def activities(room: str) -> Sequence[Design]:
    """The designs of a room that toggles are counted on, on maps of ``scattered_map``; none where it has none."""
    designs: Sequence[Design] = vars(_module(room)).get("ACTIVITIES", ())
    return designs


def _module(room: str) -> Any:
    name = f"{__name__}.{room}"
    return import_module(name) if find_spec(name) else object


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
