"""The result of an exploration: every design with its figures or its reasons, and the front among them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from codesign.data_frames import data_frame
from codesign.errors import Fault, InputError, SpecError, choose_hint, clip, show
from codesign.exploration.aggregation import Floats, told_apart
from codesign.exploration.designs import (
    Conditions,
    Design,
    StudyPoint,
    checked_index,
    designs_of,
)
from codesign.exploration.document import study_document
from codesign.exploration.front import non_dominated
from codesign.exploration.rows import study_columns
from codesign.exploration.same import same_designs
from codesign.exploration.sensitivity import axis_effects
from codesign.exploration.specs import Specs
from codesign.figures import ResultFigure
from codesign.inputs.aggregate import Rule
from codesign.inputs.constraint import Constraint, needs_of
from codesign.inputs.exploration import not_kept
from codesign.results.provenance import Provenance
from codesign.results.result import Reason
from codesign.units import counted, format_count

if TYPE_CHECKING:
    from pandas import DataFrame

    from codesign.explanation import AxisEffect, Explanation


@dataclass(frozen=True)
class ReasonCount:
    """How often one reason kept designs out: ``designs`` of them.

    ``nearest`` is the index of the design with the least gap, the first of equals; ``least_gap`` (in ``unit``) and
    ``levers`` are those of this design, in its worst condition. A reason without a limit has a gap of 0 and no levers:
    a ``failure``, with its message's first line as name; ``unreached``, with what ended the mission; ``no figure``,
    with the objective that a feasible design does not have.
    """

    kind: str
    name: str
    unit: str
    designs: int
    nearest: int
    least_gap: float
    levers: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Study:
    """Every design of an exploration, and every point: a design in one condition.

    Attributes:
        specs: what the points are made of; None of a study that was put together by hand.
        axes: the values of each decision. conditions: those of each condition; without any, a design is one point.
        objectives: span the front of the designs. constraints: what a feasible design keeps.
        points: ``points[i].index`` is ``i``. Conditions move fastest: design ``d`` has the points from ``d`` times the
            number of conditions on.
        aggregate: how a figure of a design is made of its values in all conditions.
        provenance: version, digests and seeds; without a date, which only what is written has.

    Designs are named by their index in ``designs``. Of designs that differ only in what changes nothing for them
    (``same``), the first one alone counts.
    """

    platform: str
    workload: str
    axes: Mapping[str, tuple[Any, ...]]
    objectives: tuple[ResultFigure, ...]
    constraints: tuple[Constraint, ...]
    points: tuple[StudyPoint, ...]
    conditions: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    aggregate: Mapping[str, Rule] = field(default_factory=dict)
    provenance: Provenance | None = None
    specs: Specs | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", tuple(replace(point, study=self) for point in self.points))

    @property
    def every_axis(self) -> dict[str, tuple[Any, ...]]:
        """The values of each decision, then those of each condition."""
        return {**self.axes, **self.conditions}

    @cached_property
    def world(self) -> Conditions:
        """Every combination of conditions, and the rules."""
        return Conditions(self.conditions, self.aggregate)

    @cached_property
    def designs(self) -> tuple[Design, ...]:
        """Every combination of the decisions, with its points. ``designs[i].index`` is ``i``."""
        return designs_of(self.points, self.axes, self.world, self.objectives, self.constraints)

    @cached_property
    def same(self) -> Mapping[int, tuple[int, ...]]:
        """Designs that are the same as an earlier one, by that one (``same_designs``)."""
        return same_designs(self.designs)

    @cached_property
    def distinct(self) -> tuple[int, ...]:
        """Indices of the designs without those that are the same as an earlier one."""
        again = {index for others in self.same.values() for index in others}
        return tuple(design.index for design in self.designs if design.index not in again)

    def __repr__(self) -> str:
        counts = f"{format_count(len(self.feasible))} feasible, {format_count(len(self.front))} on the front"
        over = f" in {counted(len(self.world.each), 'condition')}" if self.conditions else ""
        designs = f"{counted(len(self.designs), 'design')}{over}"
        return f"Study({self.platform} × {self.workload}: {designs}, {counts})"

    @cached_property
    def feasible(self) -> tuple[int, ...]:
        """Indices of the distinct designs that fit and satisfy every constraint."""
        return tuple(index for index in self.distinct if self.designs[index].feasible)

    @cached_property
    def unreached(self) -> tuple[int, ...]:
        """Indices of the feasible designs with a mission that ended before its goals."""
        return tuple(index for index in self.feasible if self.designs[index].unreached is not None)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Indices of the designs with a point that could not be computed."""
        return self._in_state("failed")

    @property
    def broken(self) -> bool:
        """Whether every design failed: the exploration shows nothing about what is feasible."""
        return len(self.failed) == len(self.designs) > 0

    @cached_property
    def missing(self) -> tuple[int, ...]:
        """Indices of the designs with a point that was not computed."""
        return self._in_state("missing")

    def _in_state(self, state: str) -> tuple[int, ...]:
        return tuple(index for index in self.distinct if self.designs[index].state == state)

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the feasible designs that no other feasible design dominates.

        A feasible design without one of the objectives (no start arrives, so no path length) is not on the
        front; nor is one with a mission that ended before its goals, whatever the objectives. Designs of different
        tasks do not dominate each other.
        """
        if not self.objectives:
            return ()
        by_task: dict[str, list[int]] = {}
        for index in self.feasible:
            design = self.designs[index]
            result = design.points[0].result
            if design.unreached is None:
                task = result.task.task if result is not None and result.task is not None else ""
                by_task.setdefault(task, []).append(index)
        return tuple(sorted(index for indices in by_task.values() for index in self._non_dominated(indices)))

    def _non_dominated(self, candidates: Sequence[int]) -> list[int]:
        figures = [[self.designs[index].figure(name) for name in self.objectives] for index in candidates]
        values = [[math.nan if value is None else value for value in row] for row in figures]
        chosen = non_dominated(values, [self.world.maximise(name) for name in self.objectives])
        return [index for index, on_front in zip(candidates, chosen, strict=True) if on_front]

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
        place = self.feasible.index(index)
        apart = np.zeros(len(self.feasible), np.bool_)
        apart[place] = True
        for figure in figures:
            values = self._values(figure)
            apart |= np.isnan(values).any(axis=1) | told_apart(values[place], values, self.world.draws)
        return tuple(self.feasible[position] for position in np.flatnonzero(~apart))

    def _values(self, figure: ResultFigure) -> Floats:
        """What is aggregated of a figure: feasible designs × conditions."""
        if figure not in self._of_figures:
            rows = [self.designs[index].values(figure) for index in self.feasible]
            self._of_figures[figure] = np.array(rows)
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
        chosen = {name: self._listed(name, value) for name, value in condition.items()}
        left = {name: values for name, values in self.conditions.items() if name not in chosen}
        each = enumerate(self.world.each)
        kept = [number for number, values in each if chosen.items() <= values.items()]
        points = (design.points[number] for design in self.designs for number in kept)
        limits = () if left else self.constraints
        return replace(
            self,
            axes={**self.axes, **{name: (value,) for name, value in chosen.items()}},
            conditions=left,
            aggregate=self.aggregate if left else {},
            points=tuple(replace(point.judged_by(limits), index=index) for index, point in enumerate(points)),
        )

    def needing(self, needs: Sequence[str]) -> Study:
        """The study with further constraints as text, such as ``time < 100 ms``, which all designs are judged by.

        Raises:
            SpecError: a text that is no constraint, or one that contradicts another.
        """
        constraints = (*self.constraints, *needs_of(needs))
        faults = [
            Fault(
                f"--need {show(needs[index - len(self.constraints)])}", 0, 0, "", refusal.what, refusal.hint
            )
            for index, refusal in not_kept(constraints, self.aggregate)
        ]
        if faults:
            raise SpecError(faults)
        limits = () if self.conditions else constraints[len(self.constraints) :]
        points = tuple(point.judged_by(limits) for point in self.points)
        return replace(self, constraints=constraints, points=points)

    def _listed(self, name: str, value: Any) -> Any:
        """The value of a condition that is named by itself or by its number."""
        if name not in self.conditions:
            hint = choose_hint(name, self.conditions) if self.conditions else "the study has no conditions"
            raise InputError(f"there is no condition {name}", "condition", hint)
        values = self.conditions[name]
        for listed in values:
            if listed == value and type(listed) is type(value):
                return listed
        if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < len(values):
            return values[value]
        texts = (clip(json.dumps(listed), 60) for listed in values)
        numbered = clip("; ".join(f"{number}: {text}" for number, text in enumerate(texts)), 400)
        raise InputError(
            f"{name} has no value {show(value)}", "condition", f"its values by number: {numbered}"
        )

    @cached_property
    def reasons(self) -> tuple[ReasonCount, ...]:
        """The reasons that kept designs out, the most frequent first. A design counts once, by its largest gap."""
        gaps_by_reason: dict[tuple[str, str, str], list[tuple[float, int, tuple[str, ...]]]] = {}
        for index in self.distinct:
            design = self.designs[index]
            largest: dict[tuple[str, str, str], Reason] = {}
            for reason in (out.reason for out in design.out):
                key = str(reason.kind), reason.name, reason.unit
                if key not in largest or reason.gap > largest[key].gap:
                    largest[key] = reason
            for key, reason in largest.items():
                gaps_by_reason.setdefault(key, []).append((reason.gap, index, reason.levers))
            for kind, name in self._held_against(design):
                gaps_by_reason.setdefault((kind, name, ""), []).append((0, index, ()))
        counts = []
        for key, gaps in gaps_by_reason.items():
            least, nearest, levers = min(gaps)
            counts.append(ReasonCount(*key, len(gaps), nearest, least, levers))
        return tuple(sorted(counts, key=lambda count: (-count.designs, count.kind, count.name)))

    def lacking(self, design: Design) -> tuple[ResultFigure, ...]:
        """The objectives that keep a feasible design off the front because it does not have them."""
        if not design.feasible:
            return ()
        return tuple(name for name in self.objectives if design.figure(name) is None)

    def _held_against(self, design: Design) -> list[tuple[str, str]]:
        """The reasons that keep a design out besides those of its results, by kind and name."""
        if design.failure is not None:
            return [("failure", design.failure.partition("\n")[0])]
        if design.unreached is not None:
            return [("unreached", design.unreached)]
        return [("no figure", figure.name) for figure in self.lacking(design)]

    def nearest(self, count: int = 3) -> tuple[int, ...]:
        """Indices of the infeasible designs that pass their limits by least: by the largest relative gap of each."""
        short = [self.designs[index] for index in self.distinct if self.designs[index].out]
        short.sort(key=lambda design: (max(_relative_gap(out.reason) for out in design.out), design.index))
        return tuple(design.index for design in short[:count])

    def point(self, index: int) -> StudyPoint:
        """The point of that index.

        Raises:
            InputError: there is none.
        """
        return self.points[checked_index("point", index, len(self.points))]

    def sensitivity(self, *figures: ResultFigure) -> tuple[AxisEffect, ...]:
        """How much of the spread of each figure each axis moves; by default of each objective. See ``axis_effects``."""
        return axis_effects(self, figures or self.objectives)

    def explain(self, index: int) -> Explanation:
        """Why a design is as it is: time, energy, what keeps it out, its neighbours, and how sure that is.

        ``index``: of a design; without conditions a design is a point.

        Raises:
            InputError: there is no such design, it failed, or it was not computed.
        """
        from codesign.exploration.explain_design import explain_design

        return explain_design(self, index)

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON has it: the same at any worker count, and whether computed now or read from a store."""
        return study_document(self).model_dump(mode="json")

    def frame(self) -> DataFrame:
        """The points as a data frame of pandas, with the columns of ``exploration.rows.study_columns``.

        Raises:
            InputError: pandas is not installed.
        """
        return data_frame(study_columns(self))

    def to_json(self) -> str:
        """``to_dict`` as text, one line."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)


def _relative_gap(reason: Reason) -> float:
    return reason.gap / abs(reason.limit) if reason.limit else math.inf
