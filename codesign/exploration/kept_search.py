"""What the last search of a study did, in the store: so that it is reported later as when it ended."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from codesign.errors import StoreError
from codesign.exploration.compressed import compressed, expanded
from codesign.exploration.definition import OTHER_VERSION, read_json
from codesign.exploration.kept import Kept
from codesign.exploration.kept_boxes import box_of, row_of
from codesign.exploration.search import Searched, Trace
from codesign.exploration.space import Space
from codesign.exploration.store import Batch


def keep_search(kept: Kept, study: str, searched: Searched) -> None:
    """Keep what searches did of a study, in the place of earlier ones. ``study``: its key in the store."""
    traces = [
        {
            "name": trace.name,
            "seed": trace.seed,
            "designs": trace.designs,
            "repeated": trace.repeated,
            "excluded": [*map(row_of, trace.excluded)],
            "ended": trace.ended,
            "proved": trace.proved,
            "enumerated": trace.enumerated,
        }
        for trace in searched.traces
    ]
    if traces:
        _put(kept, study, {"traces": traces, "simulated": searched.simulated, "kept": searched.kept})


def forget_search(kept: Kept, study: str) -> None:
    """All points are asked for: the study is of no search any more."""
    if any(True for _ in kept.store.blocks([_key(study)])):
        _put(kept, study, None)


def search_of_study(
    kept: Kept, study: str, decisions: Space, chosen: Sequence[int] | None
) -> Searched | None:
    """What the last search did; None where all points were asked for.

    ``decisions``: all designs. ``chosen``: those that the study holds; None: all.

    Raises:
        StoreError: it is none of this space.
    """
    for _, data in kept.store.blocks([_key(study)]):
        try:
            return _read(read_json(expanded(data).decode()), decisions, chosen)
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as wrong:
            what = "holds a search that this version cannot read"
            raise StoreError(what, kept.where, OTHER_VERSION) from wrong
    return None


def _read(record: Any, decisions: Space, chosen: Sequence[int] | None) -> Searched | None:
    if record is None:
        return None
    held = range(len(decisions)) if chosen is None else frozenset(chosen)
    traces = tuple(_trace(each, decisions) for each in record["traces"])
    if not traces or any(design not in held for trace in traces for design in trace.designs):
        raise ValueError("a design that the study has not")
    return Searched(traces, _whole(record["simulated"]), _whole(record["kept"]))


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
        tuple(box_of(row, decisions) for row in record["excluded"]),
        ended,
        proved,
        enumerated,
    )


def _whole(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise TypeError("no whole number")
    return int(value)


def _key(study: str) -> str:
    return f"searched {study}"


def _put(kept: Kept, study: str, record: Any) -> None:
    text = json.dumps(record, separators=(",", ":"), allow_nan=False)
    kept.store.put(Batch(blocks={_key(study): compressed(text.encode())}))
