"""Every row of synthesis and placement beside what the laws say of the same design on a part of its family."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.hardware.fidelity.designs import (
    Design,
    circuit_of,
    clocks,
    job_of,
    laws_of,
    resources,
    variables_of,
    words_of,
)
from codesign.hardware.rtl.cells import Counts
from codesign.hardware.rtl.design import digest_of_circuit
from codesign.inputs.library import list_parts, load_part
from codesign.planners.clock_law import held_out
from codesign.planners.job import Line
from codesign.planners.measured import PARTS, ClockRow, ResourceRow, clock_rows, resource_rows
from codesign.system import catalog

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
        part = part_for(row.family)
        job = job_of(room, found.design, part)
        held = circuit_of(room, found.design).held_out(row.variables)
        for line, resource, predicted, counted in _lines(laws_of(room, found.design).demand(job).items, row):
            yield Point(
                planner=room,
                style=f"{row.task} {row.style}".strip(),
                family=row.family,
                part=part.full_name,
                design=words_of(job, found.design),
                variables=row.variables,
                line=line,
                quantity=resource,
                predicted=predicted,
                measured=counted,
                held=held,
                present=row.digest == found.digest,
            )


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
    """Counts and their intervals, added up."""
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
            planner=room,
            style=f"{row.task} {row.style}".strip(),
            family=row.family,
            part=row.part,
            design=words_of(job, found.design),
            variables=row.variables,
            line="",
            quantity="clock",
            predicted=laws_of(room, found.design).clock_limit(job),
            measured=row.clock,
            held=False,
            present=row.digest == found.digest,
            without=without.get(row.key),
            note=f"{seeds}; {row.path}",
        )


def width_of(figure: Figure) -> float:
    """Half of an interval over its value."""
    low, high = figure.interval
    return (high - low) / 2 / figure.value if figure.value else math.inf
