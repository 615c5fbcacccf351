"""Why designs were left out, counted over a whole study, and the designs that miss feasibility by least."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codesign.exploration.constraints import Flags
from codesign.results.result import Reason

if TYPE_CHECKING:
    from codesign.exploration.designs import Design
    from codesign.exploration.study import Study

Key = tuple[str, str, str]
Indices = NDArray[np.intp]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ReasonCount:
    """How often one reason kept designs out: ``designs`` of them.

    ``nearest`` is the index of the design with the least gap, the first of equals; ``least_gap`` (in ``unit``) and
    ``levers`` are those of this design, in its worst condition. A reason without a limit has a gap of 0 and no levers:
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


def reason_counts(study: Study) -> tuple[ReasonCount, ...]:
    """The reasons that kept designs out, the most frequent first. A design counts once, by its largest gap."""
    parts: dict[Key, list[tuple[Indices, Floats]]] = {}
    for key, designs, gaps in _gaps(study):
        parts.setdefault(key, []).append((designs, gaps))
    counts = []
    for key, held in parts.items():
        designs, gaps = (np.concatenate(each) for each in zip(*held, strict=True))
        if not len(designs):
            continue
        # The largest gap of each design, then the least of these.
        order = np.lexsort((-gaps, designs))
        designs, first = np.unique(designs[order], return_index=True)
        nearest = int(designs[gaps[order][first].argmin()])
        worst = _largest(study.designs[nearest])[key]
        counts.append(ReasonCount(*key, len(designs), nearest, worst.gap, worst.levers))
    counts += [
        ReasonCount(kind, name, "", len(designs), min(designs), 0)
        for (kind, name), designs in _held_against(study).items()
    ]
    return tuple(sorted(counts, key=lambda count: (-count.designs, count.kind, count.name)))


def _largest(design: Design) -> dict[Key, Reason]:
    """The reason with the largest gap of each kind, name and unit, of equals the first."""
    return largest(tuple(out.reason for out in design.out))


def largest(reasons: tuple[Reason, ...]) -> dict[Key, Reason]:
    """The reason with the largest gap of each kind, name and unit, of equals the first."""
    held: dict[Key, Reason] = {}
    for reason in reasons:
        key = str(reason.kind), reason.name, reason.unit
        if key not in held or reason.gap > held[key].gap:
            held[key] = reason
    return held


def _gaps(study: Study) -> Iterator[tuple[Key, Indices, Floats]]:
    """Reasons by key, the distinct designs that have them, and how far each passes the limit there."""
    judged = study.judged
    points = judged.counts_points & np.repeat(study.distinct_designs, judged.conditions)
    for reasons, members in _groups(study, points):
        designs = members // judged.conditions
        for key, reason in largest(reasons).items():
            yield key, designs, np.full(len(designs), float(reason.gap))
    for broken in judged.broken_points:
        kept = points[broken.which]
        yield ("constraint", broken.name, broken.unit), broken.which[kept], broken.gap[kept]
    for broken in (*judged.broken, *judged.short):
        kept = study.distinct_designs[broken.which]
        yield ("constraint", broken.name, broken.unit), broken.which[kept], broken.gap[kept]


def _groups(study: Study, points: Flags) -> Iterator[tuple[tuple[Reason, ...], Indices]]:
    """The points by what they have against them besides the constraints: those reasons, and the indices."""
    outcomes, indices = study.outcomes, np.flatnonzero(points)
    count = len(outcomes.reasons) + 1
    numbers = outcomes.which[indices].astype(np.int64) * count + outcomes.reason[indices] + 1
    order = np.argsort(numbers, kind="stable")
    groups, begins, counts = np.unique(numbers[order], return_index=True, return_counts=True)
    for number, begin, length in zip(groups.tolist(), begins, counts, strict=True):
        members = indices[order[begin : begin + length]]
        template, reason = divmod(number, count)
        more = (outcomes.reasons[reason - 1],) if reason else ()
        yield (*outcomes.templates[template].reasons, *more), members


def _held_against(study: Study) -> dict[tuple[str, str], list[int]]:
    """The distinct designs that are kept out by other than the reasons of their results, by kind and name."""
    judged, distinct = study.judged, study.distinct_designs
    held: dict[tuple[str, str], list[int]] = {}
    failed: dict[int, str] = {}
    for index in sorted(study.outcomes.failures):
        failed.setdefault(index // judged.conditions, study.outcomes.failures[index])
    for design, failure in failed.items():
        if distinct[design]:
            held.setdefault(("failure", failure.partition("\n")[0]), []).append(design)
    _, why = judged.ended
    for number, ended in enumerate(judged.ends):
        if designs := np.flatnonzero(judged.unreached & distinct & (why == number)).tolist():
            held["unreached", ended] = designs
    fine = judged.feasible & ~judged.unreached & distinct
    for figure in dict.fromkeys(study.objectives):
        left = fine & np.isnan(judged.figure(figure))
        for reason, where in judged.whys(figure) if left.any() else ():
            if designs := np.flatnonzero(left & where).tolist():
                held["no figure", f"{figure.name}: {reason}"] = designs
            left &= ~where
        if designs := np.flatnonzero(left).tolist():
            held["no figure", figure.name] = designs
    return held


def nearest_designs(study: Study, count: int) -> tuple[int, ...]:
    """Indices of the distinct designs that pass their limits by least: by the largest relative gap of each."""
    designs = np.flatnonzero(study.judged.out & study.distinct_designs)
    return tuple(designs[np.lexsort((designs, relative_gaps(study)[designs]))[:count]].tolist())


def relative_gaps(study: Study) -> Floats:
    """By how much each distinct design that is out passes its limits: the largest gap as a share of its limit.

    Infinite where a limit is 0; minus infinity for a design that passes none.
    """
    judged = study.judged
    largest_gap = np.full(judged.count, -math.inf)
    out = judged.out & study.distinct_designs
    for reasons, members in _groups(study, judged.counts_points & np.repeat(out, judged.conditions)):
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
