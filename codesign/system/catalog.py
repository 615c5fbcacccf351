"""The planners and architecture styles that are installed, ours and others', found through entry points."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from codesign import spec
from codesign.architectures.interface import Architecture
from codesign.errors import InputError, choose_hint
from codesign.planners.interface import Planner
from codesign.spec import SpecModel, Workload


@cache
def planners() -> Mapping[str, Planner]:
    """Every installed planner by the name that workloads use."""
    return {point.name: _loaded(point) for point in entry_points(group="codesign.planners")}


@cache
def architectures() -> Mapping[tuple[str, str], Architecture]:
    """Every installed architecture style by (planner, style)."""
    styles: list[Architecture] = []
    for point in entry_points(group="codesign.architectures"):
        styles.extend(_loaded(point))
    return {(style.planner, style.style): style for style in styles}


def task_models() -> dict[str, Mapping[str, type[BaseModel]]]:
    """The parameter model of each task of each planner: what ``spec.load_workload`` checks mappings against."""
    return {name: planner.tasks for name, planner in planners().items()}


def problem_models() -> dict[str, type[SpecModel]]:
    """The models of problems other than a map with goals and starts, by planner."""
    found = {name: planner.problem_model for name, planner in planners().items()}
    return {name: model for name, model in found.items() if model is not None}


def load_workload(source: str | Path) -> Workload:
    """The workload of that shipped name or file, checked against the installed planners.

    Raises:
        InputError: no shipped workload of that name. SpecError: all the faults of the file.
    """
    return spec.load_workload(source, task_models(), problem_models())


def planner(name: str) -> Planner:
    """The planner of that name.

    Raises:
        InputError: no such planner is installed.
    """
    known = planners()
    if name not in known:
        raise InputError(f"no planner is named {name!r}", "planner", choose_hint(name, known))
    return known[name]


def styles_of(planner_name: str) -> dict[str, Architecture]:
    """The styles of one planner by name."""
    return {style: found for (of, style), found in architectures().items() if of == planner_name}


def _loaded(point: Any) -> Any:
    try:
        return point.load()
    except Exception as fault:
        raise InputError(
            f"plug-in {point.name} ({point.value}) cannot be loaded: {fault}",
            point.group,
            "mend or uninstall the package that registers it",
        ) from fault
