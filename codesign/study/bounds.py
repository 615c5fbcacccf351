"""Bounds on the objectives of boxes of designs, by the laws that prices follow.

A family is what is left of a space when every axis but the monotone ones has a value. All of its designs compute the
same. Inside a family, a box is an interval of places on each monotone axis; ``least`` bounds what it may cost.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.models import SpecModel
from codesign.ground.numbering import distinct
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import LOWER, Constraint
from codesign.inputs.derived import DerivedFigure, derived_ends
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.inputs.exploration import Exploration
from codesign.study.aggregation import aggregated
from codesign.study.conditions import Conditions, order_of
from codesign.study.constraints import Floats, broken_bounds, budget_of, figure_of
from codesign.study.evaluation import Pricer
from codesign.study.partition import Parting, Together, parted
from codesign.study.pricing.boards import boards_of
from codesign.study.pricing.computation import Act, Computation
from codesign.study.pricing.machines import Column, Machines, Specs
from codesign.study.pricing.price import PRICED, Group, Priced, parts_of, price
from codesign.study.space import Space
from codesign.system.bind import System
from codesign.system.results.ledger import Ledger
from codesign.system.results.result import Result, times_of
from codesign.system.scenarios.requests import mean_of_requests

_ROUNDED = {"plan_time_95_s", "energy_j"}
"""Figures that sums of floats make. All others are whole picoseconds or products: exact."""


def least(system: System, fastest: Specs, slowest: Specs, computation: Computation) -> dict[str, Column]:
    """A bound below each figure that prices move, of boxes: float64, one entry a box.

    A box is every combination of the values of some axes, each of which moves costs in one direction
    (``Hardware.directions``). The figures themselves do not: a message waits for an edge of a clock, and a faster clock
    may have its next edge later. So time is bounded by what each act takes without any wait, on the fastest machine of
    the box, power by the slowest clock (static power does not depend on it, dynamic power rises with it), and energy by
    the least power over the least time.

    Args:
        system: bound, on a machine of the boxes; one that ``why_alone`` lets price.
        fastest, slowest: the machine of each box on which every act is fastest, and the one on which it is slowest.
        computation: what the system computes.
    """
    boards = boards_of(system, slowest)
    watts = {name: board.drawn(slowest.which[name]) for name, board in boards.items()}
    played = [_LeastMachines(system, fastest).play(request, watts) for request in computation.requests]
    parts = [parts_of(each, request) for each, request in zip(played, computation.requests, strict=True)]
    times = times_of([parts[number] for number in computation.of_starts])
    first = computation.requests[0]
    bounds = {
        **{name: times[name] for name in ("plan_time_worst_s", "plan_time_mean_s", "plan_time_95_s")},
        "first_plan_s": played[0].times[first.before or first.answered] / PICOSECONDS_PER_SECOND,
        "energy_j": mean_of_requests([played[number].joules["energy_j"] for number in computation.of_starts]),
    }
    used = tuple(system.designs)
    if used:
        bounds["power"] = sum(watts[used[0]])
    return {
        name: np.broadcast_to(np.asarray(column, np.float64), fastest.count)
        * (1 - _ROUNDING if name in _ROUNDED else 1.0)
        for name, column in bounds.items()
    }


class _LeastMachines(Machines):
    """Machines on which nothing waits. Each act takes at most what it takes on any machine that is not faster."""

    def watts(self, name: str) -> tuple[Column, Column]:
        """Busy and idle power, the idle one at most the busy one: then energy rises with each of the times."""
        busy, idle = super().watts(name)
        return busy, np.minimum(busy, idle)

    def _do(self, act: Act, ledger: Ledger) -> None:
        del ledger
        resource = self._resource(act)
        begin, end = resource.span(np.zeros_like(self.now), act)
        _, clocks = resource.law(act.unit)
        # From time 0 on, an end within a picosecond is rounded up; between other edges it may be 1 ps less.
        span = np.maximum(end - begin - (clocks.hz < PICOSECONDS_PER_SECOND), 0)
        resource.book(act, span)
        self.now = self.now + span


_MOST = 1e100
"""No time, power or energy is more."""

_ROUNDING = 1e-9
"""Relative: more than what an expression in floats may be off."""


@dataclass(frozen=True, eq=False)
class Best:
    """The best that boxes may come to in one condition: ``lows``, bounds below figures.

    ``pilot``: figures of the slowest design. ``template``: has the figures that no price moves. ``count``: of boxes.
    """

    lows: Mapping[str, Floats]
    pilot: Mapping[str, float]
    template: Result
    count: int

    def ends(self, name: str) -> tuple[Floats, Floats]:
        """The least and the greatest value that a declared figure may have in each box; NaN: none."""
        if name in self.lows:
            return self.lows[name], np.full(self.count, _MOST)
        value = self.pilot[name] if name in PRICED else figure_of(self.template, FIGURES[name])
        held = np.full(self.count, math.nan if value is None else value)
        return held, held


def best_of(figure: ResultFigure, best: Best) -> Floats:
    """The best value of a figure that boxes may have: infinite where no bound is known."""
    unknown = math.inf if figure.maximise else -math.inf
    if isinstance(figure, DerivedFigure):
        with np.errstate(all="ignore"):
            low, high = derived_ends(figure, best.ends)
            low, high = low - _ROUNDING * np.abs(low), high + _ROUNDING * np.abs(high)
    else:
        low, high = best.ends(figure.name)
    bound = np.asarray(high if figure.maximise else low, np.float64)
    return np.where(np.isnan(bound), unknown, bound)


def value_of(figure: ResultFigure, template: Result, priced: Priced) -> float | None:
    """A declared figure of the slowest design of a family; None where it has none."""
    if figure.name in PRICED:
        value = float(priced.figures[figure.name][0])
        return None if math.isnan(value) else value
    return figure_of(template, figure)


def upper_of(limit: Constraint) -> Constraint | None:
    """The upper bounds of a constraint alone; None where it has none."""
    kept = {name: value for name, value in limit.bounds.items() if name not in LOWER}
    lower: dict[str, Any] = dict.fromkeys(LOWER)
    return limit.model_copy(update=lower) if kept else None


Places = NDArray[np.int64]
"""Places of values in the list of an axis in its box of the space: boxes × monotone axes."""


@dataclass(frozen=True)
class Family:
    """Designs that differ in monotone axes alone.

    - ``part``: the number of the box of the space. ``places``: of each axis there, the place of its value; 0 of a
      monotone one. ``axes``: the monotone ones, as numbers of axes of that box. ``rising``: whether each is faster for
      later values, and ``traded``, whether faster is also worse in another figure. ``sizes``: how many values each has.
    """

    part: int
    places: tuple[int, ...]
    axes: tuple[int, ...]
    rising: tuple[bool, ...]
    traded: tuple[bool, ...]
    sizes: tuple[int, ...]

    def at(self, own: Sequence[int]) -> tuple[int, ...]:
        """The places of a design, by those on the monotone axes."""
        places = list(self.places)
        for axis, place in zip(self.axes, own, strict=True):
            places[axis] = int(place)
        return tuple(places)

    @property
    def slowest(self) -> tuple[int, ...]:
        """The places of the slowest design on the monotone axes."""
        return tuple(0 if rises else size - 1 for rises, size in zip(self.rising, self.sizes, strict=True))

    def corners(self, low: Places, last: Places) -> tuple[Places, Places]:
        """The fastest and the slowest design of boxes, from ``low`` to ``last``."""
        rising = np.array(self.rising, np.bool_)
        return np.where(rising, last, low), np.where(rising, low, last)


class Bounds:
    """Bounds for the designs of an exploration.

    Args:
        points: the space of the points. decisions: the space of the designs.
        section: objectives, constraints and conditions.
        pricer: prices the points; what it computed is known.
    """

    def __init__(self, points: Space, decisions: Space, section: Exploration, pricer: Pricer) -> None:
        self.points, self.decisions, self.section, self.pricer = points, decisions, section, pricer
        self.world = Conditions(section.conditions, section.aggregate)
        self._models: dict[tuple[str, str, tuple[int, ...]], SpecModel | None] = {}

    @property
    def shares(self) -> bool:
        """True if a figure is aggregated by share: a design may then be feasible though a condition is not."""
        return any(isinstance(rule, Share) for rule in self.section.aggregate.values())

    def families(self) -> Iterator[Family]:
        """All families of the space, one after another."""
        for part, box in enumerate(self.decisions.parts):
            names = list(box.axes)
            several = PLATFORM_AXIS in names
            for number in range(len(box.axes[PLATFORM_AXIS])) if several else (None,):
                rising = self._monotone(part, number)
                others = [
                    (number or 0,) if name == PLATFORM_AXIS else (0,) if axis in rising else range(len(box.axes[name]))
                    for axis, name in enumerate(names)
                ]
                directions = (tuple(each[0] for each in rising.values()), tuple(each[1] for each in rising.values()))
                sizes = tuple(len(box.axes[names[axis]]) for axis in rising)
                for places in itertools.product(*others):
                    yield Family(part, places, tuple(rising), *directions, sizes)

    def design(self, part: int, places: Sequence[int]) -> int:
        """The number of a design by its places."""
        box, index = self.decisions.parts[part], 0
        for numbers, place in zip(box.axes.values(), places, strict=True):
            index = index * len(numbers) + int(place)
        return box.begin + index

    def open(self, family: Family) -> OpenFamily | None:
        """A family with what its designs compute; None where they are simulated each by itself."""
        if self.shares:
            return None
        design = self.design(family.part, family.at(family.slowest))
        conditions = len(self.world.each)
        members = []
        for condition in range(conditions):
            member = self._member(design * conditions + condition)
            if member is None:
                return None
            members.append(member)
        return OpenFamily(self, family, members)

    def _member(self, point: int) -> Member | None:
        works = list(parted(self.pricer.explored, self.points, np.array([point])))
        work = works[0]
        if not isinstance(work, Together):
            return None
        try:
            system = self.pricer.system(work)
            if system is None:
                return None
            group = Group.of(system, work.specs, lambda: self.pricer.computation(system, {}))
            (priced,) = price([group])
        except CodesignError:
            return None
        levels = self.points.levels(np.array([point]))
        platform = self.pricer.explored.platform(work.axes)
        parting = Parting(self.pricer.explored, self.points, platform, np.array([point]), levels)
        return Member(system, work.specs, priced, group.computation, parting)

    def _monotone(self, part: int, platform: int | None) -> dict[int, tuple[bool, bool]]:
        """The monotone axes of a box of the space, by number: whether later values are faster, and are traded."""
        box, explored = self.decisions.parts[part], self.pricer.explored
        held: dict[str, Any] = {}
        if platform is not None:
            held = {PLATFORM_AXIS: self.decisions.axes[PLATFORM_AXIS][box.axes[PLATFORM_AXIS][platform]]}
        on = explored.platform(held)
        first = np.array([box.begin * len(self.world.each)])
        parting = Parting(explored, self.points, on, first, self.points.levels(first))
        models = {**on.components, **on.links}
        names, rising = list(box.axes), {}
        for name, owned in parting.priced.items():
            for axis in owned:
                model, key = models[name], axis.partition(".")[2]
                sign = model.directions().get(key)
                values = [self.decisions.axes[axis][number] for number in box.axes.get(axis, ())]
                if sign is not None and len(values) > 1 and (order := order_of(axis, values)):
                    rising[names.index(axis)] = sign == order, key in model.traded
        return dict(sorted(rising.items()))

    def model(self, member: Member, name: str, levels: Mapping[str, int]) -> SpecModel | None:
        """A component or link with values of its axes; None where it refuses them."""
        key = member.parting.platform.name, name, tuple(levels.values())
        if key not in self._models:
            self._models[key] = member.parting.model(name, levels)
        return self._models[key]


@dataclass(frozen=True, eq=False)
class Member:
    """The slowest design of a family in one condition.

    ``system``, ``specs``: bound, and its components and links. ``priced``: its outcome; ``computation``: what it
    computes, None where it does not fit. ``parting``: makes the models of components and links.
    """

    system: System
    specs: Specs
    priced: Priced
    computation: Computation | None
    parting: Parting

    @cached_property
    def template(self) -> Result:
        """The part of a result that all designs of the family share in this condition."""
        return self.priced.templates[int(self.priced.which[0])]

    @property
    def out(self) -> str:
        """The reason for which no design of the family is feasible in this condition; "": one may be."""
        if self.priced.reason[0] >= 0:
            return "clock"
        return "fit" if self.template.reasons else ""


class OpenFamily:
    """A family with what its designs compute, in each condition.

    ``out``: why none of its designs is feasible; "": one may be. ``last``: on each monotone axis the last place towards
    the fastest value at which no clock is above its limit.
    """

    def __init__(self, bounds: Bounds, family: Family, members: Sequence[Member]) -> None:
        self.bounds, self.family, self.members = bounds, family, members
        self._names = list(bounds.decisions.parts[family.part].axes)
        self.out = next(filter(None, (member.out for member in members)), "")
        self.lacks = ""
        if not self.out:
            lacking = (each.name for each in bounds.section.objectives if self._is_lacking(each))
            self.lacks = next(lacking, "")

    @property
    def task(self) -> str:
        """The task of the designs in the first condition."""
        task = self.members[0].template.task
        return "" if task is None else task.task

    def fastest_allowed(self) -> tuple[int, ...]:
        """On each monotone axis the place of the fastest value at which no clock is above its limit."""
        places = [size - 1 if rises else 0 for rises, size in zip(self.family.rising, self.family.sizes, strict=True)]
        for number, size in enumerate(self.family.sizes):
            rows = np.tile(np.array(self.family.slowest), (size, 1))
            rows[:, number] = np.arange(size)
            allowed = np.ones(size, np.bool_)
            for member in self.members:
                specs, sound = self._specs(member, rows)
                for name, board in boards_of(member.system, specs).items():
                    late = np.array([reason is not None for reason in board.too_fast])
                    allowed &= ~(late[specs.which[name]] & sound)
            fine = np.flatnonzero(allowed)
            places[number] = int(fine[-1] if self.family.rising[number] else fine[0])
        return tuple(places)

    def costs(self, low: Places, last: Places) -> Floats:
        """A bound below each objective of boxes, boxes × objectives; negated where more is better."""
        lows = self._figures(low, last, self.bounds.section.objectives)
        world = self.bounds.world
        signs = [-1.0 if world.maximise(figure) else 1.0 for figure in self.bounds.section.objectives]
        return np.column_stack([sign * column for sign, column in zip(signs, lows, strict=True)])

    def broken(self, low: Places, last: Places) -> list[tuple[str, str, int, float]]:
        """The boxes of which every design breaks a constraint: name, figure, box, bound on the figure."""
        section = self.bounds.section
        found: list[tuple[str, str, int, float]] = []
        if not section.constraints:
            return found
        lows = self._figures(low, last, [limit.figure for limit in section.constraints])
        for limit, column in zip(section.constraints, lows, strict=True):
            bound = limit if self._is_same(limit.figure) else upper_of(limit)
            if bound is None:
                continue
            budgets = [budget_of(member.template, limit) for member in self.members]
            budget = next((each for each in budgets if each is not None), math.nan)
            none = np.zeros(len(column), np.bool_)
            for broken in broken_bounds(
                bound, np.where(np.isinf(column), math.nan, column), np.array([budget]), feasible=none, unreached=none
            ):
                found += [(broken.name, limit.figure.name, int(box), float(column[box])) for box in broken.which]
        return found

    def _figures(self, low: Places, last: Places, figures: Sequence[ResultFigure]) -> list[Floats]:
        """The best value that each figure may have in boxes, aggregated over the conditions."""
        fast, slow = self.family.corners(low, last)
        members = [self._best(member, fast, slow) for member in self.members]
        world, columns = self.bounds.world, []
        for figure in figures:
            values = np.column_stack([best_of(figure, best) for best in members])
            if values.shape[1] == 1:
                columns.append(values[:, 0])
                continue
            known = np.isfinite(values).all(axis=1)
            column = np.full(len(values), -math.inf if not figure.maximise else math.inf)
            column[known] = aggregated(world.rule(figure), values[known], figure.maximise)
            columns.append(column)
        return columns

    def _best(self, member: Member, fast: Places, slow: Places) -> Best:
        (fastest, one), (slowest, other) = self._specs(member, fast), self._specs(member, slow)
        assert member.computation is not None, "a family of which none is feasible has no bounds"
        bounds = least(member.system, fastest, slowest, member.computation)
        sound = one & other
        return Best(
            {name: np.where(sound, column, -math.inf) for name, column in bounds.items()},
            {name: float(column[0]) for name, column in member.priced.figures.items()},
            member.template,
            len(sound),
        )

    def _specs(self, member: Member, rows: Places) -> tuple[Specs, NDArray[np.bool_]]:
        """The components and links of designs by their places; and which designs none of them refuses."""
        box = self.bounds.decisions.parts[self.family.part]
        columns = {self._names[axis]: rows[:, number] for number, axis in enumerate(self.family.axes)}
        models: dict[str, Sequence[Any]] = {}
        which: dict[str, NDArray[np.intp]] = {}
        sound = np.ones(len(rows), np.bool_)
        for name, held in member.specs.models.items():
            axes = member.parting.priced.get(name, [])
            base = held[int(member.specs.which[name][0])]
            if not any(axis in columns for axis in axes):
                models[name], which[name] = (base,), np.zeros(len(rows), np.intp)
                continue
            levels = np.column_stack(
                [
                    np.array(box.axes[axis])[columns[axis]]
                    if axis in columns
                    else np.full(len(rows), member.parting.levels[axis][0])
                    for axis in axes
                ]
            )
            different, which[name] = distinct(levels, axis=0)
            each = [self.bounds.model(member, name, dict(zip(axes, row, strict=True))) for row in different.tolist()]
            sound &= np.array([model is not None for model in each])[which[name]]
            models[name] = [base if model is None else model for model in each]
        return Specs(models, which, len(rows)), sound

    def _is_lacking(self, figure: ResultFigure) -> bool:
        return any(
            value_of(figure, member.template, member.priced) is None and not isinstance(figure, DerivedFigure)
            for member in self.members
        )

    @staticmethod
    def _is_same(figure: ResultFigure) -> bool:
        """True if all designs of a family have the same figure."""
        return not isinstance(figure, DerivedFigure) and (figure.name not in PRICED or figure.name == "cycles")
