"""The study as JSON has it: what ``hwsw explore --json`` prints, and its JSON Schema."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from codesign.inputs.exploration import FigureName
from codesign.results.model import ResultModel
from codesign.results.result import Result


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


class Counts(ResultModel):
    """How many points there are; how many are feasible, failed, were not computed, are on the front.

    ``unreached`` counts the feasible points with a mission that ended before its goals.
    """

    points: int = Field(description="all points")
    feasible: int = Field(description="those that fit and satisfy every constraint")
    unreached: int = Field(description="those of the feasible with a mission that ended before its goals")
    failed: int = Field(description="those that could not be simulated")
    missing: int = Field(description="those that were not computed")
    front: int = Field(description="those on the front")


class Point(ResultModel):
    """One design point.

    ``result`` is null where ``state`` is not ``done``, and ``failure`` says why where it is ``failed``.
    """

    index: int = Field(description="its number in the enumeration, from 0")
    axes: dict[str, Any] = Field(description="value of each axis, as the workload gives it")
    state: Literal["done", "failed", "missing"] = Field(description="what became of it")
    feasible: bool = Field(description="whether it fits and satisfies every constraint")
    on_front: bool = Field(description="whether it is on the front")
    unreached: str | None = Field(
        description="why the mission of a feasible point ended before its goals; null where it reached them"
    )
    figures: dict[FigureName, int | float | None] = Field(
        description="each in its unit of ``units``; counts are integers"
    )
    failure: str | None = Field(description="why it failed")
    result: Result | None = Field(description="all of its figures")


class StudyDocument(ResultModel):
    """Every point of an exploration with all its figures, and the front among them."""

    schema_version: Literal[2] = Field(default=2, description="version of this form")
    platform: str = Field(description="name of the platform")
    workload: str = Field(description="name of the workload")
    axes: dict[str, list[Any]] = Field(description="the values of each axis, in the order of the workload")
    units: dict[FigureName, str] = Field(
        description="the unit of each figure; 1 for a number of things or a share"
    )
    objectives: list[Objective] = Field(description="figures that span the front")
    constraints: list[ConstraintBounds] = Field(description="bounds that a feasible point satisfies")
    counts: Counts = Field(description="how many points there are of each kind")
    points: list[Point] = Field(description="in the order of enumeration: points[i].index is i")
    front: list[int] = Field(description="indices of the points on the front")


def study_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw explore --json`` prints."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **StudyDocument.model_json_schema(mode="serialization"),
    }
