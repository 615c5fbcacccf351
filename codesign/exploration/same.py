"""Designs that are one: they differ only in axes that change nothing for them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from codesign.exploration.designs import Design, StudyPoint
from codesign.exploration.space import canonical
from codesign.figures import FIGURES
from codesign.inputs.workload import PLACE_KEYS
from codesign.results.result import Result


def same_designs(designs: Sequence[Design]) -> dict[int, tuple[int, ...]]:
    """The designs that are the same as an earlier one, by the first of each kind, as indices.

    Two designs are the same if each axis in which they differ moves nothing that either uses, in any condition, and
    all of their declared figures are equal in every condition. Equal figures alone do not make them the same. A design
    that was not run in every condition is the same as no other: what it would use is not known.

    An axis moves nothing that a point uses if it moves a component or link that did nothing in the run and has no task,
    a task that another design of the study has and this one has not, or a parameter that the style does not use.
    """
    tasks = {task for design in designs for point in design.points for task in _places(point)}
    by_use: dict[str, list[Design]] = {}
    for design in designs:
        idle = _idle_axes(design, tasks)
        if idle is not None:
            used = {name: value for name, value in design.axes.items() if name not in idle}
            by_use.setdefault(canonical([sorted(idle), used]), []).append(design)
    same: dict[int, tuple[int, ...]] = {}
    for group in by_use.values():
        if len(group) > 1:
            same |= _equal_in_figures(group)
    return same


def _equal_in_figures(group: Iterable[Design]) -> dict[int, tuple[int, ...]]:
    by_figures: dict[tuple[Any, ...], list[int]] = {}
    for design in group:
        figures = tuple(point.figure(figure) for point in design.points for figure in FIGURES.values())
        by_figures.setdefault(figures, []).append(design.index)
    return {first: tuple(others) for first, *others in by_figures.values() if others}


def _idle_axes(design: Design, tasks: set[str]) -> frozenset[str] | None:
    """The axes that move nothing that the design uses; None where there are none, or the design was not run."""
    results = [point.result for point in design.points]
    idle = frozenset(design.axes)
    for result in results:
        if result is None or result.utilisation is None or not result.places:
            return None
        idle = frozenset(name for name in idle if _is_idle(name, result, tasks))
        if not idle:
            return None
    return idle


def _is_idle(axis: str, result: Result, tasks: set[str]) -> bool:
    head, _, key = axis.partition(".")
    if head in result.parameters:
        first = key.partition(".")[0]
        return first not in result.parameters[head] and first not in PLACE_KEYS
    if head in tasks:
        return head not in result.places
    busy = (result.utilisation or {}).get(head)
    use = (result.links or {}).get(head)
    serves = (
        head in result.places.values() or head == result.external_memory or head in (result.displays or {})
    )
    return busy == 0 and not serves and (use is None or use.sent == 0)


def _places(point: StudyPoint) -> Iterable[str]:
    return () if point.result is None else point.result.places
