"""Fit a design against a part: demand, budget, gap and levers for each kind of resource and each bound.

Resources are a vector: each kind is held against its own budget, and nothing is ever added up over kinds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.models import Part
from codesign.ground.units import format_frequency
from codesign.inputs.components import FpgaComponent
from codesign.inputs.library import CLOCK, DYNAMIC, STATIC, CalibrationFile, FittedTerm
from codesign.planners.job import Demand, Job, Lever, Line, lever_texts, sum_by_resource
from codesign.planners.styles import Architecture, TaskStyle
from codesign.system.bind import Design
from codesign.system.results.result import BoundUse, Clock, Power, Reason, ResourceItem, ResourceUse
from codesign.system.verdicts.fits import ends_text, limit_verdicts

# The laws of a style on an FPGA, as the calibration that its platform names corrects them.


@dataclass(frozen=True)
class Laws:
    """The laws of a style on one FPGA. ``calibration``: the FPGA's, if it is for this style, else None."""

    style: Architecture | TaskStyle
    part: Part
    calibration: CalibrationFile | None = None

    def demand(self, job: Job[Any, Any]) -> Demand:
        """The demand, calibrated."""
        demand = self.style.demand(job)
        return demand if self.calibration is None else replace(demand, items=self._calibrated(demand.items))

    def items(self, job: Job[Any, Any]) -> tuple[Line, ...]:
        """The resources alone, calibrated."""
        return self._calibrated(self.style.items(job))

    def _calibrated(self, items: tuple[Line, ...]) -> tuple[Line, ...]:
        """The lines of resources: of each resource they sum up to its calibrated total, rounded once."""
        if self.calibration is None:
            return items
        lines: list[Line] = []
        before: dict[str, int] = {}
        totals = sum_by_resource(items)
        for line in items:
            term, total = self._term(line.resource), totals[line.resource]
            if term is None or not total:
                lines.append(line)
                continue
            times, least, most = term.at(total)
            begin = before.get(line.resource, 0)
            before[line.resource] = end = begin + line.amount
            amount = round(end * times) - round(begin * times)
            low, high = (round(bound * line.amount) for bound in (least, most))
            figure = self._figure(line.figure, term, times, amount, min(low, amount), max(high, amount))
            lines.append(replace(line, figure=figure))
        return tuple(lines)

    def clock_limit(self, job: Job[Any, Any]) -> Figure:
        """The fastest clock, Hz, at most the clock of a block RAM of the part."""
        limit, term = self.style.clock_limit(job), self._term(CLOCK)
        if term is None:
            return limit
        most = self.part.block_ram_clock.interval[1]
        value, low, high = (min(bound * limit.value, most) for bound in term.at(limit.value))
        return self._figure(limit, term, term.factor.value, value, low, high)

    def power_demand(self, job: Job[Any, Any], demand: Demand) -> Demand:
        """The demand that the power rests on. ``demand``: of the same job, calibrated.

        A factor of the dynamic power is one of the law with the demand as the law has it. Without such a factor, the
        law takes the calibrated demand.
        """
        calibrated = self.calibration is not None and self._term(DYNAMIC) is not None
        return self.style.demand(job) if calibrated else demand

    def power(self, demand: Demand, clock: int) -> tuple[Figure, Figure]:
        """Static and dynamic power at a clock in Hz, W. ``demand``: see ``power_demand``."""
        static, dynamic = self.style.power(demand, clock, self.part)
        return self._times(static, self._term(STATIC)), self._times(dynamic, self._term(DYNAMIC))

    def _term(self, name: str) -> FittedTerm | None:
        return None if self.calibration is None else self.calibration.terms.get(name)

    def _times(self, figure: Figure, term: FittedTerm | None) -> Figure:
        if term is None or not figure.value:
            return figure
        value, low, high = (bound * figure.value for bound in term.at(figure.value))
        return self._figure(figure, term, term.factor.value, value, low, high)

    def _figure(self, law: Figure, term: FittedTerm, times: float, value: float, low: float, high: float) -> Figure:
        """A figure of a law times a number, with its source."""
        assert self.calibration is not None, "only a calibration has terms"
        first, *others = term.samples
        more = f" and {len(others)} more" if others else ""
        cited = f"calibration {self.calibration.name}: {times:.4g} times the law, by {first.report}{more}"
        return Figure(value, law.unit, Status.CALIBRATED, f"{cited}; law: {law.source}", low, high)


def laws_of(style: Architecture | TaskStyle, component: FpgaComponent, task: str = "") -> Laws:
    """The laws of a style on an FPGA of a platform; ``task``: that is placed by itself."""
    calibration = component.calibrated
    if calibration is not None and not is_for(calibration, style, task):
        calibration = None
    return Laws(style, component.chip, calibration)


def is_for(calibration: CalibrationFile, style: Architecture | TaskStyle, task: str = "") -> bool:
    """True if a calibration is for the laws of a style."""
    return (calibration.planner, calibration.style, calibration.task) == (style.planner, style.style, task)


def calibration_notes(
    name: str, component: FpgaComponent, style: Architecture | TaskStyle, task: str = ""
) -> tuple[str, ...]:
    """A note where the calibration of an FPGA is for another style, or was fitted on another part."""
    calibration = component.calibrated
    if calibration is None:
        return ()
    key = f"{name}.calibration"
    if not is_for(calibration, style, task):
        of = " ".join(filter(None, (calibration.planner, calibration.style, calibration.task)))
        return (f"{key}: {calibration.name} is for {of}; the laws of {style.planner} {style.style} stay as they are",)
    if calibration.part != component.chip.full_name:
        return (f"{key}: {calibration.name} was fitted on {calibration.part}, this is {component.chip.full_name}",)
    return ()


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


@dataclass(frozen=True)
class DesignFit:
    """A design's use of a component. ``power``: static and dynamic; None on a processor. ``notes``: for the user."""

    part: PartFit
    power: Power | None
    notes: tuple[str, ...]


def fit_design(
    name: str, component: FpgaComponent | None, design: Design, clock: int, tell: TellLevers = lever_texts
) -> DesignFit:
    """Hold a design against the component of that name, at a clock in Hz; ``component``: None of a processor."""
    style, job = design.style, design.job
    if component is None:
        held = fit(style.demand(job), None, clock, None, tell)
        return DesignFit(held, None, fit_notes(name, held))
    laws = laws_of(style, component, design.task)
    demand = laws.demand(job)
    held = fit(demand, component.chip, clock, laws.clock_limit(job), tell)
    static, dynamic = laws.power(laws.power_demand(job, demand), clock)
    notes = fit_notes(name, held) + calibration_notes(name, component, style, design.task)
    return DesignFit(held, Power(static=static, dynamic=dynamic), notes)


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
        Reason.over("resource", use.resource, use.demand, use.budget, "", tell(demand.levers.get(use.resource, ())))
        for use in uses
        if use.gap
    ]
    reasons += [
        Reason.over("bound", bound.name, bound.figure.value, bound.limit, bound.figure.unit, tell(bound.levers))
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
    """The reason for which a design does not run at a clock (Hz); None if it runs.

    A clock above the law's value is refused, though a fitted law's interval reaches further: an exploration would
    otherwise always end at the upper end of the interval, where no design was shown to run.
    """
    if clock <= limit.value:
        return None
    slower = f"clock: at most {math.floor(limit.value / 1e6)} MHz, the estimate for a design of this size"
    return Reason.over("clock", "clock", clock, math.floor(limit.value), "Hz", (slower, "make the design smaller"))


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
