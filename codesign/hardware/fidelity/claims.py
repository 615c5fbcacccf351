"""The figures that the papers published, beside the laws and the Verilog of this package, one by one.

Only rows of the papers that the Verilog has too stand here: rows of a ``rows.yaml`` with a ``circuit``. It names a
measure of this module. ``hwsw reproduce`` compares all rows with the model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from codesign.hardware.fidelity.points import TOTAL, Point, circuit_of, clocks, job_of, resources, words_of
from codesign.inputs.library import load_part
from codesign.planners.breadth_first.paper.measures import PAPER as BREADTH_FIRST
from codesign.planners.counted import REPORTS
from codesign.planners.harmonic.paper.measures import PAPER as HARMONIC
from codesign.planners.papers import Case, Entry, Paper, filled, printed
from codesign.planners.velocity_obstacle.paper.measures import PAPER as VELOCITY_OBSTACLE
from codesign.planners.wavefront.paper.measures import PAPER as WAVEFRONT

PAPERS = HARMONIC, BREADTH_FIRST, WAVEFRONT, VELOCITY_OBSTACLE
REPORTED, COUNTED_A_SLICE = "XC7Z020-1", 2
"""The part of the public reports of power, and how many slices laws count in one of it."""


@dataclass(frozen=True)
class Claim:
    """A figure of a paper.

    - ``name``: what reasons name it by. ``place``: paper, table or section.
    - ``published``, ``law``, ``circuit``: in ``unit``; None where the law does not speak of it, or nothing counts it.
    - ``how``: what ``circuit`` is taken from.
    """

    name: str
    place: str
    quantity: str
    unit: str
    published: float
    law: float | None
    circuit: float | None
    how: str

    @property
    def error(self) -> float | None:
        """By what share the circuit is above the paper; the law where no circuit was counted."""
        value = self.law if self.circuit is None else self.circuit
        return None if value is None or not self.published else value / self.published - 1


@dataclass(frozen=True)
class Counted:
    """The figures of laws and circuits for a row, and their source. ``published``: if it is not printed as such."""

    law: float | None
    circuit: float | None
    how: str
    published: float | None = None


Measure = Callable[[Sequence[Point], Case], Counted | None]
MEASURES: dict[str, Measure] = {}
"""The measures that a row of a paper may name for its ``circuit``, by name."""


def measure(function: Measure) -> Measure:
    """Let rows name a function. It is called with all points, and with the numbers of the row; None: it has none."""
    MEASURES[function.__name__] = function
    return function


def claims(points: Sequence[Point]) -> tuple[Claim, ...]:
    """Every figure that papers and Verilog both have, and the public reports of power."""
    of_papers = [claim for paper in PAPERS for claim in _of_paper(paper, points)]
    return (
        *(claim for claim in of_papers if claim.unit != "W"),
        *_of_reports(),
        *(claim for claim in of_papers if claim.unit == "W"),
    )


def _of_paper(paper: Paper, points: Sequence[Point]) -> Iterator[Claim]:
    for part in paper.sheet.parts:
        entries = [entry for entry in part.entries if entry.circuit is not None]
        for case in paper.cases(part, None) if entries else ():
            for entry in entries:
                claim = _of_row(paper, entry, case, points)
                if claim is not None:
                    yield claim


def _of_row(paper: Paper, entry: Entry, case: Mapping[str, Any], points: Sequence[Point]) -> Claim | None:
    assert entry.circuit is not None, "chosen by it"
    values = {**paper.figures, **case, **entry.of}
    row = None if entry.measure is None else paper.row(entry, case, None)
    counted = MEASURES[entry.circuit.measure](points, Case(**values, row=row))
    if counted is None:
        return None
    place = entry.circuit.place or f"{paper.printed.cited}, {filled(entry.place, values)}"
    listed = printed(entry.published, entry.circuit.over, values)
    return Claim(
        name=filled(entry.circuit.name, values),
        place=place,
        quantity=filled(entry.circuit.what or entry.what, values),
        unit=entry.circuit.unit or entry.unit or "1",
        published=listed if counted.published is None else counted.published,
        law=counted.law,
        circuit=counted.circuit,
        how=counted.how,
    )


def _chosen(points: Sequence[Point], **wanted: str) -> list[Point]:
    return [point for point in points if all(vars(point)[name] == value for name, value in wanted.items())]


def _plain(points: Sequence[Point], line: str, quantity: str) -> list[Point]:
    """A line of the harmonic circuit by the plain pipeline of the publication, on Virtex-II."""
    chosen = _chosen(points, planner="harmonic", family="xc2v", line=line, quantity=quantity)
    return [point for point in chosen if not point.variables.get("PIPELINE")]


@measure
def node_count(points: Sequence[Point], case: Case) -> Counted | None:
    """A resource of one node, as the mean over arrays."""
    rows = _plain(points, "nodes", case.kind)
    if case.rows * case.columns != 1 or not rows:
        return None
    nodes = [row.variables["ROWS"] * row.variables["COLUMNS"] for row in rows]
    law = fmean(row.predicted.value / count for row, count in zip(rows, nodes, strict=True))
    counted = fmean(row.measured / count for row, count in zip(rows, nodes, strict=True))
    return Counted(law, counted, f"mean of {len(rows)} arrays, Yosys for Virtex-II")


@measure
def slices_of_line(points: Sequence[Point], case: Case) -> Counted | None:
    """Slices of the decision or the control, as half of the LUT of the largest."""
    rows = _plain(points, case.line, "lut4")
    if not rows:
        return None
    most = max(rows, key=lambda row: row.measured)
    how = f"half of {most.measured:,.0f} LUT, {most.design}"
    listed = case.decision_slices_a_bit * case.design_precision + case.decision_slices
    published = listed if case.line == "decision" else None
    return Counted(most.predicted.value / 2, most.measured / 2, how, published)


@measure
def placed_clock(points: Sequence[Point], case: Case) -> Counted | None:
    """The fastest placement of a style, on whatever part."""
    rows = _chosen(points, planner=case.planner, style=case.style, quantity="clock")
    if not rows:
        return None
    best = max(rows, key=lambda row: row.measured)
    how = f"placed on {best.part}, not on the paper's part: {best.design}"
    return Counted(best.predicted.value, best.measured, how)


@measure
def cycles_of_elements(_points: Sequence[Point], _case: Case) -> Counted | None:
    """Cycles a cell of arrays with several cells an element, as the laws count them and ``hwsw verify`` compares."""
    jobs = [
        (job_of("wavefront", design), design)
        for design in (*resources("wavefront"), *(each.design for each in clocks("wavefront")))
        if design.parameters.get("element_cells", 1) > 1
    ]
    if not jobs:
        return None
    job, design = max(jobs, key=lambda pair: pair[0].problem.free.size)
    cycles = sum(circuit_of("wavefront", design).expected(job).cycles.values()) / job.problem.free.size
    return Counted(cycles, cycles, f"load, wave and path, {words_of(job, design)}")


@measure
def lut_of_style(points: Sequence[Point], case: Case) -> Counted | None:
    """The LUT of Table I, whose share of the part is published, beside the synthesised circuit of the same width."""
    rows = [
        point
        for point in _chosen(
            points, planner="velocity_obstacle", style=case.style, family="xc3se", line=TOTAL, quantity="lut4"
        )
        if point.variables["WIDTH"] == 16 and not point.variables["PARALLEL"] and not point.variables["CROSS_PRODUCT"]
    ]
    if not rows:
        return None
    row = min(rows, key=lambda each: (each.variables["ROBOTS"], len(each.design)))
    how = f"Yosys for Spartan-3E, {row.design}"
    return Counted(row.predicted.value, row.measured, how, case.luts / 100 * case.lut4_of_part)


@measure
def power_by_law(_points: Sequence[Point], case: Case) -> Counted:
    """The law of power. No circuit was measured."""
    return Counted(case.row.modelled / 1e3, None, f"{case.row.use}: {case.row.source}")


def _of_reports() -> Iterator[Claim]:
    """Power: the laws beside public reports. No circuit was measured."""
    part = load_part(REPORTED)
    for report in REPORTS:
        counted = report.slices * COUNTED_A_SLICE
        yield Claim(
            "power of the fabric",
            f"Mucha and Scechura 2023, {part.name}",
            f"dynamic, {report.slices:,} slices at {report.clock / 1e6:.0f} MHz",
            "W",
            report.dynamic,
            part.dynamic_power.value * counted * report.clock,
            None,
            f"{part.name}: power of a slice and Hz, which comes from these two reports",
        )
