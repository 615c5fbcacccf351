"""Exact fields of unsigned fixed-point values, at any precision.

A value h with p fractional bits is the integer h in 0..2^p: p + 1 bits, so that a goal (the value 1) is 2^p.
Beyond 63 bits no machine integer holds it. So a :class:`Field` keeps the whole map as 64-bit limbs, least significant
first, and makes Python integers only on request.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError

LIMB_BITS = 64


def limbs_needed(precision: int) -> int:
    """Limbs that hold 0..2^precision.

    >>> limbs_needed(63), limbs_needed(64)
    (1, 2)
    """
    return precision // LIMB_BITS + 1


@dataclass(frozen=True, eq=False)
class Field:
    """The values of a whole map at one precision.

    Attributes:
        limbs: uint64, rows × columns × limbs, least significant limb first; read-only.
        precision: fractional bits p; every value lies in 0..2^p.
    """

    limbs: NDArray[np.uint64]
    precision: int

    def __post_init__(self) -> None:
        if self.limbs.ndim != 3 or self.limbs.shape[2] != limbs_needed(self.precision):
            raise InputError(f"limbs of shape {self.limbs.shape} cannot hold precision {self.precision}", "limbs")
        self.limbs.flags.writeable = False

    @classmethod
    def from_ints(cls, values: Any, precision: int) -> Self:
        """The field of an integer array (rows × columns; any integer type, or objects of Python int).

        Raises InputError for anything but integers in 0..2^precision.
        """
        array = np.asarray(values)
        if array.ndim != 2:
            raise InputError(f"values have {array.ndim} dimensions, not 2", "values")
        if array.dtype.kind not in "iuO" or not all(
            isinstance(value, int | np.integer) for value in (array.flat if array.dtype == object else ())
        ):
            raise InputError(f"values of type {array.dtype} are not integers", "values", "give integers in 0..2^p")
        exact = np.frompyfunc(int, 1, 1)(array)
        lowest, highest = min(exact.flat, default=0), max(exact.flat, default=0)
        if lowest < 0 or highest > 1 << precision:
            at_fault = lowest if lowest < 0 else highest
            raise InputError(f"value {at_fault} is outside 0..2^{precision}", "values", "values have p fractional bits")
        limbs = np.empty((*array.shape, limbs_needed(precision)), np.uint64)
        for index in range(limbs.shape[2]):
            limbs[:, :, index] = ((exact >> (LIMB_BITS * index)) & ((1 << LIMB_BITS) - 1)).astype(np.uint64)
        return cls(limbs, precision)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return self.limbs.shape[0], self.limbs.shape[1]

    def shifted(self, precision: int) -> Field:
        """The same values at a higher precision: every value times 2^(precision - self.precision)."""
        distance = precision - self.precision
        if distance < 0:
            raise InputError(f"precision {precision} is below the field's {self.precision}", "precision")
        if distance == 0:
            return self
        words, bits = divmod(distance, LIMB_BITS)
        limbs = np.zeros((*self.shape, limbs_needed(precision)), np.uint64)
        for source in range(self.limbs.shape[2]):
            target = source + words
            if target < limbs.shape[2]:
                limbs[:, :, target] |= self.limbs[:, :, source] << np.uint64(bits)
            if bits and target + 1 < limbs.shape[2]:
                limbs[:, :, target + 1] = self.limbs[:, :, source] >> np.uint64(LIMB_BITS - bits)
        return Field(limbs, precision)

    def to_ints(self) -> NDArray[np.object_]:
        """The exact values, as an object array of Python int (rows × columns)."""
        values: NDArray[np.object_] = self.limbs[:, :, -1].astype(object)
        for index in range(self.limbs.shape[2] - 2, -1, -1):
            values = (values << LIMB_BITS) | self.limbs[:, :, index].astype(object)
        return values

    def to_float(self) -> NDArray[np.float64]:
        """The values scaled to 0..1, rounded to doubles (rows × columns)."""
        scaled = np.zeros(self.shape)
        for index in range(self.limbs.shape[2]):
            scaled += np.ldexp(self.limbs[:, :, index].astype(np.float64), LIMB_BITS * index - self.precision)
        return scaled

    def digest(self) -> str:
        """SHA-256 of shape, precision and values: equal if and only if the fields are."""
        return self._digest

    @cached_property
    def _digest(self) -> str:
        head = f"{self.shape} {self.precision} ".encode()
        return hashlib.sha256(head + self.limbs.astype("<u8").tobytes()).hexdigest()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Field):
            return NotImplemented
        return self.precision == other.precision and bool(np.array_equal(self.limbs, other.limbs))

    def __hash__(self) -> int:
        return hash((self.precision, self.limbs.tobytes()))


class LowerBound(Field):
    """A field proved to be nowhere above the converged one: relaxing from it gives the same bits as from 0."""
