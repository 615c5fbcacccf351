"""The points and designs of a study that fit, keep the constraints and reach their goals, in arrays.

``Design.out`` has the reasons of one design; what follows for all designs from the same rules stands here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import ResultFigure
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import Constraint
from codesign.study.aggregation import Floats, aggregated
from codesign.study.conditions import Conditions
from codesign.study.constraints import Broken, Flags, Why, broken_bounds, budget_of
from codesign.study.outcomes import Outcomes, State
from codesign.system.results.result import Result


class Judged:
    """The points and designs of a study, judged. Arrays of points end in ``points``; all others are of designs.

    ``world``: the conditions and the rules. ``figures``: the objectives and what else designs are compared by.
    """

    def __init__(
        self,
        outcomes: Outcomes,
        world: Conditions,
        constraints: Sequence[Constraint] = (),
        figures: Sequence[ResultFigure] = (),
    ) -> None:
        self._outcomes, self._world, self._constraints = outcomes, world, constraints
        self._compared = {*figures, *(limit.figure for limit in constraints)}
        self.conditions = len(world.each)
        self.count = len(outcomes) // self.conditions
        self._figures: dict[ResultFigure, Floats] = {}

    def by_design(self, points: NDArray[np.generic]) -> NDArray[np.generic]:
        """An array of points as designs × conditions."""
        return points.reshape(self.count, self.conditions)

    # ---- points ----

    @cached_property
    def fits_points(self) -> Flags:
        """The points that fit, whatever the constraints."""
        fits = self._outcomes.each(lambda template: template.feasible, False)
        return np.asarray(fits & (self._outcomes.state == State.DONE) & (self._outcomes.reason < 0))

    @cached_property
    def ended_points(self) -> NDArray[np.int64]:
        """The number in ``ends`` of why the mission of each point ended before its goals; -1: it reached them."""
        numbers = {ended: number for number, ended in enumerate(self.ends)}
        return self._outcomes.each(lambda template: numbers.get(_ended(template) or "", -1), -1)

    @cached_property
    def ends(self) -> tuple[str, ...]:
        """The reasons for which missions ended before their goals, each once."""
        return tuple(dict.fromkeys(filter(None, map(_ended, self._outcomes.templates))))

    @cached_property
    def broken_points(self) -> list[Broken]:
        """The constraints that points do not keep; none over conditions, where designs keep them."""
        outcomes = self._outcomes
        return [
            broken
            for limit in (() if self._world.axes else self._constraints)
            for broken in broken_bounds(
                limit,
                outcomes.column(limit.figure),
                self._budgets(limit),
                feasible=self.fits_points,
                unreached=self.ended_points >= 0,
                whys=partial(outcomes.whys, limit.figure),
            )
        ]

    @cached_property
    def feasible_points(self) -> Flags:
        """The points that fit and, in a study without conditions, keep every constraint."""
        feasible = self.fits_points.copy()
        for broken in self.broken_points:
            feasible[broken.which] = False
        return feasible

    @cached_property
    def unreached_points(self) -> Flags:
        """The feasible points with a mission that ended before its goals."""
        return np.asarray(self.feasible_points & (self.ended_points >= 0))

    def _budgets(self, limit: Constraint) -> Floats:
        def budget(template: Result) -> float:
            held = budget_of(template, limit)
            return math.nan if held is None else held

        return np.asarray(self._outcomes.each(budget, math.nan) if limit.of_part else np.full(1, math.nan), np.float64)

    # ---- designs ----

    @cached_property
    def state(self) -> NDArray[np.int8]:
        """Failed where a point failed, else missing where one is missing, else done."""
        states = self.by_design(self._outcomes.state)
        whole = np.where((states == State.MISSING).any(axis=1), State.MISSING, State.DONE)
        return np.where((states == State.FAILED).any(axis=1), State.FAILED, whole).astype(np.int8)

    @cached_property
    def tolerant(self) -> bool:
        """True if no figure that designs are judged by needs a run in every condition.

        A share does not, nor does what a design takes of its chip.
        """
        by_share = [figure for figure in self._compared if isinstance(self._world.rule(figure), Share)]
        return bool(by_share) and all(figure in by_share or figure.is_resource for figure in self._compared)

    @cached_property
    def blocked(self) -> NDArray[np.int64]:
        """The number of conditions in which a design is infeasible by itself."""
        return np.asarray(self.conditions - self.by_design(self.feasible_points).sum(axis=1))

    @cached_property
    def counts_points(self) -> Flags:
        """The points with reasons that keep their designs out."""
        done, blocked = self.state == State.DONE, self.blocked
        out = done & (blocked == self.conditions) if self.tolerant else done & (blocked > 0)
        return np.asarray(np.repeat(out, self.conditions) & ~self.feasible_points)

    @cached_property
    def broken(self) -> list[Broken]:
        """The constraints that designs do not keep over the conditions; none without conditions."""
        if not self._world.axes:
            return []
        held = (self.state == State.DONE) & ((self.blocked == 0) | self.tolerant)
        unreached = np.asarray(self.by_design(self.unreached_points).any(axis=1))
        broken = []
        for limit in self._constraints:
            all_of = broken_bounds(
                limit,
                self.figure(limit.figure),
                self.budgets(limit) if limit.of_part else np.full(1, math.nan),
                feasible=np.ones(self.count, np.bool_),
                unreached=unreached,
                whys=partial(self.whys, limit.figure),
            )
            broken += [_those(each, held[each.which]) for each in all_of]
        return broken

    @cached_property
    def short(self) -> list[Broken]:
        """The rules that require a share of the conditions which designs fall short of."""
        short = []
        for name, rule in self._world.aggregate.items():
            if isinstance(rule, Share) and rule.required is not None:
                met = self.values_by_share(rule).mean(axis=1)
                which = np.flatnonzero((self.state == State.DONE) & (met < rule.required))
                limit = np.full(len(which), rule.required)
                what = f"{name} in share of conditions"
                short.append(Broken(what, "1", which, met[which], limit, rule.required - met[which]))
        return short

    @cached_property
    def out(self) -> Flags:
        """The designs with a reason that keeps them out."""
        reasoned = self._outcomes.each(lambda template: bool(template.reasons), False) | (self._outcomes.reason >= 0)
        for broken in self.broken_points:
            reasoned[broken.which] = True
        out = np.asarray(self.by_design(self.counts_points & reasoned).any(axis=1))
        for broken in (*self.broken, *self.short):
            out[broken.which] = True
        return out

    @cached_property
    def feasible(self) -> Flags:
        """The designs that fit in every condition that counts, and satisfy every constraint."""
        return np.asarray((self.state == State.DONE) & ~self.out)

    @cached_property
    def unreached(self) -> Flags:
        """The feasible designs with a mission that ended before its goals, and counts."""
        ended = self.by_design(self.unreached_points).sum(axis=1)
        counts = (ended > 0) & self.feasible
        return np.asarray(counts & (ended + self.blocked == self.conditions) if self.tolerant else counts)

    @cached_property
    def ended(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Of designs that are ``unreached``: the first condition that is, and why, as a number in ``ends``."""
        condition = np.asarray(self.by_design(self.unreached_points).argmax(axis=1), np.int64)
        return condition, np.asarray(self.by_design(self.ended_points)[np.arange(self.count), condition], np.int64)

    def budgets(self, limit: Constraint) -> Floats:
        """The budget of the part of each design of a resource that a constraint bounds by a share; NaN: it has none."""
        table = self.by_design(np.broadcast_to(self._budgets(limit), len(self._outcomes)))
        return np.asarray(table[np.arange(self.count), (~np.isnan(table)).argmax(axis=1)], np.float64)

    # ---- figures of designs ----

    def figure(self, figure: ResultFigure) -> Floats:
        """The aggregated figure of each design; NaN where it has no value in some condition."""
        if figure not in self._figures:
            rule = self._world.rule(figure)
            if self.conditions == 1 and not isinstance(rule, Share):
                self._figures[figure] = self._outcomes.column(figure)
            else:
                values, column = self.values(figure), np.full(self.count, math.nan)
                held = ~np.isnan(values).any(axis=1)
                column[held] = aggregated(rule, values[held], figure.maximise)
                self._figures[figure] = column
        return self._figures[figure]

    def whys(self, figure: ResultFigure) -> list[Why]:
        """The reasons for no value of a figure in some condition, with their designs; see ``Outcomes.whys``."""
        whys = self._outcomes.whys(figure)
        return [(why, np.asarray(self.by_design(where).any(axis=1))) for why, where in whys]

    def values(self, figure: ResultFigure) -> Floats:
        """The values that are aggregated, designs × conditions: the figure; by share, 1 if the limit is met, else 0."""
        rule = self._world.rule(figure)
        return self.values_by_share(rule) if isinstance(rule, Share) else self.plain(figure)

    def plain(self, figure: ResultFigure) -> Floats:
        """The figure of each point, designs × conditions; NaN: none."""
        return np.asarray(self.by_design(self._outcomes.column(figure)), np.float64)

    def values_by_share(self, rule: Share) -> Floats:
        """1 where a design meets the limit of a share in a condition, else 0: designs × conditions."""
        values = self._outcomes.column(rule.share.figure)
        fine = self.feasible_points & ~self.unreached_points
        met = fine & ~np.isnan(values)
        nowhere = np.zeros(len(values), np.bool_)
        budgets = self._budgets(rule.share)
        for broken in broken_bounds(rule.share, values, budgets, feasible=nowhere, unreached=nowhere):
            met[broken.which] = False
        return np.asarray(self.by_design(met.astype(np.float64)))


def _ended(template: Result) -> str | None:
    mission = template.mission
    return None if mission is None or mission.reached else mission.ended


def _those(broken: Broken, kept: Flags) -> Broken:
    demand, limit, gap = (each[kept] for each in (broken.demand, broken.limit, broken.gap))
    return Broken(broken.name, broken.unit, broken.which[kept], demand, limit, gap)
