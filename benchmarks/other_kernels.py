# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The relaxation as one would write it first: four 64-bit limbs a node in numba, and 32-bit digits in plain numpy.

Both exact at p = 255, block-synchronous and sound, to be timed against the bit planes. The limbs come in two
layouts: those of a node together, and each limb of all nodes as a plane of its own, which the compiler turns into
vectors of eight nodes. Blocks are copied to two buffers that an iteration reads and writes in turns; whether a
bit changed falls out of the same pass.

Tried and left: a carry as an array of its own and one pass a limb (1.5 times slower); 62 bits a limb, whose sums
need no comparison (a limb more, and as slow); sixteen digits of 30 bits a vector (slower still); other numbers of
limbs in one kernel by a loop over them (no vectors).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

LIMBS = 4
ZERO, TWO, TOP = np.uint64(0), np.uint64(2), np.uint64(62)


@njit(inline="always")
def _sum(north, south, west, east, carry):
    """The sum of four limbs and a carry: its low 64 bits, and the carry to the next limb."""
    vertical, horizontal = north + south, west + east
    around = vertical + horizontal
    total = around + carry
    carry = np.uint64(vertical < north) + np.uint64(horizontal < west)
    return total, carry + np.uint64(around < vertical) + np.uint64(total < around)


@njit(cache=True)
def node_by_node(values, movable, out):
    """One iteration of a block with a frame, rows × columns × limbs; whether a bit changed. ``movable``: 0 or ~0."""
    changed = ZERO
    for i in range(1, values.shape[0] - 1):
        for j in range(1, values.shape[1] - 1):
            if movable[i, j] == ZERO:
                continue
            below = carry = ZERO
            for limb in range(LIMBS):
                total, carry = _sum(
                    values[i - 1, j, limb],
                    values[i + 1, j, limb],
                    values[i, j - 1, limb],
                    values[i, j + 1, limb],
                    carry,
                )
                if limb > 0:
                    average = below >> TWO | total << TOP
                    changed |= average ^ values[i, j, limb - 1]
                    out[i, j, limb - 1] = average
                below = total
            average = below >> TWO | carry << TOP
            changed |= average ^ values[i, j, LIMBS - 1]
            out[i, j, LIMBS - 1] = average
    return changed != ZERO


@njit(cache=True)
def plane_by_plane(values, movable, out):
    """The same, limbs × rows × columns: the loop over columns has no branch, and turns into vectors."""
    changed = ZERO
    for i in range(1, values.shape[1] - 1):
        m = movable[i]
        n0, n1, n2, n3 = values[0, i - 1], values[1, i - 1], values[2, i - 1], values[3, i - 1]
        h0, h1, h2, h3 = values[0, i], values[1, i], values[2, i], values[3, i]
        s0, s1, s2, s3 = values[0, i + 1], values[1, i + 1], values[2, i + 1], values[3, i + 1]
        o0, o1, o2, o3 = out[0, i], out[1, i], out[2, i], out[3, i]
        for j in range(1, values.shape[2] - 1):
            t0, carry = _sum(n0[j], s0[j], h0[j - 1], h0[j + 1], ZERO)
            t1, carry = _sum(n1[j], s1[j], h1[j - 1], h1[j + 1], carry)
            t2, carry = _sum(n2[j], s2[j], h2[j - 1], h2[j + 1], carry)
            t3, carry = _sum(n3[j], s3[j], h3[j - 1], h3[j + 1], carry)
            d0 = ((t0 >> TWO | t1 << TOP) ^ h0[j]) & m[j]
            d1 = ((t1 >> TWO | t2 << TOP) ^ h1[j]) & m[j]
            d2 = ((t2 >> TWO | t3 << TOP) ^ h2[j]) & m[j]
            d3 = ((t3 >> TWO | carry << TOP) ^ h3[j]) & m[j]
            o0[j], o1[j], o2[j], o3[j] = h0[j] ^ d0, h1[j] ^ d1, h2[j] ^ d2, h3[j] ^ d3
            changed |= d0 | d1 | d2 | d3
    return changed != ZERO


def digits_of_32_bits(values: NDArray[np.int64], movable: NDArray[np.bool_], out: NDArray[np.int64]) -> bool:
    """The same in plain numpy: digits × rows × columns in int64, so that no sum overflows."""
    inside = np.s_[:, 1:-1, 1:-1]
    total = values[:, :-2, 1:-1] + values[:, 2:, 1:-1] + values[:, 1:-1, :-2] + values[:, 1:-1, 2:]
    for digit in range(len(total) - 1):
        total[digit + 1] += total[digit] >> 32
    total &= 0xFFFFFFFF
    total[:-1] = total[:-1] >> 2 | (total[1:] & 3) << 30
    total[-1] >>= 2
    np.copyto(total, values[inside], where=~movable[1:-1, 1:-1])
    out[inside] = total
    return bool((total != values[inside]).any())


def visits(iterate: Any, values: Any, movable: Any, block: Any, most: int, sweeps: int, limbs_last: bool) -> int:
    """Sweep after sweep until no visit changes a bit, or ``sweeps`` are made; the iterations made.

    ``values`` and ``movable`` have a frame; ``values`` is changed.
    """
    count = 0
    for _ in range(sweeps):
        settled = True
        for top in range(0, movable.shape[0] - 2, block[0]):
            for left in range(0, movable.shape[1] - 2, block[1]):
                rows, columns = slice(top, top + block[0] + 2), slice(left, left + block[1] + 2)
                # Plain slices that touch the frame end there: the last block may be partial.
                part = values[rows, columns] if limbs_last else values[:, rows, columns]
                here, there = part.copy(), part.copy()
                free = movable[rows, columns].copy()
                changed, made = True, 0
                while changed and made < most:
                    changed = iterate(here, free, there)
                    here, there = there, here
                    made += 1
                part[:] = here
                settled &= made == 1 and not changed
                count += made
        if settled:
            break
    return count


compiled_visits = njit(visits)
"""``visits`` for the kernels of limbs."""
