"""Designs on shipped platforms that make one plan, their results, and the same with other values of figures."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import codesign
from codesign.ground.errors import CodesignError
from codesign.ground.memo import Memo
from codesign.inputs.files import data_folder
from codesign.system import point_of
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

MEMO = Memo()
load_platform, load_workload = cache(codesign.load_platform), cache(codesign.load_workload)
UNITS = {"s": 1e12, "Hz": 1.0, "W": 1.0, "1": 1.0}
WRITTEN = {"s": "ps", "Hz": "Hz", "W": "W"}

Design = tuple[str, str, tuple[tuple[str, Any], ...]]
"""A platform, a workload, and settings."""


def design(platform: str, workload: str, **settings: Any) -> Design:
    """A design; ``search__component`` sets ``search.component``."""
    return platform, workload, tuple((name.replace("__", "."), value) for name, value in settings.items())


def on_host(platform: str, host: str) -> Design:
    """Breadth-first search in software."""
    return design(platform, "breadth-first", search__component=host, search__style="software")


@cache
def result_of(one: Design) -> Result:
    """The result of a design."""
    return with_values(one, {})


def with_values(one: Design, values: Mapping[str, Any]) -> Result:
    """The result of a design with raw values by axis."""
    platform, workload, settings = one
    point = point_of(load_platform(platform), load_workload(workload), {**dict(settings), **values})
    return simulate(*point, memo=MEMO)


def written(value: float, unit: str) -> Any:
    """A value of an input as a platform file has it. A number of things becomes whole."""
    if unit == "1":
        return round(value)
    number = value * UNITS[unit]
    return f"{number if unit == 'W' else round(number)!r} {WRITTEN[unit]}"


@cache
def shipped_plans() -> tuple[Design, ...]:
    """Every shipped platform with every shipped workload of one plan that fits it."""
    designs = []
    for workload in sorted(path.stem for path in data_folder("workloads").glob("*.yaml")):
        if load_workload(workload).scenario.type != "plan_once":
            continue
        for platform in sorted(path.stem for path in data_folder("platforms").glob("*.yaml")):
            try:
                if result_of(design(platform, workload)).feasible:
                    designs.append(design(platform, workload))
            except CodesignError:
                continue  # the platform lacks a component
    return tuple(designs)
