"""The boxes that searches excluded, in the store: bounds hold for a study whatever was evaluated since."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

from codesign.errors import StoreError
from codesign.exploration.compressed import compressed, expanded
from codesign.exploration.definition import OTHER_VERSION, read_json
from codesign.exploration.kept import Kept
from codesign.exploration.search import ExcludedBox
from codesign.exploration.space import Space
from codesign.exploration.store import Batch


def keep_boxes(kept: Kept, study: str, excluded: Sequence[ExcludedBox], decisions: Space) -> None:
    """Keep the boxes of a search, unless those of an earlier one hold as many designs.

    ``study``: its key in the store.
    """
    if _designs(excluded) > _designs(boxes_of(kept, study, decisions)):
        kept.store.put(Batch(blocks={_key(study): _packed(excluded)}))


def boxes_of(kept: Kept, study: str, decisions: Space) -> tuple[ExcludedBox, ...]:
    """The boxes that were kept for a study.

    Raises:
        StoreError: they are none of this space.
    """
    for _, data in kept.store.blocks([_key(study)]):
        try:
            return tuple(box_of(row, decisions) for row in read_json(expanded(data).decode()))
        except (ValueError, TypeError, AttributeError, RecursionError) as wrong:
            what = "holds boxes of a search that this version cannot read"
            raise StoreError(what, kept.where, OTHER_VERSION) from wrong
    return ()


def _designs(excluded: Sequence[ExcludedBox]) -> int:
    return sum(box.designs for box in excluded)


def _key(study: str) -> str:
    return f"excluded {study}"


def _packed(excluded: Sequence[ExcludedBox]) -> bytes:
    rows = [*map(row_of, excluded)]
    return compressed(json.dumps(rows, separators=(",", ":"), allow_nan=False).encode())


def row_of(box: ExcludedBox) -> list[Any]:
    """A box as JSON has it."""
    return [box.part, box.low, box.high, box.bound, box.by, box.why]


def box_of(row: Any, decisions: Space) -> ExcludedBox:
    """The box that ``row_of`` wrote.

    Raises:
        ValueError, TypeError, AttributeError: it is none of this space.
    """
    part, low, high, bound, by, why = row
    numbers = [part, *low, *high, *([] if by is None else [by])]
    if any(type(number) is not int for number in numbers) or not isinstance(why, str):
        raise TypeError("a box of what is no number")
    last = decisions.boxes[-1]
    if not 0 <= part < len(decisions.boxes) or not 0 <= (by or 0) < last.begin + last.size:
        raise ValueError("a box outside the space")
    sizes = map(len, decisions.boxes[part].axes.values())
    if any(not 0 <= one < other <= size for one, other, size in zip(low, high, sizes, strict=True)):
        raise ValueError("a box outside the space")
    values = None if bound is None else {str(name): float(value) for name, value in bound.items()}
    if values is not None and not all(map(math.isfinite, values.values())):
        raise ValueError("a bound that is no number")
    return ExcludedBox(part, tuple(low), tuple(high), values, by, why)
