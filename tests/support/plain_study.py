"""What a study says of its points and designs, point by point: the reference of what it computes in arrays."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import LOWER, STRICT, Constraint
from codesign.study.aggregation import aggregated
from codesign.study.constraints import figure_of
from codesign.study.pricing.price import PRICED
from codesign.study.study import Study
from codesign.study.table import _is_idle
from codesign.system.results.result import Reason, Result


@dataclass
class Plain:
    """A point: its template and prices, or why it failed; neither: it is missing."""

    template: Result | None = None
    prices: dict[str, float] = field(default_factory=dict)
    too_fast: Reason | None = None
    failure: str | None = None
    limits: tuple[Constraint, ...] = ()

    @property
    def state(self) -> str:
        return "done" if self.template else "failed" if self.failure else "missing"

    def figure(self, figure: ResultFigure) -> float | None:
        if self.template is None:
            return None
        return self.prices.get(figure.name) if figure.name in PRICED else figure_of(self.template, figure)

    @property
    def fits(self) -> bool:
        return self.template is not None and self.template.feasible and self.too_fast is None

    @property
    def reasons(self) -> list[Reason]:
        if self.template is None:
            return []
        mission = self.template.mission
        reasons = [*self.template.reasons, *([self.too_fast] if self.too_fast else [])]
        for limit in self.limits:
            unreached = mission is not None and not mission.reached
            reasons += passed(limit, self.figure(limit.figure), self.budget(limit), self.fits, unreached)
        return reasons

    @property
    def feasible(self) -> bool:
        return self.fits and not any(reason.kind == "constraint" for reason in self.reasons)

    @property
    def unreached(self) -> str | None:
        mission = self.template.mission if self.template and self.feasible else None
        return None if mission is None or mission.reached else mission.ended

    def budget(self, limit: Constraint) -> int | None:
        uses = self.template.resources if self.template and limit.of_part else ()
        return next((use.budget for use in uses if use.resource == limit.figure.name), None)


def passed(limit: Constraint, value: float | None, budget: int | None, feasible: bool, unreached: bool) -> list[Reason]:
    reasons = []
    for bound, end in limit.bounds.items():
        sign, name = 1 if bound in LOWER else -1, f"{limit.figure} {bound.replace('_', ' ')}"
        if value is None and not feasible:
            continue
        name += f" {100 * end:.6g} %" if limit.of_part else ""
        most, demand = end, 0.0 if value is None else value
        if value is None:
            name += f": {'goals not reached' if unreached else 'no such figure'}"
        else:
            over = sign * (end - (value / budget if budget else value))
            if over < 0 or (over == 0 and bound not in STRICT):
                continue
            most *= budget or 1
        gap = abs(most) if value is None else max(0.0, sign * (most - value))
        unit = limit.figure.unit
        reasons.append(Reason(kind="constraint", name=name, demand=demand, limit=most, gap=gap, unit=unit))
    return reasons


class PlainDesign:
    """A design over the conditions of a study."""

    def __init__(self, study: Study, index: int, points: list[Plain]) -> None:
        self.study, self.index, self.points = study, index, points
        figures = {*study.objectives, *(limit.figure for limit in study.constraints)}
        by_share = {each for each in figures if isinstance(study.world.rule(each), Share)}
        self.tolerant = bool(by_share) and all(each in by_share or each.is_resource for each in figures)
        states = {point.state for point in points}
        self.state = "failed" if "failed" in states else "missing" if "missing" in states else "done"
        self.out: list[tuple[Reason, int | None]] = []
        self.ended: tuple[str, int] | None = None
        if self.state == "done":
            self._judge()

    def _judge(self) -> None:
        blocked = [number for number, point in enumerate(self.points) if not point.feasible]
        if len(blocked) == len(self.points) or not self.tolerant:
            self.out += [(reason, number) for number in blocked for reason in self.points[number].reasons]
        if self.study.conditions and (not blocked or self.tolerant):
            for limit in self.study.constraints:
                unreached = any(point.unreached for point in self.points)
                budget = next((b for point in self.points if (b := point.budget(limit)) is not None), None)
                reasons = passed(limit, self.figure(limit.figure), budget, True, unreached)
                self.out += [(reason, None) for reason in reasons]
        for name, rule in self.study.aggregate.items():
            if isinstance(rule, Share) and rule.required is not None:
                met = float(self.values(rule.share.figure).mean())
                if met < rule.required:
                    what, gap = f"{name} in share of conditions", rule.required - met
                    fields: dict[str, Any] = {"kind": "constraint", "name": what, "unit": "1", "gap": gap}
                    self.out.append((Reason(demand=met, limit=rule.required, **fields), None))
        ended = [(why, number) for number, point in enumerate(self.points) if (why := point.unreached)]
        counts = not self.tolerant or len(ended) + len(blocked) == len(self.points)
        self.ended = ended[0] if ended and not self.out and counts else None

    @property
    def feasible(self) -> bool:
        return self.state == "done" and not self.out

    def values(self, figure: ResultFigure) -> Any:
        rule = self.study.world.rule(figure)
        if isinstance(rule, Share):
            return np.array([float(meets(point, rule.share)) for point in self.points])
        values = (point.figure(figure) for point in self.points)
        return np.array([math.nan if value is None else value for value in values])

    def figure(self, figure: ResultFigure) -> float | None:
        rule = self.study.world.rule(figure)
        if len(self.points) == 1 and not isinstance(rule, Share):
            return self.points[0].figure(figure)
        values = self.values(figure)
        return None if np.isnan(values).any() else float(aggregated(rule, values, figure.maximise))

    def idle(self, tasks: set[str]) -> frozenset[str]:
        templates = [point.template for point in self.points]
        if any(each is None or each.utilisation is None or not each.places for each in templates):
            return frozenset()
        return frozenset(
            name
            for name in self.study.axes
            if all(_is_idle(name, each, tasks) for each in templates if each is not None)
        )


def meets(point: Plain, limit: Constraint) -> bool:
    value = point.figure(limit.figure)
    if not point.feasible or point.unreached is not None or value is None:
        return False
    return not passed(limit, value, point.budget(limit), True, False)


class PlainStudy:
    """The same answers as those of a study, each from its definition."""

    def __init__(self, study: Study, points: list[Plain]) -> None:
        self.study = study
        for point in points:
            point.limits = () if study.conditions else study.constraints
        count = len(list(itertools.product(*study.conditions.values())))
        self.designs = [
            PlainDesign(study, index, points[begin : begin + count])
            for index, begin in enumerate(range(0, len(points), count))
        ]
        self.points = points
        self.same = self._same()
        again = {index for others in self.same.values() for index in others}
        self.distinct = [design for design in self.designs if design.index not in again]

    def _same(self) -> dict[int, tuple[int, ...]]:
        tasks = {task for point in self.points if point.template for task in point.template.places}
        groups: dict[Any, list[int]] = {}
        for design in self.designs:
            if idle := design.idle(tasks):
                axes = self.study.designs[design.index].axes
                used = tuple(str(value) for name, value in axes.items() if name not in idle)
                figures = tuple(point.figure(figure) for point in design.points for figure in FIGURES.values())
                groups.setdefault((idle, used, figures), []).append(design.index)
        return {first: tuple(others) for first, *others in groups.values() if others}

    @property
    def front(self) -> list[int]:
        objectives = self.study.objectives
        by_task: dict[str, list[tuple[int, list[float]]]] = {}
        for design in self.distinct:
            values = [design.figure(figure) for figure in objectives]
            if design.feasible and design.ended is None and None not in values:
                template = design.points[0].template
                task = template.task.task if template and template.task else ""
                signs = [-1 if self.study.world.maximise(figure) else 1 for figure in objectives]
                costs = [sign * (value or 0.0) for sign, value in zip(signs, values, strict=True)]
                by_task.setdefault(task, []).append((design.index, costs))
        return sorted(
            index
            for rivals in by_task.values()
            for index, own in rivals
            if not any(its != own and all(a <= b for a, b in zip(its, own, strict=True)) for _, its in rivals)
        )

    @property
    def reasons(self) -> list[tuple[Any, ...]]:
        gaps: dict[tuple[str, str, str], list[tuple[float, int, tuple[str, ...]]]] = {}
        for design in self.distinct:
            largest: dict[tuple[str, str, str], Reason] = {}
            for reason, _ in design.out:
                key = str(reason.kind), reason.name, reason.unit
                if key not in largest or reason.gap > largest[key].gap:
                    largest[key] = reason
            for key, reason in largest.items():
                gaps.setdefault(key, []).append((reason.gap, design.index, reason.levers))
            failure = next((point.failure for point in design.points if point.failure), None)
            if failure:
                held = [("failure", failure)]
            elif design.ended:
                held = [("unreached", design.ended[0])]
            else:
                lacking = (each for each in self.study.objectives if design.figure(each) is None)
                held = [("no figure", each.name) for each in lacking if design.feasible]
            for kind, name in held:
                gaps.setdefault((kind, name, ""), []).append((0, design.index, ()))
        counts = []
        for key, each in gaps.items():
            least, nearest, levers = min(each)
            counts.append((*key, len(each), nearest, least, levers))
        return sorted(counts, key=lambda count: (-count[3], count[0], count[1]))

    def nearest(self) -> list[int]:
        def miss(design: PlainDesign) -> tuple[float, int]:
            gaps = [r.gap / abs(r.limit) if r.limit else math.inf for r, _ in design.out]
            return max(gaps), design.index

        short = sorted((design for design in self.distinct if design.out), key=miss)
        return [design.index for design in short[:3]]
