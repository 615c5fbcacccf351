# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The gains of a visit: in d of the block, and in r of its neighbours.

``kernels`` defines r and d, and explains why an edit here requires one there.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, get, load, one_lane, put, spread, store, zeros
from codesign.planners.harmonic.plan.layout import LANES, WORD_BITS, WORD_BYTES
from codesign.planners.harmonic.plan.planes import add_gains, add_signed_gains, clear_planes, needed_planes
from codesign.planners.harmonic.plan.visits import trim


@njit(nogil=True)
def add_visit(layout, state, block, signed):
    """Add the sums of the visit to d of its block."""
    none, everything = spread(np.uint64(0)), spread(~np.uint64(0))
    step = layout.plane
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
                add_signed_gains(planes, word, have, state.visit, word, count, none, none, everything, step)
            total = needed_planes(planes, begin, end, step, total + 1, 0, True)
        else:
            over = zeros()
            for word in range(begin, end, LANES):
                over |= add_gains(
                    planes, word, have, state.visit, word, count, none, none, everything, step
                )
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


@njit(nogil=True)
def _push(layout, state, block, segment, source, target, vectors, right, left, select, count, signed):
    """Add the gains of border nodes of the visited block to r of their neighbours in a segment of ``block``.

    ``source`` and ``target`` are the first words in either; the gains have ``count`` planes and are shifted ``right``,
    then ``left``.
    """
    # r = N + E + S + W - 4h, so where N of a node gains d during the visit of its block, r of the node gains d too.
    # Inside the visited block the iterations have done that; here it is done for the nodes just beyond the border.
    if count == 0:
        return
    step, visit, own = layout.plane, state.visit, block * layout.segments + segment
    planes = state.residual + block * layout.planes * step * WORD_BYTES
    mask = state.mask + block * step * WORD_BYTES
    begin, end = get(state.begin, segment), get(state.end, segment)
    have = get(state.width, own) + 2
    if signed:
        # The sum of two signed numbers takes one bit more than the longer; all segments of the block widen with it.
        # The two planes of a settled block have no sign, so it takes one bit more in any case.
        have = max(have + 1, count)
        _widen(layout, state, block, have + 1)
        for word in range(0, vectors * LANES, LANES):
            selected = select & load(mask, target + word)
            add_signed_gains(
                planes, target + word, have, visit, source + word, count, right, left, selected, step
            )
        trim(layout, state, block, signed)
        return
    if have < count:
        clear_planes(planes, begin, end, step, have, count)
        have = count
    over = zeros()
    for word in range(0, vectors * LANES, LANES):
        selected = select & load(mask, target + word)
        over |= add_gains(
            planes, target + word, have, visit, source + word, count, right, left, selected, step
        )
    if any_bit(over):
        # All groups have the plane of the carries now.
        clear_planes(planes, begin, target, step, have, have + 1)
        clear_planes(planes, target + vectors * LANES, end, step, have, have + 1)
        have += 1
    width = needed_planes(planes, begin, end, step, have, 2, signed) - 2
    put(state.width, own, width)
    put(state.active, block, max(get(state.active, block), width))


@njit(nogil=True)
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
    row, column = block // layout.across, block % layout.across
    no_bits, lowest_bit = spread(np.uint64(0)), spread(np.uint64(1))
    shift = spread(np.uint64((layout.block_columns - 1) % WORD_BITS))
    aside = layout.end - layout.stride + LANES - layout.first
    bottom, each = layout.block_rows - 1, layout.each
    lane = bottom % LANES
    # West: column 0 (bit 0) to the last column (bit ``shift`` of the last word column) of the block before. All
    # blocks but the last of a row are whole, so that column exists. East: the last column to column 0.
    for segment in range(each):
        first = get(state.begin, segment)
        vectors = (get(state.end, segment) - first) // LANES
        last, beside = first + aside, segment + (layout.columns - 1) * each
        if column > 0:
            count, select = get(state.visit_width, segment), lowest_bit << shift
            _push(
                layout, state, block - 1, beside, first, last, vectors, no_bits, shift, select, count, signed
            )
        if column < layout.across - 1:
            count = get(state.visit_width, beside)
            _push(
                layout,
                state,
                block + 1,
                segment,
                last,
                first,
                vectors,
                shift,
                no_bits,
                lowest_bit,
                count,
                signed,
            )
    for top in range(layout.columns):
        word = layout.first + top * layout.stride
        head, foot = top * each, (top + 1) * each - 1
        # North: row 0 to row ``bottom``, which is in lane ``lane`` of its group. The source begins ``lane`` words
        # before row 0, so that row 0 comes into the same lane; the words before it are not selected.
        if row > 0:
            count, select = get(state.visit_width, head), one_lane(lane)
            above, lowest = block - layout.across, word - lane
            _push(
                layout,
                state,
                above,
                foot,
                lowest,
                lowest + bottom,
                1,
                no_bits,
                no_bits,
                select,
                count,
                signed,
            )
        # South: row ``bottom`` to row 0, which is in lane 0 of its group. The source begins at ``bottom``.
        if row < layout.down - 1:
            count, select = get(state.visit_width, foot), one_lane(0)
            below = block + layout.across
            _push(
                layout, state, below, head, word + bottom, word, 1, no_bits, no_bits, select, count, signed
            )
