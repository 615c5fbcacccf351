"""Axes settled at one value for all points of an exploration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from codesign.inputs.axes import ordered
from codesign.inputs.document import KeyPath, Origin, put
from codesign.inputs.edit import SCENARIO, VARIANT_AXIS, Movable, design_point, moves
from codesign.inputs.exploration import Exploration
from codesign.inputs.platform import Platform
from codesign.inputs.workload import Workload


def pin(
    platform: Platform, workload: Workload, values: Mapping[str, Any], by: str = "point: "
) -> tuple[Platform, Workload]:
    """The specs with values put in, and their exploration kept without the axes that these values settle.

    Where variants are explored, a value in mapping or scenario stays as an axis of one value: each variant brings its
    own, and what is settled holds in all of them.

    Raises:
        SpecError: as ``design_point``, of any variant explored too.
    """
    moved_platform, point = design_point(platform, workload, values, by)
    section = workload.explore
    if section is not None:
        variants = () if VARIANT_AXIS in values else section.axes.get(VARIANT_AXIS, ())
        for name in variants:
            of_variant = {axis: value for axis, value in values.items() if _exists_in(section, axis, name)}
            design_point(platform, workload, {VARIANT_AXIS: name, **of_variant}, f"variant {name}: {by}")
        movable = Movable.of(platform, workload.document)
        held = {
            axis: value
            for axis, value in values.items()
            if variants and (moves(axis, SCENARIO) or movable.section(axis.partition(".")[0]) == "mapping")
        }
        section = _held_axes(section, movable, values, held)
    return moved_platform, point.model_copy(update={"explore": section})


def held(workload: Workload, values: Mapping[str, Any], by: str = "point: ") -> Workload:
    """The workload with each value in the place of its axis, as an axis of one value.

    Over several platforms, what is settled holds on each of them.

    Args:
        workload: with or without a section ``explore``.
        values, by: as for ``design_point``. Whether they are accepted, the exploration checks.
    """
    if not values:
        return workload
    section = _held_axes(workload.explore or Exploration(), Movable.of(None, workload.document), values, values)
    rest = {axis: listed for axis, listed in section.axes.items() if axis not in values}
    edits: dict[KeyPath, Any] = {("explore", "axes"): {axis: list(listed) for axis, listed in rest.items()}}
    edits["explore", "when"] = section.when_as_written
    document = put(workload.document, edits, lambda path: Origin(path, workload.document))
    edits = {("explore", "axes", axis): [value] for axis, value in values.items()}
    document = put(document, edits, lambda path: Origin((f"{by}{path[-1]}",)))
    # The value is the first of its axis, and is reported as the axis itself.
    first = {(*path, 0): (len(document.origins) + 1, Origin((f"{by}{path[-1]}",))) for path in edits}
    document = replace(document, origins={**document.origins, **first})
    return workload.model_copy(update={"explore": section}).with_document(document, workload)


def _exists_in(section: Exploration, axis: str, variant: Any) -> bool:
    """True if an axis exists for points of a variant."""
    return variant in section.when.get(axis, {}).get(VARIANT_AXIS, (variant,))


def _held_axes(
    section: Exploration, movable: Movable, values: Mapping[str, Any], held: Mapping[str, Any]
) -> Exploration:
    """The exploration with axes settled; the axes of ``held`` stay, first, with one value each."""
    # A role and the name that fills it are one axis.
    paths = {movable.path(axis): value for axis, value in values.items()}
    named = {axis: paths[movable.path(axis)] for axis in section.every_axis if movable.path(axis) in paths}
    gone = {**values, **named}
    left = section.settled(gone)
    # Those settled come first: an axis may move a key inside of one of them.
    axes = {axis: (value,) for axis, value in held.items()} | left.axes
    kept = {
        axis: {other: listed for other, listed in section.when[axis].items() if other not in gone}
        for axis in held
        if axis in section.when
    }
    when = {axis: conditions for axis, conditions in {**kept, **left.when}.items() if conditions}
    order = ordered(axes, when)
    return left.model_copy(update={"axes": {axis: axes[axis] for axis in order}, "when": when})
