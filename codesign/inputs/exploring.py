"""An exploration that a command line changes: axes, conditions and needs, checked as in a file, and axes pinned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from codesign.ground.errors import InputError, show
from codesign.inputs.axes import ordered
from codesign.inputs.checks import workload_faults
from codesign.inputs.document import REMOVED, KeyPath, Origin, put
from codesign.inputs.edit import SCENARIO, VARIANT_AXIS, Movable, design_point, moves
from codesign.inputs.exploration import Exploration
from codesign.inputs.faults import validate
from codesign.inputs.platform import Platform
from codesign.inputs.workload import Workload

_CONSTRAINTS: KeyPath = ("explore", "constraints")


def exploring(
    workload: Workload,
    axes: Mapping[str, Mapping[str, Any] | Sequence[Any]],
    conditions: Mapping[str, Mapping[str, Any] | Sequence[Any]],
    needs: Sequence[str] = (),
) -> Workload:
    """The workload with other values of axes and conditions, and with further constraints.

    Args:
        workload: loaded, with or without a section ``explore``.
        axes, conditions: raw values by axis, or ``values`` and what the axis depends on, ``when``. They replace the
            file's values, whether the axis there is a decision or a condition.
        needs: constraints as text.

    Raises:
        InputError: a condition depends on an axis.
        SpecError: every fault, at its option (``--axis relax.block[1]``), or at its place in the file.
    """
    if not (axes or conditions or needs):
        return workload
    written = workload.document.tree.get("explore") or {}
    edits: dict[KeyPath, Any] = {}
    options: dict[KeyPath, str] = {}
    for section, other, values, beside, option in (
        ("axes", "conditions", axes, conditions, "--axis"),
        ("conditions", "axes", conditions, axes, "--condition"),
    ):
        for axis, listed in values.items():
            form = listed if isinstance(listed, Mapping) else {"values": listed}
            edits["explore", section, axis] = list(form["values"])
            if "when" in form and section == "conditions":
                what = "a condition is met by every design"
                raise InputError(what, f"{option} {axis}", "leave when out, or make it a decision")
            if "when" in form or (section == "conditions" and axis in (written.get("when") or {})):
                edits["explore", "when", axis] = form.get("when", REMOVED)
                options["explore", "when", axis] = f"{option} {axis} when"
            if axis in (written.get(other) or {}) and axis not in beside:
                edits["explore", other, axis] = REMOVED
                options["explore", other, axis] = f"{option} {axis}"
            options["explore", section, axis] = f"{option} {axis}"
    kept = written.get("constraints") or []
    if needs:
        edits[_CONSTRAINTS] = [*kept, *needs]

    def origin(path: KeyPath) -> Origin:
        return Origin((options[path],)) if path in options else Origin(path, workload.document)

    document = put(workload.document, edits, origin)
    first = 1 + max((number for number, _ in document.origins.values()), default=-1)
    of_needs = {
        (*_CONSTRAINTS, len(kept) + number): (first + number, Origin((f"--need {show(need)}",)))
        for number, need in enumerate(needs)
    }
    document = replace(document, origins={**document.origins, **of_needs})
    return validate(Workload, document, workload_faults).with_document(document)


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
