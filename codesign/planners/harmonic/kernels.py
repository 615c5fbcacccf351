# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""The relaxation of one stage as bit planes: 512 nodes an instruction, and no lane to overflow.

With h = (H << D) + d within a stage, keep of every node its residual r = N + E + S + W - 4h instead of h
itself. An iteration adds t = floor(r / 4), the node's *step*, to h, so that

    r' = (r mod 4) + t_N + t_E + t_S + t_W        d' = d + t

and an iteration changes a bit if and only if some step is not 0. Four things follow:

- **r never outgrows its bits.** From 0 <= r < 2^k follows r' <= 3 + 4 (2^(k-2) - 1) < 2^k, and likewise from
  -2^(k-1) <= r < 2^(k-1) in two's complement. So within a visit nothing overflows and nothing is widened; and
  where steps are 0 or 1, an iteration is a cellular automaton. The precision p does not occur at all.
- **The next stage starts from r << D**, without a look at the wide values.
- **d is needed** at the borders of a block at the end of its visit, where it goes to r of the neighbours, and
  everywhere at the end of a stage; not in between. So the steps of four iterations are added up at once.
- **From r >= 0 values only rise**, in any order of blocks. Only a start that has some r < 0 needs a sign, and
  only from there can the sweeps go on for ever; that is noticed.

Bit i of r over a whole block is a *plane*. Bit b of a word is a column, eight words below each other are a
vector of 512 nodes (a *group*), and an integer a node is a column of bits through the planes; sums are chains
of full adders. North and south are the same plane one word off, west and east one bit off. Every group keeps
count of the planes it needs, so that quiet parts of a block cost little and settled ones next to nothing; a
settled block costs no more than a look.

What it takes: of each plane and group, an iteration loads three vectors (two of them across cache lines), does
12 logic operations and stores one vector: 256 bytes and 12 operations for 512 nodes and one bit of t. On an
AMD EPYC of the Zen 4 kind that is 2.6 to 3 ns, about 9 cycles: operations (two vectors a cycle) and accesses
(one line a cycle, a store every other) are about balanced. A machine without 512-bit registers takes two or
four times as many operations. With few iterations a visit, what is done at its ends costs as much again.

Tried and left: the majority as one instruction instead of two (an intrinsic of x86 alone, a few percent, lost
in noise); one width a block instead of one a group (up to 1.8 times slower); planes of all blocks side by side
(they fell on each other in the cache); numba's arrays inside the kernel (reference counts at every use, 5 times
slower), hence addresses.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.lanes import any_bit, get, load, one_lane, put, spread, store, zeros
from codesign.planners.harmonic.layout import LANES, SLOTS, WORD_BITS

RUNNING, CONVERGED, GROW, CYCLE = range(4)
POSITION, DONE_ITERATIONS, UNSETTLED, SWEEPS, POWER, SINCE = range(6)
CONTROL_SIZE = 6


@njit(cache=True)
def _majority(a, b, c):
    """The carry of a + b + c, whose sum is a ^ b ^ c."""
    return (a & b) | (c & (a | b))


@njit(cache=True)
def _add_seven(n, s, e, w, a, b, c):
    """Sum and the three carries of seven bits of equal weight."""
    first = n ^ s ^ e
    second = first ^ w ^ a
    return second ^ b ^ c, _majority(n, s, e), _majority(first, w, a), _majority(second, b, c)


@njit(cache=True)
def _around(layout, ring, at):
    """North, south, east and west of eight words of a plane."""
    one, last = spread(np.uint64(1)), spread(np.uint64(WORD_BITS - 1))
    centre = load(ring, at)
    west, east = centre << one, centre >> one
    if layout.columns > 1:
        west |= load(ring, at - layout.stride) >> last
        east |= load(ring, at + layout.stride) << last
    return load(ring, at - 1), load(ring, at + 1), east, west


@njit(cache=True, inline="always")
def _needed(planes, at, step, count, least, signed):
    """``count`` less the planes of a group, at the top, that say nothing; not below ``least``."""
    while count > least:
        top = load(planes, at + (count - 1) * step)
        if signed and count > least + 1:
            top ^= load(planes, at + (count - 2) * step)
        if any_bit(top):
            break
        count -= 1
    return count


@njit(cache=True, inline="always")
def _iterate_group(layout, ring, free, source, target, width, signed):
    """One iteration of eight words of a block."""
    step = layout.plane
    at, out = source + 2 * step, target
    n, s, e, w = _around(layout, ring, at)
    low, c = load(ring, source), load(ring, source + step)
    around = n ^ s ^ e
    store(ring, out, (around ^ w ^ low) & free)
    a, b = _majority(n, s, e), _majority(around, w, low)
    for _ in range(1, width):
        at += step
        out += step
        n, s, e, w = _around(layout, ring, at)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out, total & free)
    out += step
    if signed:
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out, total & free)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out + step, total & free)
    else:
        store(ring, out, (a ^ b ^ c) & free)
        store(ring, out + step, _majority(a, b, c) & free)


@njit(cache=True)
def _iterate(layout, state, block, source, target, uniform, signed):
    """One iteration of a block, from one slot of the ring to another; the planes that the next steps take.

    ``uniform``: the planes of the steps of all groups, where r has a sign.
    """
    ring, step, widths = state.ring, layout.plane, state.ring_width
    from_width, to_width = source * layout.groups, target * layout.groups
    source *= layout.planes * step
    target *= layout.planes * step
    aside = layout.stride // LANES
    most = 0
    for column in range(layout.first, layout.end, layout.stride):
        for word in range(column, column + layout.rows, LANES):
            here = from_width + word // LANES
            width = (
                uniform if signed else max(get(widths, here - 1), get(widths, here), get(widths, here + 1))
            )
            if layout.columns > 1 and not signed:
                width = max(width, get(widths, here - aside), get(widths, here + aside))
            needed = 0
            if width > 0:
                free = load(state.mask, block * step + word)
                _iterate_group(layout, ring, free, source + word, target + word, width, signed)
                needed = _needed(ring, target + word, step, width + 2, 2, signed) - 2
                most = max(most, needed)
            else:
                store(ring, target + word, load(ring, source + word))
                store(ring, target + step + word, load(ring, source + step + word))
            there = to_width + word // LANES
            if not signed:
                for plane in range(width, get(widths, there)):
                    store(ring, target + (plane + 2) * step + word, zeros())
            put(widths, there, uniform if signed else needed)
    return most


@njit(cache=True, inline="always")
def _carry_on(planes, at, step, plane, have, carry):
    """Add a carry from ``plane`` on to an unsigned number of ``have`` planes; the planes it has then."""
    while any_bit(carry):
        here = at + plane * step
        digit = load(planes, here) if plane < have else zeros()
        store(planes, here, digit ^ carry)
        carry &= digit
        plane += 1
    return max(have, plane)


@njit(cache=True, inline="always")
def _sum_steps(ring, steps, slots, visit, at, step, width, have):
    """Add four unsigned steps of ``width`` planes to a group of ``visit``; the planes it has then, about."""
    s0, s1, s2, s3 = slots
    a = b = c = d = zeros()
    for plane in range(width):
        digit = load(visit, at + plane * step) if plane < have else zeros()
        t0, t1, t2, t3 = (
            load(ring, s0 + steps),
            load(ring, s1 + steps),
            load(ring, s2 + steps),
            load(ring, s3 + steps),
        )
        first = t0 ^ t1 ^ t2
        second = t3 ^ digit ^ a
        third = first ^ second ^ b
        store(visit, at + plane * step, third ^ c ^ d)
        d = _majority(third, c, d)
        a, b, c = _majority(t0, t1, t2), _majority(t3, digit, a), _majority(first, second, b)
        steps += step
    digit = load(visit, at + width * step) if width < have else zeros()
    first = a ^ b ^ c
    store(visit, at + width * step, first ^ d ^ digit)
    a, b = _majority(a, b, c), _majority(first, d, digit)
    digit = load(visit, at + (width + 1) * step) if width + 1 < have else zeros()
    store(visit, at + (width + 1) * step, a ^ b ^ digit)
    return _carry_on(visit, at, step, width + 2, max(have, width + 2), _majority(a, b, digit))


@njit(cache=True)
def _sum_signed_steps(ring, steps, slots, visit, at, step, width, have):
    """``_sum_steps`` in two's complement."""
    total = max(have, width + 2) + 1
    x = t0 = t1 = t2 = t3 = a = b = c = d = zeros()
    for plane in range(total):
        if plane < width:
            t0, t1 = load(ring, slots[0] + steps), load(ring, slots[1] + steps)
            t2, t3 = load(ring, slots[2] + steps), load(ring, slots[3] + steps)
            steps += step
        if plane < have:
            x = load(visit, at)
        first = t0 ^ t1 ^ t2
        second = t3 ^ x ^ a
        third = first ^ second ^ b
        store(visit, at, third ^ c ^ d)
        d = _majority(third, c, d)
        a, b, c = _majority(t0, t1, t2), _majority(t3, x, a), _majority(first, second, b)
        at += step
    return total


@njit(cache=True)
def _accumulate(layout, state, s0, s1, s2, s3, uniform, signed):
    """Add the steps of four slots of the ring to what the visit added so far."""
    step, ring, visit, groups, widths = layout.plane, state.ring, state.visit, layout.groups, state.ring_width
    slot = layout.planes * step
    slots = s0 * slot, s1 * slot, s2 * slot, s3 * slot
    for word in range(layout.first, layout.end, LANES):
        group = word // LANES
        have = get(state.visit_width, group)
        if signed:
            have = _sum_signed_steps(ring, word + 2 * step, slots, visit, word, step, uniform, have)
        else:
            width = max(
                get(widths, s0 * groups + group),
                get(widths, s1 * groups + group),
                get(widths, s2 * groups + group),
                get(widths, s3 * groups + group),
            )
            if width == 0:
                continue
            have = _sum_steps(ring, word + 2 * step, slots, visit, word, step, width, have)
        put(state.visit_width, group, _needed(visit, word, step, have, 0, signed))


@njit(cache=True, inline="always")
def _add(planes, at, have, gains, source, count, right, left, select, step, signed):
    """Add gains, shifted ``right``, then ``left``, where selected, to a number; the planes it has then, about.

    Both numbers are given by the word of their lowest plane and how many planes they have.
    """
    x = y = carry = zeros()
    for plane in range(count):
        x = ((load(gains, source + plane * step) >> right) << left) & select
        if plane < have:
            y = load(planes, at + plane * step)
        elif not signed:
            y = zeros()
        store(planes, at + plane * step, x ^ y ^ carry)
        carry = _majority(x, y, carry)
    if not signed:
        return _carry_on(planes, at, step, count, max(have, count), carry)
    total = max(have, count) + 1
    for plane in range(count, total):
        if plane < have:
            y = load(planes, at + plane * step)
        store(planes, at + plane * step, x ^ y ^ carry)
        carry = _majority(x, y, carry)
    return total


@njit(cache=True)
def _add_visit(layout, state, block, signed):
    """Add what the visit added to d of its block."""
    none, everything = spread(np.uint64(0)), spread(~np.uint64(0))
    base = block * layout.planes * layout.plane
    for word in range(layout.first, layout.end, LANES):
        count = get(state.visit_width, word // LANES)
        if count > 0:
            group = block * layout.groups + word // LANES
            at, have = base + word, get(state.odometer_width, group)
            have = _add(
                state.odometer,
                at,
                have,
                state.visit,
                word,
                count,
                none,
                none,
                everything,
                layout.plane,
                signed,
            )
            width = _needed(state.odometer, at, layout.plane, have, 0, signed)
            put(state.odometer_width, group, width)
            put(state.deepest, block, max(get(state.deepest, block), width))


@njit(cache=True)
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


@njit(cache=True)
def _trim(layout, state, block, signed):
    """Lower the widths of a block to what r needs. Visits rely on it: settled and of width 0 are the same."""
    base = block * layout.planes * layout.plane
    most = 0
    for word in range(layout.first, layout.end, LANES):
        group = block * layout.groups + word // LANES
        count = get(state.width, group) + 2
        put(state.width, group, _needed(state.residual, base + word, layout.plane, count, 2, signed) - 2)
        most = max(most, get(state.width, group))
    if signed:
        for word in range(layout.first, layout.end, LANES):
            put(state.width, block * layout.groups + word // LANES, most)
    put(state.active, block, most)


@njit(cache=True)
def trim_all(layout, state, signed):
    """Lower all widths to what r needs."""
    for block in range(layout.down * layout.across):
        _trim(layout, state, block, signed)


@njit(cache=True)
def _push(layout, state, block, source, target, vectors, right, left, select, signed):
    """Add what border nodes of the visited block gained to r of their neighbours in ``block``.

    ``source`` and ``target`` are the first words in either; the gains are shifted ``right``, then ``left``.
    """
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
            have = max(have + 1, count)
            _widen(layout, state, block, have + 1)
        at = base + target + word
        have = _add(residual, at, have, visit, source + word, count, right, left, selected, step, signed)
        if signed:
            _trim(layout, state, block, signed)
        else:
            width = _needed(residual, at, step, have, 2, signed) - 2
            put(state.width, group, width)
            put(state.active, block, max(get(state.active, block), width))


@njit(cache=True)
def _push_all(layout, state, block, signed):
    """Tell the four neighbouring blocks what the border nodes gained."""
    row, column = block // layout.across, block % layout.across
    none, one = spread(np.uint64(0)), spread(np.uint64(1))
    shift = spread(np.uint64((layout.block_columns - 1) % WORD_BITS))
    first, last = layout.first, layout.end - layout.stride + LANES
    bottom = layout.block_rows - 1
    lane = bottom % LANES
    if column > 0:
        vectors = layout.rows // LANES
        _push(layout, state, block - 1, first, last, vectors, none, shift, one << shift, signed)
    if column < layout.across - 1:
        vectors = layout.rows // LANES
        _push(layout, state, block + 1, last, first, vectors, shift, none, one, signed)
    for top in range(first, last + 1, layout.stride):
        if row > 0:
            select = one_lane(lane)
            _push(
                layout,
                state,
                block - layout.across,
                top - lane,
                top + bottom - lane,
                1,
                none,
                none,
                select,
                signed,
            )
        if row < layout.down - 1:
            select = one_lane(0)
            _push(layout, state, block + layout.across, top + bottom, top, 1, none, none, select, signed)


@njit(cache=True)
def _enter(layout, state, block, signed):
    """Copy r of a block into the first slot of the ring."""
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


@njit(cache=True)
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


@njit(cache=True)
def _visit(layout, state, control, block, iterations, budget, signed):
    """Iterate a block until it settles, ``iterations`` are done or the budget is spent; the budget left."""
    width, done = get(state.active, block), control[DONE_ITERATIONS]
    _enter(layout, state, block, signed)
    current = 0
    while width > 0 and done < iterations and budget > 0:
        before, made = current, 0
        uniform = width if signed else 0
        while made < SLOTS and width > 0 and done < iterations:
            following = (current + 1) % (SLOTS + 1)
            width = _iterate(layout, state, block, current, following, uniform, signed)
            current = following
            made += 1
            done += 1
        nothing = SLOTS + 1
        s1 = (before + 1) % (SLOTS + 1) if made > 1 else nothing
        s2 = (before + 2) % (SLOTS + 1) if made > 2 else nothing
        s3 = (before + 3) % (SLOTS + 1) if made > 3 else nothing
        _accumulate(layout, state, before, s1, s2, s3, uniform, signed)
        budget -= made * layout.columns * layout.rows
    _leave(layout, state, block, current)
    put(state.active, block, width)
    if signed:
        _trim(layout, state, block, signed)
    control[DONE_ITERATIONS] = done
    return budget


@njit(cache=True)
def _has_room(layout, state, block, iterations):
    """Whether a visit cannot need more planes than there is room for, here or in a neighbouring block."""
    bits = 8
    while iterations > 0:
        bits += 1
        iterations >>= 1
    need = max(get(state.active, block) + bits, get(state.deepest, block) + 2)
    for group in range(layout.groups):
        need = max(need, get(state.visit_width, group) + 8)
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


@njit(cache=True)
def _same(layout, state):
    """Whether r is what the snapshot holds."""
    for block in range(layout.down * layout.across):
        if get(state.active, block) != get(state.snapshot_active, block):
            return False
    for block in range(layout.down * layout.across):
        first = block * layout.planes * layout.plane
        for word in range(first, first + (get(state.active, block) + 2) * layout.plane):
            if get(state.residual, word) != get(state.snapshot, word):
                return False
    return True


@njit(cache=True)
def _repeats(layout, state, control):
    """Whether r is what it was at an earlier sweep (Brent's method), so that the sweeps would never end."""
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
    the number of visits written. A visit may be left half done, and is gone on with in the next call.
    """
    made = 0
    while made < len(counts) and budget > 0:
        block = control[POSITION]
        if layout.transposed:
            block = block % layout.down * layout.across + block // layout.down
        if get(state.active, block) == 0 and control[DONE_ITERATIONS] == 0:
            counts[made] = 1
        else:
            if not _has_room(layout, state, block, iterations):
                return GROW, made
            budget = _visit(layout, state, control, block, iterations, budget, signed)
            finished = control[DONE_ITERATIONS] == iterations
            if get(state.active, block) > 0 and not finished:
                return RUNNING, made
            # A settled block takes one more iteration, which changes nothing.
            counts[made] = control[DONE_ITERATIONS] + (not finished)
            _add_visit(layout, state, block, signed)
            _push_all(layout, state, block, signed)
            for group in range(layout.groups):
                put(state.visit_width, group, 0)
            control[DONE_ITERATIONS] = 0
            if finished or not published:
                control[UNSETTLED] = 1
        made += 1
        budget -= 1
        control[POSITION] += 1
        if control[POSITION] == layout.down * layout.across:
            control[POSITION] = 0
            control[SWEEPS] += 1
            if control[UNSETTLED] == 0:
                return CONVERGED, made
            control[UNSETTLED] = 0
            if signed and _repeats(layout, state, control):
                return CYCLE, made
    return RUNNING, made
