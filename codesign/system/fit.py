"""Fit a design against a part: demand, budget, gap and levers for each kind of resource and each bound.

Resources are a vector: each kind is held against its own budget, and nothing is ever added up over kinds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from codesign.ground.figures import RESOURCES, Figure
from codesign.ground.part import Part
from codesign.ground.units import format_frequency
from codesign.planners.demand import Demand, Lever, lever_texts, sum_by_resource
from codesign.system.results.result import BoundUse, Clock, Reason, ResourceItem, ResourceUse
from codesign.system.verdicts.fits import ends_text, limit_verdicts

TellLevers = Callable[[Iterable[Lever]], tuple[str, ...]]
"""Puts levers into words; it may try them."""


@dataclass(frozen=True)
class PartFit:
    """A design's use of a part. ``reasons``: why it does not fit; empty where it fits."""

    resources: tuple[ResourceUse, ...]
    bounds: tuple[BoundUse, ...]
    clock: Clock | None
    reasons: tuple[Reason, ...]


def fit(
    demand: Demand, part: Part | None, clock: int, clock_limit: Figure | None, tell: TellLevers = lever_texts
) -> PartFit:
    """Hold ``demand`` and ``clock`` (Hz) against ``part`` and the clock that a design of this size reaches.

    ``tell`` puts levers into words.

    On a processor there is no part, no clock limit and no resource; only the bounds are held.
    """
    uses, bounds, reasons = fit_part(demand, part, tell)
    if clock_limit is None:
        return PartFit(uses, bounds, None, reasons)
    too_fast = clock_reason(clock, clock_limit)
    return PartFit(
        uses, bounds, Clock(hz=clock, limit=clock_limit), (*reasons, *([too_fast] if too_fast is not None else []))
    )


def fit_part(
    demand: Demand, part: Part | None, tell: TellLevers = lever_texts
) -> tuple[tuple[ResourceUse, ...], tuple[BoundUse, ...], tuple[Reason, ...]]:
    """The use of a part at any clock, the other limits, and why the design does not fit."""
    uses: tuple[ResourceUse, ...] = ()
    if part is not None:
        sums = sum_by_resource(demand.items)
        uses = tuple(
            _use(demand, part, resource, sums.get(resource, 0)) for resource in RESOURCES if resource in part.resources
        )
    reasons = [
        Reason(
            kind="resource",
            name=use.resource,
            demand=use.demand,
            limit=use.budget,
            gap=use.gap,
            unit="",
            levers=tell(demand.levers.get(use.resource, ())),
        )
        for use in uses
        if use.gap
    ]
    reasons += [
        Reason(
            kind="bound",
            name=bound.name,
            demand=bound.figure.value,
            limit=bound.limit,
            gap=bound.figure.value - bound.limit,
            unit=bound.figure.unit,
            levers=tell(bound.levers),
        )
        for bound in demand.bounds
        if bound.limit is not None and bound.figure.value > bound.limit
    ]
    bounds = tuple(
        BoundUse(name=bound.name, figure=bound.figure, limit=bound.most)
        for bound in demand.bounds
        if bound.most is not None
    )
    return uses, bounds, tuple(reasons)


def clock_reason(clock: int, limit: Figure) -> Reason | None:
    """Why a design does not run at a clock (Hz); None where it does.

    A clock above the law's value is refused, though a fitted law's interval reaches further: an exploration would
    otherwise always end at the upper end of the interval, where no design was shown to run.
    """
    if clock <= limit.value:
        return None
    return Reason(
        kind="clock",
        name="clock",
        demand=clock,
        limit=math.floor(limit.value),
        gap=clock - math.floor(limit.value),
        unit="Hz",
        levers=(
            f"clock: at most {math.floor(limit.value / 1e6)} MHz, the estimate for a design of this size",
            "make the design smaller",
        ),
    )


def fit_notes(component: str, held: PartFit) -> tuple[str, ...]:
    """A note for each limit that the design keeps, or passes, at some values inside the intervals only.

    Feasible is what fits at the figures' own values.
    """
    notes = []
    for each in limit_verdicts(held.resources, held.bounds, held.clock):
        if each.fits != "uncertain" or each.demand is None or each.limit is None:
            continue
        if each.decides != "clock":
            notes.append(f"{component}: it is not sure whether the design fits: {ends_text(each)}")
        elif held.clock is not None and held.clock.hz <= held.clock.limit.value:
            clock, sure, most = map(format_frequency, (held.clock.hz, each.limit[0], held.clock.limit.value))
            notes.append(
                f"{component}.clock: it is not sure that the design runs at {clock}; the limit is {most} by its law,"
                f" and may be as low as {sure}"
            )
    return tuple(notes)


def _use(demand: Demand, part: Part, resource: str, total: int) -> ResourceUse:
    budget = int(part.resources[resource].value)
    items = tuple(
        ResourceItem(name=line.name, figure=line.figure) for line in demand.items if line.resource == resource
    )
    return ResourceUse(resource=resource, demand=total, budget=budget, gap=max(0, total - budget), items=items)
