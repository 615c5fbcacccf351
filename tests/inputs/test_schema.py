"""The JSON Schemas of specs: what they are, and that they accept what ships."""

from __future__ import annotations

import json
import re

import pytest
from jsonschema import Draft202012Validator

from codesign.ground.errors import InputError
from codesign.inputs import json_schema, list_platforms, list_workloads, load_platform
from codesign.inputs.files import data_folder
from codesign.inputs.library import PARTS
from codesign.inputs.workload import PLACE_KEYS
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.system import catalog

SHIPPED_TASKS = catalog.task_models()


@pytest.mark.parametrize("kind", ["platform", "workload", "part"])
def test_schemas(kind: str) -> None:
    schema = json_schema(kind, SHIPPED_TASKS)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    text = json.dumps(schema)
    defined = {f"#/$defs/{name}" for name in schema["$defs"]}
    assert set(re.findall(r'"\$ref": "([^"]+)"', text)) <= defined
    assert schema["additionalProperties"] is False
    assert all("description" in field for name, field in schema["properties"].items() if "$ref" not in field) or (
        kind == "part"
    )


def test_the_schema_of_a_workload_knows_the_planners_parameters() -> None:
    schema = json_schema("workload", SHIPPED_TASKS)
    assert "harmonic" in schema["properties"]["planner"]["enum"]
    (rule,) = (rule for rule in schema["allOf"] if rule["if"]["properties"]["planner"]["const"] == "harmonic")
    assert rule["then"]["properties"]["mapping"] == {"$ref": "#/$defs/harmonic.mapping"}
    relax = schema["$defs"]["harmonic.mapping"]["properties"]["relax"]
    assert set(relax["properties"]) == {*PLACE_KEYS, *RelaxParameters.model_fields}
    assert relax["required"] == ["component", "iterations", "schedule"]
    with pytest.raises(InputError, match="no kind of file"):
        json_schema("plattform")


def test_schemas_accept_the_shipped_files() -> None:
    for kind, documents in (
        ("platform", [load_platform(name).document for name in list_platforms()]),
        ("workload", [catalog.load_workload(name).document for name in list_workloads()]),
        ("part", [PARTS.load(path).document for path in (data_folder("platforms") / "parts").glob("*.yaml")]),
    ):
        schema = json_schema(kind, SHIPPED_TASKS, catalog.problem_models())
        Draft202012Validator.check_schema(schema)
        validator = Draft202012Validator(schema)
        assert documents
        for document in documents:
            validator.validate(document.tree)
