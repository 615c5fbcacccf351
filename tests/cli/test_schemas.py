"""What ``--json`` prints keeps to the schema that ``hwsw schema`` prints."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest
from click.testing import Result
from jsonschema import Draft202012Validator

Run = Callable[..., Result]


@pytest.mark.parametrize("part", ["XC2V6000-4", "XC3S500E-4"], ids=["feasible", "infeasible"])
def test_result_keeps_to_its_schema(hwsw: Run, specs: tuple[Path, Path], part: str) -> None:
    schema = json.loads(hwsw("schema", "result").stdout)
    Draft202012Validator.check_schema(schema)
    settings = ("--set", f"fpga.part={part}", "--set", "fpga.clock=50 MHz")
    told = json.loads(hwsw("run", *specs, *settings, "--json").stdout)
    assert told["feasible"] is (part == "XC2V6000-4")
    jsonschema.validate(told, schema)
    for broken in ({**told, "feasible": "yes"}, {**told, "surprise": 1}, {**told, "schema_version": "1"}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(broken, schema)
