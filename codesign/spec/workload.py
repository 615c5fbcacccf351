"""A workload: planner, problem, scenario, mapping, and what to explore, as declared in YAML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    Field,
    PrivateAttr,
    SerializeAsAny,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic_core import InitErrorDetails

from codesign.errors import choose_hint
from codesign.spec.base import Spec
from codesign.spec.exploration import Exploration
from codesign.spec.fields import Name
from codesign.spec.locate import find_spec, shipped_names
from codesign.spec.marks import Document, read_document
from codesign.spec.model import (
    RefusalError,
    SpecModel,
    details_of,
    raise_all,
    refusal_details,
)
from codesign.spec.problem import FileMap, ProblemSpec
from codesign.spec.scalars import clip, show
from codesign.spec.scenario import PlanOnce, Scenario
from codesign.spec.tasks import MAX_TASKS, SCENARIO_TASKS, ExtraTask, PlacedTask
from codesign.spec.validate import validate

ProblemModels = Mapping[str, type[SpecModel]]
"""Planner name → model of its problem, for planners whose problem is not a map with goals and starts."""

TaskModels = Mapping[str, Mapping[str, type[BaseModel]]]
"""Planner name → task name → model of the task's parameters.

A ``SpecModel`` refuses what a plain pydantic model lets pass (``true`` for 1), and names accepted keys.
"""


class RawParameters(BaseModel):
    """Parameters of a task that nobody has a model for: kept as they are."""

    model_config = {"frozen": True, "extra": "allow"}


class TaskMapping(SpecModel):
    """Where a task runs, in which style, with which parameters."""

    component: Name = Field(description="The component that runs the task.")
    style: Name | None = Field(
        default=None, description="The architecture style; by default the component's own."
    )
    memory: Name | None = Field(
        default=None, description="The external memory that holds what does not fit in block RAM."
    )
    parameters: SerializeAsAny[BaseModel] = Field(description="Parameters of planner and style.")


PLACE_KEYS = ("component", "style", "memory")
"""The keys of a task's mapping that say where it runs and how; the others are its parameters."""


def map_task(raw: Any, model: type[BaseModel], document: Document | None = None) -> TaskMapping:
    """The mapping of one task from its raw form: component, style, and parameters beside them.

    Raises:
        ValidationError: with locations inside ``raw``.
    """
    if not isinstance(raw, dict):
        refusal = RefusalError(
            f"{show(raw)} is not a mapping", "write {component: NAME} and the task's parameters"
        )
        raise_all("TaskMapping", [refusal_details(refusal)])
    own = {key: raw[key] for key in PLACE_KEYS if key in raw}
    rest = {key: value for key, value in raw.items() if key not in own}
    lines: list[InitErrorDetails] = []
    parameters: Any = RawParameters()
    try:
        parameters = model.model_validate(rest, context={"document": document})
    except ValidationError as error:
        lines += details_of(error, accepted=(*PLACE_KEYS, *model.model_fields))
    try:
        made = TaskMapping.model_validate({**own, "parameters": parameters})
    except ValidationError as error:
        lines += details_of(error)
    raise_all("TaskMapping", lines)
    return made


class Workload(Spec):
    """Planner, problem, scenario, mapping and exploration."""

    kind: Literal["workload"] = Field(description="This file is a workload.")
    name: Name = Field(description="Name of the workload.")
    description: str = Field(default="", description="What it is, for humans.")
    planner: Name = Field(description="The planner, such as harmonic.")
    problem: SerializeAsAny[ProblemSpec | SpecModel] = Field(description="What is to be planned.")
    scenario: Scenario = Field(default=PlanOnce(), description="How the plan is used.")
    tasks: Annotated[tuple[ExtraTask, ...], Field(max_length=MAX_TASKS)] = Field(
        default=(), description="Tasks beside those of planner and scenario, which nothing waits for."
    )
    mapping: dict[Name, TaskMapping] = Field(description="Where each task of the planner runs, and how.")
    explore: Exploration | None = Field(
        default=None, description="What hwsw explore tries, and what is good."
    )

    _models: Mapping[str, type[BaseModel]] | None = PrivateAttr(default=None)

    @property
    def map_file(self) -> Path | None:
        """The file of the map, or None where the map is generated."""
        wanted = self.problem.map if isinstance(self.problem, ProblemSpec) else None
        return wanted.path if isinstance(wanted, FileMap) else None

    @property
    def task_models(self) -> Mapping[str, type[BaseModel]] | None:
        """The parameter model of each task, or None where the workload was loaded without any."""
        return self._models

    @field_validator("planner", mode="after")
    @classmethod
    def _known(cls, value: str, info: ValidationInfo) -> str:
        tasks = (info.context or {}).get("tasks")
        if tasks is not None and value not in tasks:
            raise RefusalError(f"there is no planner {value!r}", choose_hint(value, tasks))
        return value

    @field_validator("problem", mode="wrap")
    @classmethod
    def _of_the_planner(cls, value: Any, handler: Any, info: ValidationInfo) -> Any:  # noqa: ARG003
        if isinstance(value, SpecModel):
            return value
        problems = (info.context or {}).get("problems") or {}
        model = problems.get(info.data.get("planner"), ProblemSpec)
        return model.model_validate(value, context=info.context)

    @field_validator("tasks", mode="after")
    @classmethod
    def _named_once(cls, value: tuple[ExtraTask, ...], info: ValidationInfo) -> tuple[ExtraTask, ...]:
        scenario = info.data.get("scenario", PlanOnce())
        taken = {*SCENARIO_TASKS[scenario.type]}
        taken |= set(((info.context or {}).get("tasks") or {}).get(info.data.get("planner"), ()))
        for index, task in enumerate(value):
            if task.name in taken:
                what = f"there is a task {task.name!r} already"
                raise RefusalError(what, "give each task a name of its own", (index, "name"))
            taken.add(task.name)
        return value

    @field_validator("mapping", mode="wrap")
    @classmethod
    def _map_tasks(cls, value: Any, handler: Any, info: ValidationInfo) -> Any:
        context = info.context or {}
        if "document" not in context:
            return handler(value)
        if not isinstance(value, dict) or not value:
            raise RefusalError("maps no task", "write TASK: {component: NAME, ...}")
        models = (context.get("tasks") or {}).get(info.data.get("planner"))
        if models is not None:
            models = {**_other_tasks(info.data), **models}
        lines: list[InitErrorDetails] = []
        made: dict[str, TaskMapping] = {}
        for task, raw in value.items():
            if models is not None and task not in models:
                what = f"{info.data['planner']} has no task {clip(task)!r}"
                refusal = RefusalError(what, choose_hint(clip(task, 60), models), of_key=True)
                lines.append(refusal_details(refusal, (task,)))
                continue
            try:
                made[task] = map_task(raw, (models or {}).get(task, RawParameters), context["document"])
            except ValidationError as error:
                lines += details_of(error, (task,))
        raise_all("Workload", lines)
        return made

    def with_models(self, models: Mapping[str, type[BaseModel]] | None) -> Self:
        """The workload, with the models that substituted parameters are checked against."""
        self._models = models
        return self


def _other_tasks(fields: Mapping[str, Any]) -> dict[str, type[BaseModel]]:
    """The tasks that the scenario brings and that the user adds."""
    scenario, extra = fields.get("scenario", PlanOnce()), fields.get("tasks", ())
    return dict.fromkeys((*SCENARIO_TASKS[scenario.type], *(task.name for task in extra)), PlacedTask)


def load_workload(
    source: str | Path, tasks: TaskModels | None = None, problems: ProblemModels | None = None
) -> Workload:
    """The workload with a shipped name (``labyrinth``), or in a file (with a separator or ``.yaml``).

    Args:
        source: name or path.
        tasks: the models that parameters are checked against. Without, they are taken as they stand.
        problems: the models of problems other than a map with goals and starts.

    Raises:
        InputError: no shipped workload of that name.
        SpecError: all the faults of the file.
    """
    from codesign.spec.design_point import axis_faults

    path, shown = find_spec(source, "workloads")
    document = read_document(path, shown)
    workload = validate(
        Workload, document, {"tasks": tasks, "problems": problems}, axis_faults
    ).with_document(document)
    return workload.with_models(tasks[workload.planner] if tasks is not None else None)


def list_workloads() -> list[str]:
    """Names of the shipped workloads."""
    return shipped_names("workloads")
