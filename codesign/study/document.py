"""The study as JSON has it: what ``hwsw explore --json`` prints, and its JSON Schema."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.aggregate import Share, rule_as_written
from codesign.inputs.constraint import FigureName
from codesign.study.designs import Design, StudyPoint, designs_of, points_of
from codesign.study.table import Table
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Provenance, Reason, Result


class DerivedEntry(ResultModel):
    """A figure that the exploration derives from declared ones."""

    expression: str = Field(description="the expression, as it was written")
    unit: str = Field(description="its unit; 1 for a number of things or a share")
    direction: Literal["minimise", "maximise"] = Field(description="whether less or more of it is better")
    label: str = Field(description="what tables and plots call it")


class Objective(ResultModel):
    """A figure that spans the front, its unit, and whether less or more of it is better."""

    figure: FigureName = Field(description="the figure")
    unit: str = Field(description="its unit; 1 for a number of things or a share")
    direction: Literal["minimise", "maximise"] = Field(description="whether less or more of it is better")


class ConstraintBounds(ResultModel):
    """A constraint; a bound that is null does not bind."""

    figure: FigureName = Field(description="the figure that is bounded")
    at_least: float | None = Field(description="its lower bound, in its unit")
    at_most: float | None = Field(description="its upper bound, in its unit")
    above: float | None = Field(description="its lower bound, which itself is out")
    below: float | None = Field(description="its upper bound, which itself is out")
    of_part: bool = Field(description="whether the bounds are shares of what the part has")


class Counts(ResultModel):
    """The number of designs; of those that are feasible, failed, were not computed, are on the front.

    Designs that are the same as an earlier one count as one. ``unreached`` counts the feasible designs with a mission
    that ended before its goals.
    """

    points: int = Field(description="all points: each design in each condition")
    designs: int = Field(description="all designs: combinations of the decisions")
    distinct: int = Field(description="designs without those that are the same as an earlier one")
    feasible: int = Field(description="those of the distinct that fit and satisfy every constraint")
    unreached: int = Field(description="those of the feasible with a mission that ended before its goals")
    failed: int = Field(description="those with a point that could not be simulated")
    missing: int = Field(description="those with a point that was not computed")
    front: int = Field(description="those on the front")


class Point(ResultModel):
    """One design in one condition.

    ``result`` is null where ``state`` is not ``done``, and ``failure`` says why where it is ``failed``.
    """

    index: int = Field(description="its number in the enumeration, from 0; conditions move fastest")
    design: int = Field(description="the index of its design")
    axes: dict[str, Any] = Field(description="value of each decision and condition, as the workload gives it")
    state: Literal["done", "failed", "missing"] = Field(description="what became of it")
    feasible: bool = Field(description="whether it fits and, in a study without conditions, satisfies every constraint")
    on_front: bool = Field(description="whether its design is on the front, or the same as one that is")
    unreached: str | None = Field(
        description="why the mission of a feasible point ended before its goals; null where it reached them"
    )
    figures: dict[FigureName, int | float | None] = Field(
        description="each in its unit of ``units``; counts are integers"
    )
    failure: str | None = Field(description="why it failed")
    result: Result | None = Field(description="all of its figures")


class FigureSpread(ResultModel):
    """The values of one figure of a design in all conditions that have one, in the unit of the figure."""

    least: float = Field(description="the least")
    greatest: float = Field(description="the greatest")
    deviation: float = Field(description="standard deviation of the sample; 0 of one value")
    interval: tuple[float, float] | None = Field(
        description="95 % interval of confidence of the aggregated figure; null where no seeds were drawn, or too few,"
        " and for the worst and the best"
    )


class DesignReason(ResultModel):
    """The reason for which a design is out."""

    condition: int | None = Field(
        description="the number of the combination of conditions, from 0, the last one moving fastest; null: of all"
    )
    reason: Reason = Field(description="what passes its limit")


class DesignEntry(ResultModel):
    """One combination of the decisions, over all conditions."""

    index: int = Field(description="its number in the enumeration, from 0")
    axes: dict[str, Any] = Field(description="value of each decision, as the workload gives it")
    state: Literal["done", "failed", "missing"] = Field(description="what became of its points")
    feasible: bool = Field(description="whether it fits and satisfies every constraint")
    on_front: bool = Field(description="whether it is on the front, or the same as one that is")
    same_as: int | None = Field(
        description="the first design that differs from it only in axes that change nothing for the two"
    )
    figures: dict[FigureName, float | None] = Field(
        description="the aggregated value of each objective and each constrained figure; by share the share of the"
        " conditions that meet the limit"
    )
    spread: dict[FigureName, FigureSpread] = Field(
        description="of the same figures, over the conditions; empty in a study without conditions"
    )
    out: list[DesignReason] = Field(description="why it is not feasible")
    not_told_apart: list[int] = Field(
        description="of a design on the front: the designs that no objective tells apart from it over the conditions"
    )


class StudyDocument(ResultModel):
    """Every design and every point of an exploration with all figures, and the front."""

    schema_version: Literal[3] = Field(default=3, description="version of this form")
    platform: str = Field(description="name of the platform")
    workload: str = Field(description="name of the workload")
    provenance: Provenance | None = Field(description="version, digests, seeds, and the date of this document")
    axes: dict[str, list[Any]] = Field(description="the values of each decision, in the order of the workload")
    when: dict[str, dict[str, list[Any]]] = Field(
        default={}, description="for which values of other decisions a decision exists; of those that may not"
    )
    conditions: dict[str, list[Any]] = Field(description="the values of each condition, alike")
    figures: dict[str, DerivedEntry] = Field(
        default={}, description="the figures that the exploration derives, by name"
    )
    aggregate: dict[str, Any] = Field(
        description="the rule of each figure that has one, and the default, as the workload has them"
    )
    units: dict[FigureName, str] = Field(description="the unit of each figure; 1 for a number of things or a share")
    objectives: list[Objective] = Field(description="figures that span the front")
    constraints: list[ConstraintBounds] = Field(description="bounds that a feasible design satisfies")
    counts: Counts = Field(description="how many designs there are of each kind")
    designs: list[DesignEntry] = Field(description="in the order of enumeration: designs[i].index is i")
    points: list[Point] = Field(description="in the order of enumeration: points[i].index is i")
    front: list[int] = Field(description="indices of the designs on the front; of designs that are the same, the first")


def study_document(table: Table) -> StudyDocument:
    """The document of a study. It has all full results: priced points are simulated for it."""
    first_of, count = table.first_of_same, table.judged.conditions
    return StudyDocument(
        platform=table.platform,
        workload=table.workload,
        provenance=None if table.provenance is None else table.provenance.stamped(),
        axes={name: list(values) for name, values in table.axes.items()},
        when={
            axis: {other: list(values) for other, values in conditions.items()}
            for axis, conditions in table.when.items()
        },
        conditions={name: list(values) for name, values in table.conditions.items()},
        figures={name: DerivedEntry.model_validate(figure.as_written) for name, figure in table.figures.items()},
        aggregate={name: rule_as_written(rule) for name, rule in table.aggregate.items()},
        units={figure: figure.unit for figure in _every(table)},
        objectives=[_objective(table, figure) for figure in table.objectives],
        constraints=[ConstraintBounds.model_validate(limit.model_dump()) for limit in table.constraints],
        counts=Counts(
            points=len(table.outcomes),
            designs=table.judged.count,
            distinct=len(table.distinct),
            feasible=len(table.feasible),
            unreached=len(table.unreached),
            failed=len(table.failed),
            missing=len(table.missing),
            front=len(table.front),
        ),
        designs=[
            _design(table, design, None if first == design.index else first)
            for design, first in zip(designs_of(table), first_of.tolist(), strict=True)
        ],
        points=[_point(table, point, point.index // count) for point in points_of(table)],
        front=list(table.front),
    )


def _every(table: Table) -> tuple[ResultFigure, ...]:
    """The declared figures, and those that the study derives."""
    return *FIGURES.values(), *table.figures.values()


def _objective(table: Table, figure: ResultFigure) -> Objective:
    maximise = table.world.maximise(figure)
    unit = "1" if isinstance(table.world.rule(figure), Share) else figure.unit
    return Objective(figure=figure, unit=unit, direction="maximise" if maximise else "minimise")


def _design(table: Table, design: Design, same_as: int | None) -> DesignEntry:
    figures = tuple(dict.fromkeys((*table.objectives, *(limit.figure for limit in table.constraints))))
    spreads = {figure: design.spread(figure) for figure in figures} if table.conditions else {}
    return DesignEntry(
        index=design.index,
        axes=design.axes,
        state=design.state,
        feasible=design.feasible,
        on_front=bool(table.on_front[design.index]),
        same_as=same_as,
        figures={figure: design.figure(figure) for figure in figures},
        spread={
            figure: FigureSpread(
                least=each.least, greatest=each.greatest, deviation=each.deviation, interval=each.interval
            )
            for figure, each in spreads.items()
            if each is not None
        },
        out=[DesignReason(condition=out.condition, reason=out.reason) for out in design.out],
        not_told_apart=list(table.alike.get(design.index, ())),
    )


def _point(table: Table, point: StudyPoint, design: int) -> Point:
    return Point(
        index=point.index,
        design=design,
        axes=point.axes,
        state=point.state,
        feasible=point.feasible,
        on_front=bool(table.on_front[design]),
        unreached=point.unreached,
        figures={figure: _typed(figure, point.figure(figure)) for figure in _every(table)},
        failure=point.failure,
        result=point.result,
    )


def _typed(figure: ResultFigure, value: float | None) -> int | float | None:
    return round(value) if figure.counted == "count" and value is not None else value


def study_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw explore --json`` prints."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **StudyDocument.model_json_schema(mode="serialization"),
    }
