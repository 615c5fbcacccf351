# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The relaxation of one stage as bit planes: 512 nodes an instruction, and no lane to overflow.

Within a stage h = (H << D) + d. The kernel keeps the residual r = N + E + S + W - 4h of every node instead of h. An
iteration adds t = floor(r / 4), the node's *step*, to h, so that

    r' = (r mod 4) + t_N + t_E + t_S + t_W        d' = d + t

and an iteration changes a bit if and only if some step is not 0. Four things follow:

- **r never outgrows its bits.** From 0 <= r < 2^k follows r' <= 3 + 4 (2^(k-2) - 1) < 2^k, and likewise from
  -2^(k-1) <= r < 2^(k-1) in two's complement. So within a visit nothing overflows and nothing is widened; and
  where steps are 0 or 1, an iteration is a cellular automaton. The precision p does not occur at all.
- **The next stage starts from r << D**, without a look at the wide values.
- **d is needed** at the borders of a block at the end of its visit, where it is added to r of the neighbours, and
  everywhere at the end of a stage. So the steps of four iterations are summed at once.
- **From r >= 0 values only rise**, in any order of blocks. Only a start with some r < 0 needs a sign, and
  only from there can the sweeps go on for ever. The kernel detects that.

Bit i of r over a whole block is a *plane*. Bit b of a word is a column, eight words below each other are a
vector of 512 nodes (a *group*), and an integer a node is a column of bits through the planes; sums are chains
of full adders. North and south are the same plane one row off, west and east one bit off. Rows of few columns share
words (``layout``). Some groups together, a *segment*, count the planes that they need, once in a *turn* of up to six
iterations. So quiet parts of a block cost little, settled parts next to nothing, and a settled block one test.

Cost: of each plane and group, an iteration loads three vectors (two of them across cache lines; five where rows share
words), does 7 logic operations and two shifts and stores one vector. With 512-bit registers that takes about 2 ns.
A machine without them takes two or four times as many operations, and the majority of three bits takes four instead
of one. With few iterations a visit, the work at its end costs two thirds as much again.

Tried and left: one width a block (up to 1.8 times slower, where steps of many bits differ from group to group);
code for each small width without a loop over planes (no faster, and twice the time to compile); north and south
by shuffles of three vectors instead of loads across cache lines (no faster); shorter turns, so that the ring fits the
first cache (slower); planes of all blocks side by side (they fell on each other in the cache); numba's arrays inside
the kernel (reference counts at every use, 5 times slower), hence addresses; calls within a visit (34 words of layout
and state on the stack each, a fifth of a visit), hence ``forceinline``, which takes less time to compile than
``inline="always"``; smaller segments (up to 1.4 times slower).

``planes`` does the arithmetic of a group. Here are the visit of a block, the exchange between blocks, and the sweeps.
Within a turn all groups of a segment have one width, as a step never takes more planes than the widest step around it
took before. So a turn counts planes once, not at every iteration.

Numba keeps the compiled ``advance`` and ``lift`` until *this* file changes, and sees no edit in ``CALLED``. A test
compares CALLED_DIGEST with those files. After an edit there, the new digest here makes numba compile anew.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, get, load, put, spread, store, zeros
from codesign.planners.harmonic.plan.layout import EAST, INSIDE, LANES, NORTH, SLOTS, SOUTH, WEST, WORD_BITS, WORD_BYTES
from codesign.planners.harmonic.plan.planes import (
    add_gains,
    add_signed_gains,
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


CALLED = ("lanes", "layout", "planes")
CALLED_DIGEST = "8d731b2332ae4615"

RUNNING, CONVERGED, GROW, CYCLE = range(4)
POSITION, DONE_ITERATIONS, UNSETTLED, SWEEPS, POWER, SINCE = range(6)
CONTROL_SIZE = 6


@njit(cache=True, nogil=True)
def lift(old_layout, old, layout, new, shift, signed):
    """Set r to the r of ``old`` << ``shift``, in planes and widths that are zero before."""
    #   plane   0 .. shift - 1   shift   shift + 1  ..
    #           0    0           r_0     r_1        ..
    from_block, to_block = old_layout.planes * old_layout.plane, layout.planes * layout.plane
    for block in range(layout.down * layout.across):
        for segment in range(old_layout.segments):
            planes = get(old.width, block * old_layout.segments + segment) + 2
            begin, end = get(old.begin, segment), get(old.end, segment)
            for plane in range(planes):
                source = block * from_block + plane * layout.plane
                target = block * to_block + (plane + shift) * layout.plane
                for word in range(begin, end, LANES):
                    store(new.residual, target + word, load(old.residual, source + word))
            # r of 2 planes, its steps 0, is now t = r >> 2 with ``shift`` planes: the stage begins unsettled.
            # A segment of this layout may lie in one of the last, or be made of several.
            width = planes + shift if signed and planes == 2 else planes + shift - 2
            for place in range(layout.segments):
                if begin < get(new.end, place) and get(new.begin, place) < end:
                    own = block * layout.segments + place
                    put(new.width, own, max(get(new.width, own), width))
        trim(layout, new, block, signed)


@njit(forceinline=True, nogil=True)
def _has_room(layout, state, block, iterations):
    """True if a visit cannot need more planes than there is room for, here or in a neighbouring block."""
    # d of a visit adds up at most I steps, each below 2^active: active + bit_length(I) planes hold it. The 8 more are
    # room for the two planes of r below its steps and for carries under way in ``planes``. The neighbours' r grows by
    # d of this visit.
    bits = 8
    while iterations > 0:
        bits += 1
        iterations >>= 1
    need = max(get(state.active, block) + bits, get(state.deepest, block) + 2)
    for segment in range(layout.segments):
        need = max(need, get(state.visit_width, segment) + 8)
    row, column = block // layout.across, block % layout.across
    if row > 0:
        need = max(need, get(state.active, block - layout.across) + 8)
    if row < layout.down - 1:
        need = max(need, get(state.active, block + layout.across) + 8)
    if column > 0:
        need = max(need, get(state.active, block - 1) + 8)
    if column < layout.across - 1:
        need = max(need, get(state.active, block + 1) + 8)
    return need <= layout.planes


@njit(nogil=True)
def _same(layout, state):
    for block in range(layout.down * layout.across):
        if get(state.active, block) != get(state.snapshot_active, block):
            return False
    for block in range(layout.down * layout.across):
        first = block * layout.planes * layout.plane
        for word in range(first, first + (get(state.active, block) + 2) * layout.plane):
            if get(state.residual, word) != get(state.snapshot, word):
                return False
    return True


@njit(nogil=True)
def _repeats(layout, state, control):
    """True if r is the same as at an earlier sweep (Brent's method), so that the sweeps would never end."""
    # Without a sign values only rise up to a bound; with one, finitely many states in a deterministic sweep either
    # settle or come back. The snapshot is renewed at sweeps 1, 3, 7, 15, ..: once it lies on the cycle and the wait is
    # as long as the cycle, the two meet.
    if _same(layout, state):
        return True
    control[SINCE] += 1
    if control[SINCE] == control[POWER]:
        control[SINCE] = 0
        control[POWER] *= 2
        for block in range(layout.down * layout.across):
            put(state.snapshot_active, block, get(state.active, block))
            first = block * layout.planes * layout.plane
            for word in range(first, first + (get(state.active, block) + 2) * layout.plane):
                put(state.snapshot, word, get(state.residual, word))
    return False


@njit(cache=True, nogil=True)
def advance(layout, state, control, counts, iterations, budget, published, signed):
    """Visit block after block in raster order.

    Args:
        control: int64, what carries over from call to call.
        counts: int32, filled with the iterations of each visit.
        iterations: most iterations of a visit. budget: words times iterations after which to return, about.
        published: the published termination test instead of the sound one.
        signed: r may be negative.

    Returns the status (RUNNING: call again; CONVERGED; GROW: more planes are needed, then call again; CYCLE) and
    the number of visits written. A visit may be interrupted; the next call continues it.
    """
    # The loop over blocks of the paper's listing (section 4), for one precision:
    #
    #   converge := true
    #   for b := 1 to B:   visit b (at most I iterations);   if not block_cvg: converge := false
    #
    # block_cvg is that the *last* iteration changed nothing. A block that changed and then settled counts as converged
    # there, although its neighbours have not seen its values: ``published``. The sound test asks that no iteration of
    # the sweep changed a bit.
    written = 0
    while written < len(counts) and budget > 0:
        block = control[POSITION]
        # Position counts blocks along the rows of the map; transposed, these are the columns of the layout.
        if layout.transposed:
            block = block % layout.down * layout.across + block // layout.down
        # A settled block still takes the one iteration in which the circuit sees that nothing changes.
        if get(state.active, block) == 0 and control[DONE_ITERATIONS] == 0:
            counts[written] = 1
        else:
            if not _has_room(layout, state, block, iterations):
                return GROW, written
            done, budget = visit_block(layout, state, block, control[DONE_ITERATIONS], iterations, budget, signed)
            finished = done == iterations
            if get(state.active, block) > 0 and not finished:
                control[DONE_ITERATIONS] = done
                return RUNNING, written
            # A settled block takes one more iteration, which changes nothing.
            counts[written] = done + (not finished)
            # Only now do the neighbours see the block's values: they were fixed during the visit.
            add_visit(layout, state, block, signed)
            push_all(layout, state, block, signed)
            for segment in range(layout.segments):
                put(state.visit_width, segment, 0)
            control[DONE_ITERATIONS] = 0
            if finished or not published:
                control[UNSETTLED] = 1
        written += 1
        budget -= 1
        control[POSITION] += 1
        if control[POSITION] == layout.down * layout.across:
            control[POSITION] = 0
            control[SWEEPS] += 1
            if control[UNSETTLED] == 0:
                return CONVERGED, written
            control[UNSETTLED] = 0
            if signed and _repeats(layout, state, control):
                return CYCLE, written
    return RUNNING, written
