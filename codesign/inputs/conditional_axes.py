"""What the axes of a raw workload depend on, for checks that do not wait for sound axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from codesign.inputs.boxes import in_circle, listed, refusals
from codesign.inputs.document import Document, KeyPath
from codesign.inputs.edit import PLATFORM_AXIS, VARIANT_AXIS, Movable


def conditions_of(document: Document, axis: str, axes: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """The other axes that an axis depends on, with the values for which it exists, as far as they can be read."""
    explore = document.tree.get("explore")
    when = explore.get("when") if isinstance(explore, dict) else None
    if not isinstance(when, dict) or axis not in when:
        return {}
    if not all(isinstance(each, dict) for each in when.values()) or in_circle(axes, when):
        return {}
    chosen = {other: listed(raw, axes[other]) for other, raw in when[axis].items() if other in axes}
    return {other: values for other, values in chosen.items() if values}


def is_unsound(document: Document, axis: str, axes: Mapping[str, Any]) -> bool:
    """Whether what an axis depends on is at fault: it may not exist where the axis does not fit."""
    explore = document.tree.get("explore")
    when = explore.get("when") if isinstance(explore, dict) else None
    if not isinstance(when, dict) or axis not in when:
        return False
    lists = {name: values if isinstance(values, list) else [] for name, values in axes.items()}
    mappings = isinstance(when[axis], dict) and all(isinstance(each, dict) for each in when.values())
    if not mappings or in_circle(axes, when):
        return True
    chosen = {other: listed(raw, lists.get(other, ())) for other, raw in when[axis].items()}
    return any(name == axis for name, _ in refusals(lists, {axis: chosen}))


def settings_of(document: Document, axis: str, axes: Mapping[str, Any]) -> dict[str, Any]:
    """The first values of other axes for which an axis exists; those of platform and variant left out."""
    settings: dict[str, Any] = {}
    for other, values in conditions_of(document, axis, axes).items():
        settings |= settings_of(document, other, axes)
        if other not in (VARIANT_AXIS, PLATFORM_AXIS):
            settings[other] = values[0]
    return settings


def edits_of(movable: Movable, values: Mapping[str, Any]) -> dict[KeyPath, Any]:
    """What puts values in the places of axes, of those that move the same section as the last one."""
    *_, last = values
    section = movable.path(last)[0]
    edits: dict[KeyPath, Any] = {}
    for axis, value in values.items():
        edits |= movable.edits(axis, value) if movable.path(axis)[0] == section else {}
    return edits
