"""The planners and architecture styles that are installed, ours and others', found through entry points.

A plug-in that cannot be loaded disables nothing but itself: it is left out with a warning, kept in ``broken``, and
refused where a workload asks for it.
"""

from __future__ import annotations

import logging
from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from codesign import spec
from codesign.errors import Fault, InputError, SpecError, choose_hint
from codesign.planners.interface import Planner
from codesign.planners.styles import Architecture, TaskStyle
from codesign.spec import SpecModel, Workload

_log = logging.getLogger(__name__)

_PLANNERS, _STYLES, _TASKS = "codesign.planners", "codesign.architectures", "codesign.task_styles"
_REMEDY = "mend or uninstall the package that registers it"


@dataclass(frozen=True)
class BrokenPlugIn:
    """A plug-in that cannot be loaded: the entry point's ``group``, ``name`` and ``value``, and ``why``."""

    group: str
    name: str
    value: str
    why: str

    def __str__(self) -> str:
        return f"plug-in {self.name} ({self.value}) cannot be loaded: {self.why}"


@cache
def planners() -> Mapping[str, Planner]:
    """Every installed planner by the name that workloads use; without those that cannot be loaded."""
    return _loaded(_PLANNERS)[0]


@cache
def architectures() -> Mapping[tuple[str, str], Architecture]:
    """Every installed architecture style by (planner, style); without those that cannot be loaded."""
    found = _loaded(_STYLES)[0]
    return {key: style for styles in found.values() for key, style in styles.items()}


@cache
def task_styles() -> Mapping[tuple[str, str, str, str], TaskStyle]:
    """Every installed style of a task placed by itself, by (planner, task, type of component, style).

    Without those that cannot be loaded.
    """
    found = _loaded(_TASKS)[0]
    return {key: style for styles in found.values() for key, style in styles.items()}


def broken() -> tuple[BrokenPlugIn, ...]:
    """The planners and styles that are registered, and cannot be loaded."""
    return tuple(plug_in for group in GROUPS for plug_in in _loaded(group)[1])


def registered() -> tuple[tuple[str, EntryPoint], ...]:
    """(group, entry point) of every plug-in that is installed, ours included; in an order of its own."""
    found = [(group, point) for group in GROUPS for point in entry_points(group=group)]
    return tuple(sorted(found, key=lambda each: (each[0], each[1].name, each[1].value)))


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
    try:
        return spec.load_workload(source, task_models(), problem_models())
    except SpecError as wrong:
        raise SpecError(_blame_plug_in(fault) for fault in wrong.faults) from None


def _blame_plug_in(fault: Fault) -> Fault:
    """The fault; of a planner that is registered but cannot be loaded, with the reason."""
    for plug_in in broken():
        if plug_in.group == _PLANNERS and fault.key == "planner" and repr(plug_in.name) in fault.what:
            return replace(fault, what=str(plug_in), hint=_REMEDY)
    return fault


def planner(name: str) -> Planner:
    """The planner of that name.

    Raises:
        InputError: no such planner is installed, or it cannot be loaded.
    """
    known = planners()
    _refuse_broken(_PLANNERS, name, known)
    if name not in known:
        raise InputError(f"no planner is named {name!r}", "planner", choose_hint(name, known))
    return known[name]


def styles_of(planner_name: str) -> dict[str, Architecture]:
    """The styles of one planner by name.

    Raises:
        InputError: it has none, and those registered under its name cannot be loaded.
    """
    found = {style: found for (of, style), found in architectures().items() if of == planner_name}
    if not found:
        _refuse_broken(_STYLES, planner_name, ())
    return found


def task_styles_of(planner_name: str, task: str) -> dict[tuple[str, str], TaskStyle]:
    """The styles of one task placed by itself, by (type of component, style), ours first; none where it cannot be.

    Raises:
        InputError: it has none, and those registered under its planner's name cannot be loaded.
    """
    found = {
        (component_type, name): style
        for (*of, component_type, name), style in task_styles().items()
        if of == [planner_name, task]
    }
    if not found:
        _refuse_broken(_TASKS, planner_name, ())
    return found


def _refuse_broken(group: str, name: str, known: Container[str]) -> None:
    for plug_in in broken():
        if (plug_in.group, plug_in.name) == (group, name) and name not in known:
            raise InputError(str(plug_in), group, _REMEDY)


@cache
def _loaded(group: str) -> tuple[dict[str, Any], tuple[BrokenPlugIn, ...]]:
    """What the entry points of a group stand for, each once found sound; and those that are not."""
    found, failed = {}, []
    for point in entry_points(group=group):
        try:
            found[point.name] = GROUPS[group](point.load())
        # The code of others: it may raise anything, and one that ends the process must not end ours.
        except (Exception, SystemExit) as fault:
            why = " ".join(f"{type(fault).__name__}: {fault}".split())[:200]
            failed.append(BrokenPlugIn(group, point.name, point.value, why))
            _log.warning("%s; it is left out: %s", failed[-1], _REMEDY)
    return found, tuple(failed)


def _sound_planner(plug_in: Any) -> Planner:
    """The planner, once what is asked of every planner when a workload is read has been answered."""
    dict(plug_in.tasks), plug_in.problem_model, plug_in.planning_task
    planner: Planner = plug_in
    return planner


def _sound_task_styles(plug_in: Any) -> dict[tuple[str, str, str, str], TaskStyle]:
    return {(style.planner, style.task, style.component_type, style.style): style for style in plug_in}


def _sound_styles(plug_in: Any) -> dict[tuple[str, str], Architecture]:
    return {(style.planner, style.style): style for style in plug_in}


GROUPS = {_PLANNERS: _sound_planner, _STYLES: _sound_styles, _TASKS: _sound_task_styles}
"""Every entry-point group that plug-ins are loaded from, each with what reads an entry; results depend on all."""
