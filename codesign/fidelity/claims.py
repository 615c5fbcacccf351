"""What the papers published, beside the laws and the Verilog of this package, figure by figure.

Only figures that the Verilog has too stand here; ``hwsw reproduce`` compares all rows of the papers with the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import fmean

from codesign.fidelity.designs import circuit_of, clocks, job_of, resources, words_of
from codesign.fidelity.points import TOTAL, Point
from codesign.inputs.part_file import load_part
from codesign.planners.breadth_first import published as breadth_first
from codesign.planners.harmonic import published as harmonic
from codesign.planners.power_law import REPORTS
from codesign.planners.reproduction import Row
from codesign.planners.velocity_obstacle import published as velocity_obstacle
from codesign.planners.velocity_obstacle.paper.tables import table_rows
from codesign.planners.wavefront import published as wavefront

PRECISION = harmonic.WHOLE_DESIGN_PRECISION
"""Bits that the slices of the published decision are taken at."""

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


def claims(points: Sequence[Point]) -> tuple[Claim, ...]:
    """Every figure that papers and Verilog both have."""
    return (
        *_of_harmonic(points),
        *_of_clocks(points),
        *_of_elements(),
        *_of_velocity_obstacles(points),
        *_of_power(),
    )


def _chosen(points: Sequence[Point], **wanted: str) -> list[Point]:
    return [point for point in points if all(vars(point)[name] == value for name, value in wanted.items())]


def _of_harmonic(points: Sequence[Point]) -> Iterator[Claim]:
    """A node and the control, by the plain pipeline of the publication, on Virtex-II."""
    plain = [
        point
        for point in _chosen(points, planner="harmonic", family="xc2v")
        if not point.variables.get("PIPELINE")
    ]
    node = harmonic.NODE
    for name, quantity, listed in (
        ("flip-flops", "flip_flops", node.flip_flops),
        ("LUT", "lut4", node.lut4),
    ):
        rows = _chosen(plain, line="nodes", quantity=quantity)
        if rows:
            nodes = [row.variables["ROWS"] * row.variables["COLUMNS"] for row in rows]
            law = fmean(row.predicted.value / count for row, count in zip(rows, nodes, strict=True))
            counted = fmean(row.measured / count for row, count in zip(rows, nodes, strict=True))
            how = f"mean of {len(rows)} arrays, Yosys for Virtex-II"
            place = f"{harmonic.PAPER}, {node.table}"
            yield Claim(f"harmonic {name} a node", place, f"{name} a node", "1", listed, law, counted, how)
    slices = harmonic.DECISION_SLICES_A_BIT * PRECISION + harmonic.DECISION_SLICES
    for name, line, listed in (
        ("decision", "decision", slices),
        ("control", "control", harmonic.CONTROL_SLICES),
    ):
        rows = _chosen(plain, line=line, quantity="lut4")
        if rows:
            most = max(rows, key=lambda row: row.measured)
            how = f"half of {most.measured:,.0f} LUT, {most.design}"
            place = f"{harmonic.PAPER}, section 5.4"
            half = most.predicted.value / 2
            yield Claim(
                f"harmonic {name}", place, f"slices of the {name}", "1", listed, half, most.measured / 2, how
            )


def _of_clocks(points: Sequence[Point]) -> Iterator[Claim]:
    """Published clocks beside the fastest placement of the same style, on whatever part."""
    block = harmonic.BLOCK
    for planner, style, place, listed in (
        ("harmonic", "bit_serial", f"{harmonic.PAPER}, {block.table}, {block.part}", block.clock),
        (
            "breadth_first",
            "state_machine",
            f"{breadth_first.PAPER}, section 3.2, XC2VP30",
            breadth_first.CLOCK_LIMIT,
        ),
        ("wavefront", "delay_line", f"{wavefront.PAPER}, assumed there", wavefront.CLOCK),
        ("wavefront", "delay_line", f"{wavefront.RIVAL}, {wavefront.RIVAL_PART}", wavefront.RIVAL_CLOCK),
    ):
        rows = _chosen(points, planner=planner, style=style, quantity="clock")
        if rows:
            best = max(rows, key=lambda row: row.measured)
            how = f"placed on {best.part}, not on the paper's part: {best.design}"
            paper = place.split(",", 1)[0]
            name = f"{planner} clock, {paper}"
            yield Claim(name, place, "clock", "Hz", listed, best.predicted.value, best.measured, how)


def _of_elements() -> Iterator[Claim]:
    """Cycles a cell of arrays with several cells an element, as the laws count them and ``hwsw verify`` compares."""
    jobs = [
        (job_of("wavefront", design), design)
        for design in (*resources("wavefront"), *(each.design for each in clocks("wavefront")))
        if design.parameters.get("element_cells", 1) > 1
    ]
    if jobs:
        job, design = max(jobs, key=lambda pair: pair[0].problem.free.size)
        cycles = sum(circuit_of("wavefront", design).expected(job).cycles.values())
        cells = job.problem.free.size
        yield Claim(
            "wavefront cycles a cell",
            f"{wavefront.RIVAL}, {wavefront.RIVAL_PART}",
            "cycles a cell",
            "1",
            wavefront.RIVAL_CYCLES_A_PIXEL,
            cycles / cells,
            cycles / cells,
            f"load, wave and path, {words_of(job, design)}",
        )


def _of_velocity_obstacles(points: Sequence[Point]) -> Iterator[Claim]:
    """Table I in LUT beside the synthesised circuit of the same width."""
    for style, (_, share, _) in velocity_obstacle.TABLE_I.items():
        rows = [
            point
            for point in _chosen(
                points,
                planner="velocity_obstacle",
                style=style.value,
                family="xc3se",
                line=TOTAL,
                quantity="lut4",
            )
            if point.variables["WIDTH"] == 16
            and not point.variables["PARALLEL"]
            and not point.variables["CROSS_PRODUCT"]
        ]
        if rows:
            row = min(rows, key=lambda each: (each.variables["ROBOTS"], len(each.design)))
            listed = share / 100 * velocity_obstacle.LUT4_OF_PART
            place = f"{velocity_obstacle.PAPER}, Table I"
            how = f"Yosys for Spartan-3E, {row.design}"
            yield Claim(
                f"velocity obstacles LUT, {style.value}",
                place,
                f"LUT, 2 robots, {style.value}",
                "1",
                listed,
                row.predicted.value,
                row.measured,
                how,
            )


def _of_power() -> Iterator[Claim]:
    """Power: the laws beside published figures. No circuit was measured."""
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
    for row in table_rows():
        if row.unit == "mW" and row.table == "Table III" and isinstance(row.published, int | float):
            yield _of_row(row)


def _of_row(row: Row) -> Claim:
    assert isinstance(row.published, int | float), "chosen by it"
    assert isinstance(row.modelled, int | float), "the law answers for every published power"
    return Claim(
        "power of velocity obstacles",
        f"{velocity_obstacle.PAPER}, {row.table}",
        row.quantity,
        "W",
        row.published / 1e3,
        row.modelled / 1e3,
        None,
        f"{row.use}: {row.source}",
    )
