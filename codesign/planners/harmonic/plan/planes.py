# mypy: ignore-errors
# The compiler of numba gives types to the kernels.
"""Arithmetic of one group: chains of full adders over the planes of eight words, 512 nodes at once.

``kernels`` defines r, its steps and their sums, and explains why an edit here requires one there.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from codesign.planners.harmonic.plan.lanes import any_bit, load, spread, store, zeros
from codesign.planners.harmonic.plan.layout import WORD_BITS


@njit(nogil=True)
def _majority(a, b, c):
    """The carry of a + b + c. The sum is a ^ b ^ c."""
    # Bit by bit a + b + c = 2 · carry + sum: a full adder, 64 of them in a word.
    return (a & b) | (c & (a | b))


@njit(nogil=True)
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
    return second ^ b ^ c, _majority(n, s, e), _majority(first, w, a), _majority(second, b, c)


@njit(nogil=True)
def _around(layout, ring, at):
    """North, south, east and west of eight words of a plane."""
    one_bit, other_bits = spread(np.uint64(1)), spread(np.uint64(WORD_BITS - 1))
    # A word holds 64 columns of one row, bit b for column b; the next row is the next word:
    #
    #    at - stride          at             at + stride
    #   ..  61 62 63 |  0  1  2 ..  63 |  0  1  2  ..
    #              '--> <<1       >>1 <--'
    #
    # << 1 puts each node's western neighbour into its own bit. Bit 0 has it in bit 63 of the word column to the west.
    # With one word column the zeros that a shift brings in are right: outside of the block every step is 0
    # (``layout``).
    centre = load(ring, at)
    west, east = centre << one_bit, centre >> one_bit
    if layout.columns > 1:
        west |= load(ring, at - layout.stride) >> other_bits
        east |= load(ring, at + layout.stride) << other_bits
    return load(ring, at - 1), load(ring, at + 1), east, west


@njit(inline="always", nogil=True)
def needed_planes(planes, at, step, count, least, signed):
    """``count`` less the redundant planes at the top of a group; not below ``least``."""
    while count > least:
        # Such a plane is all 0 or, in two's complement, a copy of the plane below it: both hold the sign.
        top = load(planes, at + (count - 1) * step)
        if signed and count > least + 1:
            top ^= load(planes, at + (count - 2) * step)
        if any_bit(top):
            break
        count -= 1
    return count


@njit(inline="always", nogil=True)
def iterate_group(layout, ring, free, source, target, width, signed):
    """One iteration of eight words of a block."""
    step = layout.plane
    # r' = (r mod 4) + t_N + t_E + t_S + t_W with t = r >> 2. The shift is free: plane i of t is plane i + 2 of r.
    #
    #   weight       2^(w-1)  ..   2    1
    #   t_N          n        ..   n    n
    #   t_E          e        ..   e    e
    #   t_S          s        ..   s    s        seven bits in each column: four of the steps, three of carries
    #   t_W          w        ..   w    w
    #   r mod 4                    c    low      plane 0 takes no carries, so only two leave it: a and b.
    #   carries      a b c    ..   a b           Plane 1 of r fills the place of the third, c.
    at, out = source + 2 * step, target
    n, s, e, w = _around(layout, ring, at)
    low, c = load(ring, source), load(ring, source + step)
    around = n ^ s ^ e
    # ``free`` keeps r of obstacles, of goals and of cells outside of the map at 0, so that they never step.
    store(ring, out, (around ^ w ^ low) & free)
    a, b = _majority(n, s, e), _majority(around, w, low)
    for _ in range(1, width):
        at += step
        out += step
        n, s, e, w = _around(layout, ring, at)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out, total & free)
    out += step
    # The carries that are left, of weight 2^w, fill two planes more: r' has w + 2, as r had. With a sign, copies of
    # the top planes of the steps are added as well, and carries beyond plane w + 1 are dropped (modulo 2^(w+2)).
    if signed:
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out, total & free)
        total, a, b, c = _add_seven(n, s, e, w, a, b, c)
        store(ring, out + step, total & free)
    else:
        store(ring, out, (a ^ b ^ c) & free)
        store(ring, out + step, _majority(a, b, c) & free)


@njit(inline="always", nogil=True)
def _carry_on(planes, at, step, plane, have, carry):
    """Add a carry from ``plane`` on to an unsigned number of ``have`` planes; the planes it has then."""
    # A half adder a plane, until none of the 512 nodes carries.
    while any_bit(carry):
        here = at + plane * step
        digit = load(planes, here) if plane < have else zeros()
        store(planes, here, digit ^ carry)
        carry &= digit
        plane += 1
    return max(have, plane)


@njit(inline="always", nogil=True)
def sum_steps(ring, steps, slots, visit, at, step, width, have):
    """Add four unsigned steps of ``width`` planes to a group of ``visit``; the planes it has then, about."""
    # x + t_0 + t_1 + t_2 + t_3 with x the sum so far: nine bits of weight 2^i, five of numbers and four of carries,
    # give one bit of the sum and four carries of weight 2^(i+1), in four full adders:
    #
    #  t0 t1 t2   t3 x  a     b       c d
    #  [  FA  ]---[ FA ]---[ FA ]---[ FA ]--- sum
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
    # Above the steps: x and four carries in plane ``width``, x and two in the next, x and one from there on.
    digit = load(visit, at + width * step) if width < have else zeros()
    first = a ^ b ^ c
    store(visit, at + width * step, first ^ d ^ digit)
    a, b = _majority(a, b, c), _majority(first, d, digit)
    digit = load(visit, at + (width + 1) * step) if width + 1 < have else zeros()
    store(visit, at + (width + 1) * step, a ^ b ^ digit)
    return _carry_on(visit, at, step, width + 2, max(have, width + 2), _majority(a, b, digit))


@njit(nogil=True)
def sum_signed_steps(ring, steps, slots, visit, at, step, width, have):
    """``sum_steps`` in two's complement."""
    # Four steps take two bits more than one of them, and x added to that one bit more. Numbers that have ended go on
    # with their sign: t0 .. t3 and x are not loaded again and keep their last plane.
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


@njit(inline="always", nogil=True)
def add_gains(planes, at, have, gains, source, count, right, left, select, step, signed):
    """Add gains, shifted ``right``, then ``left``, where selected, to a number; the planes it has then, about.

    Both numbers are given by the word of their lowest plane and how many planes they have.
    """
    # Ripple carry. The gains go from one block to another across a border, so their column or row is first moved to
    # where the neighbour stands in its own words, and all other nodes are left out (``select``).
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
    # Both numbers go on with their sign, the last plane loaded.
    total = max(have, count) + 1
    for plane in range(count, total):
        if plane < have:
            y = load(planes, at + plane * step)
        store(planes, at + plane * step, x ^ y ^ carry)
        carry = _majority(x, y, carry)
    return total
