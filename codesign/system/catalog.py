"""The planners and architecture styles that are installed, ours and others', found through one group of entry points.

A plug-in that cannot be loaded disables nothing but itself: it is left out with a warning, kept in ``broken``, and
refused where a workload asks for it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, Any

from codesign import inputs as spec
from codesign.ground.errors import Fault, InputError, SpecError, choose_hint
from codesign.ground.models import Task, TaskParameters
from codesign.planners.circuits import CircuitStyle
from codesign.planners.interface import Planner
from codesign.planners.plug_in import PlugIn, Reproduce
from codesign.planners.registered import GROUP, Headlines, is_ours, registered
from codesign.planners.reproduction import Settings
from codesign.planners.styles import Architecture, TaskStyle

if TYPE_CHECKING:
    from codesign.ground.models import SpecModel
    from codesign.inputs import Workload
    from codesign.inputs.files import Source

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
    return tuple(each for each in map(_loaded, range(len(_points()))) if isinstance(each, PlugIn))


@cache
def planners() -> Mapping[str, Planner]:
    """Every installed planner by the name that workloads use."""
    return {each.planner.name: each.planner for each in plug_ins() if each.planner is not None}


def headlines_of(point: EntryPoint) -> Headlines:
    """The names and one-line descriptions that a list has of a plug-in, by kind; none of one that cannot be loaded."""
    plug_in = _loaded(_points().index(point))
    if not isinstance(plug_in, PlugIn):
        return {}
    planner = plug_in.planner
    named = {} if planner is None else {planner.name: planner}
    return {
        "planners": {name: each.description for name, each in named.items()},
        "tasks": {
            f"{name}, {task}": each.task_text(task)
            for name, each in named.items()
            if each.problem_model is None
            for task in Task
        },
        "styles": {
            f"{style.planner}.{style.style}": f"on {style.component_type}: {style.description}"
            for style in plug_in.styles
        },
    }


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
    return tuple(each for each in map(_loaded, range(len(_points()))) if isinstance(each, BrokenPlugIn))


_points = cache(registered)
"""Those of this process."""


@dataclass(frozen=True)
class ByPlanner(Mapping[str, Any]):
    """An attribute of each planner that has it, by the planner's name. Only the planner that is asked for is loaded."""

    attribute: str

    def __getitem__(self, name: str) -> Any:
        for plug_in in _about(name):
            if plug_in.planner is not None and plug_in.planner.name == name:
                value = getattr(plug_in.planner, self.attribute)
                if value is not None:
                    return value
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return (name for name in planners() if name in self)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __bool__(self) -> bool:
        return True


def task_models() -> Mapping[str, Mapping[str, type[TaskParameters]]]:
    """The parameter model of each task of each planner: what ``spec.load_workload`` checks mappings against."""
    return ByPlanner("tasks")


def problem_models() -> Mapping[str, type[SpecModel]]:
    """The models of problems other than a map with goals and starts, by planner."""
    return ByPlanner("problem_model")


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
    for plug_in in _about(name):
        if plug_in.planner is not None and plug_in.planner.name == name:
            return plug_in.planner
    _refuse_broken(name)
    raise InputError(f"no planner is named {name!r}", "planner", choose_hint(name, planners()))


def styles_of(planner_name: str) -> dict[str, Architecture]:
    """The styles of one planner by name.

    Raises:
        InputError: it has none, and those registered under its name cannot be loaded.
    """
    plug_ins = _about(planner_name)
    styles = {each.style: each for plug_in in plug_ins for each in plug_in.styles if each.planner == planner_name}
    if not styles:
        _refuse_broken(planner_name)
    return styles


def task_styles_of(planner_name: str, task: str) -> dict[tuple[str, str], TaskStyle]:
    """The styles of one task placed by itself, by (type of component, style), ours first; none where it cannot be.

    Raises:
        InputError: it has none, and those registered under its planner's name cannot be loaded.
    """
    styles = {
        (each.component_type, each.style): each
        for plug_in in _about(planner_name)
        for each in plug_in.task_styles
        if (each.planner, each.task) == (planner_name, task)
    }
    if not styles:
        _refuse_broken(planner_name)
    return styles


def _refuse_broken(name: str) -> None:
    for plug_in in broken():
        if plug_in.name == name:
            raise InputError(str(plug_in), GROUP, _REMEDY)


def _about(planner_name: str) -> Iterator[PlugIn]:
    """The plug-ins that may have the planner or styles of it.

    One of ours is named as its planner, and has styles of no other. Those of other packages have any name.
    """
    for number, point in enumerate(_points()):
        plug_in = _loaded(number) if point.name == planner_name or not is_ours(point) else None
        if isinstance(plug_in, PlugIn):
            yield plug_in


@cache
def _loaded(number: int) -> PlugIn | BrokenPlugIn:
    """The plug-in of an entry point, by its number among those that are registered."""
    point = _points()[number]
    try:
        plug_in = _sound(point.load())
        _refuse_second(number, plug_in)
    # The code of others: it may raise anything, and one that ends the process must not end ours.
    except (Exception, SystemExit) as fault:
        why = " ".join(f"{type(fault).__name__}: {fault}".split())[:200]
        broken = BrokenPlugIn(point.name, point.value, why)
        _log.warning("%s; it is left out: %s", broken, _REMEDY)
        return broken
    return plug_in


def _refuse_second(number: int, plug_in: PlugIn) -> None:
    """Refuse a plug-in with a name that one before it has: neither may replace the other without a word.

    Raises:
        ValueError: its entry point or its planner has the name of one before it.
    """
    name = _points()[number].name
    planner = plug_in.planner.name if plug_in.planner is not None else None
    for other, point in enumerate(_points()[:number]):
        before = None if is_ours(point) else _loaded(other)
        if isinstance(before, BrokenPlugIn):
            continue
        if point.name == name:
            raise ValueError(f"an entry point {name} is registered already")
        named = point.name if before is None else before.planner.name if before.planner is not None else None
        if planner is not None and planner == named:
            raise ValueError(f"a planner {planner} is registered already")


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
