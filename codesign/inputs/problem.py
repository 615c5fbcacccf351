"""The problem of a workload: its map, its goals and its starts."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, WrapValidator, field_validator, model_validator

from codesign.ground.errors import outside_map, show
from codesign.ground.models import RefusalError, SpecModel, Task, raise_all, refusal_details
from codesign.inputs.map_spec import GeneratedMap, Map, Seed, Share
from codesign.inputs.places import Place, Point, ScenarioLine, as_list
from codesign.inputs.tasks import Change


class SampledStarts(SpecModel):
    """Starts drawn at random from the free cells with a path to a goal across the sides of cells."""

    count: Annotated[int, Field(ge=1, le=100_000)] = Field(default=64, description="How many starts.")
    seed: Seed = Field(default=0, description="Chooses which cells.")


_PLACES = "a list of [row, column] or {x: METRES, y: METRES}"


def _choose_goals(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict):
        return ScenarioLine.model_validate(value, context=info.context)
    if isinstance(value, list | tuple | ScenarioLine):
        return as_list(value, handler, "Goals")
    raise RefusalError(f"{show(value)} names no goals", f"write {_PLACES}, or {{scen: FILE, line: 2}}")


def _choose_starts(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict):
        model = ScenarioLine if "scen" in value else SampledStarts
        return model.model_validate(value, context=info.context)
    if isinstance(value, list | tuple | SampledStarts | ScenarioLine):
        return as_list(value, handler, "Starts")
    hint = f"write {_PLACES}, {{count: 64, seed: 0}}, or {{scen: FILE, line: 2}}"
    raise RefusalError(f"{show(value)} names no starts", hint)


Places = Annotated[tuple[Place, ...], Field(min_length=1)]
Goals = Annotated[Places | ScenarioLine, WrapValidator(_choose_goals)]
Starts = Annotated[Places | SampledStarts | ScenarioLine, WrapValidator(_choose_starts)]


class ProblemSpec(SpecModel):
    """The problem that is planned: a map, goals, and starts that judge the plan."""

    map: Map = Field(description="The map: generated, or read from a file.")
    goals: Goals = Field(
        description="Goals: a list of [row, column], counted from 0 at the top left, or {x: 12.5 m, y: 3 m} in the"
        " frame of the map; or {scen: FILE, line: 2}, the goal of a problem of a MovingAI .scen file."
    )
    starts: Starts = Field(
        default=SampledStarts(),
        description="Starts that judge the plan. {count, seed} draws them from the cells with a path across the sides"
        " of cells to a goal. A list names them, written as goals are; the planner's own moves must lead each of them"
        " to a goal. With goals from a .scen file, the default is the start of the same problem.",
    )
    task: Task = Field(
        default=Task.PATH,
        description="What is asked and timed. path: a path from each start; field: an answer in every cell that leads"
        " to a goal; replan: a path from each start after a change.",
    )
    change: Change | None = Field(
        default=None,
        description="The change that task replan follows: {blocked, freed}, lists of cells, or {count, seed}, drawn."
        " The other tasks leave it out.",
    )
    arrive: Share = Field(
        default=1.0,
        description="Share of the starts that can arrive which have to arrive. A plan of fewer is not feasible.",
    )
    reach: Share = Field(
        default=0.1,
        description="Share of the free cells from which a path across the sides of cells has to lead to a goal. With"
        " fewer, the goals stand in pockets of the map, and the workload is refused.",
    )

    @model_validator(mode="after")
    def _has_a_change(self) -> Self:
        if self.task is Task.REPLAN and self.change is None:
            hint = "add change: {count: 20, seed: 0}, or name cells: {blocked: [[row, column], ...]}"
            raise RefusalError("task replan follows a change of the map, and none is given", hint, ("task",))
        return self

    @field_validator("goals", "starts", mode="after")
    @classmethod
    def _sound_places(cls, value: Any, info: ValidationInfo) -> Any:
        """Cells of a map that is generated and not downsampled are checked here; all others once the map is made."""
        if isinstance(value, SampledStarts | ScenarioLine):
            return value
        refusals, seen = [], set()
        declared = info.data.get("map")
        shape = declared.shape if isinstance(declared, GeneratedMap) and declared.downsample == 1 else None
        for index, place in enumerate(value):
            if place in seen:
                written = place if isinstance(place, Point) else list(place)
                refusals.append(refusal_details(RefusalError(f"{written} is named twice", "name it once"), (index,)))
            elif shape and isinstance(place, tuple) and not (place[0] < shape[0] and place[1] < shape[1]):
                refusals.append(refusal_details(RefusalError(*outside_map(place, shape)), (index,)))
            seen.add(place)
        raise_all("ProblemSpec", refusals)
        return value

    @model_validator(mode="after")
    def _starts_of_the_goals(self) -> Self:
        if isinstance(self.goals, ScenarioLine) and "starts" not in self.model_fields_set:
            self.__dict__["starts"] = self.goals
        return self
