"""The laws of a style on an FPGA, as the calibration that its platform names corrects them.

A calibration multiplies: each line of a resource, the clock limit, the static and the dynamic power. What it adds to a
resource is a multiplication too, by another number for each size (``FittedTerm.at``). A figure so made is
``calibrated``, and its source names the file and its reports.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from codesign.ground.figures import Figure, Status
from codesign.ground.part import Part
from codesign.inputs.calibration_file import CLOCK, DYNAMIC, STATIC, CalibrationFile, FittedTerm
from codesign.inputs.components import FpgaComponent
from codesign.planners.demand import Demand, Line
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, TaskStyle


@dataclass(frozen=True)
class Laws:
    """The laws of a style on one FPGA. ``calibration``: that of the FPGA where it is for this style, else None."""

    style: Architecture | TaskStyle
    part: Part
    calibration: CalibrationFile | None = None

    def demand(self, job: Job[Any, Any]) -> Demand:
        """The demand. The lines of a resource sum up to its calibrated total, rounded once."""
        demand = self.style.demand(job)
        if self.calibration is None:
            return demand
        lines: list[Line] = []
        before: dict[str, int] = {}
        for line in demand.items:
            term = self._term(line.resource)
            if term is None or not demand.total(line.resource):
                lines.append(line)
                continue
            times, least, most = term.at(demand.total(line.resource))
            begin = before.get(line.resource, 0)
            before[line.resource] = end = begin + line.amount
            amount = round(end * times) - round(begin * times)
            low, high = (round(bound * line.amount) for bound in (least, most))
            figure = self._figure(line.figure, term, times, amount, min(low, amount), max(high, amount))
            lines.append(replace(line, figure=figure))
        return replace(demand, items=tuple(lines))

    def clock_limit(self, job: Job[Any, Any]) -> Figure:
        """The fastest clock, Hz, at most that of a block RAM of the part."""
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
    """Whether a calibration is for the laws of a style."""
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
