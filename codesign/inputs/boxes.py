"""The parts of a space. An axis may exist for some values of other axes only; a part is where the same axes exist."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codesign.errors import choose_hint, clip, show
from codesign.models import RefusalError

MAX_PARTS = 1000

Values = Mapping[str, Sequence[Any]]
"""The values of each axis, in order."""

When = Mapping[str, Mapping[str, Sequence[Any]]]
"""Axis → other axis → the values of the other for which the axis exists. An axis that is not named always exists."""


@dataclass(frozen=True)
class Part:
    """Points with the same axes: every combination of these values, the last axis moving fastest.

    - ``begin``: the place of the first point in the enumeration. ``size``: how many points there are.
    - ``axes``: the numbers of the values, of each axis that exists.
    """

    begin: int
    axes: Mapping[str, tuple[int, ...]]

    @property
    def size(self) -> int:
        """The number of points."""
        return math.prod(map(len, self.axes.values()))


def parts_of(axes: Values, when: When) -> tuple[Part, ...]:
    """The parts, which together hold each point once.

    Args:
        axes: every axis behind those that its existence depends on (``ordered``).
        when: see ``When``; sound (``refusals``).

    Raises:
        RefusalError: there are more than ``MAX_PARTS``.
    """
    allowed = {
        axis: {other: _numbers(axes[other], values) for other, values in conditions.items()}
        for axis, conditions in when.items()
    }
    classes = {axis: _classes(len(values), axis, allowed) for axis, values in axes.items()}
    parts: list[Part] = []
    begin = 0
    for numbers in _combined(classes, allowed, list(axes), {}):
        parts.append(Part(begin, numbers))
        begin += parts[-1].size
        if len(parts) > MAX_PARTS:
            what = f"more than {MAX_PARTS:,} combinations of conditions on axes"
            raise RefusalError(what, "let fewer axes depend on each other")
    return tuple(parts)


_Allowed = Mapping[str, Mapping[str, Collection[int]]]
"""As ``When``, with the numbers of the values."""


def _combined(
    classes: Mapping[str, list[tuple[int, ...]]],
    allowed: _Allowed,
    names: list[str],
    chosen: dict[str, tuple[int, ...]],
) -> Iterator[dict[str, tuple[int, ...]]]:
    """The numbers of the values in each part, the first axis moving slowest."""
    if not names:
        yield dict(chosen)
        return
    axis, *rest = names
    conditions = allowed.get(axis, {})
    # All values of a class are alike to every condition.
    if not all(other in chosen and chosen[other][0] in numbers for other, numbers in conditions.items()):
        yield from _combined(classes, allowed, rest, chosen)
        return
    for numbers in classes[axis]:
        yield from _combined(classes, allowed, rest, {**chosen, axis: numbers})


def _classes(count: int, axis: str, allowed: _Allowed) -> list[tuple[int, ...]]:
    """The numbers of the values of an axis, parted by the axes that exist for them."""
    of_axis = [conditions[axis] for conditions in allowed.values() if axis in conditions]
    classes: dict[tuple[bool, ...], list[int]] = {}
    for number in range(count):
        classes.setdefault(tuple(number in numbers for numbers in of_axis), []).append(number)
    return [tuple(numbers) for numbers in classes.values()]


def _numbers(values: Sequence[Any], chosen: Sequence[Any]) -> set[int]:
    texts = set(map(value_text, chosen))
    return {number for number, value in enumerate(values) if value_text(value) in texts}


def value_text(value: Any) -> str:
    """The text by which values of an axis are compared."""
    return json.dumps(value, sort_keys=True)


def ordered(axes: Collection[str], when: Mapping[str, Collection[str]]) -> list[str]:
    """The axes in their order, but each behind those that its existence depends on; of a circle, as they are."""
    order: list[str] = []
    waiting = list(axes)
    while waiting:
        free = [axis for axis in waiting if not set(when.get(axis, ())) & set(waiting)]
        order.append(free[0] if free else waiting[0])
        waiting.remove(order[-1])
    return order


def listed(raw: Any, values: Sequence[Any]) -> tuple[Any, ...]:
    """The values that one value, or a list of values, of an axis names: ``base`` or ``[base, on-host]``."""
    one = value_text(raw) in set(map(value_text, values))
    return tuple(raw) if isinstance(raw, list | tuple) and not one else (raw,)


def refusals(axes: Values, when: When) -> list[tuple[str, RefusalError]]:
    """What is wrong with the existence of each axis, by the axis."""
    wrong = []
    for axis, conditions in when.items():
        if axis not in axes:
            what = f"when {clip(axis)}: there is no such axis among the decisions"
            wrong.append((axis, RefusalError(what, choose_hint(clip(axis, 60), axes))))
        for other, values in conditions.items():
            refusal = _refusal(axis, other, values, axes)
            if refusal is not None:
                wrong.append((axis, refusal))
    if not wrong:
        wrong = [(axis, _circle(axis)) for axis in in_circle(axes, when)]
    return wrong or [(axis, _never(axis)) for axis in _nowhere(axes, when)]


def _refusal(axis: str, other: str, values: Sequence[Any], axes: Values) -> RefusalError | None:
    at = ("when", other)
    if other == axis:
        return RefusalError("an axis does not depend on itself", "name another axis", at)
    if other not in axes:
        hint = choose_hint(clip(other, 60), [name for name in axes if name != axis])
        return RefusalError("there is no such axis among the decisions", hint, at)
    known = set(map(value_text, axes[other]))
    strange = [value for value in values if value_text(value) not in known]
    if values and not strange:
        return None
    what = f"{show(strange[0])} is no value of axis {other}" if values else "names no value"
    word = clip(str(strange[0]), 60) if strange else ""
    return RefusalError(what, choose_hint(word, map(str, axes[other])), at)


def in_circle(axes: Collection[str], when: Mapping[str, Collection[str]]) -> list[str]:
    """The first axis that depends on itself by others; none where no axis does."""
    order = ordered(axes, when)
    place = {axis: number for number, axis in enumerate(order)}
    return [
        axis for axis in order if any(place.get(other, -1) >= place[axis] for other in when.get(axis, ()))
    ][:1]


def _circle(axis: str) -> RefusalError:
    what = f"{axis} depends on an axis that depends on it"
    return RefusalError(what, "leave one of the conditions out", ("when",))


def _nowhere(axes: Values, when: When) -> list[str]:
    """The axes that exist for no point."""
    order = ordered(axes, when)
    parts = parts_of({axis: axes[axis] for axis in order}, when)
    return [axis for axis in when if not any(axis in part.axes for part in parts)]


def _never(axis: str) -> RefusalError:
    what = f"no point has axis {axis}: its conditions contradict each other"
    return RefusalError(what, "leave one of them out", ("when",))


def settled(axes: Values, when: When, values: Mapping[str, Any]) -> dict[str, dict[str, Sequence[Any]]]:
    """What is left of ``when`` for the axes that may still exist, after some axes were given a value each.

    Axes that cannot exist with these values are not in the answer, nor are those that were given one; all others are,
    though with an empty mapping where nothing is left to depend on.
    """
    left: dict[str, dict[str, Sequence[Any]]] = {}
    for axis in ordered(axes, when):
        if axis in values:
            continue
        conditions = when.get(axis, {})
        kept = {other: chosen for other, chosen in conditions.items() if other not in values}
        met = all(
            value_text(values[other]) in set(map(value_text, chosen))
            for other, chosen in conditions.items()
            if other in values
        )
        if met and all(other in left for other in kept):
            left[axis] = kept
    return left
