"""The cover of a certificate: its entries are every design of its space, each once."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CertificateError
from codesign.study.certificates.form import MAX_SPACE, Axis, Certificate

Int = NDArray[np.int64]
Shapes = list[tuple[int, ...]]

MAX_DENSE = 100_000_000
"""Most designs of a space that are marked one by one."""

_FEW = 64
_MOST_WORK = 200
HINT = "its front is not proved: write it again, hwsw explore … --certify FILE"


def require(holds: bool, what: str) -> None:
    """Refuse a certificate where something does not hold.

    Raises:
        CertificateError: it does not.
    """
    if not holds:
        raise CertificateError(what, hint=HINT)


def covered(certificate: Certificate) -> NDArray[np.int64]:
    """The number of designs of each entry, int64.

    Raises:
        CertificateError: a design of the space is in no entry, or in two.
    """
    head, columns = certificate.head, certificate.columns
    shapes = _parts(certificate.definition.axes, head.parts)
    ends = [0, *itertools.accumulate(map(math.prod, shapes))]
    require(ends[-1] <= MAX_SPACE, f"its space has more than {MAX_SPACE:,} designs")
    design, part, low, high = (columns[name].astype(np.int64) for name in ("design", "part", "low", "high"))
    require(bool(((design >= 0) & (design < ends[-1])).all()), "a design is outside the space")
    known = (part >= 0) & (part < len(shapes))
    sides = np.array(shapes, np.int64).reshape(len(shapes), low.shape[1])[np.where(known, part, 0)]
    known &= ((low >= 0) & (low < high) & (high <= sides)).all(axis=1)
    require(bool(known.all()), f"box {int(known.argmin())} is outside the space" if len(known) else "")
    dense = ends[-1] <= MAX_DENSE
    (_count_each if dense else _count_apart)(design, part, low, high, shapes, ends)
    return np.concatenate([np.ones(len(design), np.int64), (high - low).prod(axis=1)])


def _count_each(design: Int, part: Int, low: Int, high: Int, shapes: Shapes, ends: list[int]) -> None:
    """Mark every design of the space, each once."""
    taken = np.zeros(ends[-1], np.bool_)
    taken[design] = True
    require(int(taken.sum()) == len(design), "a design stands in two rows")
    for box, (own, first, last) in enumerate(zip(part.tolist(), low.tolist(), high.tolist(), strict=True)):
        inside = taken[ends[own] : ends[own + 1]].reshape(shapes[own])[tuple(map(slice, first, last))]
        require(not inside.any(), f"box {box} holds a design that another entry holds")
        inside[...] = True
    require(bool(taken.all()), f"design {int(taken.argmin())} is in no entry")


def _count_apart(design: Int, part: Int, low: Int, high: Int, shapes: Shapes, ends: list[int]) -> None:
    """Of a space that is too large to mark: entries that do not meet, and are as many designs as the space."""
    of_rows = np.searchsorted(np.array(ends[1:]), design, side="right")
    for own, shape in enumerate(shapes):
        rows = design[of_rows == own] - ends[own]
        places = np.stack(np.unravel_index(rows, shape), axis=1).astype(np.int64)
        first = np.concatenate([places, low[part == own]])
        last = np.concatenate([places + 1, high[part == own]])
        require(_apart(first, last), "two of its entries hold the same design")
        size = sum((last - first).prod(axis=1).tolist())
        require(size == math.prod(shape), f"{math.prod(shape) - size:,} designs of part {own} are in no entry")


def _apart(low: Int, high: Int) -> bool:
    """True if no two boxes meet. They are cut in two, again and again, until few are left to compare."""
    stack, work = [(low, high)], _MOST_WORK * (len(low) + 1)
    while stack:
        low, high = stack.pop()
        work -= len(low)
        require(work > 0, "its boxes lie too much across each other")
        if len(low) <= _FEW:
            apart = ((high[:, None] <= low) | (high <= low[:, None])).any(axis=2)
            if not (apart | np.eye(len(low), dtype=np.bool_)).all():
                return False
            continue
        begins = [np.unique(column) for column in low.T]
        if max(map(len, begins)) == 1:
            return False
        cuts = [own[len(own) // 2] for own in begins]
        larger = [
            max((low[:, axis] < cut).sum(), (high[:, axis] > cut).sum()) if len(begins[axis]) > 1 else len(low) + 1
            for axis, cut in enumerate(cuts)
        ]
        axis = int(np.argmin(larger))
        cut = cuts[axis]
        before, behind = low[:, axis] < cut, high[:, axis] > cut
        clipped = low[behind]
        clipped[:, axis] = np.maximum(clipped[:, axis], cut)
        stack += [(low[before], high[before]), (clipped, high[behind])]
    return True


def _parts(axes: list[Axis], parts: list[dict[str, list[int]]]) -> list[tuple[int, ...]]:
    """The shape of each part, with 1 for an axis that it lacks: together they are the space, each design once."""
    values = {axis.axis: set(range(len(axis.values))) for axis in axes}
    require(len(values) == len(axes), "an axis stands in it twice")
    conditions = [(other, set(held)) for axis in axes for other, held in axis.when.items()]
    known = all(held <= values.get(other, set()) for other, held in conditions)
    require(known, "an axis depends on values that there are not")
    cells, sets = 0, [{name: set(numbers) for name, numbers in part.items()} for part in parts]
    for part, chosen in zip(parts, sets, strict=True):
        sound = list(part) == [name for name in values if name in part] and all(
            own <= values[name] and len(own) == len(part[name]) > 0 for name, own in chosen.items()
        )
        for axis in axes:
            # It exists where all conditions hold: for every value of the part, or for none.
            holds = all(chosen.get(other, {-1}) <= set(held) for other, held in axis.when.items())
            fails = any(not chosen.get(other, set()) & set(held) for other, held in axis.when.items())
            sound = sound and (holds if axis.axis in part else fails)
        require(sound, "a part of its space does not follow from its axes")
        # Of the grid of all axes, a design is as many cells as the axes that it lacks have combinations.
        cells += math.prod(len(part.get(name, own)) for name, own in values.items())
    for one, other in itertools.combinations(sets, 2):
        apart = any(one[name].isdisjoint(other[name]) for name in one.keys() & other.keys())
        require(apart, "two parts of its space hold the same designs")
    require(cells == math.prod(map(len, values.values())), "its parts are not the whole space")
    return [tuple(len(part.get(name, [0])) for name in values) for part in parts]
