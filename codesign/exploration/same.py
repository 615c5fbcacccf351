"""Designs that are one: they differ only in axes that change nothing for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.exploration.constraints import figure_of
from codesign.exploration.space import canonical
from codesign.figures import FIGURES
from codesign.inputs.workload import PLACE_KEYS
from codesign.pricing.price import PRICED
from codesign.results.result import Result

if TYPE_CHECKING:
    from codesign.exploration.study import Study

Indices = NDArray[np.intp]


def first_of_same(study: Study) -> Indices:
    """For each design the first one that is the same: itself where no earlier one is.

    Two designs are the same if each axis in which they differ moves nothing that either uses, in any condition, and
    all of their declared figures are equal in every condition. Equal figures alone do not make them the same. A design
    that was not run in every condition is the same as no other: what it would use is not known.

    An axis moves nothing that a point uses if it moves a component or link that did nothing in the run and has no task,
    a task that another design of the study has and this one has not, or a parameter that the style does not use.
    """
    first = np.arange(study.judged.count)
    idle = _idle_axes(study)
    held = np.flatnonzero(idle.any(axis=1))
    # By the axes that are idle, and by the values of the others.
    keys = [np.unique(idle[held], axis=0, return_inverse=True)[1].reshape(-1)] if len(held) else []
    levels = study.decisions.levels(held)
    for number, name in enumerate(study.axes):
        keys.append(np.where(idle[held, number], -1, first_of_equals(study.axes[name])[levels[name]]))
    held, keys = _several(held, keys)
    if not len(held):
        return first
    keys += [column[held] for column in _figure_columns(study)]
    group = _groups(keys)
    _, firsts = np.unique(group, return_index=True)
    first[held] = held[firsts][group]
    return first


def first_of_equals(values: Sequence[Any]) -> Indices:
    """For each value the number of the first one that is equal as JSON; behind them -1, where there is no value."""
    texts = list(map(canonical, values))
    return np.array([*map(texts.index, texts), -1], np.intp)


def _several(held: Indices, keys: Sequence[NDArray[Any]]) -> tuple[Indices, list[NDArray[Any]]]:
    """Those designs whose keys another one has too, and their keys in one column."""
    if not len(held):
        return held, []
    group = _groups(keys)
    several = np.bincount(group)[group] > 1
    return held[several], [group[several]]


def _groups(keys: Sequence[NDArray[Any]]) -> Indices:
    """The number of the group of equal rows of each row. Missing figures (NaN) are equal."""
    order = np.lexsort(tuple(keys))
    differs = np.zeros(len(order), np.bool_)
    for key in keys:
        left, right = key[order[:-1]], key[order[1:]]
        differs[1:] |= (left != right) & ~(np.isnan(left) & np.isnan(right))
    group = np.empty(len(order), np.intp)
    group[order] = np.cumsum(differs)
    return group


def _figure_columns(study: Study) -> list[NDArray[Any]]:
    """Columns that are equal where all declared figures of designs are, in every condition."""
    outcomes, judged = study.outcomes, study.judged
    numbers: dict[tuple[float | None, ...], int] = {}
    fixed = [figure for figure in FIGURES.values() if figure.name not in PRICED]

    def number(template: Result) -> int:
        return numbers.setdefault(tuple(figure_of(template, figure) for figure in fixed), len(numbers))

    columns = [judged.by_design(outcomes.each(number, -1))]
    columns += [judged.by_design(outcomes.figures[name]) for name in PRICED]
    return [column[:, condition] for column in columns for condition in range(judged.conditions)]


def _idle_axes(study: Study) -> NDArray[np.bool_]:
    """Which axes move nothing that a design uses: designs × axes; none of a design that was not run."""
    outcomes, judged, names = study.outcomes, study.judged, tuple(study.axes)
    tasks = {task for number in outcomes.used() for task in outcomes.templates[number].places}
    rows = [
        [
            bool(template.utilisation is not None and template.places) and _is_idle(name, template, tasks)
            for name in names
        ]
        for template in outcomes.templates
    ]
    table = np.array([*rows, [False] * len(names)], np.bool_).reshape(len(rows) + 1, len(names))
    if not table.any():
        return np.zeros((judged.count, len(names)), np.bool_)
    idle = np.ones((judged.count, len(names)), np.bool_)
    for which in judged.by_design(outcomes.which).T:
        idle &= table[which]
    return idle


def _is_idle(axis: str, result: Result, tasks: set[str]) -> bool:
    head, _, key = axis.partition(".")
    head = result.roles.get(head, head)
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
