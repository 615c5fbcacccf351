"""Every row of synthesis and placement beside what the laws say of the same design on a part of its family."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from codesign import maps
from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.hardware.rtl.cells import Counts
from codesign.hardware.rtl.design import digest_of_circuit
from codesign.inputs.library import list_parts, load_part
from codesign.planners.circuits import Circuit, CircuitStyle
from codesign.planners.clock_law import held_out
from codesign.planners.interface import Problem
from codesign.planners.job import Job, Line
from codesign.planners.measured import PARTS, ClockRow, ResourceRow, clock_rows, resource_rows
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
    text = Path(__file__).with_name("designs.yaml").read_text("utf-8")
    listed: Mapping[str, Mapping[str, Any]] = yaml.safe_load(text)
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


RESOURCES = tuple(Counts().by_resource())
TOTAL, OTHERS = "all", "others"
"""The sum of all lines and modules; and of those that only the demand, or only the circuit, has by this name."""


@dataclass(frozen=True)
class Point:
    """One figure of the laws beside the same one counted by synthesis, or reached by placements.

    - ``planner``, ``style`` (after its task, where that is placed by itself), ``design`` in words.
    - ``family`` (of rows), and the ``part`` that the law was asked about.
    - ``line``, ``quantity``: of the demand; for a clock "" and ``clock``.
    - ``variables``: the parameters of the top module.
    - ``predicted``: by the law. ``measured``: in its unit; of a clock the median of the seeds.
    - ``held``: whether the law left the row out of its fit.
    - ``present``: whether the row is of the Verilog that the package holds, by its digest.
    - ``without``: of a clock, by what share the fit to all other placements is above it; None where no other one
      speaks of it.
    - ``note``: of a clock, the seeds and the critical path.
    """

    planner: str
    style: str
    family: str
    part: str
    design: str
    variables: Mapping[str, int]
    line: str
    quantity: str
    predicted: Figure
    measured: float
    held: bool
    present: bool
    without: float | None = None
    note: str = ""

    @property
    def error(self) -> float:
        """By what share of the measured figure the law is above it; 1 where nothing of it was measured."""
        if not self.measured:
            return float(self.predicted.value > 0)
        return self.predicted.value / self.measured - 1

    @property
    def holds(self) -> bool:
        """True if the law's interval has the measured figure in it."""
        low, high = self.predicted.interval
        return low <= self.measured <= high


@dataclass(frozen=True, eq=False)
class Known:
    """A design that rows are found for: its variables and the digest of its Verilog."""

    design: Design
    variables: Mapping[str, int]
    digest: str


def rooms() -> tuple[str, ...]:
    """The planners with circuits, by name."""
    return tuple(dict.fromkeys(planner for planner, *_ in catalog.circuits()))


def points() -> tuple[Point, ...]:
    """Every row of every room."""
    return tuple(point for room in rooms() for point in (*resource_points(room), *clock_points(room)))


def rows_of(room: str) -> Iterator[ResourceRow | ClockRow]:
    """Every row of a room."""
    for planner, style, task in catalog.circuits():
        if planner == room:
            yield from resource_rows(room, style, task)
            yield from clock_rows(room, style, task)


@cache
def known_designs(room: str) -> tuple[Known, ...]:
    """The designs of a room, in the order of its lists."""
    designs = dict.fromkeys((*resources(room), *(placed.design for placed in clocks(room))))
    circuits = ((each, circuit_of(room, each).circuit(job_of(room, each))) for each in designs)
    return tuple(Known(each, variables_of(circuit), digest_of_circuit(circuit)) for each, circuit in circuits)


def known_of(room: str, row: ResourceRow | ClockRow) -> Known | None:
    """The design of a row: of its Verilog, or else the first that has its variables, and maybe later ones too."""
    alike = [
        known
        for known in known_designs(room)
        if (known.design.style, known.design.task) == (row.style, row.task)
        and row.variables.items() <= known.variables.items()
    ]
    return next((known for known in alike if known.digest == row.digest), alike[0] if alike else None)


@cache
def part_for(family: str) -> Part:
    """The largest shipped part of a family of rows, in its fastest grade."""
    parts = (load_part(name) for name in list_parts())
    return max(
        (part for part in parts if PARTS.get(part.family) == family),
        key=lambda part: (part.resources["lut4"].value, part.block_ram_clock.value, part.full_name),
    )


def resource_points(room: str) -> Iterator[Point]:
    """Each line and resource of each synthesis, and their sums."""
    for row in rows_of(room):
        found = known_of(room, row)
        if not isinstance(row, ResourceRow) or found is None:
            continue
        job = job_of(room, found.design, part_for(row.family))
        of_row, held = _of_row(room, row, found, job), circuit_of(room, found.design).held_out(row.variables)
        for line, resource, predicted, counted in _lines(laws_of(room, found.design).demand(job).items, row):
            yield Point(**of_row, line=line, quantity=resource, predicted=predicted, measured=counted, held=held)


def _of_row(room: str, row: ResourceRow | ClockRow, found: Known, job: Job[Any, Any]) -> dict[str, Any]:
    """The fields of a point that follow from its row and its design."""
    assert job.part is not None, "a design on a part"
    return {
        "planner": room,
        "style": f"{row.task} {row.style}".strip(),
        "family": row.family,
        "part": job.part.full_name,
        "design": words_of(job, found.design),
        "variables": row.variables,
        "present": row.digest == found.digest,
    }


def _lines(items: tuple[Line, ...], row: ResourceRow) -> Iterator[tuple[str, str, Figure, int]]:
    """Line, resource, law and count: of the lines that demand and circuit share, of the others, and of all."""
    for resource in RESOURCES:
        law = sum_by_name(items, resource)
        counted = {name: row.count(name, resource) for name in row.pieces}
        shared = [name for name in law if counted.get(name)]
        for name in shared:
            yield name, resource, law[name], counted[name]
        for line, taken in ((OTHERS, set(shared)), (TOTAL, set[str]())):
            predicted = _sum([figure for name, figure in law.items() if name not in taken], "sum of lines")
            count = sum(number for name, number in counted.items() if name not in taken)
            if predicted.value or count:
                yield line, resource, replace(predicted, status=Status.CALIBRATED), count


def sum_by_name(items: tuple[Line, ...], resource: str) -> dict[str, Figure]:
    """The demand for a resource by the name of the line."""
    sums: dict[str, Figure] = {}
    for line in items:
        if line.resource == resource:
            before = sums.get(line.name)
            sums[line.name] = line.figure if before is None else _sum((before, line.figure), before.source)
    return sums


def _sum(figures: Sequence[Figure], source: str) -> Figure:
    low, high = (sum(figure.interval[end] for figure in figures) for end in (0, 1))
    status = figures[0].status if figures else Status.CALIBRATED
    return Figure(sum(figure.value for figure in figures), "1", status, source, low, high)


def clock_points(room: str) -> Iterator[Point]:
    """Each placed design: the clock limit of its style on that part, and the median of the seeds."""
    without = held_out(import_module(f"codesign.planners.{room}.styles.timing").placements())
    for row in rows_of(room):
        found = known_of(room, row)
        if not isinstance(row, ClockRow) or found is None:
            continue
        job = job_of(room, found.design, load_part(row.part))
        seeds = f"{len(row.clocks)} seed{'s' if len(row.clocks) > 1 else ''}"
        yield Point(
            **_of_row(room, row, found, job) | {"part": row.part},
            line="",
            quantity="clock",
            predicted=laws_of(room, found.design).clock_limit(job),
            measured=row.clock,
            held=False,
            without=without.get(row.key),
            note=f"{seeds}; {row.path}",
        )


def width_of(figure: Figure) -> float:
    """Half of an interval over its value."""
    low, high = figure.interval
    return (high - low) / 2 / figure.value if figure.value else math.inf
