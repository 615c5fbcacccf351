"""The result of an exploration: every design with its figures or its reasons, and the front among them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.data_frames import data_frame
from codesign.errors import Fault, SpecError, clip, show
from codesign.exploration.aggregation import Floats, told_apart
from codesign.exploration.constraints import Flags
from codesign.exploration.designs import Conditions, Design, Rows, StudyPoint, checked_index
from codesign.exploration.document import study_document
from codesign.exploration.front import non_dominated
from codesign.exploration.full_results import FullResults
from codesign.exploration.judged import Judged
from codesign.exploration.outcomes import Outcomes, State
from codesign.exploration.reasons import ReasonCount, nearest_designs, reason_counts
from codesign.exploration.rivals import StudyRivals
from codesign.exploration.rows import FigureColumn, figure_columns, study_columns
from codesign.exploration.same import Indices, first_of_same
from codesign.exploration.search import Searched
from codesign.exploration.sensitivity import axis_effects
from codesign.exploration.space import Box, Sample, Space
from codesign.exploration.specs import Specs
from codesign.figures import FIGURES, ResultFigure, figure_of
from codesign.inputs.aggregate import Rule
from codesign.inputs.boxes import When
from codesign.inputs.constraint import Constraint, needs_of
from codesign.inputs.derived import DerivedFigure
from codesign.inputs.exploration import not_kept
from codesign.notebooks import InNotebooks
from codesign.progress import Show, silent
from codesign.results.provenance import Provenance
from codesign.results.result import Result
from codesign.units import counted, format_count

if TYPE_CHECKING:
    from pandas import DataFrame

    from codesign.certificates.check import Verdict
    from codesign.explanation import AxisEffect, Explanation


@dataclass(frozen=True, repr=False)
class Study(InNotebooks):
    """Every design of an exploration, and every point: a design in one condition.

    Attributes:
        specs: what the points are made of; None of a study that was put together by hand.
        axes: the values of each decision. conditions: those of each condition; without any, a design is one point.
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
        """The values of each decision, then those of each condition."""
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
        """Which points and designs are feasible, and their figures, in arrays."""
        return Judged(self.outcomes, self.world, self.constraints, self.objectives)

    @property
    def points(self) -> Rows[StudyPoint]:
        """Every point. ``points[i].index`` is ``i``."""
        return Rows(self, StudyPoint, len(self.outcomes))

    @property
    def designs(self) -> Rows[Design]:
        """Every combination of the decisions, with its points. ``designs[i].index`` is ``i``."""
        return Rows(self, Design, self.judged.count)

    @cached_property
    def first_of_same(self) -> Indices:
        """For each design the first one that is the same: itself where no earlier one is."""
        return first_of_same(self)

    @cached_property
    def distinct_designs(self) -> Flags:
        """Which designs are not the same as an earlier one."""
        return np.asarray(self.first_of_same == np.arange(self.judged.count))

    @cached_property
    def same(self) -> Mapping[int, tuple[int, ...]]:
        """Designs that are the same as an earlier one, by that one (``first_of_same``)."""
        again = np.flatnonzero(~self.distinct_designs)
        same: dict[int, list[int]] = {}
        for index, first in zip(again.tolist(), self.first_of_same[again].tolist(), strict=True):
            same.setdefault(first, []).append(index)
        return {first: tuple(others) for first, others in same.items()}

    @cached_property
    def distinct(self) -> tuple[int, ...]:
        """Indices of the designs without those that are the same as an earlier one."""
        return _indices(self.distinct_designs)

    @cached_property
    def on_front(self) -> Flags:
        """Which designs are on the front, or the same as one that is."""
        chosen = np.zeros(self.judged.count, np.bool_)
        chosen[list(self.front)] = True
        return np.asarray(chosen[self.first_of_same])

    def __repr__(self) -> str:
        fates = f"{format_count(len(self.feasible))} feasible, {format_count(len(self.front))} on the front"
        over = f" in {counted(len(self.world.each), 'condition')}" if self.conditions else ""
        name, designs = f"{clip(self.platform)} × {clip(self.workload)}", counted(len(self.designs), "design")
        return f"Study({name}: {designs}{over}, {fates})"

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
        """Whether every design failed: the exploration shows nothing about what is feasible."""
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
        numbers: dict[str, int] = {}

        def number(template: Result) -> int:
            return numbers.setdefault("" if template.task is None else template.task.task, len(numbers))

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
        """What is aggregated of a figure: feasible designs × conditions."""
        if figure not in self._of_figures:
            self._of_figures[figure] = self.judged.values(figure)[
                self.judged.feasible & self.distinct_designs
            ]
        return self._of_figures[figure]

    @cached_property
    def _of_figures(self) -> dict[ResultFigure, Floats]:
        return {}

    def at(self, condition: Mapping[str, Any]) -> Study:
        """The study in some of its conditions: of each named condition one value, the others as they are.

        ``condition``: the value by condition, or its number in the list, from 0. Where every condition is named, the
        study has none left, and its figures are those of single points.

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

    def needing(self, needs: Sequence[str]) -> Study:
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

    @cached_property
    def reasons(self) -> tuple[ReasonCount, ...]:
        """The reasons that kept designs out, the most frequent first. A design counts once, by its largest gap."""
        return reason_counts(self)

    def lacking(self, design: Design) -> tuple[ResultFigure, ...]:
        """The objectives that keep a feasible design off the front because it does not have them."""
        if not design.feasible:
            return ()
        return tuple(name for name in self.objectives if design.figure(name) is None)

    def nearest(self, count: int = 3) -> tuple[int, ...]:
        """Indices of the infeasible designs that pass their limits by least: by the largest relative gap of each."""
        return nearest_designs(self, count)

    def point(self, index: int) -> StudyPoint:
        """The point of that index.

        Raises:
            InputError: there is none.
        """
        return self.points[checked_index("point", index, len(self.points))]

    @property
    def templates(self) -> list[Result]:
        """What results of points have in common, in the order of their first points."""
        return [self.outcomes.templates[number] for number in self.outcomes.used()]

    @cached_property
    def rivals(self) -> StudyRivals:
        """The points that are feasible and reached their goals, for the question which is best by one figure."""
        return StudyRivals(self, np.flatnonzero(self.judged.feasible_points & ~self.judged.unreached_points))

    def result(self, index: int) -> Result | None:
        """The full result of a point; see ``StudyPoint.result``."""
        return self._results[index]

    @cached_property
    def _results(self) -> FullResults:
        return FullResults(self)

    def sensitivity(self, *figures: ResultFigure) -> tuple[AxisEffect, ...]:
        """How much of the spread of each figure each axis moves; by default of each objective. See ``axis_effects``."""
        return axis_effects(self, figures or self.objectives)

    def explain(self, index: int, show: Show = silent) -> Explanation:
        """Why a design is as it is: time, energy, what keeps it out, its neighbours, and how sure that is.

        ``index``: of a design; without conditions a design is a point. ``show`` is told what is run.

        Raises:
            InputError: there is no such design, it failed, or it was not computed.
        """
        from codesign.exploration.explain_design import explain_design

        return explain_design(self, index, show)

    def certify(self, path: Path | str) -> Verdict:
        """Write the certificate of the front, which ``hwsw verify-front`` checks; see ``exploration.certify``."""
        from codesign.exploration.certify import certify

        return certify(self, path)

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON has it: the same at any worker count, and whether computed now or read from a store."""
        return study_document(self).model_dump(mode="json")

    def frame(self) -> DataFrame:
        """The computed points as a data frame of pandas, with the columns of ``exploration.rows.study_columns``.

        Raises:
            InputError: pandas is not installed.
        """
        return data_frame(study_columns(self))

    def figure_of(self, word: ResultFigure | str) -> ResultFigure:
        """The declared or derived figure of a name, or of the name of its column.

        Raises:
            InputError: no figure has this name.
        """
        return word if isinstance(word, ResultFigure) else figure_of(word, {**FIGURES, **self.figures})

    @cached_property
    def figure_columns(self) -> list[FigureColumn]:
        """The columns of figures that a table of its points has."""
        return figure_columns(self)

    def to_parquet(self, path: Path | str, show: Show = silent) -> None:
        """Write every computed point as a Parquet file; see ``exploration.parquet.write_parquet``."""
        from codesign.exploration.parquet import write_parquet

        write_parquet(self, Path(path), show)

    def to_json(self) -> str:
        """``to_dict`` as text, one line."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)


def _indices(which: Flags) -> tuple[int, ...]:
    return tuple(np.flatnonzero(which).tolist())
