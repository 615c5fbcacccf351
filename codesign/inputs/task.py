"""The change of a map that a task ``replan`` follows."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, WrapValidator, model_validator

from codesign.errors import show
from codesign.inputs.fields import Cell
from codesign.inputs.scenario import ReplanPolicy
from codesign.models import RefusalError, SpecModel, raise_all, refusal_details

MAX_CHANGED = 10_000

Seed = Annotated[int, Field(ge=0, le=2**64 - 1)]
ChangedCells = Annotated[tuple[Cell, ...], Field(max_length=MAX_CHANGED)]

_POLICY = (
    "What the new plan begins with: restart, lower_bound or continue. Without it, the planner's first policy."
)


class DeclaredChange(SpecModel):
    """Cells that are named."""

    blocked: ChangedCells = Field(
        default=(), description="Free cells that become obstacles: [[row, column], ...]."
    )
    freed: ChangedCells = Field(default=(), description="Obstacles that become free, alike.")
    policy: ReplanPolicy | None = Field(default=None, description=_POLICY)

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if not self.blocked and not self.freed:
            raise RefusalError(
                "changes no cell", "name cells under blocked or freed, or draw some: {count: 20}"
            )
        refusals, seen = [], set()
        for name in ("blocked", "freed"):
            for index, cell in enumerate(vars(self)[name]):
                if cell in seen:
                    refusal = RefusalError(f"{list(cell)} is named twice", "name it once")
                    refusals.append(refusal_details(refusal, (name, index)))
                seen.add(cell)
        raise_all("DeclaredChange", refusals)
        return self


class DrawnChange(SpecModel):
    """Free cells drawn at random that become obstacles. Every start that could arrive still can."""

    count: Annotated[int, Field(ge=1, le=MAX_CHANGED)] = Field(
        description="How many free cells become obstacles."
    )
    seed: Seed = Field(default=0, description="Chooses which cells.")
    policy: ReplanPolicy | None = Field(default=None, description=_POLICY)


def _choose_change(value: Any, _handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, DeclaredChange | DrawnChange):
        return value
    if not isinstance(value, dict):
        hint = "write {blocked: [[row, column], ...], freed: [...]}, or {count: 20, seed: 0}"
        raise RefusalError(f"{show(value)} names no change", hint)
    model = DrawnChange if "count" in value or "seed" in value else DeclaredChange
    return model.model_validate(value, context=info.context)


Change = Annotated[DeclaredChange | DrawnChange, WrapValidator(_choose_change)]
