"""JSON Schema of the files, for editors: completion and hover texts in any that speaks YAML."""

from __future__ import annotations

from itertools import chain
from typing import Any

from pydantic import BaseModel

from codesign.ground.errors import InputError, choose_hint
from codesign.inputs.library import CalibrationFile, HostFile, PartFile
from codesign.inputs.platform import Platform, PricesFile
from codesign.inputs.tasks import SCENARIO_TASKS
from codesign.inputs.workload import PLACE_KEYS, ProblemModels, TaskMapping, TaskModels, Variant, Workload

DIALECT = "https://json-schema.org/draft/2020-12/schema"

_MODELS: dict[str, type[BaseModel]] = {
    "platform": Platform,
    "workload": Workload,
    "part": PartFile,
    "host": HostFile,
    "calibration": CalibrationFile,
    "prices": PricesFile,
}


def json_schema(kind: str, tasks: TaskModels | None = None, problems: ProblemModels | None = None) -> dict[str, Any]:
    """JSON Schema, draft 2020-12, of a kind of file.

    Args:
        kind: ``platform``, ``workload``, ``part``, ``host``, ``calibration`` or ``prices``.
        tasks: parameter models by planner and task, for ``workload``; without, parameters are left open.
        problems: models of problems other than a map with goals and starts, by planner.

    Raises:
        InputError: no such kind.
    """
    if kind not in _MODELS:
        raise InputError(f"there is no kind of file {kind!r}", "kind", choose_hint(kind, _MODELS))
    schema = _MODELS[kind].model_json_schema()
    if kind == "workload":
        for holder in (schema, schema["$defs"]["Variant"]):
            holder["properties"]["mapping"] = _open_mapping()
        # What the planner's models say holds for a whole scenario; a variant gives the keys of it that differ.
        schema["$defs"]["Variant"]["properties"]["scenario"] = {
            "type": "object",
            "description": Variant.model_fields["scenario"].description,
        }
        for open_model in ("TaskMapping", "BaseModel", "SpecModel"):
            schema["$defs"].pop(open_model, None)
        # What it holds depends on the planner: see below.
        schema["properties"]["problem"] = {"type": "object", "description": "What is to be planned."}
        if tasks is not None:
            schema["properties"]["planner"]["enum"] = sorted(tasks)
            schema["$defs"]["Variant"]["properties"]["planner"] = schema["properties"]["planner"]
            schema["allOf"] = [
                _of_planner(schema["$defs"], name, tasks[name], (problems or {}).get(name)) for name in sorted(tasks)
            ]
            schema["$defs"]["Variant"]["allOf"] = [_variant_of_planner(name) for name in sorted(tasks)]
    return {"$schema": DIALECT, **schema}


def _open_mapping() -> dict[str, Any]:
    task = {"type": "object", "required": ["component"], "properties": _placement()}
    return {
        "type": "object",
        "minProperties": 1,
        "additionalProperties": task,
        "description": Workload.model_fields["mapping"].description,
    }


def _placement() -> dict[str, Any]:
    fields = {key: TaskMapping.model_fields[key].description for key in PLACE_KEYS}
    return {key: {"type": "string", "description": description} for key, description in fields.items()}


def _placement_only() -> dict[str, Any]:
    """Of a task that has nothing to choose but its place."""
    return {"type": "object", "properties": _placement(), "required": ["component"], "additionalProperties": False}


def _of_planner(
    definitions: dict[str, Any], planner: str, models: Any, problem: type[BaseModel] | None
) -> dict[str, Any]:
    """The schema of problem and mapping of a workload of ``planner``; their own definitions go to ``definitions``."""

    def schema_of(model: type[BaseModel], prefix: str) -> dict[str, Any]:
        schema = model.model_json_schema(ref_template=f"#/$defs/{prefix}.{{model}}")
        for name, definition in schema.pop("$defs", {}).items():
            definitions[f"{prefix}.{name}"] = definition
        return schema

    tasks = {task: _placement_only() for task in dict.fromkeys(chain(*SCENARIO_TASKS.values()))}
    for task, model in models.items():
        schema = schema_of(model, f"{planner}.{task}")
        schema["properties"] = {**_placement(), **schema.get("properties", {})}
        schema["required"] = ["component", *schema.get("required", [])]
        tasks[task] = schema
    # A task that the user adds has a name of their own.
    definitions[f"{planner}.mapping"] = {
        "type": "object",
        "properties": tasks,
        "additionalProperties": _placement_only(),
    }
    own = {"$ref": "#/$defs/ProblemSpec"} if problem is None else schema_of(problem, f"{planner}.problem")
    mapping = {"$ref": f"#/$defs/{planner}.mapping"}
    without = {"if": {"not": {"required": ["planner"]}}, "then": {"properties": {"mapping": mapping}}}
    return {
        "if": {"properties": {"planner": {"const": planner}}, "required": ["planner"]},
        "then": {
            "properties": {
                "mapping": mapping,
                "problem": own,
                "variants": {"type": "object", "additionalProperties": without},
            }
        },
    }


def _variant_of_planner(planner: str) -> dict[str, Any]:
    return {
        "if": {"properties": {"planner": {"const": planner}}, "required": ["planner"]},
        "then": {"properties": {"mapping": {"$ref": f"#/$defs/{planner}.mapping"}}},
    }
