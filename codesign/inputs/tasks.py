"""Tasks of a workload beside its planner's tasks: those that its scenario brings, and those the user adds."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, WrapValidator, field_validator, model_validator
from pydantic_core import InitErrorDetails

from codesign.ground.errors import choose_hint, clip, show
from codesign.ground.models import RefusalError, SpecModel, TaskParameters, raise_all, refusal_details
from codesign.inputs.fields import Cell, Name
from codesign.inputs.scenario import SCENARIOS, ReplanPolicy

MAX_CHANGED = 10_000

Seed = Annotated[int, Field(ge=0, le=2**64 - 1)]
ChangedCells = Annotated[tuple[Cell, ...], Field(max_length=MAX_CHANGED)]

_POLICY = "What the new plan begins with: restart, lower_bound or continue. Without it, the planner's first policy."


class DeclaredChange(SpecModel):
    """Cells that are named."""

    blocked: ChangedCells = Field(default=(), description="Free cells that become obstacles: [[row, column], ...].")
    freed: ChangedCells = Field(default=(), description="Obstacles that become free, alike.")
    policy: ReplanPolicy | None = Field(default=None, description=_POLICY)

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if not self.blocked and not self.freed:
            raise RefusalError("changes no cell", "name cells under blocked or freed, or draw some: {count: 20}")
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

    count: Annotated[int, Field(ge=1, le=MAX_CHANGED)] = Field(description="How many free cells become obstacles.")
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


MAX_TASKS = 256
MAX_BITS = 10**12


class PlacedTask(TaskParameters):
    """A task with nothing to choose but its place."""


SCENARIO_TASKS: dict[str, tuple[str, ...]] = {name: model.tasks for name, model in SCENARIOS.items()}
"""The tasks of each scenario, by its type, in the order in which data flow through them.

- ``sense``: the robot looks around. ``load``: keeps the map and brings it to the planner.
- ``command``: asked for the plan, and tells the robot where to go. ``move``: the robot goes there.
- ``display``: draws what it is sent.
"""

Bits = Annotated[int, Field(ge=1, le=MAX_BITS)]


class ExtraTask(SpecModel):
    """A task that follows others and returns nothing: logging, drawing, supervision.

    It runs ``units`` of ``kernel`` on its processor each time a task that it follows has ended. Without an entry in the
    mapping it runs where the plan is asked for.
    """

    name: Name = Field(description="Name of the task, which the mapping places.")
    after: Annotated[dict[Name, Bits], Field(min_length=1, max_length=MAX_TASKS)] = Field(
        description="Tasks that it follows, each with the bits that it receives from it."
    )
    kernel: Name = Field(description="Kernel that it runs each time. Its processor gives the cost.")
    units: Annotated[int, Field(ge=0, le=10**12)] = Field(default=1, description="Units of the kernel.")

    @field_validator("after", mode="before")
    @classmethod
    def _with_bits(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return value
        name = value[0] if isinstance(value, list) and value else value
        example = name if isinstance(name, str) and name.isidentifier() else "TASK"
        what = f"{show(value)} is not a mapping"
        raise RefusalError(what, f"write {{{clip(example, 60)}: 128}}: each task, and the bits that it sends")


def task_refusals(
    tasks: Sequence[ExtraTask], taken: Collection[str], placed: Collection[str] | None
) -> list[InitErrorDetails]:
    """The faults of the tasks that a user adds, with locations inside their list.

    Args:
        tasks: the tasks.
        taken: the names of the tasks of planner and scenario.
        placed: the tasks that some variant of the workload has; None where that is not known.
    """
    names: set[str] = set()
    lines: list[InitErrorDetails] = []
    for index, task in enumerate(tasks):
        if task.name in names or task.name in taken:
            what = f"there is a task {task.name!r} already"
            refusal = RefusalError(what, "give each task a name of its own")
            lines.append(refusal_details(refusal, (index, "name")))
        names.add(task.name)
    accepted = {*names, *(placed or ())}
    for index, task in enumerate(tasks):
        for name in task.after:
            if placed is not None and name not in accepted:
                hint = choose_hint(clip(name, 60), accepted - {task.name})
                refusal = RefusalError(f"there is no task {clip(name)!r}", hint, of_key=True)
                lines.append(refusal_details(refusal, (index, "after", name)))
    if len(names) == len(tasks):
        for index, name, circle in _circles(tasks):
            what = f"tasks wait for each other in a circle: {' -> '.join(circle)}"
            hint = "break it where one of them can go on without the other"
            refusal = RefusalError(what, hint, of_key=True)
            lines.append(refusal_details(refusal, (index, "after", name)))
    return lines


def _circles(tasks: Sequence[ExtraTask]) -> Iterator[tuple[int, str, list[str]]]:
    """Of each circle: the task and the name in its ``after`` that close it, and the names in the order of flow."""
    places = {task.name: index for index, task in enumerate(tasks)}
    open_, done = set[str](), set[str]()
    for task in tasks:
        way, ahead = [task.name], [iter(task.after)]
        while way and way[0] not in done:
            open_.add(way[-1])
            name = next((name for name in ahead[-1] if name in places and name not in done), None)
            if name is None:
                open_.discard(way[-1])
                done.add(way.pop())
                ahead.pop()
            elif name in open_:
                yield places[way[-1]], name, [name, *reversed(way[way.index(name) + 1 :]), name]
            else:
                way.append(name)
                ahead.append(iter(tasks[places[name]].after))
