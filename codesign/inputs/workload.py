"""A workload: planner, problem, scenario, mapping, and what to explore, as declared in YAML."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    ConfigDict,
    Field,
    PrivateAttr,
    SerializeAsAny,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic_core import InitErrorDetails

from codesign.errors import choose_hint, clip, show
from codesign.inputs.base import Spec
from codesign.inputs.exploration import Exploration
from codesign.inputs.fields import Name
from codesign.inputs.problem import FileMap, ProblemSpec
from codesign.inputs.scenario import PlanOnce, Scenario
from codesign.inputs.tasks import MAX_TASKS, SCENARIO_TASKS, ExtraTask, PlacedTask, task_refusals
from codesign.inputs.variants import BASE, MAX_VARIANTS, merged, parts_present, sound_scenario
from codesign.inputs.yaml_tree import Document
from codesign.models import (
    RefusalError,
    SpecModel,
    TaskParameters,
    details_of,
    raise_all,
    refusal_details,
)

ProblemModels = Mapping[str, type[SpecModel]]
"""Planner name → model of its problem, for planners whose problem is not a map with goals and starts."""

TaskModels = Mapping[str, Mapping[str, type[TaskParameters]]]
"""Planner name → task name → model of the task's parameters.

A ``SpecModel`` refuses what a plain pydantic model lets pass (``true`` for 1), and names accepted keys.
"""


class RawParameters(TaskParameters):
    """Parameters of a task that nobody has a model for: kept as they are."""

    model_config = ConfigDict(frozen=True, extra="allow")


class TaskMapping(SpecModel):
    """Where a task runs, in which style, and with which parameters."""

    component: Name = Field(description="The component that runs the task.")
    style: Name | None = Field(
        default=None,
        description="Architecture style. Without it, the component's own is taken. hwsw list shows all.",
    )
    external_memory: Name | None = Field(
        default=None,
        description="Of the planning task: the external memory that holds what does not fit in block RAM.",
    )
    parameters: SerializeAsAny[TaskParameters] = Field(description="Parameters of planner and style.")


PLACE_KEYS = ("component", "style", "external_memory")
"""The keys of a task's mapping that say where it runs and how; the others are its parameters."""


def map_task(raw: Any, model: type[TaskParameters], document: Document | None = None) -> TaskMapping:
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


class Variant(SpecModel):
    """Another way to do the same: what it gives stands in the place of the workload's own.

    ``scenario`` is whole: the workload's, with the keys that the variant changes put in.
    """

    description: str = Field(default="", description="What it is, for readers.")
    planner: Name | None = Field(default=None, description="Its planner. Without it, that of the workload.")
    mapping: dict[Name, TaskMapping] | None = Field(
        default=None, description="Where its tasks run. It replaces the whole mapping of the workload."
    )
    scenario: Scenario | None = Field(
        default=None, description="Keys of the scenario that differ. The others stay as in the workload."
    )


class Workload(Spec):
    """The job: planner, problem, scenario, mapping, variants and exploration."""

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
    explore: Exploration | None = Field(
        default=None, description="What hwsw explore tries, and which figures decide."
    )

    _models: TaskModels | None = PrivateAttr(default=None)

    @property
    def map_file(self) -> Path | None:
        """The file of the map, or None where the map is generated."""
        wanted = self.problem.map if isinstance(self.problem, ProblemSpec) else None
        return wanted.path if isinstance(wanted, FileMap) else None

    @property
    def task_models(self) -> Mapping[str, type[TaskParameters]] | None:
        """The parameter model of each task, or None where the workload was loaded without any."""
        return self.models_of(self.planner, self.scenario)

    def models_of(self, planner: str, scenario: Scenario) -> Mapping[str, type[TaskParameters]] | None:
        """As ``task_models``, of another planner or scenario."""
        if self._models is None or planner not in self._models:
            return None
        return {**_other_tasks(scenario, (task.name for task in self.tasks)), **self._models[planner]}

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
        problems = (info.context or {}).get("problems") or {}
        model = problems.get(info.data.get("planner"), ProblemSpec)
        return model.model_validate(value, context=info.context)

    @field_validator("tasks", mode="after")
    @classmethod
    def _sound_tasks(cls, value: tuple[ExtraTask, ...], info: ValidationInfo) -> tuple[ExtraTask, ...]:
        context, fields = info.context or {}, info.data
        models = context.get("tasks") or {}
        planner, scenario = fields.get("planner"), fields.get("scenario")
        taken = {*models.get(planner, ()), *(SCENARIO_TASKS[scenario.type] if scenario else ())}
        known = None
        if "document" in context and planner in models and scenario:
            variants = context["document"].tree.get("variants")
            named = variants.values() if isinstance(variants, dict) else ()
            planners = [raw.get("planner") for raw in named if isinstance(raw, dict)]
            known = taken.union(*SCENARIO_TASKS.values()) if variants else taken
            known = known.union(
                *(models[name] for name in planners if isinstance(name, str) and name in models)
            )
        raise_all("Workload", task_refusals(value, taken, known))
        return value

    @field_validator("mapping", mode="wrap")
    @classmethod
    def _map_tasks(cls, value: Any, handler: Any, info: ValidationInfo) -> Any:
        if "document" not in (info.context or {}):
            return handler(value)
        fields = info.data
        others = _other_tasks(fields.get("scenario"), _extra_names(fields, info.context or {}, value))
        return _mapped(value, fields.get("planner"), others, info.context or {})

    @field_validator("variants", mode="wrap")
    @classmethod
    def _each_variant(cls, value: Any, handler: Any, info: ValidationInfo) -> Any:
        if "document" not in (info.context or {}) or not isinstance(value, dict) or len(value) > MAX_VARIANTS:
            return handler(value)
        lines: list[InitErrorDetails] = []
        made: dict[str, Variant] = {}
        for name, raw in value.items():
            if name == BASE:
                what = f"{BASE} is what the workload itself does"
                refusal = RefusalError(what, "give the variant another name", of_key=True)
                lines.append(refusal_details(refusal, (name,)))
                continue
            try:
                made[name] = _variant(raw, info.data, info.context or {})
            except ValidationError as error:
                lines += details_of(error, (name,))
        raise_all("Workload", lines)
        return handler(made)

    def with_models(self, models: TaskModels | None) -> Self:
        """The workload, with the models, by planner and task, that substituted parameters are checked against."""
        self._models = models
        return self


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


def _mapped(
    value: Any, planner: str | None, others: Mapping[str, type[TaskParameters]], context: Mapping[str, Any]
) -> dict[str, TaskMapping]:
    """A mapping from its raw form; ``others``: the tasks that are not the planner's."""
    if not isinstance(value, dict) or not value:
        refusal = RefusalError("maps no task", "write TASK: {component: NAME, ...}")
        raise_all("Workload", [refusal_details(refusal)])
    models = (context.get("tasks") or {}).get(planner or "")
    if models is not None:
        models = {**others, **models}
    lines: list[InitErrorDetails] = []
    made: dict[str, TaskMapping] = {}
    for task, raw in value.items():
        if models is not None and task not in models:
            what = f"{planner} has no task {clip(task)!r}"
            refusal = RefusalError(what, choose_hint(clip(task, 60), models), of_key=True)
            lines.append(refusal_details(refusal, (task,)))
            continue
        try:
            made[task] = map_task(raw, (models or {}).get(task, RawParameters), context["document"])
        except ValidationError as error:
            lines += details_of(error, (task,))
    raise_all("Workload", lines)
    return made


def _variant(raw: Any, fields: Mapping[str, Any], context: Mapping[str, Any]) -> Variant:
    """A variant from its raw form, ``fields`` those of the workload that are sound.

    Raises:
        ValidationError: with locations inside ``raw``.
    """
    if not isinstance(raw, dict):
        refusal = RefusalError(
            f"{show(raw)} is not a mapping", "write {planner: NAME, mapping: {...}, scenario: {...}}"
        )
        raise_all("Variant", [refusal_details(refusal)])
    lines: list[InitErrorDetails] = []
    named = raw.get("planner", fields.get("planner"))
    planner = named if isinstance(named, str) else None
    other = _planner_refusal(raw, fields, context)
    lines += [other] if other else []
    scenario = fields.get("scenario")
    if "scenario" in raw:
        try:
            scenario = _varied_scenario(raw["scenario"], context["document"])
        except ValidationError as error:
            scenario, lines = None, lines + details_of(error)
    made = {key: value for key, value in raw.items() if key not in {"scenario", "mapping"}}
    made |= {"scenario": scenario} if "scenario" in raw else {}
    others = _other_tasks(scenario, _extra_names(fields, context, raw.get("mapping")))
    if "mapping" in raw and not other:
        try:
            made["mapping"] = _mapped(raw["mapping"], planner, others, context)
        except ValidationError as error:
            lines += details_of(error, ("mapping",))
    elif "mapping" not in raw and scenario is not None:
        lost = stray_task(fields.get("mapping", {}), scenario, fields.get("scenario", PlanOnce()))
        if lost is not None:
            refusal = RefusalError(lost, "give the variant a mapping of its own")
            lines.append(refusal_details(refusal, ("scenario",)))
    try:
        variant = Variant.model_validate(made)
    except ValidationError as error:
        lines += [line for line in details_of(error) if line["loc"][0] not in {"scenario", "mapping"}]
    raise_all("Variant", lines)
    return variant


def _planner_refusal(
    raw: Mapping[str, Any], fields: Mapping[str, Any], context: Mapping[str, Any]
) -> InitErrorDetails | None:
    """What keeps the planner of a variant from taking the workload's problem, or its mapping."""
    planner, base = raw.get("planner"), fields.get("planner")
    tasks, problems = context.get("tasks"), context.get("problems") or {}
    if not isinstance(planner, str) or base is None or planner == base:
        return None
    if tasks is not None and planner not in tasks:
        refusal = RefusalError(
            f"there is no planner {clip(planner)!r}", choose_hint(clip(planner, 60), tasks)
        )
    elif problems.get(planner) is not problems.get(base):
        what = f"the problem of {planner} is of another kind than that of {base}"
        refusal = RefusalError(what, "choose a planner of the same kind, or make a workload of its own")
    elif "mapping" not in raw:
        what = f"the workload maps the tasks of {base}, not those of {planner}"
        refusal = RefusalError(what, "give the variant a mapping of its own")
    else:
        return None
    return refusal_details(refusal, ("planner",))


def _varied_scenario(raw: Any, document: Document) -> Scenario:
    """The workload's scenario with the keys of ``raw`` put in."""
    if not isinstance(raw, dict):
        refusal = RefusalError(f"{show(raw)} is not a mapping", "write the keys that differ")
        raise_all("Variant", [refusal_details(refusal, ("scenario",))])
    try:
        return sound_scenario(merged(document.tree.get("scenario"), raw), document)
    except ValidationError as error:
        # A key of the workload's scenario that clashes is told of the variant, which brought the clash in.
        lines = details_of(error)
        for line in lines:
            line["loc"] = parts_present({"scenario": raw}, line["loc"], keep_last=line["type"] == "missing")
        raise ValidationError.from_exception_data("Variant", lines) from None


def stray_task(mapping: Iterable[str], scenario: Scenario, before: Scenario) -> str | None:
    """What is wrong where a mapping made for scenario ``before`` places a task that ``scenario`` does not have."""
    known = SCENARIO_TASKS[scenario.type]
    for task in mapping:
        if task in SCENARIO_TASKS[before.type] and task not in known:
            return f"scenario {scenario.type} has no task {task!r}, which the mapping places"
    return None
