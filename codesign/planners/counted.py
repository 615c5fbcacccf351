"""The laws of what synthesis counts, as tables: ``planners/ROOM/measured/laws.yaml``, beside the rows.

The count of a resource of a piece of a circuit is a sum of terms. A table writes the terms of each as a tuple of
expressions over the parameters of the top module. Coefficients and their errors follow from the rows. For each
circuit a table has:

- ``styles``, ``task``: whose rows it is fitted to; ``where``: a condition on these rows.
- ``held_out``: the rows that no law is fitted to, and that all laws are held against.
- ``similar``: the family that stands for one without laws of its own. A family has its own where rows of it are held
  out, with every value that the expression ``each`` has in any family.
- ``define``: names for expressions. A name that a row or a design gives itself is not asked for here.
- ``source``: how far off the laws are, as text. ``off``: the mean error of the law, ``lut4``, ``flip_flops``: for the
  resource of the piece. ``unheld``: the same where no row is held out.
- ``pieces``: by name the terms of ``lut4`` and ``flip_flops``. ``rows``: those that have the piece, in place of
  ``where``; ``like``: only rows with the same value as the design share its law; ``assumed``: where the law is too
  weak for the status ``calibrated``.

Power on an FPGA stands here too. Its energy is the energy of the part, whose figure a slice holds at the activity that
tools take where nobody says otherwise. The toggles of a style were counted in simulations of its circuit
(``ActivityRow``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib.resources import files
from types import CodeType
from typing import Any

from codesign.ground.figures import Figure, Status, weakest
from codesign.ground.late import late
from codesign.ground.models import Part
from codesign.planners.job import Demand, Line
from codesign.planners.measured import (
    ActivityRow,
    Fit,
    Point,
    ResourceRow,
    activity_rows,
    family_of,
    fit,
    resource_rows,
)


def index_bits(count: int) -> int:
    """Bits that number ``count`` things (rows, columns, words), at least 1."""
    return max(1, (count - 1).bit_length())


# Power on an FPGA: static by part, and dynamic = toggles a cycle × energy of a toggle × clock.

TYPICAL = 0.125
"""Toggles a net and edge of the clock that tools take by default: of such a design is the power of a part's slice."""

LEAST_MARGIN = 0.05
"""The least interval of a counted activity."""


@dataclass(frozen=True)
class PowerReport:
    """A public report: ``dynamic`` power of the fabric in W at ``clock`` Hz, on LUT, flip-flops and slices."""

    dynamic: float
    clock: float
    luts: int
    flip_flops: int
    slices: int


REPORTS = (PowerReport(0.070, 100e6, 12_403, 18_391, 7_847), PowerReport(0.084, 100e6, 17_372, 25_373, 9_709))
"""Mucha and Scechura 2023, two sizes of an A* array on the XC7Z020-1, by Vivado."""


@cache
def counted_activity(room: str, style: str) -> Figure | None:
    """Toggles a net and cycle of a style over ``TYPICAL``, by the rows of its room; None where it has none."""
    return activity_by(activity_rows(room, style))


def activity_by(rows: Sequence[ActivityRow]) -> Figure | None:
    """Toggles a net and cycle over ``TYPICAL``, by counts on designs of one style; None without rows.

    The value is the mean of the rows. The interval is the largest error of a row that the mean of all others predicts,
    and a quarter more.
    """
    if not rows:
        return None
    rates = [row.rate for row in rows]
    mean = sum(rates) / len(rates)
    others = [(sum(rates) - rate) / (len(rates) - 1) for rate in rates] if len(rates) > 1 else rates
    worst = max(abs(rate / other - 1) for rate, other in zip(rates, others, strict=True))
    margin = max(LEAST_MARGIN, 1.25 * worst)
    source = (
        f"{mean:.3f} toggles a net and cycle, counted on {len(rows)} designs,"
        f" {min(rates):.3f} to {max(rates):.3f} over them;"
        f" {TYPICAL} in a typical design"
    )
    value = mean / TYPICAL
    return Figure(value, "1", Status.MEASURED, source, value * max(0.0, 1 - margin), value * (1 + margin))


def slice_power(
    demand: Demand, clock: int, part: Part, activity: Figure | None = None, status: Status = Status.CALIBRATED
) -> tuple[Figure, Figure]:
    """Static power of ``part``; and slices × ``clock`` (Hz) × the part's power a slice and Hz × ``activity``, W.

    Block RAMs and the clock tree are in the figure for a slice of a typical design; pins are not counted. ``activity``:
    over the activity of a typical design; None: as typical.
    """
    scale = demand.total("slices") * clock
    rate = part.dynamic_power
    low, high = rate.interval
    value, least, most = (1.0, 1.0, 1.0) if activity is None else (activity.value, *activity.interval)
    counted = "" if activity is None else f" × {value:.3g} ({activity.source})"
    dynamic = Figure(
        value=rate.value * scale * value,
        unit="W",
        status=weakest(status, rate.status),
        source=f"slices × clock × {rate.value * 1e12:.3g} µW a slice and MHz ({rate.source}){counted}",
        low=low * scale * least,
        high=high * scale * most,
    )
    return part.static_power, dynamic


yaml = late("yaml")

Terms = tuple[float, ...]


def _times(count: float, terms: Terms) -> Terms:
    return tuple(count * term for term in terms)


def _apart(value: Any, values: Sequence[Any], terms: Terms) -> Terms:
    """The terms with coefficients of their own for each of the values."""
    return tuple(term * (value == each) for each in values for term in terms)


OPERATIONS: Mapping[str, Any] = {
    "__builtins__": {"bool": bool, "max": max, "min": min, "sum": sum},
    "width": int.bit_length,
    "up": lambda total, unit: -(-total // unit),
    "times": _times,
    "apart": _apart,
}
"""The functions of every table besides the functions of its room: ``width`` is the bits of a whole number, ``up`` a
quotient that is rounded up."""


class _Names(dict[str, Any]):
    def __init__(self, laws: CountedLaws, design: Any, family: str) -> None:
        row = isinstance(design, Mapping)
        super().__init__(design if row else {}, design=design, family=family)
        self._laws = laws
        self._layout = laws.layout(design) if row and laws.layout else design

    def __missing__(self, name: str) -> Any:
        defined = self._laws.table.get("define", {})
        if name not in defined and (name in self._laws.functions or not hasattr(self._layout, name)):
            raise KeyError(name)
        value = self.value(str(defined[name])) if name in defined else getattr(self._layout, name)
        self[name] = value
        return value

    def value(self, text: str) -> Any:
        """The value of an expression of the table. Tables ship with the package: no text of a user comes here."""
        return eval(_compiled(text), {**OPERATIONS, **self._laws.functions}, self)


@cache
def _compiled(text: str) -> CodeType:
    return compile(text.strip(), "laws.yaml", "eval")


@cache
def _tables(room: str) -> Mapping[str, Any]:
    file = files("codesign.planners") / room / "measured" / "laws.yaml"
    tables: Mapping[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))
    return tables


@dataclass(frozen=True, eq=False)
class CountedLaws:
    """The table ``name`` of a room, evaluated.

    ``functions``: what its expressions may call. ``layout``: makes the object of a design, whose properties they may
    name, of the variables of a row. A design is such an object, or the variables themselves.
    """

    room: str
    name: str
    functions: Mapping[str, Any] = field(default_factory=dict)
    layout: Callable[[Mapping[str, int]], Any] | None = None

    @cached_property
    def table(self) -> Mapping[str, Any]:
        """The table as the file has it."""
        table: Mapping[str, Any] = _tables(self.room)[self.name]
        return table

    @property
    def pieces(self) -> Sequence[str]:
        """The names of the pieces."""
        return tuple(self.table["pieces"])

    def resources(self, piece: str) -> Sequence[str]:
        """The resources that a piece has laws of."""
        return [each for each in ("lut4", "flip_flops") if each in self.table["pieces"][piece]]

    def terms(self, piece: str, resource: str, design: Any, family: str) -> Terms:
        """The terms of a resource of a piece in a family of rows."""
        return self._terms(piece, resource, _Names(self, design, family))

    def _terms(self, piece: str, resource: str, names: _Names) -> Terms:
        terms: Terms = names.value(self.table["pieces"][piece][resource])
        return terms

    def holds(self, text: str, variables: Mapping[str, int]) -> bool:
        """True if a condition of the table is true of a row."""
        return bool(_Names(self, variables, "").value(text))

    def held_out(self, variables: Mapping[str, int]) -> bool:
        """True if a row with these parameters of the top module is held out of the fits."""
        return self.holds(self.table["held_out"], variables)

    @cached_property
    def rows(self) -> tuple[ResourceRow, ...]:
        """The rows of its styles."""
        return tuple(
            row for style in self.table["styles"] for row in resource_rows(self.room, style, self.table.get("task", ""))
        )

    def family(self, part_family: str) -> tuple[str, bool]:
        """The family of rows that counts for a family of parts, and whether it is its own."""
        family, own = family_of(part_family)
        return (family, own) if family in self.families else (self.table["similar"], False)

    @cached_property
    def families(self) -> frozenset[str]:
        """The families of rows with laws of their own."""
        where, each = self.table.get("where", "True"), self.table.get("each", "0")
        rows = [row for row in self.rows if self.holds(where, row.variables)]
        values = [_Names(self, row.variables, "").value(each) for row in rows]
        held = {(row.family, value) for row, value in zip(rows, values, strict=True) if self.held_out(row.variables)}
        return frozenset(family for family, _ in held if all((family, value) in held for value in set(values)))

    def fit(self, piece: str, resource: str, design: Any, family: str) -> Fit:
        """The law that a design's resource of a piece has in a family of rows: coefficients and errors."""
        return self._fit(piece, resource, _Names(self, design, family))

    def _fit(self, piece: str, resource: str, names: _Names) -> Fit:
        like = self.table["pieces"][piece].get("like")
        return _fit(self, piece, resource, names["family"], None if like is None else names.value(like))

    def value(self, piece: str, resource: str, design: Any, family: str) -> float:
        """The count by the law, not rounded."""
        names = _Names(self, design, family)
        return self._fit(piece, resource, names).value(self._terms(piece, resource, names))

    def lines(self, design: Any, family: tuple[str, bool], *pieces: str) -> Mapping[str, tuple[Line, ...]]:
        """The lines of a demand by piece, of all or of the given ones: counts are whole and never negative.

        ``family``: of rows, and True if it is the part's own, as ``family`` gives it.
        """
        names, own = _Names(self, design, family[0]), family[1]
        return {piece: tuple(self._lines(piece, names, own)) for piece in pieces or self.pieces}

    def _lines(self, piece: str, names: _Names, own: bool) -> Iterator[Line]:
        fits = {resource: self._fit(piece, resource, names) for resource in self.resources(piece)}
        means = {resource: law.mean for resource, law in fits.items()}
        weak = names.value(self.table["pieces"][piece].get("assumed", "False"))
        status = Status.CALIBRATED if own and not weak else Status.ASSUMED
        for resource, law in fits.items():
            count = max(0, round(law.value(self._terms(piece, resource, names))))
            text = self.table["source" if law.held_out else "unheld"].format(off=law.mean, **means)
            source = f"synthesis of the RTL of this package for {names['family']}; {text}"
            yield Line.item(piece, resource, count, status, source, law.ends(count, own))


@cache
def _fit(laws: CountedLaws, piece: str, resource: str, family: str, like: Any) -> Fit:
    """The fit of a resource of a piece to the rows of a family; errors on the rows of other families beside it."""
    entry = laws.table["pieces"][piece]
    where = entry.get("rows", laws.table.get("where", "True"))
    points: dict[bool, list[Point]] = {True: [], False: []}
    for row in laws.rows:
        names = _Names(laws, row.variables, family)
        if names.value(where) and (like is None or names.value(entry["like"]) == like):
            point = Point(laws._terms(piece, resource, names), row.count(piece, resource), laws.held_out(row.variables))
            points[row.family == family].append(point)
    return fit(points[True], points[False] if points[True] else ())
