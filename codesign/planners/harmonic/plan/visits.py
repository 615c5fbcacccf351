# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The visit of one block: its iterations, in turns, and the sum of their steps.

``kernels`` defines r, its steps and d, and explains why an edit here requires one there. ``borders`` adds the sums to d
of the block and to r of its neighbours.

Within a turn all groups of a *segment* (``layout``) have one width, as a step never takes more planes than the widest
step around it took before. So a turn counts planes once, not at every iteration.
"""

from __future__ import annotations

from numba import njit

from codesign.planners.harmonic.plan.lanes import get, load, put, store
from codesign.planners.harmonic.plan.layout import LANES, SLOTS, WORD_BYTES
from codesign.planners.harmonic.plan.planes import (
    clear_planes,
    iterate_group,
    needed_planes,
    sum_more_steps,
    sum_signed_steps,
    sum_steps,
    sum_three_steps,
)


@njit(forceinline=True, nogil=True)
def iterate(layout, state, block, source, target, signed):
    """One iteration of a block, from the planes at one address to those at another."""
    # h(t + 1) = floor((N + E + S + W) / 4), section 5.2, in terms of r (``kernels``), for all nodes of the block at
    # once. Two copies of r, because a group is read again as the neighbour of those that follow.
    step, mask = layout.plane * WORD_BYTES, state.mask + block * layout.plane * WORD_BYTES
    for segment in range(layout.segments):
        width, read = get(state.turn_width, segment), get(state.read_width, segment)
        begin, end = get(state.begin, segment), get(state.end, segment)
        at, last = begin * WORD_BYTES, end * WORD_BYTES
        if width > 0 and layout.beside > 0:
            while at < last:
                free, beside = load(mask + at, 0), layout.beside * WORD_BYTES
                iterate_group(source + at, target + at, free, step, width, layout.pitch, beside, signed)
                at += LANES * WORD_BYTES
        elif width > 0:
            while at < last:
                free = load(mask + at, 0)
                iterate_group(source + at, target + at, free, step, width, layout.pitch, 0, signed)
                at += LANES * WORD_BYTES
        # Wider segments nearby read more planes than this one has. A segment that does not step in this turn keeps
        # r = r mod 4: its two low planes stay where they are, and no other segment reads them.
        if read > width:
            clear_planes(target, begin, end, layout.plane, width + 2, read + 2)


@njit(nogil=True)
def _widest_around(layout, widths, spread_widths):
    """The greatest width of each segment and of those that touch it."""
    #   s - each - 1   s - 1   s + each - 1
    #   s - each         s     s + each         s + each: the same rows in the next word column
    #   s - each + 1   s + 1   s + each + 1
    each, widest = layout.each, 0
    for column in range(layout.columns):
        for row in range(each):
            widest = 0
            for beside in range(max(column - 1, 0), min(column + 2, layout.columns)):
                for near in range(max(row - 1, 0), min(row + 2, each)):
                    widest = max(widest, get(widths, beside * each + near))
            put(spread_widths, column * each + row, widest)


@njit(forceinline=True, nogil=True)
def _begin_turn(layout, state, block, own):
    """Settle the widths of a turn: ``turn_width``, and ``read_width`` that nearby segments read."""
    # In a turn of at most ``SLOTS`` iterations nothing gets further than the next group, whichever side of it.
    widths, active = state.width + block * layout.segments * WORD_BYTES, get(state.active, block)
    level = True
    for segment in range(layout.segments):
        level &= get(widths, segment) == active
    if level:
        for segment in range(layout.segments):
            put(state.turn_width, segment, active)
            put(state.read_width, segment, active)
        return
    _widest_around(layout, widths, state.turn_width)
    _widest_around(layout, state.turn_width, state.read_width)
    for segment in range(layout.segments):
        begin, end = get(state.begin, segment), get(state.end, segment)
        clear_planes(own, begin, end, layout.plane, get(widths, segment) + 2, get(state.read_width, segment) + 2)


@njit(nogil=True)
def _copy(layout, state, source, target):
    """Copy what a turn reads of r."""
    step = layout.plane
    for segment in range(layout.segments):
        for word in range(get(state.begin, segment), get(state.end, segment), LANES):
            for plane in range(get(state.read_width, segment) + 2):
                store(target, plane * step + word, load(source, plane * step + word))


@njit(nogil=True)
def _widest_step(slots, begin, end, step, width):
    """The planes that the steps of a segment take in any iteration of a turn, ``width`` or fewer."""
    least = 0
    for slot in slots:
        least = max(least, needed_planes(slot, begin, end, step, width + 2, least + 2, False) - 2)
    return least


@njit(forceinline=True, nogil=True)
def _sum(slots, visit, begin, end, step, width, have, count, signed):
    """Add the steps of a turn of ``count`` iterations to the sums of a segment; the planes that they may have then."""
    if signed:
        for word in range(begin, end, LANES):
            sum_signed_steps(slots, word + 2 * step, visit, word, step, width, have)
        return max(have, width + 3) + 1
    if count <= 3:
        for word in range(begin, end, LANES):
            sum_three_steps(slots, word + 2 * step, visit, word, step, width, have)
        return max(have, width + 2) + 1
    if have > 0:
        for word in range(begin, end, LANES):
            sum_more_steps(slots, word + 2 * step, visit, word, step, width, have)
        return max(have, width + 3) + 1
    for word in range(begin, end, LANES):
        sum_steps(slots, word + 2 * step, visit, word, step, width)
    return width + 3


@njit(forceinline=True, nogil=True)
def _accumulate(layout, state, block, own, count, signed):
    """Add the steps of a turn of ``count`` iterations to the sums of the visit."""
    step, slot = layout.plane, layout.planes * layout.plane * WORD_BYTES
    # d of the visit += t of all iterations. The steps are not stored: they are r of each slot from plane 2 on. A turn
    # of fewer iterations adds zeros in place of the steps that it does not make.
    first, nothing = state.ring - slot, state.ring + (SLOTS - 1) * slot
    slots = (
        own,
        first + slot if count > 1 else nothing,
        first + 2 * slot if count > 2 else nothing,
        first + 3 * slot if count > 3 else nothing,
        first + 4 * slot if count > 4 else nothing,
        first + 5 * slot if count > 5 else nothing,
    )
    most = 0
    for segment in range(layout.segments):
        width, have = get(state.turn_width, segment), get(state.visit_width, segment)
        begin, end = get(state.begin, segment), get(state.end, segment)
        if not signed and width > get(state.width, block * layout.segments + segment):
            # A wider segment beside this one may or may not have led to wider steps here.
            width = _widest_step(slots, begin, end, step, width)
        if width > 0:
            total = _sum(slots, state.visit, begin, end, step, width, have, count, signed)
            have = needed_planes(state.visit, begin, end, step, total, 0, signed)
            put(state.visit_width, segment, have)
        most = max(most, have)
    if signed:
        # As with r, all segments have one width.
        for segment in range(layout.segments):
            put(state.visit_width, segment, most)


@njit(nogil=True)
def trim(layout, state, block, signed):
    """Lower the widths of a block to what r needs. Visits rely on it: settled and of width 0 are the same."""
    own = state.residual + block * layout.planes * layout.plane * WORD_BYTES
    widths, most = block * layout.segments, 0
    for segment in range(layout.segments):
        count = get(state.width, widths + segment) + 2
        begin, end = get(state.begin, segment), get(state.end, segment)
        width = needed_planes(own, begin, end, layout.plane, count, 2, signed) - 2
        put(state.width, widths + segment, width)
        most = max(most, width)
    if signed:
        # All segments of a block get the width of the widest where r has a sign.
        for segment in range(layout.segments):
            put(state.width, widths + segment, most)
    put(state.active, block, most)


@njit(nogil=True)
def _steps_made(layout, state, count):
    """The number of iterations that changed something in a turn of ``count``, after which the block is settled."""
    for made in range(1, count):
        slot, stepped = state.ring + (made - 1) * layout.planes * layout.plane * WORD_BYTES, False
        for segment in range(layout.segments):
            begin, end = get(state.begin, segment), get(state.end, segment)
            planes = get(state.turn_width, segment) + 2
            stepped |= needed_planes(slot, begin, end, layout.plane, planes, 2, False) > 2
        if not stepped:
            return made
    return count


@njit(forceinline=True, nogil=True)
def visit_block(layout, state, block, done, iterations, budget, signed):
    """Iterate a block until it settles, ``iterations`` are done or the budget is spent.

    ``done``: earlier iterations of this visit. Returns all iterations so far, and the rest of the budget.
    """
    # The inner loop of the paper's listing (section 4): ``while ((i < I) and (not (block_cvg)))``, where block_cvg is
    # that all steps are 0 (width 0). A turn makes up to six iterations:
    #
    #   r of the block    slot 0    slot 1  ..  slot 4        r of the block
    #            r_0  ->    r_1  ->   r_2   ..    r_5    ->    r_6
    #             t          t         t           t           these six steps are summed before r_6 overwrites r_0
    #
    # A settled block stays as it is. So whether it settled is asked after the turn, and when, only then.
    slot = layout.planes * layout.plane * WORD_BYTES
    own = state.residual + block * slot
    while get(state.active, block) > 0 and done < iterations and budget > 0:
        # Turns of about the same length, so that none is left with a single iteration.
        turns = (iterations - done + SLOTS - 1) // SLOTS
        count = (iterations - done + turns - 1) // turns
        _begin_turn(layout, state, block, own)
        source = own
        for made in range(count):
            target = state.ring + made * slot
            if made == count - 1:
                _accumulate(layout, state, block, own, count, signed)
                if count == 1:
                    _copy(layout, state, own, target)
                    source = target
                target = own
            iterate(layout, state, block, source, target, signed)
            source = target
        for segment in range(layout.segments):
            put(state.width, block * layout.segments + segment, get(state.turn_width, segment))
        trim(layout, state, block, signed)
        done += count if get(state.active, block) > 0 else _steps_made(layout, state, count)
        budget -= count * layout.columns * layout.words
    return done, budget
