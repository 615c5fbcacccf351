"""The axes of a section ``explore`` as a file writes them: lists, ranges, and axes that exist for some points only.

::

    relax.iterations: [1, 2, 4]
    fabric.clock: {from: 50 MHz, to: 200 MHz, step: 10 MHz}
    relax.lanes: {values: [1, 2], when: {relax.style: systolic}}
    relax.depth: {from: 1, to: 64, factor: 2, when: {workload.variant: [base, deep]}}

Every other module reads lists under ``explore.axes``, and what axes depend on under ``explore.when``. A document is
brought into that form once, when it is read. Faults stay at the places of the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from codesign.errors import Fault, InputError, choose_hint, clip
from codesign.inputs.document import REMOVED, Document, KeyPath, Origin, put
from codesign.inputs.ranges import KEYS, range_values

WHEN = "when"
VALUES = "values"


def with_listed_axes(document: Document) -> Document:
    """The document of a workload with a list in the place of each axis that is written as a mapping."""
    explore = document.tree.get("explore") if isinstance(document.tree, dict) else None
    if not isinstance(explore, dict):
        return document
    edits: dict[KeyPath, Any] = {}
    sources: dict[KeyPath, KeyPath] = {}
    faults: list[Fault] = []
    refused: list[str] = []
    for place, raw in _mappings(explore):
        axis = str(place[-1])
        try:
            edits[place], sources[place] = _values(raw, place)
        except _RefusedError as refusal:
            fault = document.fault(refusal.path, refusal.what, refusal.hint, at_key=refusal.at_key)
            # A value that is none, such as .nan, has its fault already.
            if not any(each.key.startswith(f"{fault.key}.") for each in document.faults):
                faults.append(fault)
            edits[place], sources[place] = REMOVED, place
            refused.append(axis)
            continue
        if WHEN in raw:
            of_axis: KeyPath = ("explore", WHEN, axis)
            edits[of_axis], sources[of_axis] = raw[WHEN], (*place, WHEN)
    # What depends on a refused axis is not at fault.
    for path, when in edits.items():
        if path[1] == WHEN and isinstance(when, dict):
            edits[path] = {other: values for other, values in when.items() if other not in refused}
    if not edits:
        return document
    listed = put(
        document, edits, lambda path: Origin(sources.get(path, path) if path[1] == WHEN else path, document)
    )
    number = 1 + max(number for number, _ in listed.origins.values())
    values: dict[KeyPath, tuple[int, Origin]] = {
        (*place, index): (number, Origin((*source, index), document))
        for place, source in sources.items()
        if source[-1] == VALUES
        for index in range(len(edits[place]))
    }
    return replace(listed, faults=(*listed.faults, *faults), origins={**listed.origins, **values})


class _RefusedError(Exception):
    """An axis that is written wrongly, and where."""

    def __init__(self, path: KeyPath, what: str, hint: str | None = None, *, at_key: bool = False) -> None:
        super().__init__(what)
        self.path, self.what, self.hint, self.at_key = path, what, hint, at_key


def _mappings(explore: Mapping[str, Any]) -> Iterator[tuple[KeyPath, dict[str, Any]]]:
    """Each axis and condition that is written as a mapping, with its path."""
    for section in ("axes", "conditions"):
        axes = explore.get(section)
        for axis, raw in axes.items() if isinstance(axes, dict) else ():
            if isinstance(raw, dict):
                yield ("explore", section, axis), raw


def _values(raw: Mapping[str, Any], place: KeyPath) -> tuple[list[Any], KeyPath]:
    """The values of an axis, and where they stand.

    Raises:
        _RefusedError: there are none, or it is no range.
    """
    accepted = (VALUES, *KEYS, WHEN)
    for key in raw:
        if key not in accepted:
            raise _RefusedError(
                (*place, key), "unknown key", choose_hint(clip(str(key), 60), accepted), at_key=True
            )
    if WHEN in raw and place[1] == "conditions":
        what = "a condition is met by every design"
        raise _RefusedError((*place, WHEN), what, "leave when out, or make it a decision", at_key=True)
    if WHEN in raw and not isinstance(raw[WHEN], dict):
        raise _RefusedError(
            (*place, WHEN), "is not a mapping", "write {AXIS: VALUE}, or {AXIS: [VALUE, ...]}"
        )
    if WHEN in raw and not raw[WHEN]:
        raise _RefusedError((*place, WHEN), "names no axis", "write {AXIS: VALUE}, or leave it out")
    of_range = {key: each for key, each in raw.items() if key in KEYS}
    if VALUES in raw and of_range:
        what = f"values and {', '.join(of_range)} together"
        raise _RefusedError(place, what, "keep the list, or the range")
    if VALUES in raw:
        if not isinstance(raw[VALUES], list):
            raise _RefusedError(
                (*place, VALUES), "is not a list", "write the values in brackets: [first, second]"
            )
        return raw[VALUES], (*place, VALUES)
    try:
        return range_values(of_range), place
    except InputError as fault:
        raise _RefusedError(place, fault.what, fault.hint) from None
