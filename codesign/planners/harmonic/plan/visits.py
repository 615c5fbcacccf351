# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The visit of one block: its iterations, and their gains in d of the block and in r of its neighbours.

``kernels`` defines r, its steps and d, and explains why an edit here requires one there.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, get, load, one_lane, put, spread, store, zeros
from codesign.planners.harmonic.plan.layout import LANES, SLOTS, WORD_BITS
from codesign.planners.harmonic.plan.planes import (
    add_gains,
    iterate_group,
    needed_planes,
    sum_signed_steps,
    sum_steps,
)


@njit(nogil=True)
def iterate(layout, state, block, source, target, uniform, signed):
    """One iteration of a block, from one slot of the ring to another; the planes that the next steps take.

    ``uniform``: the planes of the steps of all groups, where r has a sign.
    """
    # h(t + 1) = floor((N + E + S + W) / 4), section 5.2, in terms of r (``kernels``), for all nodes of the block at
    # once. Two slots of the ring, because a group is read again as the neighbour of those that follow.
    ring, step, widths = state.ring, layout.plane, state.ring_width
    from_width, to_width = source * layout.groups, target * layout.groups
    source *= layout.planes * step
    target *= layout.planes * step
    aside = layout.stride // LANES
    most = 0
    for column in range(layout.first, layout.end, layout.stride):
        for word in range(column, column + layout.rows, LANES):
            here = from_width + word // LANES
            # Steps come from the group itself and from the four around it; the widest of them decides.
            #
            #              g - 1
            #   g - aside    g    g + aside        aside = stride / 8: the same rows in the next word column
            #              g + 1
            width = (
                uniform if signed else max(get(widths, here - 1), get(widths, here), get(widths, here + 1))
            )
            if layout.columns > 1 and not signed:
                width = max(width, get(widths, here - aside), get(widths, here + aside))
            needed = 0
            if width > 0:
                free = load(state.mask, block * step + word)
                iterate_group(layout, ring, free, source + word, target + word, width, signed)
                needed = needed_planes(ring, target + word, step, width + 2, 2, signed) - 2
                most = max(most, needed)
            else:
                # Neither this group nor a neighbour steps: r' = r mod 4, the two low planes.
                store(ring, target + word, load(ring, source + word))
                store(ring, target + step + word, load(ring, source + step + word))
            there = to_width + word // LANES
            if not signed:
                # The target slot still holds r of five iterations ago: clear what lies above the new planes.
                for plane in range(width, get(widths, there)):
                    store(ring, target + (plane + 2) * step + word, zeros())
            put(widths, there, uniform if signed else needed)
    return most


@njit(nogil=True)
def _accumulate(layout, state, s0, s1, s2, s3, uniform, signed):
    """Add the steps of four slots of the ring to the sums of the visit."""
    step, ring, visit, groups, widths = layout.plane, state.ring, state.visit, layout.groups, state.ring_width
    # d of the visit += t of four iterations. The steps are not stored: they are r of each slot from plane 2 on.
    slot = layout.planes * step
    slots = s0 * slot, s1 * slot, s2 * slot, s3 * slot
    for word in range(layout.first, layout.end, LANES):
        group = word // LANES
        have = get(state.visit_width, group)
        if signed:
            have = sum_signed_steps(ring, word + 2 * step, slots, visit, word, step, uniform, have)
        else:
            width = max(
                get(widths, s0 * groups + group),
                get(widths, s1 * groups + group),
                get(widths, s2 * groups + group),
                get(widths, s3 * groups + group),
            )
            if width == 0:
                continue
            have = sum_steps(ring, word + 2 * step, slots, visit, word, step, width, have)
        put(state.visit_width, group, needed_planes(visit, word, step, have, 0, signed))


@njit(nogil=True)
def add_visit(layout, state, block, signed):
    """Add the sums of the visit to d of its block."""
    none, everything = spread(np.uint64(0)), spread(~np.uint64(0))
    planes, step = state.odometer, layout.plane
    # d of the stage += d of the visit, all nodes of the block at their own places.
    base = block * layout.planes * step
    for word in range(layout.first, layout.end, LANES):
        count = get(state.visit_width, word // LANES)
        if count > 0:
            group = block * layout.groups + word // LANES
            at, have = base + word, get(state.odometer_width, group)
            have = add_gains(planes, at, have, state.visit, word, count, none, none, everything, step, signed)
            width = needed_planes(planes, at, step, have, 0, signed)
            put(state.odometer_width, group, width)
            put(state.deepest, block, max(get(state.deepest, block), width))


@njit(nogil=True)
def _widen(layout, state, block, total):
    """Give r of all groups of a block ``total`` planes, by repeating the sign."""
    step, base = layout.plane, block * layout.planes * layout.plane
    for word in range(layout.first, layout.end, LANES):
        group = block * layout.groups + word // LANES
        have = get(state.width, group) + 2
        sign = load(state.residual, base + (have - 1) * step + word) if have > 2 else zeros()
        for plane in range(have, total):
            store(state.residual, base + plane * step + word, sign)
        put(state.width, group, total - 2)


@njit(nogil=True)
def trim(layout, state, block, signed):
    """Lower the widths of a block to what r needs. Visits rely on it: settled and of width 0 are the same."""
    base = block * layout.planes * layout.plane
    most = 0
    for word in range(layout.first, layout.end, LANES):
        group = block * layout.groups + word // LANES
        count = get(state.width, group) + 2
        width = needed_planes(state.residual, base + word, layout.plane, count, 2, signed) - 2
        put(state.width, group, width)
        most = max(most, width)
    if signed:
        for word in range(layout.first, layout.end, LANES):
            # All groups of a block get the width of the widest where r has a sign (``uniform`` in ``iterate``).
            put(state.width, block * layout.groups + word // LANES, most)
    put(state.active, block, most)


@njit(nogil=True)
def _push(layout, state, block, source, target, vectors, right, left, select, signed):
    """Add the gains of border nodes of the visited block to r of their neighbours in ``block``.

    ``source`` and ``target`` are the first words in either; the gains are shifted ``right``, then ``left``.
    """
    # r = N + E + S + W - 4h, so where N of a node gains d during the visit of its block, r of the node gains d too.
    # Inside the visited block the iterations have done that; here it is done for the nodes just beyond the border.
    step, visit, residual = layout.plane, state.visit, state.residual
    base, mask = block * layout.planes * step, block * step
    for word in range(0, vectors * LANES, LANES):
        # Words taken from the middle of a group may come from two.
        count = max(
            get(state.visit_width, (source + word) // LANES),
            get(state.visit_width, (source + word + 7) // LANES),
        )
        selected = select & load(state.mask, mask + target + word)
        if count == 0 or not any_bit(selected):
            continue
        group = block * layout.groups + (target + word) // LANES
        have = get(state.width, group) + 2
        if signed:
            # The sum of two signed numbers takes one bit more than the longer; all groups of the block widen with it.
            have = max(have + 1, count)
            _widen(layout, state, block, have + 1)
        at = base + target + word
        have = add_gains(residual, at, have, visit, source + word, count, right, left, selected, step, signed)
        if signed:
            trim(layout, state, block, signed)
        else:
            width = needed_planes(residual, at, step, have, 2, signed) - 2
            put(state.width, group, width)
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
    first, last = layout.first, layout.end - layout.stride + LANES
    bottom = layout.block_rows - 1
    lane = bottom % LANES
    # West: column 0 (bit 0) to the last column (bit ``shift`` of the last word column) of the block before. All
    # blocks but the last of a row are whole, so that column exists.
    if column > 0:
        vectors = layout.rows // LANES
        _push(layout, state, block - 1, first, last, vectors, no_bits, shift, lowest_bit << shift, signed)
    # East: the last column to column 0.
    if column < layout.across - 1:
        vectors = layout.rows // LANES
        _push(layout, state, block + 1, last, first, vectors, shift, no_bits, lowest_bit, signed)
    for top in range(first, last + 1, layout.stride):
        # North: row 0 to row ``bottom``, which is in lane ``lane`` of its group. The source begins ``lane`` words
        # before row 0, so that row 0 comes into the same lane; the words before it are not selected.
        if row > 0:
            above, lowest = block - layout.across, top - lane
            _push(layout, state, above, lowest, lowest + bottom, 1, no_bits, no_bits, one_lane(lane), signed)
        # South: row ``bottom`` to row 0, which is in lane 0 of its group. The source begins at ``bottom``.
        if row < layout.down - 1:
            below = block + layout.across
            _push(layout, state, below, top + bottom, top, 1, no_bits, no_bits, one_lane(0), signed)


@njit(nogil=True)
def _enter(layout, state, block, signed):
    """Copy r of a block into the first slot of the ring."""
    # The planes above the width are undefined in ``residual`` but are read in the ring, so they are cleared there.
    step, base = layout.plane, block * layout.planes * layout.plane
    for word in range(layout.first, layout.end, LANES):
        group = word // LANES
        width = get(state.width, block * layout.groups + group)
        for plane in range(width + 2):
            store(state.ring, plane * step + word, load(state.residual, base + plane * step + word))
        if not signed:
            for plane in range(width + 2, get(state.ring_width, group) + 2):
                store(state.ring, plane * step + word, zeros())
        put(state.ring_width, group, width)


@njit(nogil=True)
def _leave(layout, state, block, slot):
    """Copy r of a block back from a slot of the ring."""
    step, base = layout.plane, block * layout.planes * layout.plane
    from_slot = slot * layout.planes * step
    for word in range(layout.first, layout.end, LANES):
        group = word // LANES
        width = get(state.ring_width, slot * layout.groups + group)
        for plane in range(width + 2):
            store(
                state.residual, base + plane * step + word, load(state.ring, from_slot + plane * step + word)
            )
        put(state.width, block * layout.groups + group, width)


@njit(nogil=True)
def visit_block(layout, state, block, done, iterations, budget, signed):
    """Iterate a block until it settles, ``iterations`` are done or the budget is spent.

    ``done``: earlier iterations of this visit. Returns all iterations so far, and the rest of the budget.
    """
    # The inner loop of the paper's listing (section 4): ``while ((i < I) and (not (block_cvg)))``, where block_cvg is
    # that all steps are 0 (width 0). The ring turns over five slots, four iterations at a time:
    #
    #   slot      0      1      2      3      4      5
    #           r_0 -> r_1 -> r_2 -> r_3 -> r_4    zeros      then from slot 4 to 0, 1, 2, 3
    #            t      t      t      t                       these four steps are added to d, r_4 is the next r_0
    width = get(state.active, block)
    _enter(layout, state, block, signed)
    current = 0
    while width > 0 and done < iterations and budget > 0:
        before, in_turn = current, 0
        uniform = width if signed else 0
        while in_turn < SLOTS and width > 0 and done < iterations:
            following = (current + 1) % (SLOTS + 1)
            width = iterate(layout, state, block, current, following, uniform, signed)
            current = following
            in_turn += 1
            done += 1
        # A turn cut short adds zeros in place of the steps that it did not make.
        nothing = SLOTS + 1
        s1 = (before + 1) % (SLOTS + 1) if in_turn > 1 else nothing
        s2 = (before + 2) % (SLOTS + 1) if in_turn > 2 else nothing
        s3 = (before + 3) % (SLOTS + 1) if in_turn > 3 else nothing
        _accumulate(layout, state, before, s1, s2, s3, uniform, signed)
        budget -= in_turn * layout.columns * layout.rows
    _leave(layout, state, block, current)
    put(state.active, block, width)
    if signed:
        trim(layout, state, block, signed)
    return done, budget
