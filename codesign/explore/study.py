"""What an exploration comes to: every point with its figures or its reasons, and the front among them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from codesign.explore.front import non_dominated
from codesign.spec.exploration import Constraint, ResultFigure
from codesign.system.result import Reason, Result

SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Outcome:
    """One point: its place in the enumeration, its axis values, and what came of it.

    ``result`` is None where the computation failed (``failure`` says why) or was not yet done (``failure``
    is None too, in a study read from the file of an interrupted exploration).
    """

    index: int
    axes: dict[str, Any]
    result: Result | None = None
    failure: str | None = None

    @property
    def state(self) -> str:
        """``done``, ``failed`` or ``missing``."""
        if self.result is not None:
            return "done"
        return "missing" if self.failure is None else "failed"

    @property
    def feasible(self) -> bool:
        """Whether it fits and satisfies every constraint."""
        return self.result is not None and self.result.feasible

    def figure(self, name: ResultFigure) -> float | None:
        """One figure, or None where it has none."""
        return None if self.result is None else self.result.figure(name)


@dataclass(frozen=True)
class ReasonCount:
    """How often one reason kept points out: ``points`` of them, the nearest by ``least_gap`` (in ``unit``).

    A failure counts under kind ``failure``, with its message's first line as name.
    """

    kind: str
    name: str
    unit: str
    points: int
    least_gap: float


@dataclass(frozen=True)
class Study:
    """Every point of an exploration. ``points[i].index`` is ``i``."""

    platform: str
    workload: str
    axes: Mapping[str, tuple[Any, ...]]
    objectives: tuple[ResultFigure, ...]
    constraints: tuple[Constraint, ...]
    points: tuple[Outcome, ...]

    @cached_property
    def feasible(self) -> tuple[int, ...]:
        """Indices of the points that fit and satisfy every constraint."""
        return tuple(point.index for point in self.points if point.feasible)

    @cached_property
    def failed(self) -> tuple[int, ...]:
        """Indices of the points whose computation failed."""
        return tuple(point.index for point in self.points if point.state == "failed")

    @cached_property
    def missing(self) -> tuple[int, ...]:
        """Indices of the points that were not computed."""
        return tuple(point.index for point in self.points if point.state == "missing")

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the feasible points that no other feasible point dominates.

        A feasible point without one of the objectives (no start arrives, so no path length) is not on the
        front.
        """
        candidates = self.feasible
        if not candidates or not self.objectives:
            return ()
        figures = [[self.points[index].figure(name) for name in self.objectives] for index in candidates]
        values = [[math.nan if value is None else value for value in row] for row in figures]
        chosen = non_dominated(values, [name.maximise for name in self.objectives])
        return tuple(index for index, on_front in zip(candidates, chosen, strict=True) if on_front)

    @cached_property
    def reasons(self) -> tuple[ReasonCount, ...]:
        """What kept points out, the most frequent first."""
        gaps: dict[tuple[str, str, str], list[float]] = {}
        for point in self.points:
            for reason in point.result.reasons if point.result is not None else ():
                gaps.setdefault((reason.kind, reason.name, reason.unit), []).append(reason.gap)
            if point.failure is not None:
                gaps.setdefault(("failure", point.failure.partition("\n")[0], ""), []).append(0.0)
        counts = [ReasonCount(*name, points=len(found), least_gap=min(found)) for name, found in gaps.items()]
        return tuple(sorted(counts, key=lambda count: (-count.points, count.kind, count.name)))

    def nearest(self, count: int = 3) -> tuple[int, ...]:
        """Indices of the infeasible points that pass their limits by least: by the largest relative gap of each."""
        short = [point for point in self.points if point.result is not None and not point.feasible]
        short.sort(
            key=lambda point: (max(map(_relative_gap, _reasons(point)), default=math.inf), point.index)
        )
        return tuple(point.index for point in short[:count])

    def to_dict(self) -> dict[str, Any]:
        """The study as JSON has it: the same at any worker count, and whether computed now or found in a store."""
        front = set(self.front)
        return {
            "schema_version": SCHEMA_VERSION,
            "platform": self.platform,
            "workload": self.workload,
            "axes": {name: list(values) for name, values in self.axes.items()},
            "objectives": [
                {
                    "figure": name.value,
                    "unit": name.unit,
                    "direction": "maximise" if name.maximise else "minimise",
                }
                for name in self.objectives
            ],
            "constraints": [limit.model_dump(mode="json", exclude_none=True) for limit in self.constraints],
            "counts": {
                "points": len(self.points),
                "feasible": len(self.feasible),
                "failed": len(self.failed),
                "missing": len(self.missing),
                "front": len(front),
            },
            "points": [
                {
                    "index": point.index,
                    "axes": point.axes,
                    "state": point.state,
                    "feasible": point.feasible,
                    "on_front": point.index in front,
                    "figures": {name.value: point.figure(name) for name in ResultFigure},
                    "failure": point.failure,
                    "result": None if point.result is None else point.result.model_dump(mode="json"),
                }
                for point in self.points
            ],
            "front": list(self.front),
        }

    def to_json(self) -> str:
        """``to_dict`` as text, one line."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)


def judged(result: Result, constraints: tuple[Constraint, ...]) -> Result:
    """The result with a reason for every constraint that it does not satisfy.

    A figure that a feasible point does not have (no start arrives, so no path length) satisfies no
    constraint; one that a point lacks because it does not fit, and was never run, is not held against it.
    """
    reasons = [
        reason
        for limit in constraints
        for reason in _unsatisfied(limit, result.figure(limit.figure), result.feasible)
    ]
    if not reasons:
        return result
    return result.model_copy(update={"feasible": False, "reasons": (*result.reasons, *reasons)})


def _unsatisfied(constraint: Constraint, value: float | None, was_run: bool) -> list[Reason]:
    figure = constraint.figure
    reasons = []
    for limit, sign, word in ((constraint.at_least, 1, "at least"), (constraint.at_most, -1, "at most")):
        if limit is None or (value is None and not was_run):
            continue
        if value is None:
            name, demand, gap = f"{figure.value} {word}: no such figure", 0.0, abs(limit)
        else:
            name, demand, gap = f"{figure.value} {word}", value, sign * (limit - value)
            if gap <= 0:
                continue
        reasons.append(
            Reason(kind="constraint", name=name, demand=demand, limit=limit, gap=gap, unit=figure.unit)
        )
    return reasons


def _reasons(point: Outcome) -> tuple[Reason, ...]:
    return point.result.reasons if point.result is not None else ()


def _relative_gap(reason: Reason) -> float:
    return reason.gap / abs(reason.limit) if reason.limit else math.inf
