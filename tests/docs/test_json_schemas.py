"""What the commands print with ``--json`` is what ``hwsw schema`` says it is."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import Result

from codesign.ground.figures import FIGURES, Status
from codesign.planners.reproduction import Finding, Plot, Reproduction, Series, Use, row

Run = Callable[..., Result]
Specs = tuple[Path, Path]


def told(text: str) -> Any:
    """JSON read strictly: no NaN, no infinity."""
    return json.loads(text, parse_constant=pytest.fail)


def check(document: Any, schema: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema, jsonschema.Draft202012Validator)


def objects(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The schema and its definitions, those of objects with named properties."""
    yield from (each for each in (schema, *schema["$defs"].values()) if "properties" in each)


def test_a_study_is_what_its_schema_says(hwsw: Run, specs: Specs) -> None:
    schema = told(hwsw("schema", "study").stdout)
    for each in objects(schema):
        assert each["additionalProperties"] is False
        assert each["required"] == list(each["properties"])
    text = specs[1].read_text(encoding="utf-8")
    text = text.replace("[[12, 18], [24, 36], [6, 9]]", "[[24, 36]]").replace("[15, 255]", "[15, 31]")
    text += "  constraints:\n    - {figure: slices, at_most: 20000}\n    - {figure: first_plan_s, at_most: 5 s}\n"
    specs[1].write_text(text, encoding="utf-8")
    study = told(hwsw("explore", *specs, "--json", "--workers", 1).stdout)
    assert {point["feasible"] for point in study["points"]} == {True, False}
    assert study["units"] == {figure.name: figure.unit for figure in FIGURES.values()}
    none = {"at_least": None, "above": None, "below": None, "of_part": False}
    assert study["constraints"][1] == {"figure": "first_plan_s", **none, "at_most": 5}
    check(study, schema)
    (failed, missing) = ({**study["points"][0], "feasible": False, "result": None} for _ in range(2))
    failed |= {"state": "failed", "failure": "out of memory"}
    missing |= {"state": "missing"}
    check({**study, "points": [failed, missing]}, schema)


def test_every_property_of_a_result_says_what_it_is(hwsw: Run) -> None:
    schema = told(hwsw("schema", "result").stdout)
    silent = {
        f"{each.get('title')}.{name}"
        for each in objects(schema)
        for name, held in each["properties"].items()
        if not held.get("description")
    }
    assert not silent


def test_a_reproduction_is_what_its_schema_says(hwsw: Run) -> None:
    schema = told(hwsw("schema", "reproduction").stdout)
    for each in objects(schema):
        assert each["additionalProperties"] is False
        assert each["required"] == list(each["properties"])
    rows = (
        row("Table 2", "slices", 235, 234, status=Status.PUBLISHED, source="13 a node", use=Use.FITTED),
        row("Section 4", "speed", "about 270", 263.5, status=Status.CALIBRATED, source="costs", use=Use.KNOWN),
        row("Section 5", "clock", None, None, status=Status.ASSUMED, source="none", unit="Hz", use=Use.NOTHING),
    )
    plot = Plot("figure-3", "Figure 3", "falls", "p", "cells", (Series("a", (1.0, 2.0), (3.0, 4.0)),))
    check(told(Reproduction("Girau 2008", rows, (plot,), (Finding("It fits.", {"rows": "3"}),)).to_json()), schema)


def test_what_is_not_in_a_schema_is_refused(hwsw: Run) -> None:
    schema = told(hwsw("schema", "reproduction").stdout)
    document = told(Reproduction("Girau 2008", (), (), ()).to_json())
    check(document, schema)
    for wrong in ({**document, "more": 1}, {**document, "schema_version": 2}, {**document, "rows": [{}]}):
        with pytest.raises(jsonschema.ValidationError):
            check(wrong, schema)


def test_the_list_of_parts_names_resources_as_the_tables_do(hwsw: Run) -> None:
    parts = told(hwsw("list", "--json").stdout)["parts"]
    assert "9,312 LUT4, 9,312 flip-flops, 20 block RAMs" in parts["XC3S500E-4"]


@pytest.mark.parametrize("part", ["XC2V6000-4", "XC3S500E-4"], ids=["feasible", "infeasible"])
def test_a_result_is_what_its_schema_says(hwsw: Run, specs: Specs, part: str) -> None:
    schema = told(hwsw("schema", "result").stdout)
    # A block of the whole map takes more slices and block RAMs than the smaller part has.
    settings = ("--set", f"fpga.part={part}", "--set", "fpga.clock=50 MHz", "--set", "relax.block=[24, 36]")
    document = told(hwsw("run", *specs, *settings, "--json").stdout)
    assert document["feasible"] is (part == "XC2V6000-4")
    check(document, schema)
    for wrong in ({"feasible": "yes"}, {"surprise": 1}, {"schema_version": "1"}):
        with pytest.raises(jsonschema.ValidationError):
            check({**document, **wrong}, schema)
