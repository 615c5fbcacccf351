# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""Conversions between wide values and bit planes, once a stage, cell by cell in 64-bit limbs.

Wide values are uint64 arrays, rows × columns × limbs, least significant limb first. Bit planes are laid out as
in ``kernels``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

HALF_BITS = 32
_HALF = np.int64((1 << HALF_BITS) - 1)


@njit(cache=True, nogil=True)
def _half(limbs, row, column, half):
    """Half a limb of a value as int64; 0 outside the map and beyond the last limb."""
    if row < 0 or column < 0 or row >= limbs.shape[0] or column >= limbs.shape[1] or half >= 2 * limbs.shape[2]:
        return np.int64(0)
    limb = limbs[row, column, half // 2]
    return np.int64(limb >> np.uint64(HALF_BITS)) if half % 2 else np.int64(limb & np.uint64(_HALF))


@njit(cache=True, nogil=True)
def _all_zero(limbs, row, column):
    """True if a cell and its neighbours are 0, as most are at the start."""
    last_row, last_column = limbs.shape[0] - 1, limbs.shape[1] - 1
    some = np.uint64(0)
    for limb in range(limbs.shape[2]):
        some |= limbs[row, column, limb]
        some |= limbs[max(row - 1, 0), column, limb] | limbs[min(row + 1, last_row), column, limb]
        some |= limbs[row, max(column - 1, 0), limb] | limbs[row, min(column + 1, last_column), limb]
    return some == 0


@njit(cache=True, nogil=True)
def _rows_with_values(limbs):
    """By row: True if some value of the row, or of the row above or below, is not 0."""
    rows = limbs.shape[0]
    some = np.zeros(rows + 2, np.bool_)
    for row in range(rows):
        bits = np.uint64(0)
        for column in range(limbs.shape[1]):
            for limb in range(limbs.shape[2]):
                bits |= limbs[row, column, limb]
        some[row + 1] = bits != 0
    return some[:rows] | some[1 : rows + 1] | some[2:]


@njit(cache=True, nogil=True)
def _residual(limbs, row, column, residual):
    """N + E + S + W - 4h of a cell, in two's complement halves; the bits it takes, and whether it is negative."""
    if _all_zero(limbs, row, column):
        residual[:] = 0
        return 0, False
    # r = N + E + S + W - 4h, half a limb at a time: each of the sums is within ±2^35, so that an int64 holds it
    # together with what is carried, and >> keeps the sign of a borrow. The last half, beyond the limbs, takes the
    # sign.
    carry = np.int64(0)
    for half in range(len(residual)):
        carry += (
            _half(limbs, row - 1, column, half)
            + _half(limbs, row + 1, column, half)
            + _half(limbs, row, column - 1, half)
            + _half(limbs, row, column + 1, half)
            - 4 * _half(limbs, row, column, half)
        )
        residual[half] = carry & _HALF
        carry >>= HALF_BITS
    # The bits down from the highest that differs from the sign.
    negative = carry < 0
    sign = _HALF if negative else np.int64(0)
    for half in range(len(residual) - 1, -1, -1):
        if residual[half] != sign:
            bits = half * HALF_BITS
            rest = residual[half] ^ sign
            while rest:
                rest >>= 1
                bits += 1
            return bits, negative
    return 0, negative


@njit(cache=True, nogil=True)
def residual_bits(limbs, movable):
    """Most bits that r of any movable cell takes, its sign not counted, and whether any is negative."""
    residual = np.empty(2 * limbs.shape[2] + 1, np.int64)
    most, any_negative = 0, False
    some = _rows_with_values(limbs)
    for row in range(limbs.shape[0]):
        if not some[row]:
            continue
        for column in range(limbs.shape[1]):
            if movable[row, column]:
                bits, negative = _residual(limbs, row, column, residual)
                most = max(most, bits)
                any_negative |= negative
    return most, any_negative


@njit(cache=True, nogil=True)
def _place(layout, row, column):
    """Block of a cell, the word that holds it within a plane, and the bit in that word."""
    # Where ``layout`` has it: block in raster order, word column of 64 columns, row.
    block = row // layout.block_rows * layout.across + column // layout.block_columns
    inner_row, inner_column = row % layout.block_rows, column % layout.block_columns
    bits = inner_row * layout.pitch * 8 + inner_column % 64
    word = layout.first + inner_column // 64 * layout.stride + bits // 64
    return block, word, np.uint64(bits % 64)


@njit(cache=True, nogil=True)
def _segment(layout, word):
    column, below = (word - layout.first) // layout.stride, (word - layout.first) % layout.stride
    return column * layout.each + below // layout.segment


@njit(cache=True, nogil=True)
def fill_mask(layout, movable, mask):
    """Set the bits of ``mask`` (zero before) at the movable cells."""
    for row in range(movable.shape[0]):
        column = 0
        while column < movable.shape[1]:
            # The cells of a row that share a word.
            block, word, bit = _place(layout, row, column)
            together = min(64 - np.int64(bit), layout.block_columns - column % layout.block_columns)
            bits = np.uint64(0)
            for index in range(min(together, movable.shape[1] - column)):
                bits |= np.uint64(movable[row, column + index]) << np.uint64(index)
            mask[block * layout.plane + word] |= bits << bit
            column += together


@njit(cache=True, nogil=True)
def fill_residual(layout, limbs, movable, planes, count):
    """Set ``count`` bits of r of every movable cell in ``planes`` (zero before), negative ones in two's complement."""
    # The transpose: a number a node becomes one bit in each of ``count`` planes.
    residual = np.empty(2 * limbs.shape[2] + 1, np.int64)
    some = _rows_with_values(limbs)
    for row in range(limbs.shape[0]):
        if not some[row]:
            continue
        for column in range(limbs.shape[1]):
            if not movable[row, column]:
                continue
            bits, negative = _residual(limbs, row, column, residual)
            if bits == 0 and not negative:
                continue
            block, word, bit = _place(layout, row, column)
            word += block * layout.planes * layout.plane
            for plane in range(count):
                half = plane // HALF_BITS
                if half < len(residual):
                    value = residual[half] >> np.int64(plane % HALF_BITS) & 1
                else:
                    value = np.int64(negative)
                planes[plane * layout.plane + word] |= np.uint64(value) << bit


@njit(cache=True, nogil=True)
def _gather(planes, word, step, first, width, signed, low, together, digits):
    """64 bits from ``first`` on of ``together`` numbers of ``width`` planes that share a word, from bit ``low`` on."""
    # The transpose back: bit ``low`` + c of plane i goes to bit i of number c.
    #
    #   planes (a word each)         digits (a number each)
    #   i = 2   . . . x . .          x . .  c = 3:  .. b_2 b_1 b_0
    #   i = 1   . . . x . .    ->    x . .
    #   i = 0   . . . x . .          x . .          above the top plane: zeros, or copies of the sign
    digits[:] = 0
    last = min(first + 64, width)
    if signed and width > 0 and last - first < 64:
        sign = planes[word + (width - 1) * step] >> low
        above = ~np.uint64(0) if last <= first else ~np.uint64(0) << np.uint64(last - first)
        for column in range(together):
            digits[column] = above * (sign >> np.uint64(column) & np.uint64(1))
    for plane in range(first, last):
        bits, weight = planes[word + plane * step] >> low, np.uint64(plane - first)
        if bits:
            for column in range(together):
                digits[column] |= (bits >> np.uint64(column) & np.uint64(1)) << weight


@njit(cache=True, nogil=True)
def raise_field(layout, limbs, shift, planes, widths, signed, raised):
    """Put (limbs << shift) + d into ``raised``; d is given by its planes and the width of each segment.

    ``limbs`` and ``raised`` have the rows and columns of the map, also where the layout is transposed.
    """
    # h = (H << shift) + d, a limb at a time with its carry, where
    # (H << shift)[k] = H[k - words] << bits | H[k - words - 1] >> (64 - bits).
    words, bits = shift // 64, np.uint64(shift % 64)
    rows, columns, below, beside = raised.shape[0], raised.shape[1], raised.shape[1], 1
    if layout.transposed:
        rows, columns, below, beside = columns, rows, beside, below
    have, need = limbs.shape[2], raised.shape[2]
    old, new = limbs.ravel(), raised.ravel()
    digits = np.empty((need, 64), np.uint64)
    for row in range(rows):
        column = 0
        while column < columns:
            block, word, low = _place(layout, row, column)
            width = widths[block * layout.segments + _segment(layout, word)]
            word += block * layout.planes * layout.plane
            # As many columns as share the word.
            inner = column % layout.block_columns
            together = min(64 - np.int64(low), layout.block_columns - inner, columns - column)
            # d has few limbs, and zeros or its sign above.
            least = need if signed else min(need, (width + 63) // 64)
            for limb in range(least):
                _gather(planes, word, layout.plane, limb * 64, width, signed, low, together, digits[limb])
            for index in range(together):
                cell = row * below + (column + index) * beside
                source, target = cell * have, cell * need
                carry = before = np.uint64(0)
                for limb in range(words):
                    total = (digits[limb, index] if limb < least else np.uint64(0)) + carry
                    carry = np.uint64(total < carry)
                    new[target + limb] = total
                for limb in range(words, need):
                    here = old[source + limb - words] if limb < have + words else np.uint64(0)
                    # Not by 64 bits at once, which is undefined, where ``bits`` is 0.
                    value = here << bits | before >> np.uint64(1) >> (np.uint64(63) - bits)
                    before = here
                    partial = value + (digits[limb, index] if limb < least else np.uint64(0))
                    total = partial + carry
                    # An unsigned sum that wrapped is less than either term. Of the two additions at most one wraps.
                    carry = np.uint64(partial < value) | np.uint64(total < partial)
                    new[target + limb] = total
            column += together


@njit(cache=True, nogil=True)
def _greater(limbs, row, column, other_row, other_column):
    """True if the value at the first cell is greater than at the second; cells outside the map hold 0."""
    if row < 0 or column < 0 or row >= limbs.shape[0] or column >= limbs.shape[1]:
        return False
    for limb in range(limbs.shape[2] - 1, -1, -1):
        here, there = limbs[row, column, limb], limbs[other_row, other_column, limb]
        if here != there:
            return here > there
    return False


@njit(cache=True, nogil=True)
def _count_of_one_limb(values, candidates):
    """``count_local_maxima`` of values of 63 bits or fewer, without a branch a cell."""
    rows, columns = values.shape
    outside = np.zeros(columns, np.uint64)
    count = 0
    for row in range(rows):
        here = values[row]
        north = values[row - 1] if row > 0 else outside
        south = values[row + 1] if row < rows - 1 else outside
        for column in range(columns):
            highest = max(north[column], south[column])
            if column > 0:
                highest = max(highest, here[column - 1])
            if column < columns - 1:
                highest = max(highest, here[column + 1])
            count += candidates[row, column] & (highest <= here[column])
    return count


@njit(cache=True, nogil=True)
def count_local_maxima(limbs, candidates):
    """The number of candidates without a strictly greater one among their four neighbours."""
    # Section 4.1 stops once "no such local extremum is detected". Local minima do not matter to an ascent.
    count = 0
    if limbs.shape[2] == 1:
        return _count_of_one_limb(limbs[:, :, 0], candidates)
    for row in range(limbs.shape[0]):
        for column in range(limbs.shape[1]):
            if candidates[row, column] and not (
                _greater(limbs, row - 1, column, row, column)
                or _greater(limbs, row + 1, column, row, column)
                or _greater(limbs, row, column - 1, row, column)
                or _greater(limbs, row, column + 1, row, column)
            ):
                count += 1
    return count
