# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""Arithmetic of one group: chains of full adders over the planes of eight words, 512 nodes at once.

``kernels`` defines r, its steps and their sums, and explains why an edit here requires one there. Numbers are given by
the address of their planes and the word of a group in the lowest of them; ``step`` words lead to the next plane.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, load, majority, shift_down, shift_up, spread, store, zeros
from codesign.planners.harmonic.plan.layout import EAST, INSIDE, LANES, WEST


@njit(inline="always", nogil=True)
def _around(at, pitch, beside):
    """North, south, east and west of the eight words at an address. ``beside``: in bytes."""
    # Rows follow each other after ``pitch`` bytes, so north and south are the same plane ``pitch`` bytes off; columns
    # are bits. One bit up puts each node's western neighbour into its own bit:
    #
    #    at - beside          at             at + beside
    #   ..  61 62 63 |  0  1  2 ..  63 |  0  1  2  ..
    #              '--> up       down <--'
    #
    # Bit 0 has it in bit 63 of the word before, or of the word column to the west. Where rows fill whole words, the
    # zeros that a shift brings in are right: outside of the block every step is 0 (``layout``).
    centre = load(at, 0)
    if beside > 0:
        west = shift_up(centre, load(at - beside, 0))
        east = shift_down(load(at + beside, 0), centre)
    else:
        one_bit = spread(np.uint64(1))
        west, east = centre << one_bit, centre >> one_bit
    return load(at - pitch, 0), load(at + pitch, 0), east, west


@njit(inline="always", nogil=True)
def _add_seven(n, s, e, w, a, b, c):
    """Sum and the three carries of seven bits of equal weight."""
    # A 7-to-3 counter made of three full adders (FA), the number that the paper's Update module has (section 5.2):
    #
    #   n s e    w a     b c
    #   | | |    | |     | |
    #  [ FA ]--[ FA  ]--[ FA ]-- sum          n + s + e + w + a + b + c = sum + 2 · (the three carries)
    #    |        |        |
    #  carry    carry    carry                those of plane i are the a, b, c of plane i + 1
    first = n ^ s ^ e
    second = first ^ w ^ a
    return second ^ b ^ c, majority(n, s, e), majority(first, w, a), majority(second, b, c)


@njit(inline="always", nogil=True)
def iterate_group(source, target, free, step, width, pitch, beside, signed):
    """One iteration of the eight words at ``source``. In bytes: ``step`` to the next plane, ``pitch``, ``beside``."""
    # r' = (r mod 4) + t_N + t_E + t_S + t_W with t = r >> 2. The shift is free: plane i of t is plane i + 2 of r.
    #
    #   weight       2^(w-1)  ..   2    1
    #   t_N          n        ..   n    n
    #   t_E          e        ..   e    e
    #   t_S          s        ..   s    s        seven bits in each column: four of the steps, three of carries
    #   t_W          w        ..   w    w
    #   r mod 4                    c    low      plane 0 takes no carries, so only two leave it: a and b.
    #   carries      a b c    ..   a b           Plane 1 of r fills the place of the third, c.
    at = source + 2 * step
    n, s, e, w = _around(at, pitch, beside)
    low, c = load(source, 0), load(source + step, 0)
    around = n ^ s ^ e
    # ``free`` keeps r of obstacles, of goals and of cells outside of the map at 0, so that they never step.
    store(target, 0, (around ^ w ^ low) & free)
    a, b = majority(n, s, e), majority(around, w, low)
    # A loop over addresses: the compiler unrolls a loop over a range, and then lacks registers for the addresses.
    last = at + (width - 1) * step
    while at != last:
        at += step
        target += step
        n, s, e, w = _around(at, pitch, beside)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(target, 0, total & free)
    target += step
    # The carries that are left, of weight 2^w, fill two planes more: r' has w + 2, as r had. With a sign, copies of
    # the top planes of the steps are added as well, and carries beyond plane w + 1 are dropped (modulo 2^(w+2)).
    if signed:
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(target, 0, total & free)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(target + step, 0, total & free)
    else:
        store(target, 0, (a ^ b ^ c) & free)
        store(target + step, 0, majority(a, b, c) & free)


@njit(inline="always", nogil=True)
def needed_planes(planes, begin, end, step, count, least, signed):
    """``count`` less the redundant planes at the top of the groups from ``begin`` to ``end``; not below ``least``."""
    while count > least:
        # Such a plane is all 0 or, in two's complement, a copy of the plane below it: both hold the sign.
        some = zeros()
        for at in range(begin + (count - 1) * step, end + (count - 1) * step, LANES):
            top = load(planes, at)
            if signed and count > least + 1:
                top ^= load(planes, at - step)
            some |= top
        if any_bit(some):
            break
        count -= 1
    return count


@njit(inline="always", nogil=True)
def clear_planes(planes, begin, end, step, first, last):
    """Zero the planes from ``first`` to ``last``, exclusive, of the groups from ``begin`` to ``end``."""
    for plane in range(first, last):
        for at in range(begin + plane * step, end + plane * step, LANES):
            store(planes, at, zeros())


@njit(inline="always", nogil=True)
def _steps(slots, at):
    s0, s1, s2, s3, s4, s5 = slots
    return load(s0, at), load(s1, at), load(s2, at), load(s3, at), load(s4, at), load(s5, at)


@njit(inline="always", nogil=True)
def sum_steps(slots, at, visit, out, step, width):
    """Put the sum of six unsigned steps of ``width`` planes into ``width`` + 3 planes."""
    # Six numbers and five carries of weight 2^i give one bit of the sum and five carries of weight 2^(i+1), in five
    # full adders:
    #
    #  t0 t1 t2   t3 t4 t5
    #  [  FA  ]   [  FA  ]       a       b c     d e
    #      '---------'---------[ FA ]---[ FA ]---[ FA ]--- sum
    a = b = c = d = e = zeros()
    for _ in range(width):
        t0, t1, t2, t3, t4, t5 = _steps(slots, at)
        first, second = t0 ^ t1 ^ t2, t3 ^ t4 ^ t5
        third = first ^ second ^ a
        fourth = third ^ b ^ c
        store(visit, out, fourth ^ d ^ e)
        e = majority(fourth, d, e)
        d = majority(third, b, c)
        c = majority(first, second, a)
        a, b = majority(t0, t1, t2), majority(t3, t4, t5)
        at += step
        out += step
    # Five carries are left.
    first = a ^ b ^ c
    store(visit, out, first ^ d ^ e)
    a, b = majority(a, b, c), majority(first, d, e)
    store(visit, out + step, a ^ b)
    store(visit, out + 2 * step, a & b)


@njit(inline="always", nogil=True)
def sum_more_steps(slots, at, visit, out, step, width, have):
    """Add six unsigned steps of ``width`` planes to a sum of ``have`` planes: max(``have``, ``width`` + 3) + 1 then."""
    # As ``sum_steps``, with the sum so far, x, in one more full adder.
    x = a = b = c = d = e = f = zeros()
    for plane in range(width):
        t0, t1, t2, t3, t4, t5 = _steps(slots, at)
        x = load(visit, out) if plane < have else zeros()
        first, second = t0 ^ t1 ^ t2, t3 ^ t4 ^ t5
        third = first ^ second ^ a
        fourth = third ^ b ^ c
        fifth = fourth ^ d ^ e
        store(visit, out, fifth ^ x ^ f)
        f = majority(fifth, x, f)
        e = majority(fourth, d, e)
        d = majority(third, b, c)
        c = majority(first, second, a)
        a, b = majority(t0, t1, t2), majority(t3, t4, t5)
        at += step
        out += step
    # Six carries are left, then three, two and one.
    x = load(visit, out) if width < have else zeros()
    first, second = a ^ b ^ c, d ^ e ^ f
    store(visit, out, first ^ second ^ x)
    a, b, c = majority(a, b, c), majority(d, e, f), majority(first, second, x)
    out += step
    x = load(visit, out) if width + 1 < have else zeros()
    first = a ^ b ^ c
    store(visit, out, first ^ x)
    a, b = majority(a, b, c), first & x
    out += step
    x = load(visit, out) if width + 2 < have else zeros()
    store(visit, out, a ^ b ^ x)
    a = majority(a, b, x)
    for _ in range(width + 3, have):
        out += step
        x = load(visit, out)
        store(visit, out, x ^ a)
        a &= x
    store(visit, out + step, a)


@njit(inline="always", nogil=True)
def sum_three_steps(slots, at, visit, out, step, width, have):
    """Add three unsigned steps to a sum of ``have`` planes; it has max(``have``, ``width`` + 2) + 1 then."""
    x = a = b = c = zeros()
    for plane in range(width):
        t0, t1, t2 = load(slots[0], at), load(slots[1], at), load(slots[2], at)
        x = load(visit, out) if plane < have else zeros()
        first = t0 ^ t1 ^ t2
        second = first ^ a ^ b
        store(visit, out, second ^ x ^ c)
        c = majority(second, x, c)
        b = majority(first, a, b)
        a = majority(t0, t1, t2)
        at += step
        out += step
    x = load(visit, out) if width < have else zeros()
    first = a ^ b ^ c
    store(visit, out, first ^ x)
    a, b = majority(a, b, c), first & x
    out += step
    x = load(visit, out) if width + 1 < have else zeros()
    store(visit, out, a ^ b ^ x)
    a = majority(a, b, x)
    for _ in range(width + 2, have):
        out += step
        x = load(visit, out)
        store(visit, out, x ^ a)
        a &= x
    store(visit, out + step, a)


@njit(nogil=True)
def sum_signed_steps(slots, at, visit, out, step, width, have):
    """``sum_more_steps`` in two's complement."""
    # Numbers that have ended go on with their sign: they are not loaded again and keep their last plane.
    x = a = b = c = d = e = f = zeros()
    t0 = t1 = t2 = t3 = t4 = t5 = zeros()
    for plane in range(max(have, width + 3) + 1):
        if plane < width:
            t0, t1, t2, t3, t4, t5 = _steps(slots, at)
            at += step
        if plane < have:
            x = load(visit, out)
        first, second = t0 ^ t1 ^ t2, t3 ^ t4 ^ t5
        third = first ^ second ^ a
        fourth = third ^ b ^ c
        fifth = fourth ^ d ^ e
        store(visit, out, fifth ^ x ^ f)
        f = majority(fifth, x, f)
        e = majority(fourth, d, e)
        d = majority(third, b, c)
        c = majority(first, second, a)
        a, b = majority(t0, t1, t2), majority(t3, t4, t5)
        out += step


@njit(inline="always", nogil=True)
def _moved(gains, source, shift, side, select):
    """Eight words of gains, moved from a border to where the neighbour stands in its own words."""
    x = load(gains, source)
    if side == WEST:
        x = x << shift
    elif side == EAST:
        x = x >> shift
    return x if side == INSIDE else x & select


@njit(inline="always", nogil=True)
def add_gains(planes, at, have, gains, source, count, shift, side, select, step):
    """Add gains to a number; what is carried out of it.

    The number has ``have`` planes, the gains ``count``. It has the more of both then, and one more, the carry. Gains
    that go across a border are shifted by columns, and all but the border's nodes are left out (``select``).
    """
    # Ripple carry.
    carry = zeros()
    for _ in range(min(have, count)):
        x, y = _moved(gains, source, shift, side, select), load(planes, at)
        store(planes, at, x ^ y ^ carry)
        carry = majority(x, y, carry)
        at += step
        source += step
    for _ in range(have, count):
        x = _moved(gains, source, shift, side, select)
        store(planes, at, x ^ carry)
        carry &= x
        at += step
        source += step
    # About half of 512 carries end at each plane, so some are left after a few. A look costs as much as a plane.
    top = at + max(have - count, 0) * step
    for plane in range(count, have):
        if plane >= count + 8 and not any_bit(carry):
            break
        y = load(planes, at)
        store(planes, at, y ^ carry)
        carry &= y
        at += step
    store(planes, top, carry)
    return carry


@njit(inline="always", nogil=True)
def add_signed_gains(planes, at, have, gains, source, count, shift, side, select, step):
    """``add_gains`` in two's complement; the planes that the number has then: one more than the longer."""
    x = y = carry = zeros()
    total = max(have, count) + 1
    # Both numbers go on with their sign, the last plane loaded.
    for plane in range(total):
        if plane < count:
            x = _moved(gains, source + plane * step, shift, side, select)
        if plane < have:
            y = load(planes, at + plane * step)
        store(planes, at + plane * step, x ^ y ^ carry)
        carry = majority(x, y, carry)
    return total
