"""Points and designs: a design is one combination of the decisions, with one point in each of the conditions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from codesign.errors import InputError, clip
from codesign.exploration.aggregation import Draws, Floats, Spread, aggregated, interval, spread
from codesign.exploration.constraints import budget_of, figure_of, unsatisfied, with_constraints
from codesign.figures import ResultFigure
from codesign.inputs.aggregate import Rule, Share, rule_for
from codesign.inputs.constraint import Constraint
from codesign.records import Listener
from codesign.results.result import Reason, Result
from codesign.scenarios import simulate
from codesign.units import format_count

if TYPE_CHECKING:
    from codesign.explanation import Explanation
    from codesign.exploration.study import Study
    from codesign.inputs import Platform, Workload

State = Literal["done", "failed", "missing"]

SEED = ".seed"
"""The end of the name of a condition that is drawn: its values stand for all that might have been drawn."""


@dataclass(frozen=True, repr=False)
class StudyPoint:
    """One point: its place in the enumeration, its axis values, and what came of it.

    ``result`` is None where the computation failed (``failure`` says why) or was not yet done (``failure``
    is None too, in a study read from the file of an interrupted exploration). ``study``: that it is a point of.
    """

    index: int
    axes: dict[str, Any]
    result: Result | None = None
    failure: str | None = None
    study: Study | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"StudyPoint({self.index}: {clip(axes)}; {fate})"

    @property
    def state(self) -> State:
        """What became of it."""
        if self.result is not None:
            return "done"
        return "missing" if self.failure is None else "failed"

    @property
    def feasible(self) -> bool:
        """Whether it fits and, in a study without conditions, satisfies every constraint."""
        return self.result is not None and self.result.feasible

    @property
    def unreached(self) -> str | None:
        """Why the mission of a feasible point ended before its goals; None where it reached them, or had none."""
        mission = self.result.mission if self.result is not None and self.feasible else None
        return None if mission is None or mission.reached else mission.ended

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Why it is not feasible."""
        return self.result.reasons if self.result is not None else ()

    def judged_by(self, constraints: tuple[Constraint, ...]) -> StudyPoint:
        """The point, with a reason for each of these constraints that it does not satisfy."""
        if self.result is None or not constraints:
            return self
        return replace(self, result=with_constraints(self.result, constraints))

    def figure(self, figure: ResultFigure) -> float | None:
        """One figure, or None where it has none."""
        return None if self.result is None else figure_of(self.result, figure)

    def specs(self) -> tuple[Platform, Workload]:
        """Platform and workload of the point, as ``codesign.simulate`` takes them.

        Raises:
            InputError: the point is of no study that was explored; or a map, part or host file has changed since.
                SpecError: a file is missing; or the point cannot be placed on its platform.
        """
        specs = None if self.study is None else self.study.specs
        if specs is None:
            raise InputError(f"{self!r} is of no exploration, so nothing is known of its specs")
        return specs.point(self.axes)

    def run(self, *, listeners: Sequence[Listener] = (), levers: bool = False) -> Result:
        """Simulate the point again, for its records or its levers; see ``codesign.simulate``.

        Raises:
            InputError, SpecError: see ``specs``.
        """
        platform, workload = self.specs()
        result = simulate(platform, workload, listeners=listeners, levers=levers)
        assert self.study is not None, "it has specs"
        return result if self.study.conditions else with_constraints(result, self.study.constraints)

    def explain(self) -> Explanation:
        """Why the point is as it is, among the points in the same conditions; see ``Study.explain``."""
        study = _study_of(self)
        return study.at({name: self.axes[name] for name in study.conditions}).explain(
            self.index // len(study.world.each)
        )


def _study_of(row: StudyPoint) -> Study:
    if row.study is None:
        raise InputError(f"{row!r} is of no study, so there is nothing to compare it with")
    return row.study


@dataclass(frozen=True)
class Conditions:
    """The conditions of a study, and the rules by which a figure is made of its values in all of them."""

    axes: Mapping[str, tuple[Any, ...]]
    aggregate: Mapping[str, Rule]

    @cached_property
    def each(self) -> tuple[dict[str, Any], ...]:
        """Every combination of conditions, the last axis moving fastest; one without any where there are none."""
        return tuple(
            dict(zip(self.axes, values, strict=True)) for values in itertools.product(*self.axes.values())
        )

    @cached_property
    def draws(self) -> Draws | None:
        """The number of the seed, or combination of seeds, of each condition; None where fewer than two were drawn."""
        places = itertools.product(*(range(len(values)) for values in self.axes.values()))
        drawn = [position for position, name in enumerate(self.axes) if name.endswith(SEED)]
        seeds = [tuple(place[position] for position in drawn) for place in places]
        numbers = {seed: number for number, seed in enumerate(dict.fromkeys(seeds))}
        return np.array([numbers[seed] for seed in seeds], np.intp) if len(numbers) > 1 else None

    def rule(self, figure: ResultFigure) -> Rule:
        """The rule of a figure."""
        return rule_for(self.aggregate, figure)

    def maximise(self, figure: ResultFigure) -> bool:
        """Whether more of the aggregated figure is better: of a share that meets a limit it is, whatever the figure."""
        return figure.maximise or isinstance(self.rule(figure), Share)


@dataclass(frozen=True)
class Out:
    """Why a design is not feasible: a reason of its point in one condition, or of all of them together (None)."""

    reason: Reason
    condition: int | None = None


@dataclass(frozen=True, repr=False)
class Design:
    """One combination of the decisions.

    Attributes:
        index: its number in the enumeration of designs, from 0. axes: the value of each decision.
        points: its point in each condition.
        conditions: of the study.
        out: why it is not feasible; empty where it is, or was not computed.
        ended: why a mission of a feasible design ended before its goals, and the number of that condition.
    """

    index: int
    axes: dict[str, Any]
    points: tuple[StudyPoint, ...]
    conditions: Conditions
    out: tuple[Out, ...] = ()
    ended: tuple[str, int] | None = None

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"Design({self.index}: {clip(axes)}; {fate})"

    def explain(self) -> Explanation:
        """Why the design is as it is; see ``Study.explain``."""
        return _study_of(self.points[0]).explain(self.index)

    @cached_property
    def state(self) -> State:
        """``failed`` where one of its points failed, else ``missing`` where one was not computed."""
        states = {point.state for point in self.points}
        return "failed" if "failed" in states else "missing" if "missing" in states else "done"

    @property
    def feasible(self) -> bool:
        """Whether it fits in every condition that counts, and satisfies every constraint."""
        return self.state == "done" and not self.out

    @property
    def unreached(self) -> str | None:
        """Why a mission of a feasible design ended before its goals; None where all that count reached them."""
        return self.ended[0] if self.ended else None

    @property
    def failure(self) -> str | None:
        """Why the first of its points that failed did."""
        return next((point.failure for point in self.points if point.failure is not None), None)

    def figure(self, figure: ResultFigure) -> float | None:
        """The aggregated figure; None where it has no value in some condition. A share that meets a limit has all."""
        rule = self.conditions.rule(figure)
        if len(self.points) == 1 and not isinstance(rule, Share):
            return self.points[0].figure(figure)
        values = self.values(figure)
        if np.isnan(values).any():
            return None
        return float(aggregated(rule, values, figure.maximise))

    def values(self, figure: ResultFigure) -> Floats:
        """What is aggregated, of each condition: the figure (NaN: none); by share, 1 where the limit is met, else 0."""
        rule = self.conditions.rule(figure)
        if isinstance(rule, Share):
            return np.array([float(_meets(point, rule.share)) for point in self.points])
        return self._plain(figure)

    def spread(self, figure: ResultFigure) -> Spread | None:
        """The spread of the figure over the conditions that have it; None where none has."""
        plain = self._plain(figure)
        known = plain[~np.isnan(plain)]
        if not len(known):
            return None
        told, values = spread(known), self.values(figure)
        if self.conditions.draws is None or np.isnan(values).any():
            return told
        rule = self.conditions.rule(figure)
        return replace(told, interval=interval(rule, values, figure.maximise, self.conditions.draws))

    def _plain(self, figure: ResultFigure) -> Floats:
        values = (point.figure(figure) for point in self.points)
        return np.array([math.nan if value is None else value for value in values])


def designs_of(
    points: Sequence[StudyPoint],
    axes: Iterable[str],
    conditions: Conditions,
    objectives: Sequence[ResultFigure],
    constraints: Sequence[Constraint],
) -> tuple[Design, ...]:
    """The designs that the points, the conditions moving fastest, are of."""
    count, names = len(conditions.each), tuple(axes)
    # What is decided by shares, and by what a design takes of its chip, needs no run in every condition.
    figures = {*objectives, *(limit.figure for limit in constraints)}
    by_share = [figure for figure in figures if isinstance(conditions.rule(figure), Share)]
    tolerant = bool(by_share) and all(figure in by_share or figure.is_resource for figure in figures)
    return tuple(
        _judged(
            Design(
                index,
                {name: points[begin].axes[name] for name in names if name in points[begin].axes},
                tuple(points[begin : begin + count]),
                conditions,
            ),
            constraints if conditions.axes else (),
            tolerant,
        )
        for index, begin in enumerate(range(0, len(points), count))
    )


def _judged(design: Design, constraints: Sequence[Constraint], tolerant: bool) -> Design:
    """The design with what keeps it out."""
    if design.state != "done":
        return design
    blocked = [number for number, point in enumerate(design.points) if not point.feasible]
    out: list[Out] = []
    if len(blocked) == len(design.points) or not tolerant:
        out = [Out(reason, number) for number in blocked for reason in design.points[number].reasons]
    if not blocked or tolerant:
        out += [Out(reason) for limit in constraints for reason in _passed(design, limit)]
    out += [Out(reason) for reason in _short_shares(design)]
    ended = [(why, number) for number, point in enumerate(design.points) if (why := point.unreached)]
    counts = bool(ended) and not out and (not tolerant or len(ended) + len(blocked) == len(design.points))
    return replace(design, out=tuple(out), ended=ended[0] if counts else None) if out or counts else design


def _passed(design: Design, limit: Constraint) -> list[Reason]:
    unreached = any(point.unreached for point in design.points)
    budgets = (budget_of(point.result, limit) for point in design.points if point.result is not None)
    budget = next((each for each in budgets if each is not None), None)
    return unsatisfied(limit, design.figure(limit.figure), budget, feasible=True, unreached=unreached)


def _short_shares(design: Design) -> list[Reason]:
    """A reason for each rule that requires a share of the conditions which the design falls short of."""
    reasons = []
    for name, rule in design.conditions.aggregate.items():
        if not isinstance(rule, Share) or rule.required is None:
            continue
        met = float(design.values(rule.share.figure).mean())
        if met < rule.required:
            what = f"{name} in share of conditions"
            reasons.append(
                Reason(
                    kind="constraint",
                    name=what,
                    demand=met,
                    limit=rule.required,
                    gap=rule.required - met,
                    unit="1",
                )
            )
    return reasons


def _meets(point: StudyPoint, limit: Constraint) -> bool:
    if not point.feasible or point.unreached is not None:
        return False
    value = point.figure(limit.figure)
    if value is None or point.result is None:
        return False
    return not unsatisfied(limit, value, budget_of(point.result, limit), feasible=True, unreached=False)


def checked_index(kind: str, index: int, count: int) -> int:
    """The index of a point or design of which there are ``count``.

    Raises:
        InputError: it is out of range; with the range and the nearest one.
    """
    if 0 <= index < count:
        return index
    nearest = format_count(min(max(index, 0), count - 1))
    hint = f"the study has {kind}s 0 to {format_count(count - 1)}; the nearest is {nearest}"
    raise InputError(f"there is no {kind} {clip(str(index), 40)}", hint=hint)
