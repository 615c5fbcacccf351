"""The planners and architecture styles that are installed, ours and others', found through one group of entry points.

A plug-in that cannot be loaded disables nothing but itself: it is left out with a warning, kept in ``broken``, and
refused where a workload asks for it.
"""

from __future__ import annotations

import logging
from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from codesign import inputs as spec
from codesign.ground.errors import Fault, InputError, SpecError, choose_hint
from codesign.ground.models import TaskParameters
from codesign.inputs import SpecModel, Workload
from codesign.inputs.files import Source
from codesign.planners.circuits import CircuitStyle
from codesign.planners.interface import Planner
from codesign.planners.plug_in import GROUP, PlugIn, Reproduce
from codesign.planners.reproduction import Settings
from codesign.planners.styles import Architecture, TaskStyle

_log = logging.getLogger(__name__)

_REMEDY = "mend or uninstall the package that registers it"


@dataclass(frozen=True)
class BrokenPlugIn:
    """A plug-in that cannot be loaded: the entry point's ``name`` and ``value``, and ``why``."""

    name: str
    value: str
    why: str

    def __str__(self) -> str:
        return f"plug-in {self.name} ({self.value}) cannot be loaded: {self.why}"


def plug_ins() -> tuple[PlugIn, ...]:
    """Every installed plug-in, ours first; without those that cannot be loaded."""
    return tuple(_loaded()[0].values())


@cache
def planners() -> Mapping[str, Planner]:
    """Every installed planner by the name that workloads use."""
    return {each.planner.name: each.planner for each in plug_ins() if each.planner is not None}


@cache
def architectures() -> Mapping[tuple[str, str], Architecture]:
    """Every installed architecture style by (planner, style)."""
    return {(style.planner, style.style): style for each in plug_ins() for style in each.styles}


@cache
def task_styles() -> Mapping[tuple[str, str, str, str], TaskStyle]:
    """Every installed style of a task placed by itself, by (planner, task, type of component, style)."""
    return {
        (style.planner, style.task, style.component_type, style.style): style
        for each in plug_ins()
        for style in each.task_styles
    }


@cache
def circuits() -> Mapping[tuple[str, str, str], CircuitStyle]:
    """Every installed circuit by (planner, style, task); the task is "" for the planning task."""
    return {(each.planner, each.style, each.task): each for plug_in in plug_ins() for each in plug_in.circuits}


def papers() -> dict[str, Reproduce]:
    """The parts that hold the model against a paper, by planner."""
    papers = {each.planner.name: each.reproduce for each in plug_ins() if each.planner is not None}
    return {name: reproduce for name, reproduce in papers.items() if reproduce is not None}


def paper_settings(name: str) -> type[Settings]:
    """The model of the settings of a paper's runs, by its planner."""
    return next(
        (each.settings for each in plug_ins() if each.planner is not None and each.planner.name == name), Settings
    )


def broken() -> tuple[BrokenPlugIn, ...]:
    """The plug-ins that are registered and cannot be loaded."""
    return _loaded()[1]


def registered() -> tuple[EntryPoint, ...]:
    """The entry points of all installed plug-ins: ours first, then by name."""
    points = entry_points(group=GROUP)
    return tuple(sorted(points, key=lambda point: (not point.value.startswith("codesign."), point.name, point.value)))


def task_models() -> dict[str, Mapping[str, type[TaskParameters]]]:
    """The parameter model of each task of each planner: what ``spec.load_workload`` checks mappings against."""
    return {name: planner.tasks for name, planner in planners().items()}


def problem_models() -> dict[str, type[SpecModel]]:
    """The models of problems other than a map with goals and starts, by planner."""
    models = {name: planner.problem_model for name, planner in planners().items()}
    return {name: model for name, model in models.items() if model is not None}


def load_workload(source: Source) -> Workload:
    """The workload of that shipped name, file, YAML text or dict, checked against the installed planners.

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
        if fault.key == "planner" and repr(plug_in.name) in fault.what:
            return replace(fault, what=str(plug_in), hint=_REMEDY)
    return fault


def planner(name: str) -> Planner:
    """The planner of that name.

    Raises:
        InputError: no such planner is installed, or it cannot be loaded.
    """
    installed = planners()
    _refuse_broken(name, installed)
    if name not in installed:
        raise InputError(f"no planner is named {name!r}", "planner", choose_hint(name, installed))
    return installed[name]


def styles_of(planner_name: str) -> dict[str, Architecture]:
    """The styles of one planner by name.

    Raises:
        InputError: it has none, and those registered under its name cannot be loaded.
    """
    styles = {name: style for (planner, name), style in architectures().items() if planner == planner_name}
    if not styles:
        _refuse_broken(planner_name, ())
    return styles


def task_styles_of(planner_name: str, task: str) -> dict[tuple[str, str], TaskStyle]:
    """The styles of one task placed by itself, by (type of component, style), ours first; none where it cannot be.

    Raises:
        InputError: it has none, and those registered under its planner's name cannot be loaded.
    """
    styles = {
        (component_type, name): style
        for (*of, component_type, name), style in task_styles().items()
        if of == [planner_name, task]
    }
    if not styles:
        _refuse_broken(planner_name, ())
    return styles


def _refuse_broken(name: str, installed: Container[str]) -> None:
    for plug_in in broken():
        if plug_in.name == name and name not in installed:
            raise InputError(str(plug_in), GROUP, _REMEDY)


@cache
def _loaded() -> tuple[dict[str, PlugIn], tuple[BrokenPlugIn, ...]]:
    """The plug-ins that the entry points stand for, by the name of the entry point; and those that are broken."""
    loaded: dict[str, PlugIn] = {}
    failed: list[BrokenPlugIn] = []
    for point in registered():
        try:
            plug_in = _sound(point.load())
            _refuse_second(point, plug_in, loaded)
            loaded[point.name] = plug_in
        # The code of others: it may raise anything, and one that ends the process must not end ours.
        except (Exception, SystemExit) as fault:
            why = " ".join(f"{type(fault).__name__}: {fault}".split())[:200]
            failed.append(BrokenPlugIn(point.name, point.value, why))
            _log.warning("%s; it is left out: %s", failed[-1], _REMEDY)
    return loaded, tuple(failed)


def _refuse_second(point: EntryPoint, plug_in: PlugIn, loaded: Mapping[str, PlugIn]) -> None:
    """Refuse a plug-in with a name that another one has: neither may replace the other without a word.

    Raises:
        ValueError: its entry point or its planner has the name of one that is loaded.
    """
    if point.name in loaded:
        raise ValueError(f"an entry point {point.name} is registered already")
    planners = {each.planner.name for each in loaded.values() if each.planner is not None}
    if plug_in.planner is not None and plug_in.planner.name in planners:
        raise ValueError(f"a planner {plug_in.planner.name} is registered already")


def _sound(plug_in: Any) -> PlugIn:
    """The plug-in, once it has answered everything that it is asked when a workload is read.

    Raises:
        TypeError: it is no ``PlugIn``.
    """
    if not isinstance(plug_in, PlugIn):
        raise TypeError(f"a {type(plug_in).__name__} is registered, not a codesign.plugin.PlugIn")
    planner = plug_in.planner
    if planner is not None:
        dict(planner.tasks), planner.problem_model, planner.planning_task
    return plug_in
