"""The rows of circuits of this package that were synthesised, placed and routed: the record that laws are fitted to.

Each room keeps its rows in ``planners/ROOM/measured``, one a line: ``resources.json``, ``clocks.json`` and, of toggles
in simulation, ``activity.json``. Only
``python -m benchmarks.measure`` writes them. The variables of a row are the parameters of its top module, whole numbers
by their names in the Verilog. A law is a sum of terms of these variables, fitted to some rows and held against others.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from importlib.resources import files
from typing import TypeVar

import numpy as np

PARTS = {
    "Virtex-II": "xc2v",
    "Virtex-II Pro": "xc2vp",
    "Spartan-3E": "xc3se",
    "Virtex-4": "xc4v",
    "Artix-7": "xc7",
    "Zynq-7000": "xc7",
    "ECP5": "ecp5",
    "GW2A": "gowin",
    "GW1N": "gowin",
    "iCE40 HX": "ice40",
    "iCE40 UltraPlus": "ice40",
}
"""The family of rows that counts for each family of parts."""

NEAREST = {"Zynq UltraScale+": "xc7", "PolarFire": "ecp5", "PolarFire SoC": "ecp5"}
"""The nearest family of rows for parts that no open tool synthesises for: with LUT of as many inputs."""


@dataclass(frozen=True)
class ResourceRow:
    """A synthesis: ``pieces`` has the count by resource of each line of the demand, "" what no line counts.

    ``digest``: of the circuit, as ``rtl.design`` takes it. ``tools``: what synthesised it.
    """

    style: str
    task: str
    family: str
    digest: str
    variables: Mapping[str, int]
    pieces: Mapping[str, Mapping[str, int]]
    tools: str

    @property
    def key(self) -> tuple[str, ...]:
        """The key of a row: a second one of the same key takes its place."""
        return self.style, self.task, self.family, json.dumps(self.variables, sort_keys=True)

    def count(self, piece: str, resource: str) -> int:
        """The count of a line of the demand; 0 where the circuit has none of it."""
        return self.pieces.get(piece, {}).get(resource, 0)


@dataclass(frozen=True)
class ClockRow:
    """Placements of one design on one part. ``clocks``: Hz by seed, from 1 on.

    The critical path of the median seed, ns: ``source_ns`` from the clock to the output of ``source`` (``memory`` or
    ``flip-flop``), ``logic_ns`` of ``levels`` LUT and carries, ``routing_ns``, ``setup_ns``. ``path``: in words.
    """

    style: str
    task: str
    family: str
    part: str
    digest: str
    variables: Mapping[str, int]
    totals: Mapping[str, int]
    clocks: Sequence[int]
    source: str
    source_ns: float
    levels: int
    logic_ns: float
    routing_ns: float
    setup_ns: float
    path: str
    tools: str

    @property
    def key(self) -> tuple[str, ...]:
        """The key of a row: a second one of the same key takes its place."""
        return self.style, self.task, self.part, json.dumps(self.variables, sort_keys=True)

    @property
    def clock(self) -> float:
        """The median of the seeds, Hz."""
        return float(np.median(self.clocks))

    @property
    def period_ns(self) -> float:
        """The period of the median, ns."""
        return 1e9 / self.clock


@dataclass(frozen=True)
class ActivityRow:
    """Toggles that were counted in ``cycles`` cycles of a run, on ``nets`` nets of the circuit as LUT and flip-flops.

    ``design``: map and parameters, in words. ``seed``: of the map.
    """

    style: str
    task: str
    digest: str
    variables: Mapping[str, int]
    design: str
    seed: int
    toggles: int
    nets: int
    cycles: int
    tools: str

    @property
    def key(self) -> tuple[str, ...]:
        """The key of a row: a second one of the same key takes its place."""
        return self.style, self.task, self.design, str(self.seed)

    @property
    def rate(self) -> float:
        """Toggles a net and cycle."""
        return self.toggles / max(1, self.nets * self.cycles)


Row = ResourceRow | ClockRow | ActivityRow
R = TypeVar("R", ResourceRow, ClockRow, ActivityRow)


def family_of(part_family: str) -> tuple[str, bool]:
    """The family of rows for a family of parts, and whether it is its own; ("", False) where none is near.

    >>> family_of("Zynq-7000"), family_of("PolarFire"), family_of("assumed array chip")
    (('xc7', True), ('ecp5', False), ('', False))
    """
    return PARTS.get(part_family) or NEAREST.get(part_family, ""), part_family in PARTS


@cache
def resource_rows(room: str, style: str, task: str = "") -> tuple[ResourceRow, ...]:
    """The syntheses of a style of a room, in the order of the file; none where the room has no file."""
    return _rows(ResourceRow, room, "resources", (style, task))


@cache
def clock_rows(room: str, style: str, task: str = "") -> tuple[ClockRow, ...]:
    """The placements of a style of a room, in the order of the file; none where the room has no file."""
    return _rows(ClockRow, room, "clocks", (style, task))


@cache
def activity_rows(room: str, style: str, task: str = "") -> tuple[ActivityRow, ...]:
    """The counted toggles of a style of a room, in the order of the file; none where the room has no file."""
    return _rows(ActivityRow, room, "activity", (style, task))


def _rows(model: type[R], room: str, kind: str, circuit: tuple[str, str]) -> tuple[R, ...]:
    file = files("codesign.planners") / room / "measured" / f"{kind}.json"
    rows = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else []
    return tuple(row for row in (model(**each) for each in rows) if (row.style, row.task) == circuit)


def rows_text(rows: Sequence[Row]) -> str:
    """Rows as a file holds them: JSON, one row a line."""
    return "[\n" + ",\n".join(json.dumps(asdict(row), ensure_ascii=False) for row in rows) + "\n]\n"


MARGIN = 1.25
"""The factor from the largest error on a row or a placement to the interval of a law."""

LEAST_OF_LAW = 0.1
"""A count is at most ten times what a law says, however far the law is below a few units."""


@dataclass(frozen=True)
class Fit:
    """A sum of terms, each with its coefficient, that rows are fitted with by least squares of the relative error.

    ``residuals``: relative, fitted over measured less 1, of the rows that it was fitted to; ``held_out``: of the
    others; ``elsewhere``: of the rows of other families.
    """

    coefficients: tuple[float, ...]
    residuals: tuple[float, ...]
    held_out: tuple[float, ...]
    elsewhere: tuple[float, ...] = ()

    def value(self, terms: Sequence[float]) -> float:
        """The sum for these terms."""
        return float(np.dot(self.coefficients, terms))

    @cached_property
    def mean(self) -> float:
        """The mean of the sizes of the relative errors on rows held out; of the residuals where none was."""
        return float(np.mean(np.abs(self.held_out or self.residuals)))

    def ends(self, count: float, own: bool = True) -> tuple[int, int]:
        """The least and the most that a count of this law may be.

        As far off as the errors of the rows, and a quarter more. ``own``: the law is of the family of the part; else
        the errors on the rows of other families count too.
        """
        least, most = self._factors[own]
        return math.floor(count / least), math.ceil(count / max(most, LEAST_OF_LAW))

    @cached_property
    def _factors(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The law over the least and over the most count: of a family of its own (True), and of others (False).

        The law is 1 + error times the count, so the count is the law over that.
        """
        every = [self.residuals + self.held_out + more for more in (self.elsewhere, ())]
        other, own = ((1 + MARGIN * max(0.0, *each), 1 + MARGIN * min(0.0, *each)) for each in every)
        return other, own

    @property
    def worst(self) -> float:
        """The largest relative error of all rows."""
        return float(np.max(np.abs(self.residuals + self.held_out)))


@dataclass(frozen=True)
class Point:
    """A measured value with the terms of its row. ``held``: whether it is held out of the fit."""

    terms: Sequence[float]
    value: float
    held: bool = False


def fit(points: Sequence[Point], elsewhere: Sequence[Point] = ()) -> Fit:
    """Fit the coefficients of the terms to the points that are not held out. ``elsewhere``: of other families.

    Values are weighted by 1 / max(1, value), so that the relative error counts; the least solution where rows leave a
    coefficient open.
    """
    taken = [point for point in points if not point.held]
    weights = np.array([1 / max(1.0, abs(point.value)) for point in taken])
    terms = np.array([point.terms for point in taken], np.float64)
    values = np.array([point.value for point in taken], np.float64)
    coefficients = np.linalg.lstsq(terms * weights[:, None], values * weights, rcond=None)[0]

    def errors(of: Iterable[Point]) -> tuple[float, ...]:
        return tuple(
            (float(np.dot(coefficients, point.terms)) - point.value) / max(1.0, abs(point.value)) for point in of
        )

    return Fit(
        tuple(float(value) for value in coefficients),
        errors(taken),
        errors(point for point in points if point.held),
        errors(elsewhere),
    )
