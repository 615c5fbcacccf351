"""The clock of a design on a part: by what was placed on its family, or by a published law and what that is worth.

A style gives its placements (``measured.clock_rows``), each with what its clock depends on besides the part: its
``Registers``. On a family with placements the period is

    period = T(family, pipeline) · r(grade)
             · exp(s(family, pipeline) · (g(size) - g(middle size)) + d(pipeline) · doublings)

T is what the critical path takes on that family: the time of its memory or flip-flop from the clock to the output, its
LUT, and its routing at a middle size. Only the routing grows with the size. The growth g of a pipeline is the
form that best predicts the placements of the pipeline it was not fitted to, by the mean square of the errors: none,
log2 or the fourth root.
Where a circuit takes 2, 4 or 8 bits of a value a cycle, each doubling adds the same share d. The factors are fitted by
least squares of the relative error over all families together, so a family with one size placed takes s (the mean) and
d from the others.

Each placement is predicted by the fit to all others, wherever its pipeline was placed at another size or on another
part. The interval is the largest of these errors of the pipeline on the family, or on the family or on all where few
are known, and a quarter more, at least 10 %.

A clock is ``measured`` only where it was: for the circuit (its pipeline, the bits of its digits, its options), in a
speed grade and between sizes that were placed. All else is a transfer, with the interval that transfers have earned:

- a size beyond those that were placed: the share by which the largest and smallest sizes lie off the fit to the sizes
  between, as a power of how far they are beyond them;
- an option, or bits of a digit, that were not placed: ``TRANSFER`` times, which is how far the clocks of one style's
  circuits lie apart;
- a speed grade that was not placed lies between the grades that were.

A published clock stays what it is on its own families. On a family that was neither placed nor published, the interval
reaches from the slowest to the fastest that the design is on the families that were, and half as far again. The value
is its middle, but no faster than published.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from more_itertools import map_reduce

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.planners.measured import MARGIN, ClockRow, family_of

GROWTHS: dict[str, Callable[[float], float]] = {
    "none": lambda _: 0.0,
    "log2": math.log2,
    "fourth root": lambda size: size**0.25,
}
"""The forms of the growth of a period with the size that are tried. A faster one runs away beyond what was placed."""

LEAST_ERRORS = 3
"""Errors of a family from which on its interval is its own."""

LEAST_WIDTH = 0.1
"""The interval of a law is at least this share: two seeds of one design lie as far apart."""

GRADES_APART = 1.15
"""The share by which a grade that was not placed may differ; grades of one family lie 10 to 20 % apart."""

TRANSFER = 2.7
"""The factor by which a circuit may be faster, or slower, than the law of another one of its planner says: as of all
that were placed."""

LEAST_GROWTH = 0.25
"""The uncertainty of a size beyond those that were placed, as a power of how far it is: at least this. Assumed."""

BEYOND = 0.5
"""The sum that is added to the spread (its logarithm) between the known families, for one that is not known."""

SLOW_FAMILIES = {"iCE40 UltraPlus": 3 / 8, "GW1N": 1 / 2}
"""Families made for low power, over the slowest that was placed: their LUT take two to three times as long. Assumed."""

LEAST_SHARE, MOST_SHARE = 1 / 3, 1.1
"""Of a published law's value, where no circuit of the style was placed anywhere: 0.34 to 1.08 of them were measured."""


UNTIMED = {"gowin": "; the placer has no delays from a block RAM of the family, and none of its multipliers"}
"""The delays that the open timing of a family leaves out: a clock there is an upper bound."""


@dataclass(frozen=True)
class Registers:
    """The figures that a clock depends on besides the part.

    The ``pipeline`` in words, the ``size`` that routing grows with, and how often the bits that pass in a cycle were
    doubled, ``doublings``. ``options``: in words, what else the circuit has that the law does not count. ``like``: the
    pipeline whose law stands for it on a family where it was not placed; the circuit may be slower, by ``TRANSFER``.
    The value is not lowered to what it reached elsewhere, which the source of the figure gives.
    """

    pipeline: str
    size: float
    doublings: float = 0.0
    options: frozenset[str] = frozenset()
    like: str = ""


@dataclass(frozen=True, eq=False)
class Placement:
    """A row of the record with what its clock depends on. It is equal to itself alone, so laws are fitted once."""

    row: ClockRow
    registers: Registers


Growths = Mapping[str, str]
"""The form of the growth of each pipeline."""


@dataclass(frozen=True)
class ClockLaw:
    """The periods of a style over families, pipelines and sizes.

    ``growth``: of each pipeline, a key of ``GROWTHS``.
    ``columns``: the name of each factor's logarithm. ``held_out``: the errors of placements that were held out,
    relative, by their places. ``families``, ``pipelines``: of the placements. ``beyond``: the uncertainty of a size
    beyond those that were placed, as a power of how far it is.
    """

    growth: Growths
    columns: tuple[tuple[str, ...], ...]
    factors: tuple[float, ...]
    middle: float
    held_out: Mapping[int, float]
    families: tuple[str, ...]
    pipelines: tuple[str, ...]
    beyond: float = LEAST_GROWTH

    @property
    def errors(self) -> tuple[float, ...]:
        """The sizes of the errors."""
        return tuple(map(abs, self.held_out.values()))

    def errors_of(self, family: str, pipeline: str = "") -> tuple[float, ...]:
        """The sizes of the errors of a pipeline on a family; where few are known, of the family, or else of all.

        ``family``: "" for any.
        """
        for kinds in ({pipeline}, set(self.pipelines)):
            own = tuple(
                abs(error)
                for place, error in self.held_out.items()
                if family in ("", self.families[place]) and self.pipelines[place] in kinds
            )
            if len(own) >= LEAST_ERRORS:
                return own
        return self.errors

    def width(self, family: str = "", pipeline: str = "") -> float:
        """Half of the interval of a pipeline on a family, relative."""
        return max(LEAST_WIDTH, MARGIN * max(self.errors_of(family, pipeline), default=0.5))

    def period(self, part: str, family: str, registers: Registers) -> float | None:
        """The period on a part, ns; None where the pipeline was not placed on the family, or none was doubled."""
        needed: set[tuple[str, ...]] = {("T", family, registers.pipeline)}
        if registers.doublings:
            needed.add(("d", registers.pipeline))
        if not needed <= set(self.columns):
            return None
        terms = _terms(self.columns, part, family, registers, self.growth, self.middle)
        return math.exp(float(np.dot(self.factors, terms)))


def _columns(placements: Sequence[Placement]) -> tuple[tuple[str, ...], ...]:
    """The factors of a fit: T of each family and pipeline, r of each part but the most placed of its family, s, d."""
    rows = [each.row for each in placements]
    families = {row.family for row in rows}
    parts = {family: sorted(row.part for row in rows if row.family == family) for family in families}
    first = {family: max(names, key=lambda name: (names.count(name), name)) for family, names in parts.items()}
    times = {("T", each.row.family, each.registers.pipeline) for each in placements}
    grades = {("r", row.part) for row in rows if row.part != first[row.family]}
    slopes = {("s", family, pipeline) for _, family, pipeline in times if _grows(placements, pipeline, family)}
    doubled = {("d", each.registers.pipeline) for each in placements if each.registers.doublings}
    return (*sorted(times), *sorted(grades), *sorted(slopes), *sorted(doubled))


def _grows(placements: Sequence[Placement], pipeline: str, family: str = "") -> bool:
    """True if the pipeline was placed in two sizes at least, on the family or on any one."""
    placed = {
        (each.row.family, each.registers.size)
        for each in placements
        if each.registers.pipeline == pipeline and family in ("", each.row.family)
    }
    return len(placed) > len({of_family for of_family, _ in placed})


def _terms(
    columns: Sequence[tuple[str, ...]], part: str, family: str, registers: Registers, growth: Growths, middle: float
) -> list[float]:
    grow = GROWTHS[growth.get(registers.pipeline, "none")]
    growing = grow(registers.size) - grow(middle)
    present: dict[tuple[str, ...], float] = {
        ("T", family, registers.pipeline): 1.0,
        ("r", part): 1.0,
        ("d", registers.pipeline): registers.doublings,
    }
    # A family with one size takes the mean of the growth of the others.
    slopes = [column for column in columns if column[0] == "s" and column[2] == registers.pipeline]
    own = [column for column in slopes if column[1] == family]
    present |= {column: growing / len(own or slopes) for column in own or slopes}
    return [present.get(column, 0.0) for column in columns]


def _fitted(placements: Sequence[Placement], growth: Growths, middle: float) -> ClockLaw:
    columns = _columns(placements)
    terms = [_terms(columns, each.row.part, each.row.family, each.registers, growth, middle) for each in placements]
    periods = [math.log(each.row.period_ns) for each in placements]
    factors = np.linalg.lstsq(np.array(terms), np.array(periods), rcond=None)[0]
    families = tuple(each.row.family for each in placements)
    pipelines = tuple(each.registers.pipeline for each in placements)
    return ClockLaw(growth, columns, tuple(map(float, factors)), middle, {}, families, pipelines)


def _held_out(placements: Sequence[Placement], growth: Growths, middle: float, pipeline: str = "") -> dict[int, float]:
    """The clock by the fit to the others over the placed one less 1, by the place of the placement.

    ``pipeline``: of this one alone. The others have to hold its part, its pipeline on its family, and its pipeline in
    two sizes on one family.
    """
    errors = {}
    for index, each in enumerate(placements):
        if pipeline not in ("", each.registers.pipeline):
            continue
        others = [*placements[:index], *placements[index + 1 :]]
        if not _grows(others, each.registers.pipeline) or each.row.part not in {it.row.part for it in others}:
            continue
        law = _fitted(others, growth, middle)
        period = law.period(each.row.part, each.row.family, each.registers)
        if period is not None:
            errors[index] = each.row.period_ns / period - 1
    return errors


def _beyond(placements: Sequence[Placement], growth: Growths, middle: float) -> float:
    """The distance of an end of the sizes from the fit without all beyond the next one, as a power of their ratio."""
    powers = [LEAST_GROWTH]
    for row, kind in {((each.row.part, each.row.family), each.registers.pipeline) for each in placements}:
        sizes = sorted(
            {each.registers.size for each in placements if _alike(each, kind, row[1]) and each.row.part == row[0]}
        )
        for end, near in ((-1, -2), (0, 1)) if len(sizes) > 2 else ():
            low, high = sorted((sizes[near], sizes[-1 - near]))
            inside = [
                each for each in placements if not _alike(each, kind, row[1]) or low <= each.registers.size <= high
            ]
            law = _fitted(inside, growth, middle)
            for each in placements:
                if _alike(each, kind, row[1]) and each.row.part == row[0] and each.registers.size == sizes[end]:
                    period = law.period(*row, each.registers)
                    if period is not None:
                        off = abs(math.log(each.row.period_ns / period))
                        powers.append(off / abs(math.log(sizes[end] / sizes[near])))
    return max(powers)


def _alike(placement: Placement, pipeline: str, family: str) -> bool:
    return placement.registers.pipeline == pipeline and placement.row.family == family


@cache
def clock_law(placements: tuple[Placement, ...]) -> ClockLaw | None:
    """The law with the growths that predict best what is held out; None without placements."""
    if not placements:
        return None
    sizes = [each.registers.size for each in placements]
    middle = math.sqrt(min(sizes) * max(sizes))

    pipelines = sorted({each.registers.pipeline for each in placements})
    start = dict.fromkeys(pipelines, "log2")

    def missed(pipeline: str, form: str) -> float:
        errors = _held_out(placements, {**start, pipeline: form}, middle, pipeline).values()
        return sum(error**2 for error in errors)

    growth = {each: min(GROWTHS, key=partial(missed, each)) for each in pipelines}
    law = _fitted(placements, growth, middle)
    return replace(law, held_out=_held_out(placements, growth, middle), beyond=_beyond(placements, growth, middle))


def held_out(placements: tuple[Placement, ...]) -> Mapping[tuple[str, ...], float]:
    """By what share the fit to all others is above the clock of each placement, by the key of its row.

    Placements that no other one speaks of are not among them.
    """
    law = clock_law(placements)
    errors = {} if law is None else law.held_out
    return {placements[index].row.key: error for index, error in errors.items()}


NOTHING_PLACED = Registers("", 1.0)


def on_family(
    published: Figure,
    part: Part,
    *families: str,
    registers: Registers = NOTHING_PLACED,
    placements: tuple[Placement, ...] = (),
) -> Figure:
    """The fastest clock of a design on a part, Hz.

    Args:
        published: the clock by a published law; on ``families`` it stays.
        part: the part.
        families: the families of the published law.
        registers: what the clock of the design depends on besides the part.
        placements: what was placed of its style.

    >>> from codesign.ground.figures import Figure, Status
    >>> ram = Figure(200, "Hz", Status.PUBLISHED, "data sheet")
    >>> part = Part(name="LFE5U-85F", family="ECP5", speed_grade="-8", resources={}, block_ram_shapes=(),
    ...     block_ram_clock=ram, static_power=ram, dynamic_power=ram)
    >>> law = Figure(150, "Hz", Status.CALIBRATED, "a fit", 120, 180)
    >>> on_family(law, part, "Virtex-4").interval, on_family(law, part, "ECP5").interval
    ((50.0, 180), (120, 180))
    """
    family, own = family_of(part.family)
    if registers.like and not any(_alike(each, registers.pipeline, family) and own for each in placements):
        alike = replace(registers, pipeline=registers.like, like="")
        figure = on_family(published, part, *families, registers=alike, placements=placements)
        low, high = figure.interval
        slower = f"the value is that of {registers.like}, and it may be {TRANSFER} times slower"
        source = f"{registers.pipeline}: not placed on {part.family}; {slower}{_reached(registers, placements)}"
        return Figure(figure.value, "Hz", Status.ASSUMED, f"{source}: {figure.source}", low / TRANSFER, high)
    if part.family in families:
        return published
    law = clock_law(placements)
    parts = {each.row.part: each.row.family for each in placements}
    if law is not None and own and family in parts.values():
        placed = _placed(law, part, family, registers, placements)
        if placed is not None:
            return placed
    return _between(law, part, registers, parts, published, families)


def _reached(registers: Registers, placements: tuple[Placement, ...]) -> str:
    """The share that a circuit reached of the law that stands for it, where both were placed, in words.

    At the nearest size that was placed.
    """
    law, text = clock_law(placements), ""
    if law is None:
        return text
    placed = map_reduce(
        (each for each in placements if each.registers.pipeline == registers.pipeline),
        lambda each: (each.row.part, each.row.family),
        lambda each: each.registers.size,
    )
    for (part, family), sizes in sorted(placed.items()):
        near = replace(registers, size=min(max(registers.size, min(sizes)), max(sizes)))
        own, other = (law.period(part, family, replace(near, pipeline=kind)) for kind in (near.pipeline, near.like))
        if own is not None and other is not None:
            text += f"; on {part} it reached {other / own:.0%} of that"
    return text


def _placed(
    law: ClockLaw, part: Part, family: str, registers: Registers, placements: tuple[Placement, ...]
) -> Figure | None:
    """The clock by the placements on the family of the part; of another grade, by the grades that were placed."""
    parts = sorted({each.row.part for each in placements if each.row.family == family})
    periods = {name: law.period(name, family, registers) for name in parts}
    times = [period for period in periods.values() if period is not None]
    if not times:
        return None
    own = periods.get(part.full_name)
    same_grade = (name for name in parts if name.endswith(part.speed_grade))
    near = next(same_grade, None) if own is None else part.full_name
    width = law.width(family, registers.pipeline)
    if near is None:
        apart = GRADES_APART if len(times) == 1 else 1.0
        slowest, fastest = 1e9 / max(times) / apart, 1e9 / min(times) * apart
        value, low, high = math.sqrt(slowest * fastest), slowest * (1 - width), fastest * (1 + width)
        where = f"{' and '.join(parts)}, not on {part.full_name}"
    else:
        value = 1e9 / (periods[near] or min(times))
        low, high = value * (1 - width), value * (1 + width)
        where = near
    path = _path(near or parts[0], family, registers, placements)
    apart, what = _transfer(law, near or "", family, registers, placements)
    status = Status.ASSUMED if what else Status.MEASURED
    source = (
        f"placed and routed on {where}: {path}; growth with the size: {law.growth[registers.pipeline]}; ±{width:.0%},"
        f" from {len(law.errors_of(family, registers.pipeline))} placements that were held out{UNTIMED.get(family, '')}"
    )
    if what:
        source += f"; not placed: {what}, so a transfer, {apart:.2f} times as wide either way"
    return _below_ram(Figure(value, "Hz", status, source, low / apart, high * apart), part)


def _transfer(
    law: ClockLaw, part: str, family: str, registers: Registers, placements: Sequence[Placement]
) -> tuple[float, str]:
    """The factor by which a clock may be off as the circuit was not placed so, and what was not; 1 and "" if it was.

    ``part``: the placed part in the speed grade, or "".
    """
    alike = [each for each in placements if _alike(each, registers.pipeline, family)]
    sizes = [each.registers.size for each in alike if each.row.part == part]
    grade = f"{registers.pipeline} in this speed grade" if not sizes else ""
    sizes = sizes or [each.registers.size for each in alike]
    over = max(1.0, registers.size / max(sizes), min(sizes) / registers.size)
    beyond = f"a size of {registers.size:,.0f} where {min(sizes):,.0f} to {max(sizes):,.0f} were" if over > 1 else ""
    placed = {(each.registers.options, each.registers.doublings) for each in alike}
    other = (registers.options, registers.doublings) not in placed
    words = [*sorted(registers.options), *([f"{2**registers.doublings:.0f} bits a cycle"] * (registers.doublings > 0))]
    options = (" with ".join(words) or "a plain circuit") * other
    apart = over**law.beyond * (TRANSFER if other else 1.0)
    return apart, ", ".join(filter(None, (grade, beyond, options)))


def _path(part: str, family: str, registers: Registers, placements: Sequence[Placement]) -> str:
    """The critical path of the placement of this pipeline that is nearest: on the part, or else on its family."""
    near = [each for each in placements if each.row.family == family and each.registers.pipeline == registers.pipeline]
    nearest = min(
        near,
        key=lambda each: (
            each.row.part != part,
            abs(each.registers.doublings - registers.doublings),
            abs(math.log(each.registers.size / registers.size)),
        ),
    )
    return f"{registers.pipeline}, {nearest.row.path}"


def _between(
    law: ClockLaw | None,
    part: Part,
    registers: Registers,
    parts: dict[str, str],
    published: Figure,
    families: Sequence[str],
) -> Figure:
    """The clock on a family that was neither placed nor published: between those that were."""
    low, high = published.interval
    slow = SLOW_FAMILIES.get(part.family, 1.0)
    periods = [
        period
        for name, family in sorted(parts.items())
        if law is not None and (period := law.period(name, family, registers)) is not None
    ]
    if law is None or not periods:
        shares = LEAST_SHARE * slow, MOST_SHARE
        low, high = min(low, published.value * shares[0]), max(high, published.value * shares[1])
        value = published.value
        what = f"{published.source}; of {' and '.join(families)}, not of {part.family}: no circuit of it was placed"
    else:
        width = law.width(pipeline=registers.pipeline)
        low, high = min(low, 1e9 / max(periods) * (1 - width)), max(high, 1e9 / min(periods) * (1 + width))
        value = min(math.sqrt(low * high), published.value)
        beyond = (high / low) ** (BEYOND / 2)
        low, high = min(low / beyond * slow, value), high * beyond
        names = " and ".join(sorted(parts))
        what = (
            f"{part.family} was never placed: from the slowest to the fastest of {names}, and of"
            f" {' and '.join(families)} by {published.source}; half as wide again, as it may be beyond them"
        )
    return _below_ram(Figure(value, "Hz", Status.ASSUMED, what, low, high), part)


def _below_ram(limit: Figure, part: Part) -> Figure:
    """The limit, no faster than a block RAM of the part."""
    ram = part.block_ram_clock
    low, high = limit.interval
    if limit.value <= ram.value:
        return Figure(
            limit.value,
            limit.unit,
            limit.status,
            limit.source,
            min(low, ram.interval[1]),
            max(limit.value, min(high, ram.interval[1])),
        )
    source = f"block RAM of {part.full_name}: {ram.source}"
    return Figure(ram.value, limit.unit, ram.status, source, min(low, ram.interval[0]), max(ram.value, ram.interval[1]))
