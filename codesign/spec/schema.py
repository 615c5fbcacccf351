"""JSON Schema of the files, for editors: completion and hover texts in any that speaks YAML."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from codesign.errors import InputError, choose_hint
from codesign.spec.part import PartFile
from codesign.spec.platform import Platform
from codesign.spec.workload import TaskModels, Workload

DIALECT = "https://json-schema.org/draft/2020-12/schema"

_MODELS: dict[str, type[BaseModel]] = {"platform": Platform, "workload": Workload, "part": PartFile}


def json_schema(kind: str, tasks: TaskModels | None = None) -> dict[str, Any]:
    """JSON Schema, draft 2020-12, of a kind of file.

    Args:
        kind: ``platform``, ``workload`` or ``part``.
        tasks: parameter models by planner and task, for ``workload``; without, parameters are left open.

    Raises:
        InputError: no such kind.
    """
    if kind not in _MODELS:
        raise InputError(f"there is no kind of file {kind!r}", "kind", choose_hint(kind, _MODELS))
    schema = _MODELS[kind].model_json_schema()
    if kind == "workload":
        schema["properties"]["mapping"] = _open_mapping()
        schema["$defs"].pop("TaskMapping", None)
        schema["$defs"].pop("BaseModel", None)
        if tasks is not None:
            schema["properties"]["planner"]["enum"] = sorted(tasks)
            schema["allOf"] = [_of_planner(schema["$defs"], name, tasks[name]) for name in sorted(tasks)]
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
    return {
        "component": {"type": "string", "description": "The component that runs the task."},
        "style": {"type": "string", "description": "The architecture style; by default the component's own."},
    }


def _of_planner(definitions: dict[str, Any], planner: str, models: Any) -> dict[str, Any]:
    """What the mapping of a workload of ``planner`` holds; the models' own definitions go to ``definitions``."""
    tasks = {}
    for task, model in models.items():
        schema = model.model_json_schema(ref_template=f"#/$defs/{planner}.{task}.{{model}}")
        for name, definition in schema.pop("$defs", {}).items():
            definitions[f"{planner}.{task}.{name}"] = definition
        schema["properties"] = {**_placement(), **schema.get("properties", {})}
        schema["required"] = ["component", *schema.get("required", [])]
        tasks[task] = schema
    mapping = {"type": "object", "properties": tasks, "additionalProperties": False}
    return {
        "if": {"properties": {"planner": {"const": planner}}, "required": ["planner"]},
        "then": {"properties": {"mapping": mapping}},
    }
