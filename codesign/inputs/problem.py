"""The problem of a workload: its map, its goals and its starts."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, ValidationInfo, WrapValidator, field_validator

from codesign.errors import outside_map, show
from codesign.inputs.fields import Cell
from codesign.inputs.map_spec import GeneratedMap, Map, Seed
from codesign.models import RefusalError, SpecModel, raise_all, refusal_details


class SampledStarts(SpecModel):
    """Starts drawn at random from the free cells with a path to a goal across the sides of cells."""

    count: Annotated[int, Field(ge=1, le=100_000)] = Field(default=64, description="How many starts.")
    seed: Seed = Field(default=0, description="Chooses which cells.")


def _choose_starts(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict):
        return SampledStarts.model_validate(value, context=info.context)
    if isinstance(value, list | tuple | SampledStarts):
        return handler(value)
    raise RefusalError(
        f"{show(value)} names no starts", "write a list of [row, column], or {count: 64, seed: 0}"
    )


Cells = Annotated[tuple[Cell, ...], Field(min_length=1)]
Starts = Annotated[Cells | SampledStarts, WrapValidator(_choose_starts)]


class ProblemSpec(SpecModel):
    """What is to be planned: a map, goals, and starts that judge the plan."""

    map: Map = Field(description="The map: generated, or read from a file.")
    goals: Cells = Field(description="Goals: a list of [row, column], counted from 0 at the top left.")
    starts: Starts = Field(
        default=SampledStarts(),
        description="Starts that judge the plan. {count, seed} draws them from the cells with a path across the sides"
        " of cells to a goal. A list [[row, column], ...] names them; the planner's own moves must lead"
        " each of them to a goal.",
    )

    @field_validator("goals", "starts", mode="after")
    @classmethod
    def _cells_inside(cls, value: Any, info: ValidationInfo) -> Any:
        """Cells of a generated map are checked here; those of a map file once it is read."""
        if isinstance(value, SampledStarts):
            return value
        refusals, seen = [], set()
        declared = info.data.get("map")
        shape = declared.shape if isinstance(declared, GeneratedMap) else None
        for index, cell in enumerate(value):
            if cell in seen:
                refusal = RefusalError(f"{list(cell)} is named twice", "name it once")
                refusals.append(refusal_details(refusal, (index,)))
            elif shape and not (cell[0] < shape[0] and cell[1] < shape[1]):
                refusals.append(refusal_details(RefusalError(*outside_map(cell, shape)), (index,)))
            seen.add(cell)
        raise_all("ProblemSpec", refusals)
        return value
