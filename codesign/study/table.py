"""The table of a study: columns of points and designs, and what follows from them alone.

A point is a row, and its axes, figures, ends of intervals, state and template are columns (``Outcomes``). A design is a
row of another table: the points in all conditions, judged (``Judged``). Everything that is said of a study (its front,
reasons, rivals, files, pages, certificate) is a function of this table. The engine of the columns is NumPy: it sorts
and groups a million rows as quickly as the engines of data frames do, and is loaded anyway (docs/benchmarks.md).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import Fault, InputError, SpecError, clip, show
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.figures import figure_of as figure_named
from codesign.ground.memo import Memo
from codesign.ground.numbering import Numbering
from codesign.ground.units import counted, format_count
from codesign.inputs import Platform, Workload
from codesign.inputs.aggregate import Rule
from codesign.inputs.axes import When
from codesign.inputs.constraint import Constraint, needs_of
from codesign.inputs.derived import DerivedFigure
from codesign.inputs.exploration import not_kept
from codesign.inputs.workload import PLACE_KEYS
from codesign.maps import OccupancyGrid
from codesign.study.aggregation import Floats, told_apart
from codesign.study.conditions import Conditions
from codesign.study.constraints import Flags, figure_of, with_constraints
from codesign.study.definition import Specs
from codesign.study.front import non_dominated
from codesign.study.groups import Groups
from codesign.study.judged import Judged
from codesign.study.outcomes import Outcomes, State
from codesign.study.pricing.price import PRICED
from codesign.study.rivals import StudyRivals
from codesign.study.search import Searched
from codesign.study.space import Box, Sample, Space, canonical
from codesign.system.results.result import Provenance, Result
from codesign.system.scenarios import simulate

_MOST_HELD = 256


class FullResults:
    """The full results of points by index. The last ones that were simulated are held.

    ``limits``: the constraints that each point is held to. ``specs``: of a point, for ``simulate``.
    """

    def __init__(
        self,
        outcomes: Outcomes,
        limits: tuple[Constraint, ...],
        specs: Callable[[int], tuple[Platform, Workload, OccupancyGrid | None]],
    ) -> None:
        self._outcomes, self._limits, self._specs, self._memo = outcomes, limits, specs, Memo()
        self._held: OrderedDict[int, Result] = OrderedDict()

    def __getitem__(self, index: int) -> Result | None:
        """The full result of a point, with a reason for each limit that it does not keep.

        Raises:
            InputError: it has to be simulated, and is of no exploration, or comes to other figures by now.
            SpecError: a file is missing.
        """
        outcomes = self._outcomes
        if outcomes.state[index] != State.DONE:
            return None
        number = int(outcomes.which[index])
        result = outcomes.templates[number] if number in outcomes.whole else self._simulated(index)
        return with_constraints(result, self._limits)

    def _simulated(self, index: int) -> Result:
        if index not in self._held:
            platform, workload, grid = self._specs(index)
            result = simulate(platform, workload, memo=self._memo, grid=grid)
            moved = [
                FIGURES[name].label
                for name in PRICED
                if result.figure(FIGURES[name]) != self._outcomes.value(FIGURES[name], index)
            ]
            if moved:
                what = f"point {index} has another {' and another '.join(moved)} now than in the study"
                raise InputError(what, hint="other code computed the study: run hwsw explore again")
            self._held[index] = result
            if len(self._held) > _MOST_HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(index)
        return self._held[index]


Indices = NDArray[np.intp]


@dataclass(frozen=True, repr=False)
class Table:
    """The columns of a study, and what is asked of all of its designs.

    Attributes:
        specs: what the points are made of; None of a study that was put together by hand.
        axes: the values of each decision. conditions: the values of each; without any, a design is one point.
        objectives: span the front of the designs. constraints: what a feasible design keeps.
        outcomes: what came of each point. Conditions move fastest: design ``d`` has the points from ``d`` times the
            number of conditions on.
        aggregate: how a figure of a design is made of its values in all conditions.
        provenance: version, digests and seeds; without a date, which only what is written has.
        when: for which values of other decisions a decision exists. figures: those that it derives, by name.
        simulations: how many were made for its points when it was computed; None where it was read.
        chosen: the designs that it holds, by their place among all, in its order; None: all, as they are not too many.
        search: what searches made of the space; None where all points were asked for, or the study was read.
        excluded: the boxes of which a search proved that none of their designs is on the front.

    Designs are named by their index in ``designs``. Of designs that differ only in what changes nothing for them
    (``same``), the first one alone counts.
    """

    platform: str
    workload: str
    axes: Mapping[str, tuple[Any, ...]]
    objectives: tuple[ResultFigure, ...]
    constraints: tuple[Constraint, ...]
    outcomes: Outcomes
    conditions: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    aggregate: Mapping[str, Rule] = field(default_factory=dict)
    provenance: Provenance | None = None
    specs: Specs | None = field(default=None, compare=False)
    when: When = field(default_factory=dict)
    figures: Mapping[str, DerivedFigure] = field(default_factory=dict)
    simulations: int | None = field(default=None, compare=False)
    chosen: tuple[int, ...] | None = None
    search: Searched | None = field(default=None, compare=False)
    excluded: tuple[Box, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        assert len(self.space) == len(self.outcomes), "a point for each combination of all axes"

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def every_axis(self) -> dict[str, tuple[Any, ...]]:
        """The values of each decision, then the values of each condition."""
        return {**self.axes, **self.conditions}

    @cached_property
    def world(self) -> Conditions:
        """Every combination of conditions, and the rules."""
        return Conditions(self.conditions, self.aggregate)

    @cached_property
    def space(self) -> Space:
        """The axes of the points by their index."""
        whole = Space(self.every_axis, "", when=self.when)
        return whole if self.chosen is None else Sample.of(whole, self.chosen, len(self.world.each))

    @cached_property
    def decisions(self) -> Space:
        """The axes of the designs by their index."""
        whole = Space(self.axes, "", when=self.when)
        return whole if self.chosen is None else Sample.of(whole, self.chosen)

    @cached_property
    def judged(self) -> Judged:
        """The points and designs that are feasible, and their figures, in arrays."""
        return Judged(self.outcomes, self.world, self.constraints, self.objectives)

    @cached_property
    def first_of_same(self) -> Indices:
        """For each design the first one that is the same: itself where no earlier one is."""
        return first_of_same(self)

    @cached_property
    def distinct_designs(self) -> Flags:
        """The designs that are not the same as an earlier one."""
        return np.asarray(self.first_of_same == np.arange(self.judged.count))

    @cached_property
    def same(self) -> Mapping[int, tuple[int, ...]]:
        """Designs that are the same as an earlier one, by that one (``first_of_same``)."""
        again = np.flatnonzero(~self.distinct_designs)
        firsts = self.first_of_same[again]
        groups = Groups.of(firsts)
        return {
            int(firsts[first]): tuple(again[members].tolist())
            for first, members in zip(groups.firsts.tolist(), groups.members, strict=True)
        }

    @cached_property
    def distinct(self) -> tuple[int, ...]:
        """Indices of the designs without those that are the same as an earlier one."""
        return _indices(self.distinct_designs)

    @cached_property
    def on_front(self) -> Flags:
        """The designs on the front, and those that are the same as one on it."""
        chosen = np.zeros(self.judged.count, np.bool_)
        chosen[list(self.front)] = True
        return np.asarray(chosen[self.first_of_same])

    def __repr__(self) -> str:
        fates = f"{format_count(len(self.feasible))} feasible, {format_count(len(self.front))} on the front"
        over = f" in {counted(len(self.world.each), 'condition')}" if self.conditions else ""
        name, designs = f"{clip(self.platform)} × {clip(self.workload)}", counted(self.judged.count, "design")
        return f"{type(self).__name__}({name}: {designs}{over}, {fates})"

    @cached_property
    def feasible(self) -> tuple[int, ...]:
        """Indices of the distinct designs that fit and satisfy every constraint."""
        return _indices(self.judged.feasible & self.distinct_designs)

    @cached_property
    def unreached(self) -> tuple[int, ...]:
        """Indices of the feasible designs with a mission that ended before its goals."""
        return _indices(self.judged.unreached & self.distinct_designs)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Indices of the designs with a point that could not be computed."""
        return self._in_state(State.FAILED)

    @property
    def broken(self) -> bool:
        """True if every design failed: the exploration shows nothing about what is feasible."""
        return len(self.failed) == self.judged.count > 0

    @cached_property
    def missing(self) -> tuple[int, ...]:
        """Indices of the designs with a point that was not computed."""
        return self._in_state(State.MISSING)

    def _in_state(self, state: State) -> tuple[int, ...]:
        return _indices((self.judged.state == state) & self.distinct_designs)

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the feasible designs that no other feasible design dominates.

        A feasible design without one of the objectives (no start arrives, so no path length) is not on the
        front; nor is one with a mission that ended before its goals, whatever the objectives. Designs of different
        tasks do not dominate each other.
        """
        if not self.objectives:
            return ()
        candidates = np.flatnonzero(self.judged.feasible & ~self.judged.unreached & self.distinct_designs)
        costs = np.column_stack([self.judged.figure(figure)[candidates] for figure in self.objectives])
        maximise = [self.world.maximise(figure) for figure in self.objectives]
        tasks = self._tasks[candidates]
        chosen = np.zeros(len(candidates), np.bool_)
        for task in np.unique(tasks):
            chosen[tasks == task] = non_dominated(costs[tasks == task], maximise)
        return tuple(candidates[chosen].tolist())

    @property
    def _tasks(self) -> NDArray[np.int64]:
        """The number of the task of each design in its first condition."""
        numbers = Numbering[str]()

        def number(template: Result) -> int:
            return numbers["" if template.task is None else template.task.task]

        return np.asarray(self.judged.by_design(self.outcomes.each(number, -1))[:, 0], np.int64)

    @cached_property
    def alike(self) -> Mapping[int, tuple[int, ...]]:
        """By design of the front, the other designs that no objective tells apart from it over the conditions."""
        alike = ((index, self.alike_in(index, self.objectives)) for index in self.front)
        return {index: others for index, others in alike if others}

    def alike_in(self, index: int, figures: Sequence[ResultFigure]) -> tuple[int, ...]:
        """The feasible designs that none of the figures tells apart from a feasible one over the conditions.

        Two designs are not told apart by a figure if each is better in some conditions, or if they are equal in all; of
        drawn seeds, if the interval of confidence of their mean difference holds 0 (``told_apart``). With fewer than
        two conditions all are told apart, and a design without one of the figures is told apart from all.
        """
        if len(self.world.each) < 2:
            return ()
        feasible = np.flatnonzero(self.judged.feasible & self.distinct_designs)
        place = int(np.searchsorted(feasible, index))
        apart = np.zeros(len(feasible), np.bool_)
        apart[place] = True
        for figure in figures:
            values = self._values(figure)
            apart |= np.isnan(values).any(axis=1) | told_apart(values[place], values, self.world.draws)
        return tuple(feasible[~apart].tolist())

    def _values(self, figure: ResultFigure) -> Floats:
        """The values of a figure that are aggregated: feasible designs × conditions."""
        if figure not in self._of_figures:
            self._of_figures[figure] = self.judged.values(figure)[self.judged.feasible & self.distinct_designs]
        return self._of_figures[figure]

    @cached_property
    def _of_figures(self) -> dict[ResultFigure, Floats]:
        return {}

    def at(self, condition: Mapping[str, Any]) -> Self:
        """The study in some of its conditions: of each named condition one value, the others as they are.

        ``condition``: the value by condition, or its number in the list, from 0. If every condition is named, the
        study has none left, and its figures are figures of single points.

        Raises:
            InputError: no such condition, or no such value of it.
        """
        if not condition:
            return self
        chosen = {name: self.world.listed(name, value) for name, value in condition.items()}
        left = {name: values for name, values in self.conditions.items() if name not in chosen}
        each = enumerate(self.world.each)
        kept = [number for number, values in each if chosen.items() <= values.items()]
        designs = np.arange(self.judged.count)[:, None] * self.judged.conditions
        return replace(
            self,
            axes={**self.axes, **{name: (value,) for name, value in chosen.items()}},
            conditions=left,
            aggregate=self.aggregate if left else {},
            outcomes=self.outcomes.chosen((designs + np.array(kept)).reshape(-1)),
            excluded=(),
        )

    def needing(self, needs: Sequence[str]) -> Self:
        """The study judged by further constraints as text, such as ``time < 100 ms``; those it has count once.

        Raises:
            SpecError: a text that is no constraint, or one that contradicts another.
        """
        texts = dict(zip(dict.fromkeys(needs), needs_of(needs, figures=self.figures), strict=True))
        further = {text: each for text, each in texts.items() if each not in self.constraints}
        constraints, names = (*self.constraints, *further.values()), [*self.constraints, *further]
        faults = [
            Fault(f"--need {show(names[index])}", 0, 0, "", refusal.what, refusal.hint)
            for index, refusal in not_kept(constraints, self.aggregate)
        ]
        if faults:
            raise SpecError(faults)
        return replace(self, constraints=constraints, excluded=() if further else self.excluded)

    @property
    def templates(self) -> list[Result]:
        """The parts of results that points share, in the order of their first points."""
        return [self.outcomes.templates[number] for number in self.outcomes.used()]

    @cached_property
    def rivals(self) -> StudyRivals:
        """The points that are feasible and reached their goals, for the question which is best by one figure."""
        points = np.flatnonzero(self.judged.feasible_points & ~self.judged.unreached_points)
        return StudyRivals(self.outcomes, points, self.result)

    def made_of(self, index: int) -> Specs:
        """The specs that a point is made of.

        Raises:
            InputError: the study is of no exploration.
        """
        if self.specs is None:
            raise InputError(f"point {index} is of no exploration, so nothing is known of its specs")
        return self.specs

    def specs_on_its_map(self, index: int) -> tuple[Platform, Workload, OccupancyGrid | None]:
        """Platform and workload of a point, and the map it was computed on where that is at hand; see ``Specs``."""
        return self.made_of(index).point_on_its_map(self.space.values(index))

    def result(self, index: int) -> Result | None:
        """The full result of a point; see ``StudyPoint.result``."""
        return self._results[index]

    @cached_property
    def _results(self) -> FullResults:
        limits = () if self.conditions else self.constraints
        return FullResults(self.outcomes, limits, self.specs_on_its_map)

    def figure_of(self, word: ResultFigure | str) -> ResultFigure:
        """The declared or derived figure of a name, or of the name of its column.

        Raises:
            InputError: no figure has this name.
        """
        return word if isinstance(word, ResultFigure) else figure_named(word, {**FIGURES, **self.figures})


def _indices(which: Flags) -> tuple[int, ...]:
    return tuple(np.flatnonzero(which).tolist())


def first_of_same(table: Table) -> Indices:
    """For each design the first one that is the same: itself where no earlier one is.

    Two designs are the same if each axis in which they differ moves nothing that either uses, in any condition, and
    all of their declared figures are equal in every condition. Equal figures alone do not make them the same. A design
    that was not run in every condition is the same as no other: what it would use is not known.

    An axis moves nothing that a point uses if it moves a component or link that did nothing in the run and has no task,
    a task that another design of the study has and this one has not, or a parameter that the style does not use.
    """
    first = np.arange(table.judged.count)
    idle = _idle_axes(table)
    held = np.flatnonzero(idle.any(axis=1))
    # By the axes that are idle, and by the values of the others.
    keys = [Groups.of(*idle[held].T).which] if len(held) else []
    levels = table.decisions.levels(held)
    for number, name in enumerate(table.axes):
        keys.append(np.where(idle[held, number], -1, first_of_equals(table.axes[name])[levels[name]]))
    held, keys = _several(held, keys)
    if not len(held):
        return first
    keys += [column[held] for column in _figure_columns(table)]
    group = Groups.of(*keys)
    first[held] = held[group.firsts][group.which]
    return first


def first_of_equals(values: Sequence[Any]) -> Indices:
    """For each value the number of the first one that is equal as JSON; behind them -1, where there is no value."""
    texts = list(map(canonical, values))
    return np.array([*map(texts.index, texts), -1], np.intp)


def _several(held: Indices, keys: Sequence[NDArray[Any]]) -> tuple[Indices, list[NDArray[Any]]]:
    """Those designs whose keys another one has too, and their keys in one column."""
    if not len(held):
        return held, []
    group = Groups.of(*keys).which
    several = np.bincount(group)[group] > 1
    return held[several], [group[several]]


def _figure_columns(table: Table) -> list[NDArray[Any]]:
    """Columns that are equal where all declared figures of designs are, in every condition."""
    outcomes, judged = table.outcomes, table.judged
    numbers = Numbering[tuple[float | None, ...]]()
    fixed = [figure for figure in FIGURES.values() if figure.name not in PRICED]

    def number(template: Result) -> int:
        return numbers[tuple(figure_of(template, figure) for figure in fixed)]

    columns = [judged.by_design(outcomes.each(number, -1))]
    columns += [judged.by_design(outcomes.figures[name]) for name in PRICED]
    return [column[:, condition] for column in columns for condition in range(judged.conditions)]


def _idle_axes(table: Table) -> NDArray[np.bool_]:
    """The axes that move nothing that a design uses: designs × axes; none of a design that was not run."""
    outcomes, judged, names = table.outcomes, table.judged, tuple(table.axes)
    tasks = {task for number in outcomes.used() for task in outcomes.templates[number].places}
    rows = [
        [
            bool(template.utilisation is not None and template.places) and _is_idle(name, template, tasks)
            for name in names
        ]
        for template in outcomes.templates
    ]
    idle_of = np.array([*rows, [False] * len(names)], np.bool_).reshape(len(rows) + 1, len(names))
    if not idle_of.any():
        return np.zeros((judged.count, len(names)), np.bool_)
    idle = np.ones((judged.count, len(names)), np.bool_)
    for which in judged.by_design(outcomes.which).T:
        idle &= idle_of[which]
    return idle


def _is_idle(axis: str, result: Result, tasks: set[str]) -> bool:
    head, _, key = axis.partition(".")
    head = result.roles.get(head, head)
    if head in result.parameters:
        first = key.partition(".")[0]
        return first not in result.parameters[head] and first not in PLACE_KEYS
    if head in tasks:
        return head not in result.places
    busy = (result.utilisation or {}).get(head)
    use = (result.links or {}).get(head)
    serves = head in result.places.values() or head == result.external_memory or head in (result.displays or {})
    return busy == 0 and not serves and (use is None or use.sent == 0)
