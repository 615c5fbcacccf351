"""The reasons for which designs were left out, counted over a study, and the designs that miss feasibility by least."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES
from codesign.study.constraints import Flags, budget_of, unsatisfied
from codesign.study.groups import Groups
from codesign.study.table import Table
from codesign.system.results.result import Reason

Key = tuple[str, str, str]
Indices = NDArray[np.intp]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Out:
    """The reason for which a design is not feasible: in one condition, or in all of them together (None)."""

    reason: Reason
    condition: int | None = None


@dataclass(frozen=True)
class ReasonCount:
    """The count of one reason that kept designs out: ``designs`` of them.

    ``nearest`` is the index of the design with the least gap, the first of equals; ``least_gap`` (in ``unit``) and
    ``levers`` belong to this design, in its worst condition. A reason without a limit has a gap of 0 and no levers:
    a ``failure``, with its message's first line as name; ``unreached``, with what ended the mission; ``no figure``,
    with the objective that a feasible design does not have, and why where it is derived.
    """

    kind: str
    name: str
    unit: str
    designs: int
    nearest: int
    least_gap: float
    levers: tuple[str, ...] = ()


def point_reasons(table: Table, index: int) -> tuple[Reason, ...]:
    """The reasons for which a point is not feasible."""
    outcomes, template = table.outcomes, table.outcomes.template(index)
    if template is None:
        return ()
    number = int(outcomes.reason[index])
    reasons = template.reasons if number < 0 else (*template.reasons, outcomes.reasons[number])
    unreached = template.mission is not None and not template.mission.reached
    fits = bool(table.judged.fits_points[index])
    return reasons + tuple(
        reason
        for limit in (() if table.conditions else table.constraints)
        for reason in unsatisfied(
            limit,
            lambda name: outcomes.value(FIGURES[name], index),
            budget_of(template, limit),
            feasible=fits,
            unreached=unreached,
        )
    )


def design_outs(table: Table, index: int) -> tuple[Out, ...]:
    """The reasons for which a design is not feasible; empty if it is, or was not computed."""
    judged = table.judged
    if not judged.out[index]:
        return ()
    points = range(index * judged.conditions, (index + 1) * judged.conditions)
    out = [
        Out(reason, number)
        for number, point in enumerate(points)
        if judged.counts_points[point]
        for reason in point_reasons(table, point)
    ]
    for broken in (*judged.broken, *judged.short):
        place = int(np.searchsorted(broken.which, index))
        if place < len(broken.which) and broken.which[place] == index:
            out.append(Out(broken.reason(place)))
    return tuple(out)


def reason_counts(table: Table) -> tuple[ReasonCount, ...]:
    """The reasons that kept designs out, the most frequent first. A design counts once, by its largest gap."""
    counts = []
    parts = map_reduce(_gaps(table), itemgetter(0), itemgetter(1, 2))
    for (kind, name, unit), held in parts.items():
        designs, gaps = (np.concatenate(each) for each in zip(*held, strict=True))
        if not len(designs):
            continue
        # The largest gap of each design, then the least of these.
        firsts = Groups.of(designs).least(-gaps)
        nearest = int(designs[firsts][gaps[firsts].argmin()])
        worst = largest(tuple(out.reason for out in design_outs(table, nearest)))[kind, name, unit]
        counts.append(ReasonCount(kind, name, unit, len(firsts), nearest, worst.gap, worst.levers))
    counts += [
        ReasonCount(kind, name, "", len(which), min(which), 0) for (kind, name), which in _held_against(table).items()
    ]
    return tuple(sorted(counts, key=lambda count: (-count.designs, count.kind, count.name)))


def largest(reasons: tuple[Reason, ...]) -> dict[Key, Reason]:
    """The reason with the largest gap of each kind, name and unit, of equals the first."""
    held: dict[Key, Reason] = {}
    for reason in reasons:
        key = str(reason.kind), reason.name, reason.unit
        if key not in held or reason.gap > held[key].gap:
            held[key] = reason
    return held


def _gaps(table: Table) -> Iterator[tuple[Key, Indices, Floats]]:
    """Reasons by key, the distinct designs that have them, and how far each passes the limit there."""
    judged = table.judged
    points = judged.counts_points & np.repeat(table.distinct_designs, judged.conditions)
    for reasons, members in _groups(table, points):
        designs = members // judged.conditions
        for key, reason in largest(reasons).items():
            yield key, designs, np.full(len(designs), float(reason.gap))
    for broken in judged.broken_points:
        kept = points[broken.which]
        yield ("constraint", broken.name, broken.unit), broken.which[kept], broken.gap[kept]
    for broken in (*judged.broken, *judged.short):
        kept = table.distinct_designs[broken.which]
        yield ("constraint", broken.name, broken.unit), broken.which[kept], broken.gap[kept]


def _groups(table: Table, points: Flags) -> Iterator[tuple[tuple[Reason, ...], Indices]]:
    """The points by what they have against them besides the constraints: those reasons, and the indices."""
    outcomes, indices = table.outcomes, np.flatnonzero(points)
    count = len(outcomes.reasons) + 1
    numbers = outcomes.which[indices].astype(np.int64) * count + outcomes.reason[indices] + 1
    for members in Groups.of(numbers).members:
        template, reason = divmod(int(numbers[members[0]]), count)
        more = (outcomes.reasons[reason - 1],) if reason else ()
        yield (*outcomes.templates[template].reasons, *more), indices[members]


def _held_against(table: Table) -> dict[tuple[str, str], list[int]]:
    """The distinct designs that are kept out by other than the reasons of their results, by kind and name."""
    judged, distinct = table.judged, table.distinct_designs
    # A design fails by its first point that did, which the reversed order puts last.
    messages = sorted(table.outcomes.failures.items(), reverse=True)
    failed = {index // judged.conditions: message for index, message in messages}
    held: dict[tuple[str, str], list[int]] = map_reduce(
        (design for design in sorted(failed) if distinct[design]),
        lambda design: ("failure", failed[design].partition("\n")[0]),
    )
    _, why = judged.ended
    for number, ended in enumerate(judged.ends):
        if designs := np.flatnonzero(judged.unreached & distinct & (why == number)).tolist():
            held["unreached", ended] = designs
    fine = judged.feasible & ~judged.unreached & distinct
    for figure in dict.fromkeys(table.objectives):
        left = fine & np.isnan(judged.figure(figure))
        for reason, where in judged.whys(figure) if left.any() else ():
            if designs := np.flatnonzero(left & where).tolist():
                held["no figure", f"{figure.name}: {reason}"] = designs
            left &= ~where
        if designs := np.flatnonzero(left).tolist():
            held["no figure", figure.name] = designs
    return held


def nearest_designs(table: Table, count: int) -> tuple[int, ...]:
    """Indices of the distinct designs that pass their limits by least: by the largest relative gap of each."""
    designs = np.flatnonzero(table.judged.out & table.distinct_designs)
    return tuple(designs[np.lexsort((designs, relative_gaps(table)[designs]))[:count]].tolist())


def relative_gaps(table: Table) -> Floats:
    """By how much each distinct design that is out passes its limits: the largest gap as a share of its limit.

    Infinite where a limit is 0; minus infinity for a design that passes none.
    """
    judged = table.judged
    largest_gap = np.full(judged.count, -math.inf)
    out = judged.out & table.distinct_designs
    for reasons, members in _groups(table, judged.counts_points & np.repeat(out, judged.conditions)):
        if reasons:
            designs = members // judged.conditions
            np.maximum.at(largest_gap, designs, max(map(relative_gap, reasons)))
    for broken in (*judged.broken_points, *judged.broken, *judged.short):
        with np.errstate(divide="ignore", invalid="ignore"):
            gaps = np.where(broken.limit == 0, math.inf, broken.gap / np.abs(broken.limit))
        largest_gap[broken.which] = np.maximum(largest_gap[broken.which], gaps)
    return largest_gap


def relative_gap(reason: Reason) -> float:
    """The gap as a share of the limit; infinite where this is 0."""
    return reason.gap / abs(reason.limit) if reason.limit else math.inf
