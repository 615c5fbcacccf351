"""The study as JSON has it: what ``hwsw explore --json`` prints, and its JSON Schema."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from codesign.inputs.exploration import FigureName
from codesign.results.result import Result


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)


class Objective(_Model):
    """A figure that spans the front, its unit, and whether less or more of it is better."""

    figure: FigureName
    unit: str
    direction: Literal["minimise", "maximise"]


class Bounds(_Model):
    """A constraint; a bound that is null does not bind."""

    figure: FigureName
    at_least: float | None
    at_most: float | None


class Counts(_Model):
    """How many points there are; how many are feasible, failed, were not computed, are on the front.

    ``unreached`` counts those among the feasible whose mission ended before its goals.
    """

    points: int
    feasible: int
    unreached: int
    failed: int
    missing: int
    front: int


class Point(_Model):
    """One design point.

    ``result`` is null where ``state`` is not ``done``, and ``failure`` says why where it is ``failed``.
    """

    index: int
    axes: dict[str, Any] = Field(description="value of each axis, as the workload gives it")
    state: Literal["done", "failed", "missing"]
    feasible: bool
    on_front: bool
    unreached: str | None = Field(
        description="why the mission of a feasible point ended before its goals; null where it reached them"
    )
    figures: dict[FigureName, int | float | None] = Field(
        description="each in its unit of ``units``; counts are integers"
    )
    failure: str | None
    result: Result | None


class StudyDocument(_Model):
    """Every point of an exploration with all its figures, and the front among them."""

    schema_version: Literal[2] = 2
    platform: str
    workload: str
    axes: dict[str, list[Any]] = Field(description="the values of each axis, in the order of the workload")
    units: dict[FigureName, str] = Field(
        description="the unit of each figure; 1 for a number of things or a share"
    )
    objectives: list[Objective]
    constraints: list[Bounds]
    counts: Counts
    points: list[Point] = Field(description="in the order of enumeration: points[i].index is i")
    front: list[int] = Field(description="indices of the points on the front")


def study_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw explore --json`` prints."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **StudyDocument.model_json_schema(mode="serialization"),
    }
