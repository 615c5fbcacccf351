"""The result of an exploration: every point with its figures or its reasons, and the front among them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from codesign.data_frames import data_frame
from codesign.errors import clip
from codesign.exploration.document import ConstraintBounds, Counts, Objective, Point, StudyDocument
from codesign.exploration.front import non_dominated
from codesign.exploration.rows import study_columns
from codesign.figures import FIGURES, ResultFigure
from codesign.inputs.exploration import Constraint
from codesign.results.result import Reason, Result
from codesign.units import counted, format_count

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, repr=False)
class StudyPoint:
    """One point: its place in the enumeration, its axis values, and what came of it.

    ``result`` is None where the computation failed (``failure`` says why) or was not yet done (``failure``
    is None too, in a study read from the file of an interrupted exploration).
    """

    index: int
    axes: dict[str, Any]
    result: Result | None = None
    failure: str | None = None

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"StudyPoint({self.index}: {clip(axes)}; {fate})"

    @property
    def state(self) -> Literal["done", "failed", "missing"]:
        """What became of it."""
        if self.result is not None:
            return "done"
        return "missing" if self.failure is None else "failed"

    @property
    def feasible(self) -> bool:
        """Whether it fits and satisfies every constraint."""
        return self.result is not None and self.result.feasible

    @property
    def unreached(self) -> str | None:
        """Why the mission of a feasible point ended before its goals; None where it reached them, or had none."""
        mission = self.result.mission if self.result is not None and self.feasible else None
        return None if mission is None or mission.reached else mission.ended

    def figure(self, figure: ResultFigure) -> float | None:
        """One figure, or None where it has none."""
        return None if self.result is None else figure_of(self.result, figure)


def figure_of(result: Result, figure: ResultFigure) -> float | None:
    """One figure as designs are compared by it. A design that needs no chip takes none of a chip's resources."""
    value = result.figure(figure)
    placed = not any(reason.kind == "mapping" for reason in result.reasons)
    if value is None and figure.is_resource and result.part is None and not result.resources and placed:
        return 0.0
    return value


@dataclass(frozen=True)
class ReasonCount:
    """How often one reason kept points out: ``points`` of them.

    ``nearest`` is the index of the point with the least gap, the first of equals; ``least_gap`` (in ``unit``) and
    ``levers`` are those of this point. A reason without a limit has a gap of 0 and no levers: a ``failure``,
    with its message's first line as name; ``unreached``, with what ended the mission; ``no figure``, with the objective
    that a feasible point does not have.
    """

    kind: str
    name: str
    unit: str
    points: int
    nearest: int
    least_gap: float
    levers: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Study:
    """Every point of an exploration. ``points[i].index`` is ``i``."""

    platform: str
    workload: str
    axes: Mapping[str, tuple[Any, ...]]
    objectives: tuple[ResultFigure, ...]
    constraints: tuple[Constraint, ...]
    points: tuple[StudyPoint, ...]

    def __repr__(self) -> str:
        counts = f"{format_count(len(self.feasible))} feasible, {format_count(len(self.front))} on the front"
        return f"Study({self.platform} × {self.workload}: {counted(len(self.points), 'point')}, {counts})"

    @cached_property
    def feasible(self) -> tuple[int, ...]:
        """Indices of the points that fit and satisfy every constraint."""
        return tuple(point.index for point in self.points if point.feasible)

    @cached_property
    def unreached(self) -> tuple[int, ...]:
        """Indices of the feasible points with a mission that ended before its goals."""
        return tuple(point.index for point in self.points if point.unreached is not None)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Indices of the points that could not be computed."""
        return tuple(point.index for point in self.points if point.state == "failed")

    @property
    def broken(self) -> bool:
        """Whether every point failed: the exploration shows nothing about what is feasible."""
        return len(self.failed) == len(self.points) > 0

    @cached_property
    def missing(self) -> tuple[int, ...]:
        """Indices of the points that were not computed."""
        return tuple(point.index for point in self.points if point.state == "missing")

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the feasible points that no other feasible point dominates.

        A feasible point without one of the objectives (no start arrives, so no path length) is not on the
        front; nor is one whose mission ended before its goals, whatever the objectives. Points of different tasks do
        not dominate each other.
        """
        if not self.objectives:
            return ()
        by_task: dict[str, list[int]] = {}
        for index in self.feasible:
            point = self.points[index]
            if point.unreached is None and point.result is not None:
                by_task.setdefault(point.result.task.task if point.result.task else "", []).append(index)
        return tuple(sorted(index for indices in by_task.values() for index in self._non_dominated(indices)))

    def _non_dominated(self, candidates: Sequence[int]) -> list[int]:
        figures = [[self.points[index].figure(name) for name in self.objectives] for index in candidates]
        values = [[math.nan if value is None else value for value in row] for row in figures]
        chosen = non_dominated(values, [name.maximise for name in self.objectives])
        return [index for index, on_front in zip(candidates, chosen, strict=True) if on_front]

    @cached_property
    def reasons(self) -> tuple[ReasonCount, ...]:
        """The reasons that kept points out, the most frequent first."""
        gaps_by_reason: dict[tuple[str, str, str], list[tuple[float, int, tuple[str, ...]]]] = {}
        for point in self.points:
            for reason in _reasons(point):
                gap = reason.gap, point.index, reason.levers
                gaps_by_reason.setdefault((reason.kind, reason.name, reason.unit), []).append(gap)
            for kind, name in self._held_against(point):
                gaps_by_reason.setdefault((kind, name, ""), []).append((0, point.index, ()))
        counts = []
        for key, gaps in gaps_by_reason.items():
            least, nearest, levers = min(gaps)
            counts.append(ReasonCount(*key, len(gaps), nearest, least, levers))
        return tuple(sorted(counts, key=lambda count: (-count.points, count.kind, count.name)))

    def lacking(self, point: StudyPoint) -> tuple[ResultFigure, ...]:
        """The objectives that keep a feasible point off the front because it does not have them."""
        if not point.feasible:
            return ()
        return tuple(name for name in self.objectives if point.figure(name) is None)

    def _held_against(self, point: StudyPoint) -> list[tuple[str, str]]:
        """The reasons that keep a point out besides those of its result, by kind and name."""
        if point.failure is not None:
            return [("failure", point.failure.partition("\n")[0])]
        if point.unreached is not None:
            return [("unreached", point.unreached)]
        return [("no figure", figure.name) for figure in self.lacking(point)]

    def nearest(self, count: int = 3) -> tuple[int, ...]:
        """Indices of the infeasible points that pass their limits by least: by the largest relative gap of each."""
        short = [point for point in self.points if point.result is not None and not point.feasible]
        short.sort(
            key=lambda point: (max(map(_relative_gap, _reasons(point)), default=math.inf), point.index)
        )
        return tuple(point.index for point in short[:count])

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON has it: the same at any worker count, and whether computed now or read from a store."""
        front = set(self.front)
        document = StudyDocument(
            platform=self.platform,
            workload=self.workload,
            axes={name: list(values) for name, values in self.axes.items()},
            units={figure: figure.unit for figure in FIGURES.values()},
            objectives=[
                Objective(figure=figure, unit=figure.unit, direction=figure.direction)
                for figure in self.objectives
            ],
            constraints=[
                ConstraintBounds(figure=limit.figure, at_least=limit.at_least, at_most=limit.at_most)
                for limit in self.constraints
            ],
            counts=Counts(
                points=len(self.points),
                feasible=len(self.feasible),
                unreached=len(self.unreached),
                failed=len(self.failed),
                missing=len(self.missing),
                front=len(front),
            ),
            points=[_point(point, point.index in front) for point in self.points],
            front=list(self.front),
        )
        return document.model_dump(mode="json")

    def frame(self) -> DataFrame:
        """The points as a data frame of pandas, with the columns of ``exploration.rows.study_columns``.

        Raises:
            InputError: pandas is not installed.
        """
        return data_frame(study_columns(self))

    def to_json(self) -> str:
        """``to_dict`` as text, one line."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)


def with_constraints(result: Result, constraints: tuple[Constraint, ...]) -> Result:
    """The result with a reason for every constraint that it does not satisfy.

    A figure that a feasible point does not have (no start arrives, so no path length) satisfies no
    constraint; one that a point lacks because it does not fit, and was never run, is not held against it.
    """
    reasons = [reason for limit in constraints for reason in _unsatisfied(limit, result)]
    if not reasons:
        return result
    return result.model_copy(update={"feasible": False, "reasons": (*result.reasons, *reasons)})


def _unsatisfied(constraint: Constraint, result: Result) -> list[Reason]:
    figure, value = constraint.figure, figure_of(result, constraint.figure)
    reasons = []
    for limit, sign, word in ((constraint.at_least, 1, "at least"), (constraint.at_most, -1, "at most")):
        if limit is None or (value is None and not result.feasible):
            continue
        if value is None:
            unreached = result.mission is not None and not result.mission.reached
            why = "goals not reached" if unreached else "no such figure"
            name, demand, gap = f"{figure} {word}: {why}", 0.0, abs(limit)
        else:
            name, demand, gap = f"{figure} {word}", value, sign * (limit - value)
            if gap <= 0:
                continue
        reasons.append(
            Reason(kind="constraint", name=name, demand=demand, limit=limit, gap=gap, unit=figure.unit)
        )
    return reasons


def _point(point: StudyPoint, on_front: bool) -> Point:
    return Point(
        index=point.index,
        axes=point.axes,
        state=point.state,
        feasible=point.feasible,
        on_front=on_front,
        unreached=point.unreached,
        figures={figure: _typed(figure, point.figure(figure)) for figure in FIGURES.values()},
        failure=point.failure,
        result=point.result,
    )


def _typed(figure: ResultFigure, value: float | None) -> int | float | None:
    return round(value) if figure.counted == "count" and value is not None else value


def _reasons(point: StudyPoint) -> tuple[Reason, ...]:
    return point.result.reasons if point.result is not None else ()


def _relative_gap(reason: Reason) -> float:
    return reason.gap / abs(reason.limit) if reason.limit else math.inf
