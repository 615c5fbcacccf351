"""Whether the entries of a certificate are every design of its space, each once."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from codesign.certificates.form import MAX_SPACE, Axis, Certificate
from codesign.errors import CertificateError

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
    axes, head, columns = certificate.definition.axes, certificate.head, certificate.columns
    shapes = _parts(axes, head.parts)
    ends = [0, *itertools.accumulate(map(math.prod, shapes))]
    require(ends[-1] <= MAX_SPACE, f"its space has more than {MAX_SPACE:,} designs")
    design, claim = columns["design"], columns["claim"]
    require(bool(((design >= 0) & (design < ends[-1])).all()), "a design is outside the space")
    taken = np.zeros(ends[-1], np.bool_)
    taken[design] = True
    require(int(taken.sum()) == len(design), "a design stands in two rows")
    sizes = np.ones(len(claim), np.int64)
    for box in range(head.boxes):
        part, low, high = (columns[name][box].tolist() for name in ("part", "low", "high"))
        known = 0 <= part < len(shapes) and all(
            0 <= first < last <= count for first, last, count in zip(low, high, shapes[part], strict=True)
        )
        require(known, f"box {box} is outside the space")
        inside = taken[ends[part] : ends[part + 1]].reshape(shapes[part])[tuple(map(slice, low, high))]
        require(not inside.any(), f"box {box} holds a design that another entry holds")
        inside[...] = True
        sizes[head.rows + box] = inside.size
    require(bool(taken.all()), f"design {int(taken.argmin())} is in no entry")
    return sizes


def _parts(axes: list[Axis], parts: list[dict[str, list[int]]]) -> list[tuple[int, ...]]:
    """The shape of each part, with 1 for an axis that it lacks: together they are the space, each design once."""
    values = {axis.axis: set(range(len(axis.values))) for axis in axes}
    require(len(values) == len(axes), "an axis stands in it twice")
    cells = 0
    for part in parts:
        chosen = {name: set(numbers) for name, numbers in part.items()}
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
    for one, other in itertools.combinations(parts, 2):
        apart = any(not set(one[name]) & set(other[name]) for name in one.keys() & other.keys())
        require(apart, "two parts of its space hold the same designs")
    require(cells == math.prod(map(len, values.values())), "its parts are not the whole space")
    return [tuple(len(part.get(name, [0])) for name in values) for part in parts]
