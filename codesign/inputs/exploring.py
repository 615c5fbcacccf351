"""An exploration that a command line changes: axes, conditions and needs in the workload, checked as in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from codesign.ground.errors import InputError, show
from codesign.inputs.checks import workload_faults
from codesign.inputs.document import REMOVED, KeyPath, Origin, put
from codesign.inputs.faults import validate
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
