"""A workload: planner, problem, scenario, mapping, variants, and what to explore, as declared in YAML."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, SerializeAsAny, ValidationError, ValidationInfo, field_validator
from pydantic_core import InitErrorDetails

from codesign.ground.errors import InputError, choose_hint, clip, show
from codesign.ground.models import RefusalError, SpecModel, TaskParameters, details_of, raise_all, refusal_details
from codesign.inputs.base import Spec
from codesign.inputs.derived import DerivedFigure
from codesign.inputs.document import Document
from codesign.inputs.exploration import Exploration
from codesign.inputs.faults import context_of
from codesign.inputs.fields import Name
from codesign.inputs.map_spec import FileMap
from codesign.inputs.places import ScenarioLine
from codesign.inputs.problem import ProblemSpec
from codesign.inputs.scenario import PlanOnce, Scenario
from codesign.inputs.tasks import MAX_TASKS, SCENARIO_TASKS, ExtraTask, PlacedTask, task_refusals

BASE = "base"
"""The name under which the workload itself stands beside its variants."""

MAX_VARIANTS = 64

ProblemModels = Mapping[str, type[SpecModel]]
"""Planner name → model of its problem, where that is not a map with goals and starts."""

TaskModels = Mapping[str, Mapping[str, type[TaskParameters]]]
"""Planner name → task name → model of the task's parameters.

A ``SpecModel`` refuses what a plain pydantic model lets pass (``true`` for 1), and names accepted keys.
"""


class RawParameters(TaskParameters):
    """Parameters of a task without a model: they are kept as they are."""

    model_config = ConfigDict(frozen=True, extra="allow")


class TaskMapping(SpecModel):
    """The place of a task, its style, and its parameters."""

    component: Name = Field(description="The component that runs the task.")
    style: Name | None = Field(
        default=None, description="Architecture style. Without it, the component's own is taken. hwsw list shows all."
    )
    external_memory: Name | None = Field(
        default=None, description="Of the planning task: the external memory that holds what does not fit in block RAM."
    )
    parameters: SerializeAsAny[TaskParameters] = Field(description="Parameters of planner and style.")


PLACE_KEYS = ("component", "style", "external_memory")
"""The keys of a task's mapping that say where it runs and how; the others are its parameters."""


def map_task(raw: Any, model: type[TaskParameters], document: Document | None = None) -> TaskMapping:
    """The mapping of one task from its raw form: component, style, and parameters beside them.

    One that was validated before is taken as it is.

    Raises:
        ValidationError: with locations inside ``raw``.
    """
    if isinstance(raw, TaskMapping):
        return raw
    if not isinstance(raw, dict):
        refusal = RefusalError(f"{show(raw)} is not a mapping", "write {component: NAME} and the task's parameters")
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
        mapping = TaskMapping.model_validate({**own, "parameters": parameters})
    except ValidationError as error:
        lines += details_of(error)
    raise_all("TaskMapping", lines)
    return mapping


class Variant(SpecModel):
    """Another way to do the same: what it gives stands in the place of the workload's own.

    Planner, mapping and scenario are raw: the workload with the variant put in is what is validated.
    """

    description: str = Field(default="", description="What it is, for readers.")
    planner: Name | None = Field(default=None, description="Its planner. Without it, that of the workload.")
    mapping: dict[str, Any] | None = Field(
        default=None, description="Where its tasks run. It replaces the whole mapping of the workload."
    )
    scenario: dict[str, Any] | None = Field(
        default=None, description="Keys of the scenario that differ. The others stay as in the workload."
    )


class Workload(Spec):
    """The job: planner, problem, scenario, mapping, variants and exploration."""

    # As long as planner and scenario stay.
    alone: ClassVar[tuple[str, ...]] = ("problem",)
    entries: ClassVar[Mapping[str, bool]] = {"mapping": True}

    kind: Literal["workload"] = Field(description="This file is a workload.")
    name: Name = Field(description="Name of the workload, which results show.")
    description: str = Field(default="", description="What it is, for readers.")
    planner: Name = Field(
        description="Name of the planner, such as harmonic. hwsw list shows those that are installed."
    )
    problem: SerializeAsAny[ProblemSpec | SpecModel] = Field(
        description="What is to be planned: a map with goals, or robots."
    )
    scenario: Scenario = Field(default=PlanOnce(), description="What the plan is used for.")
    tasks: Annotated[tuple[ExtraTask, ...], Field(max_length=MAX_TASKS)] = Field(
        default=(), description="Further tasks, which nothing waits for."
    )
    mapping: dict[Name, TaskMapping] = Field(
        description="Where each task runs, and how. The task that plans is required; others have a default place."
    )
    variants: Annotated[dict[Name, Variant], Field(max_length=MAX_VARIANTS)] = Field(
        default={},
        description="Other planners, mappings or settings for the same problem. Axis workload.variant tries them.",
    )
    explore: Exploration | None = Field(default=None, description="What hwsw explore tries, and which figures decide.")

    @property
    def map_file(self) -> Path | None:
        """The file of the map, or None where the map is generated."""
        wanted = self.problem.map if isinstance(self.problem, ProblemSpec) else None
        return wanted.path if isinstance(wanted, FileMap) else None

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that the problem names: its map, and the files of its goals and starts."""
        if not isinstance(self.problem, ProblemSpec):
            return ()
        lines = (self.problem.goals, self.problem.starts)
        named = [self.map_file, *(line.path for line in lines if isinstance(line, ScenarioLine))]
        return tuple(dict.fromkeys(path for path in named if path is not None))

    @property
    def task_models(self) -> Mapping[str, type[TaskParameters]] | None:
        """The parameter model of each task, or None where the workload was loaded without any."""
        models = (self.document.context.get("tasks") or {}).get(self.planner)
        if models is None:
            return None
        return {**_other_tasks(self.scenario, (task.name for task in self.tasks)), **models}

    def validated_alone(self, section: str, name: str, raw: Any, document: Document) -> SpecModel:
        """See ``Spec.validated_alone``: a problem, or the mapping of a task."""
        if section == "problem":
            return problem_model(self.planner, document.context).model_validate(raw, context=context_of(document))
        models = self.task_models
        return map_task(raw, RawParameters if models is None else models[name], document)

    def _identity(self) -> dict[str, Any]:
        # A variant that is not chosen changes no result; one that is has no variants left.
        return {key: value for key, value in super()._identity().items() if key != "variants"}

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
        model = problem_model(info.data.get("planner"), info.context or {})
        return model.model_validate(value, context=info.context)

    @field_validator("tasks", mode="after")
    @classmethod
    def _sound_tasks(cls, value: tuple[ExtraTask, ...], info: ValidationInfo) -> tuple[ExtraTask, ...]:
        context, fields = info.context or {}, info.data
        models = context.get("tasks") or {}
        planner, scenario = fields.get("planner"), fields.get("scenario")
        taken = {*models.get(planner, ()), *(SCENARIO_TASKS[scenario.type] if scenario else ())}
        placed = None
        if "document" in context and planner in models and scenario:
            variants = context["document"].tree.get("variants")
            named = variants.values() if isinstance(variants, dict) else ()
            planners = [raw.get("planner") for raw in named if isinstance(raw, dict)]
            placed = taken.union(*SCENARIO_TASKS.values()) if variants else taken
            placed = placed.union(*(models[name] for name in planners if isinstance(name, str) and name in models))
        raise_all("Workload", task_refusals(value, taken, placed))
        return value

    @field_validator("mapping", mode="wrap")
    @classmethod
    def _map_tasks(cls, value: Any, handler: Any, info: ValidationInfo) -> Any:
        if "document" not in (info.context or {}):
            return handler(value)
        fields = info.data
        scenario, context = fields.get("scenario"), info.context or {}
        others = _other_tasks(scenario, _extra_names(fields, context, value))
        return _mapped(value, fields.get("planner"), scenario, others, context)

    @field_validator("variants", mode="wrap")
    @classmethod
    def _other_than_base(cls, value: Any, handler: Any) -> Any:
        lines: list[InitErrorDetails] = []
        if isinstance(value, dict) and BASE in value and len(value) <= MAX_VARIANTS:
            what = f"{BASE} is what the workload itself does"
            refusal = RefusalError(what, "give the variant another name", of_key=True)
            lines.append(refusal_details(refusal, (BASE,)))
        try:
            value = handler(value)
        except ValidationError as error:
            lines += details_of(error)
        raise_all("Workload", lines)
        return value


def _other_tasks(scenario: Scenario | None, extra: Iterable[str]) -> dict[str, type[TaskParameters]]:
    """The tasks that the scenario brings (None, as it is faulty: any) and those ``extra`` that the user adds."""
    brought = SCENARIO_TASKS[scenario.type] if scenario else chain(*SCENARIO_TASKS.values())
    return dict.fromkeys((*brought, *extra), PlacedTask)


def _extra_names(fields: Mapping[str, Any], context: Mapping[str, Any], mapping: Any) -> list[str]:
    """The names of the tasks that the user adds; of faulty ones too, or all in ``mapping`` where they are illegible."""
    if "tasks" in fields:
        return [task.name for task in fields["tasks"]]
    raw = context["document"].tree.get("tasks")
    named = [task.get("name") for task in raw if isinstance(task, dict)] if isinstance(raw, list) else []
    legible = [name for name in named if isinstance(name, str)]
    all_legible = isinstance(raw, list) and len(legible) == len(raw)
    return legible if all_legible or not isinstance(mapping, dict) else [*legible, *mapping]


def problem_model(planner: Any, context: Mapping[str, Any]) -> type[SpecModel]:
    """The model of a planner's problem: a map with goals and starts, unless the planner has its own."""
    model: type[SpecModel] = (context.get("problems") or {}).get(planner, ProblemSpec)
    return model


def tasks_of(tree: Mapping[str, Any], models: TaskModels | None) -> dict[str, type[TaskParameters]]:
    """The tasks that a raw workload may place, with the model of their parameters; no planner's where it has none."""
    planner, scenario, extra = tree.get("planner"), tree.get("scenario"), tree.get("tasks")
    kind = scenario.get("type") if isinstance(scenario, dict) else PlanOnce().type
    brought = SCENARIO_TASKS.get(kind, ()) if isinstance(kind, str) else ()
    names = [task.get("name") for task in extra if isinstance(task, dict)] if isinstance(extra, list) else []
    own = (models or {}).get(planner, {}) if isinstance(planner, str) else {}
    return {**dict.fromkeys((*brought, *(name for name in names if isinstance(name, str))), PlacedTask), **own}


def _mapped(
    value: Any,
    planner: str | None,
    scenario: Scenario | None,
    others: Mapping[str, type[TaskParameters]],
    context: Mapping[str, Any],
) -> dict[str, TaskMapping]:
    """A mapping from its raw form; ``others``: the tasks that are not the planner's."""
    if not isinstance(value, dict) or not value:
        refusal = RefusalError("maps no task", "write TASK: {component: NAME, ...}")
        raise_all("Workload", [refusal_details(refusal)])
    models = (context.get("tasks") or {}).get(planner or "")
    if models is not None:
        models = {**others, **models}
    lines: list[InitErrorDetails] = []
    mapping: dict[str, TaskMapping] = {}
    for task, raw in value.items():
        if models is not None and task not in models:
            what = f"{planner} has no task {clip(task)!r}"
            if scenario is not None and task in chain(*SCENARIO_TASKS.values()):
                what = f"scenario {scenario.type} has no task {task!r}, which the mapping places"
            refusal = RefusalError(what, choose_hint(clip(task, 60), models), of_key=True)
            lines.append(refusal_details(refusal, (task,)))
            continue
        try:
            mapping[task] = map_task(raw, (models or {}).get(task, RawParameters), context["document"])
        except ValidationError as error:
            lines += details_of(error, (task,))
    raise_all("Workload", lines)
    return mapping


def figures_of(*workloads: Workload) -> dict[str, DerivedFigure]:
    """The figures that the explorations of some workloads derive, by name.

    Raises:
        InputError: two of them derive different figures of one name.
    """
    figures: dict[str, DerivedFigure] = {}
    for workload in workloads:
        for name, figure in (workload.explore.figures if workload.explore else {}).items():
            if figures.setdefault(name, figure) != figure:
                both = f"{figures[name].definition} and {figure.definition}"
                what = f"two workloads have a figure {name}: {both}"
                raise InputError(what, f"explore.figures.{name}", "give one of them another name")
    return figures
