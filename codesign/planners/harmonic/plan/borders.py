# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The gains of a visit: in d of the block, and in r of its neighbours.

``kernels`` defines r and d, and explains why an edit here requires one there.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, get, load, put, spread, store, zeros
from codesign.planners.harmonic.plan.layout import EAST, INSIDE, LANES, NORTH, SOUTH, WEST, WORD_BITS, WORD_BYTES
from codesign.planners.harmonic.plan.planes import add_gains, add_signed_gains, clear_planes, needed_planes
from codesign.planners.harmonic.plan.visits import trim


@njit(forceinline=True, nogil=True)
def add_visit(layout, state, block, signed):
    """Add the sums of the visit to d of its block."""
    step, none = layout.plane, zeros()
    # d of the stage += d of the visit, all nodes of the block at their own places.
    planes = state.odometer + block * layout.planes * step * WORD_BYTES
    for segment in range(layout.segments):
        count, own = get(state.visit_width, segment), block * layout.segments + segment
        if count == 0:
            continue
        have, begin, end = get(state.odometer_width, own), get(state.begin, segment), get(state.end, segment)
        total = max(have, count)
        if signed:
            for word in range(begin, end, LANES):
                add_signed_gains(planes, word, have, state.visit, word, count, none, INSIDE, none, step)
            total = needed_planes(planes, begin, end, step, total + 1, 0, True)
        else:
            over = zeros()
            for word in range(begin, end, LANES):
                over |= add_gains(planes, word, have, state.visit, word, count, none, INSIDE, none, step)
            total += any_bit(over)
        put(state.odometer_width, own, total)
        put(state.deepest, block, max(get(state.deepest, block), total))


@njit(nogil=True)
def _widen(layout, state, block, total):
    """Give r of all segments of a block ``total`` planes, by repeating the sign."""
    step = layout.plane
    planes = state.residual + block * layout.planes * step * WORD_BYTES
    for segment in range(layout.segments):
        own = block * layout.segments + segment
        have = get(state.width, own) + 2
        for word in range(get(state.begin, segment), get(state.end, segment), LANES):
            sign = load(planes, (have - 1) * step + word) if have > 2 else zeros()
            for plane in range(have, total):
                store(planes, plane * step + word, sign)
        put(state.width, own, total - 2)


@njit(forceinline=True, nogil=True)
def _push(layout, state, block, segment, first, last, away, shift, side, count, signed):
    """Add ``count`` planes of gains of border nodes of the visited block to r of their neighbours beyond ``side``.

    Those are in the words from ``first`` to ``last`` of a segment of ``block``; the gains are ``away`` bytes off.
    """
    # r = N + E + S + W - 4h, so where N of a node gains d during the visit of its block, r of the node gains d too.
    # Inside the visited block the iterations have done that; here it is done for the nodes just beyond the border.
    step, visit, own = layout.plane, state.visit + away, block * layout.segments + segment
    planes = state.residual + block * layout.planes * step * WORD_BYTES
    mask, sides = state.mask + block * step * WORD_BYTES, state.sides + side * step * WORD_BYTES
    begin, end = get(state.begin, segment), get(state.end, segment)
    wide = get(state.width, own)
    have = wide + 2
    if signed:
        # The sum of two signed numbers takes one bit more than the longer; all segments of the block widen with it.
        # The two planes of a settled block have no sign, so it takes one bit more in any case.
        have = max(have + 1, count)
        _widen(layout, state, block, have + 1)
        for word in range(first, last, LANES):
            select = load(mask, word) & load(sides, word)
            add_signed_gains(planes, word, have, visit, word, count, shift, side, select, step)
        trim(layout, state, block, signed)
        return
    if have < count:
        clear_planes(planes, begin, end, step, have, count)
        have = count
    over = zeros()
    for word in range(first, last, LANES):
        select = load(mask, word) & load(sides, word)
        over |= add_gains(planes, word, have, visit, word, count, shift, side, select, step)
    if any_bit(over):
        # All groups have the plane of the carries now.
        clear_planes(planes, begin, first, step, have, have + 1)
        clear_planes(planes, last, end, step, have, have + 1)
        have += 1
    elif wide == 0 or have > wide + 2:
        have = needed_planes(planes, begin, end, step, have, 2, signed)
    # Else no plane is redundant: some r has the highest, as before.
    put(state.width, own, have - 2)
    put(state.active, block, max(get(state.active, block), have - 2))


@njit(forceinline=True, nogil=True)
def _level(layout, state):
    """The most planes of the sums of the visit; all segments have as many then."""
    most, least = 0, get(state.visit_width, 0)
    for segment in range(layout.segments):
        width = get(state.visit_width, segment)
        most, least = max(most, width), min(least, width)
    if least < most:
        for segment in range(layout.segments):
            begin, end = get(state.begin, segment), get(state.end, segment)
            clear_planes(state.visit, begin, end, layout.plane, get(state.visit_width, segment), most)
    return most


@njit(forceinline=True, nogil=True)
def push_all(layout, state, block, signed):
    """Add the gains of the border nodes to r in the four neighbouring blocks."""
    #                  block - across
    #                  . . bottom . .
    #                +----------------+
    #  block - 1   . | row 0          | .   block + 1
    #  last column . |                | .   column 0
    #                | row `bottom`   |
    #                +----------------+
    #                  . . row 0  . .
    #                  block + across
    count = _level(layout, state)
    if count == 0:
        return
    row, column = block // layout.across, block % layout.across
    each, easternmost = layout.each, (layout.columns - 1) * layout.each
    # A column moves by whole bytes and then, within its bytes, by bits: from column 0 (bit 0) to the last column (bit
    # ``shift`` of a byte) of the block before. All blocks but the last of a row are whole, so that column exists.
    # East is the reverse.
    last_column = layout.block_columns - 1
    shift = spread(np.uint64(last_column % 8))
    away = (layout.columns - 1) * layout.stride * WORD_BYTES + last_column % WORD_BITS // 8
    for segment in range(each):
        if column > 0:
            beside = easternmost + segment
            first, last = get(state.begin, beside), get(state.end, beside)
            _push(layout, state, block - 1, beside, first, last, -away, shift, WEST, count, signed)
        if column < layout.across - 1:
            first, last = get(state.begin, segment), get(state.end, segment)
            _push(layout, state, block + 1, segment, first, last, away, shift, EAST, count, signed)
    # A row moves by whole bytes: from row 0 to row ``bottom``, or back. It may lie in two groups.
    bottom = (layout.block_rows - 1) * layout.pitch
    begin = bottom // WORD_BYTES // LANES * LANES
    end = (bottom + layout.pitch - 1) // WORD_BYTES // LANES * LANES + LANES
    for segment in range(layout.segments):
        top = layout.first + segment // each * layout.stride
        first, last = max(get(state.begin, segment), top + begin), min(get(state.end, segment), top + end)
        if row > 0 and first < last:
            above = block - layout.across
            _push(layout, state, above, segment, first, last, -bottom, shift, NORTH, count, signed)
        if row < layout.down - 1 and segment % each == 0:
            below = block + layout.across
            _push(layout, state, below, segment, top, top + LANES, bottom, shift, SOUTH, count, signed)
