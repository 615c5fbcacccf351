"""A platform with any registered kind of link, written from the fields of its model alone."""

from __future__ import annotations

from typing import Annotated, Any

import yaml
from pydantic import TypeAdapter, ValidationError
from small_search import SMALL

import codesign
from codesign.ground.figures import Figure
from codesign.inputs import Platform, Workload
from codesign.inputs.links import LINKS, AnyLink

FIGURES: list[tuple[str | int, str | int, str | int]] = [
    (8, 4, 16),
    ("20 MHz", "10 MHz", "40 MHz"),
    ("200 ns", "100 ns", "400 ns"),
    ("2 W", "1 W", "4 W"),
]
"""Value, low and high of a figure; the first that a field takes is used."""

OTHERS: list[Any] = [8, 1.0, "2 us", "a-name"]
"""Values of a field that is no figure; the first that it takes is used."""

POWER = {"busy": "300 mW", "idle": "100 mW"}


def taken(kind: type[AnyLink], key: str, value: Any) -> bool:
    """Whether a field takes a value."""
    field = kind.model_fields[key]
    adapter: TypeAdapter[Any] = TypeAdapter(field.annotation)
    if field.metadata:
        adapter = TypeAdapter(Annotated[(field.annotation, *field.metadata)])
    try:
        adapter.validate_python(value)
    except (ValidationError, TypeError, ValueError):
        return False
    return True


def is_figure(kind: type[AnyLink], key: str) -> bool:
    return kind.model_fields[key].annotation is Figure


def figure(kind: type[AnyLink], key: str) -> dict[str, Any]:
    """A figure with an interval that a field takes."""
    value, low, high = next(each for each in FIGURES if taken(kind, key, each[0]))
    return {"value": value, "status": "assumed", "source": "a sample", "low": low, "high": high}


def link(name: str) -> dict[str, Any]:
    """A link of a kind: its figures, and what else it requires."""
    kind = LINKS[name]
    declared: dict[str, Any] = {"type": name, "between": ["host", "fpga"], "power": POWER}
    for key, field in kind.model_fields.items():
        if is_figure(kind, key):
            declared[key] = figure(kind, key)
        elif field.is_required() and key not in declared:
            declared[key] = next(value for value in OTHERS if taken(kind, key, value))
    return declared


HOST: dict[str, Any] = {
    "type": "processor",
    "clock": "1 GHz",
    "costs": {"harmonic_node_update": "40 ns"},
    "power": {"busy": "20 W", "idle": "5 W"},
}


def platform(declared: dict[str, Any], host: dict[str, Any] = HOST) -> Platform:
    """A small platform whose host and FPGA a link joins."""
    return codesign.load_platform(
        {
            "kind": "platform",
            "name": "small-board",
            "components": {"fpga": {"type": "fpga", "part": "XC2V6000-4", "clock": "50 MHz"}, "host": host},
            "links": {"line": declared},
        }
    )


def workload(axes: dict[str, Any] | None = None, **more: Any) -> Workload:
    """A small workload, with what is explored."""
    raw = yaml.safe_load(SMALL) | more
    if axes:
        raw["explore"] = {"axes": axes}
    return codesign.load_workload(raw)


def with_value(declared: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """A link with another value of a figure."""
    return declared | {key: declared[key] | {"value": value}}
