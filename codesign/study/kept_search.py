"""The traces of searches in the store of a study: the boxes that they excluded, and what the last search did.

Bounds hold for a study whatever was evaluated since, so the boxes outlive the search. A search is reported later as
when it ended.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, TypeVar

from codesign.ground.errors import StoreError
from codesign.study.blocks import compressed, expanded
from codesign.study.definition import OTHER_VERSION, read_json
from codesign.study.kept import Kept
from codesign.study.search import Searched, Trace
from codesign.study.space import Box, Space
from codesign.study.store import Batch

T = TypeVar("T")
_BOXES, _SEARCHED = "excluded", "searched"


def keep_boxes(kept: Kept, study: str, excluded: Sequence[Box], decisions: Space) -> None:
    """Keep the boxes of a search, unless the boxes of an earlier one hold as many designs.

    ``study``: its key in the store.
    """
    if _designs(excluded) > _designs(boxes_of(kept, study, decisions)):
        _put(kept, f"{_BOXES} {study}", [box.row for box in excluded])


def boxes_of(kept: Kept, study: str, decisions: Space) -> tuple[Box, ...]:
    """The boxes that were kept for a study.

    Raises:
        StoreError: they are none of this space.
    """

    def boxes(rows: Any) -> tuple[Box, ...]:
        return tuple(Box.of_row(row, decisions) for row in rows)

    return _read(kept, f"{_BOXES} {study}", "boxes of a search", boxes) or ()


def keep_search(kept: Kept, study: str, searched: Searched) -> None:
    """Keep what searches did of a study, in the place of earlier ones. ``study``: its key in the store."""
    traces = [
        {each.name: getattr(trace, each.name) for each in fields(trace)}
        | {"excluded": [box.row for box in trace.excluded]}
        for trace in searched.traces
    ]
    if traces:
        record = {"traces": traces, "simulated": searched.simulated, "kept": searched.kept}
        _put(kept, f"{_SEARCHED} {study}", record)


def forget_search(kept: Kept, study: str) -> None:
    """All points are asked for: the study is of no search any more."""
    key = f"{_SEARCHED} {study}"
    if any(True for _ in kept.store.blocks([key])):
        _put(kept, key, None)


def search_of_study(kept: Kept, study: str, decisions: Space, chosen: Sequence[int] | None) -> Searched | None:
    """The last search of a study; None if all points were asked for.

    ``decisions``: all designs. ``chosen``: the designs that the study holds; None: all.

    Raises:
        StoreError: it is none of this space.
    """

    def searched(record: Any) -> Searched | None:
        if record is None:
            return None
        held = range(len(decisions)) if chosen is None else frozenset(chosen)
        traces = tuple(_trace(each, decisions) for each in record["traces"])
        if not traces or any(design not in held for trace in traces for design in trace.designs):
            raise ValueError("a design that the study has not")
        return Searched(traces, _whole(record["simulated"]), _whole(record["kept"]))

    return _read(kept, f"{_SEARCHED} {study}", "a search", searched)


def _designs(excluded: Sequence[Box]) -> int:
    return sum(box.designs for box in excluded)


def _trace(record: Any, decisions: Space) -> Trace:
    name, ended, proved = record["name"], record["ended"], record["proved"]
    enumerated = record["enumerated"]
    if not all(isinstance(text, str) for text in (name, ended, enumerated)) or not isinstance(proved, bool):
        raise TypeError("no name, end or proof")
    return Trace(
        name,
        _whole(record["seed"]),
        [*map(_whole, record["designs"])],
        _whole(record["repeated"]),
        tuple(Box.of_row(row, decisions) for row in record["excluded"]),
        ended,
        proved,
        enumerated,
    )


def _whole(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise TypeError("no whole number")
    return int(value)


def _put(kept: Kept, key: str, record: Any) -> None:
    text = json.dumps(record, separators=(",", ":"), allow_nan=False)
    kept.store.put(Batch(blocks={key: compressed(text.encode())}))


def _read(kept: Kept, key: str, what: str, make: Callable[[Any], T]) -> T | None:
    """The object that ``make`` makes of the record under a key; None if there is none."""
    for _, data in kept.store.blocks([key]):
        try:
            return make(read_json(expanded(data).decode()))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as wrong:
            text = f"holds {what} that this version cannot read"
            raise StoreError(text, kept.where, OTHER_VERSION) from wrong
    return None
