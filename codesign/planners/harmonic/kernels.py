# mypy: ignore-errors
# ruff: noqa: ARG001
# The compiler of numba gives types to the kernels, and calls the generators with arguments some do without.
"""The relaxation of one stage as bit planes: 512 nodes an instruction, and no lane to overflow.

With h = (H << D) + d within a stage, keep of every node its residual r = N + E + S + W - 4h instead of h itself. An
iteration adds floor(r / 4) to h, so that with t = floor(r / 4) (the node's *step*)

    r' = (r mod 4) + t_N + t_E + t_S + t_W,        d' = d + t,        and a bit changes if and only if some t is not 0.

Three things follow, and this module stands on them:

- **r never needs more bits than it has.** From 0 <= r < 2^k follows r' <= 3 + 4 (2^(k-2) - 1) < 2^k, and likewise
  from -2^(k-1) <= r < 2^(k-1) in two's complement. Within a visit nothing can overflow, so nothing is widened; r only
  shrinks, and where it fits 3 bits an iteration is a cellular automaton of a few logic operations. Precision p does
  not occur at all: p = 63 and p = 1023 cost the same.
- **The next stage starts from r << D**, without a look at the wide values.
- d is needed only for the field at the end of the stage, and at the borders of a block at the end of a visit.

Layout. Bit b of a word is a column, a word holds 64 columns of one row, eight consecutive words are eight rows, one
vector of 512 bits. Bit i of r over a whole block is one *plane*. A block has its own *tile* of words: ``columns`` word
columns of ``rows`` words with eight zero words before each, one column of zeros to the left and one to the right.
So north and south are the same planes one word off, west and east are shifts by one bit, and fixed cells and all
outside the block are zeros by a mask. Sums of planes are chains of full adders: three logic operations for 512 nodes.

Eight words are one AVX-512 register; where the machine has narrower ones the compiler splits them. Plain loops over
words are not vectorised by it (a loop over planes inside, carries across), hence the vector type below.
"""

from __future__ import annotations

import operator
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic, models, overload, register_model

WORD_BITS = 64
LANES = 8
SLOTS = 4
RUNNING, CONVERGED, GROW, CYCLE = range(4)
POSITION, DONE_ITERATIONS, VISIT_WIDTH, UNSETTLED, SWEEPS, POWER, SINCE = range(7)
CONTROL_SIZE = 7

_VECTOR = ir.VectorType(ir.IntType(WORD_BITS), LANES)
_ONE_LANE = np.array([0] * 7 + [(1 << 64) - 1] + [0] * 7, np.uint64)


class Layout(NamedTuple):
    """Where things lie. All in words, but for the first three.

    ``block_rows``, ``block_columns``: nodes of a full block. ``planes``: how many planes there is room for. ``rows``:
    rows of a tile, a multiple of 8. ``columns``: word columns of a tile. ``stride``: from one word column to the next.
    ``tile``: words of a tile. ``plane``: words of a plane over all tiles. ``down``, ``across``: number of blocks.
    """

    block_rows: int
    block_columns: int
    planes: int
    rows: int
    columns: int
    stride: int
    tile: int
    plane: int
    down: int
    across: int


class State(NamedTuple):
    """What the kernel works on: flat uint64 arrays, widths int64, one each tile.

    ``mask``: ones where a node is computed. ``residual``: r, plane by plane over all tiles. ``odometer``: d, likewise.
    ``ring``: r of one tile over the last iterations, ``SLOTS`` + 1 slots and one that stays zero. ``visit``: what the
    running visit added to d, of one tile. ``width``: planes of the step t (r has two more), 0 where the block is
    settled. ``odometer_width``: planes of d. Planes above a width are undefined and mean zero, or the sign.
    ``snapshot``, ``snapshot_width``: r at an earlier sweep, to notice a start that never settles.
    """

    mask: np.ndarray
    residual: np.ndarray
    odometer: np.ndarray
    ring: np.ndarray
    visit: np.ndarray
    width: np.ndarray
    odometer_width: np.ndarray
    snapshot: np.ndarray
    snapshot_width: np.ndarray


def make_layout(shape: tuple[int, int], block: tuple[int, int], planes: int) -> Layout:
    """The layout of a map of ``shape`` in blocks of ``block``, with room for ``planes`` planes."""
    rows = -(-block[0] // LANES) * LANES
    columns = -(-block[1] // WORD_BITS)
    stride = rows + LANES
    tile = (columns + 2) * stride + LANES
    down, across = -(-shape[0] // block[0]), -(-shape[1] // block[1])
    return Layout(*block, planes, rows, columns, stride, tile, tile * down * across, down, across)


class _Lanes(types.Type):
    """Eight words that move as one."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


_lanes = _Lanes()


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _VECTOR)


def _pointer(context, builder, signature, arguments):
    array = context.make_array(signature.args[0])(context, builder, value=arguments[0])
    index = context.cast(builder, arguments[1], signature.args[1], types.intp)
    return builder.bitcast(builder.gep(array.data, [index]), _VECTOR.as_pointer())


@intrinsic
def _load(typing_context, array, index):
    """Eight words of a flat uint64 array, from ``index`` on."""

    def generate(context, builder, signature, arguments):
        return builder.load(_pointer(context, builder, signature, arguments), align=8)

    return _lanes(array, index), generate


@intrinsic
def _store(typing_context, array, index, lanes):
    """Put eight words into a flat uint64 array, from ``index`` on."""

    def generate(context, builder, signature, arguments):
        builder.store(arguments[2], _pointer(context, builder, signature, arguments), align=8)
        return context.get_dummy_value()

    return types.void(array, index, lanes), generate


@intrinsic
def _zeros(typing_context):
    def generate(context, builder, signature, arguments):
        return ir.Constant(_VECTOR, [0] * LANES)

    return _lanes(), generate


@intrinsic
def _any(typing_context, lanes):
    """Whether any bit is set."""

    def generate(context, builder, signature, arguments):
        set_lanes = builder.icmp_unsigned("!=", arguments[0], ir.Constant(_VECTOR, [0] * LANES))
        packed = builder.bitcast(set_lanes, ir.IntType(LANES))
        return builder.icmp_unsigned("!=", packed, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(lanes), generate


@intrinsic
def _spread(typing_context, word):
    """The same word in every lane."""

    def generate(context, builder, signature, arguments):
        single = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), arguments[0], ir.IntType(32)(0))
        return builder.shuffle_vector(
            single,
            ir.Constant(_VECTOR, ir.Undefined),
            ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES),
        )

    return _lanes(types.uint64), generate


def _overload_logic(instruction, *operations):
    @intrinsic
    def apply(typing_context, a, b):
        def generate(context, builder, signature, arguments):
            return getattr(builder, instruction)(*arguments)

        return _lanes(_lanes, _lanes), generate

    def choose(a, b):
        if isinstance(a, _Lanes) and isinstance(b, _Lanes):
            return lambda a, b: apply(a, b)  # noqa: PLW0108  (numba wants a plain function)
        return None

    for operation in operations:
        overload(operation)(choose)


_overload_logic("and_", operator.and_, operator.iand)
_overload_logic("or_", operator.or_, operator.ior)
_overload_logic("xor", operator.xor, operator.ixor)
_overload_logic("shl", operator.lshift)
_overload_logic("lshr", operator.rshift)


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
    one, last = _spread(np.uint64(1)), _spread(np.uint64(WORD_BITS - 1))
    centre = _load(ring, at)
    west, east = centre << one, centre >> one
    if layout.columns > 1:
        west |= _load(ring, at - layout.stride) >> last
        east |= _load(ring, at + layout.stride) << last
    return _load(ring, at - 1), _load(ring, at + 1), east, west


@njit(cache=True)
def _iterate(layout, ring, mask, tile, source, target, width, signed):
    """One iteration of a block, from one slot of the ring to another; whether r still needs ``width`` + 2 planes."""
    step = layout.tile
    widest = _zeros()
    for column in range(1, layout.columns + 1):
        first = column * layout.stride + LANES
        for word in range(first, first + layout.rows, LANES):
            free = _load(mask, tile + word)
            at, out = source + 2 * step + word, target + word
            n, s, e, w = _around(layout, ring, at)
            low, second = _load(ring, source + word), _load(ring, source + step + word)
            around = n ^ s ^ e
            _store(ring, out, (around ^ w ^ low) & free)
            a, b, c = _majority(n, s, e), _majority(around, w, low), second
            for _ in range(1, width):
                at += step
                out += step
                n, s, e, w = _around(layout, ring, at)
                total, a, b, c = _add_seven(n, s, e, w, a, b, c)
                _store(ring, out, total & free)
            out += step
            if signed:
                total, a, b, c = _add_seven(n, s, e, w, a, b, c)
                lower = total & free
                total, a, b, c = _add_seven(n, s, e, w, a, b, c)
                upper = total & free
                widest |= upper ^ lower if width > 1 else upper
            else:
                lower = (a ^ b ^ c) & free
                upper = _majority(a, b, c) & free
                widest |= upper
            _store(ring, out, lower)
            _store(ring, out + step, upper)
    return _any(widest)


@njit(cache=True)
def _trimmed(layout, planes, base, step, count, least, signed):
    """``count`` less the planes at the top that say nothing; not below ``least``."""
    while count > least:
        top = base + (count - 1) * step
        needed = _zeros()
        for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
            plane = _load(planes, top + word)
            if signed and count > least + 1:
                plane ^= _load(planes, top - step + word)
            needed |= plane
        if _any(needed):
            break
        count -= 1
    return count


@njit(cache=True)
def _accumulate(layout, state, slots, width, count, signed):
    """Add the steps of four slots to what the visit added so far; the planes that takes."""
    step, ring, visit = layout.tile, state.ring, state.visit
    total = max(count, width + 2) + 1
    s0, s1, s2, s3 = slots
    for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
        x = t0 = t1 = t2 = t3 = _zeros()
        a = b = c = d = _zeros()
        at = word
        for plane in range(total):
            if plane < width:
                t0, t1 = _load(ring, s0 + 2 * step + at), _load(ring, s1 + 2 * step + at)
                t2, t3 = _load(ring, s2 + 2 * step + at), _load(ring, s3 + 2 * step + at)
            elif not signed:
                t0 = t1 = t2 = t3 = _zeros()
            if plane < count:
                x = _load(visit, at)
            elif not signed:
                x = _zeros()
            first = t0 ^ t1 ^ t2
            second = t3 ^ x ^ a
            third = first ^ second ^ b
            _store(visit, at, third ^ c ^ d)
            a, b, c, d = (
                _majority(t0, t1, t2),
                _majority(t3, x, a),
                _majority(first, second, b),
                _majority(third, c, d),
            )
            at += step
    return _trimmed(layout, visit, 0, step, total, 0, signed)


@njit(cache=True)
def _add_visit(layout, state, tile, count, signed):
    """Add what the visit added to d of its block."""
    step, visit, odometer = layout.tile, state.visit, state.odometer
    have = state.odometer_width[tile]
    total = max(have, count) + 1
    base = tile * layout.tile
    for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
        x = y = carry = _zeros()
        for plane in range(total):
            if plane < count:
                x = _load(visit, plane * step + word)
            elif not signed:
                x = _zeros()
            at = plane * layout.plane + base + word
            if plane < have:
                y = _load(odometer, at)
            elif not signed:
                y = _zeros()
            _store(odometer, at, x ^ y ^ carry)
            carry = _majority(x, y, carry)
    state.odometer_width[tile] = _trimmed(layout, odometer, base, layout.plane, total, 0, signed)


@njit(cache=True)
def _push(layout, state, tile, source, target, vectors, right, left, select, count, signed):
    """Add what border nodes of the visited block gained to r of their neighbours in block ``tile``.

    ``source`` and ``target`` are the first words in either tile; the gains are shifted ``right``, then ``left``.
    """
    step, visit, residual = layout.tile, state.visit, state.residual
    base = tile * layout.tile
    target += base
    gained = _zeros()
    for word in range(0, vectors * LANES, LANES):
        some = _zeros()
        for plane in range(count):
            some |= _load(visit, plane * step + source + word)
        gained |= ((some >> right) << left) & select & _load(state.mask, target + word)
    if not _any(gained):
        return
    have = state.width[tile] + 2
    total = max(have + 1 if signed else have, count) + 1
    for plane in range(have, total):
        at = base + plane * layout.plane
        for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
            sign = _load(residual, at - layout.plane + word) if signed and have > 2 else _zeros()
            _store(residual, at + word, sign)
    for word in range(0, vectors * LANES, LANES):
        selected = select & _load(state.mask, target + word)
        x = carry = _zeros()
        for plane in range(total):
            if plane < count:
                x = ((_load(visit, plane * step + source + word) >> right) << left) & selected
            elif not signed:
                x = _zeros()
            at = target + word + plane * layout.plane
            y = _load(residual, at)
            _store(residual, at, x ^ y ^ carry)
            carry = _majority(x, y, carry)
    state.width[tile] = _trimmed(layout, residual, base, layout.plane, total, 2, signed) - 2


@njit(cache=True)
def _push_all(layout, state, tile, count, signed):
    """Tell the four neighbouring blocks what the border nodes gained."""
    row, column = tile // layout.across, tile % layout.across
    none, one = _spread(np.uint64(0)), _spread(np.uint64(1))
    bit = np.uint64((layout.block_columns - 1) % WORD_BITS)
    shift = _spread(bit)
    last_column = layout.columns * layout.stride
    last_row = layout.block_rows - 1
    lane = last_row % LANES
    first = layout.stride + LANES
    if column > 0:
        vectors, select = layout.rows // LANES, one << shift
        _push(
            layout, state, tile - 1, first, last_column + LANES, vectors, none, shift, select, count, signed
        )
    if column < layout.across - 1:
        vectors = layout.rows // LANES
        _push(layout, state, tile + 1, last_column + LANES, first, vectors, shift, none, one, count, signed)
    for words in range(layout.stride, last_column + 1, layout.stride):
        if row > 0:
            select = _load(_ONE_LANE, 7 - lane)
            top, bottom = words + LANES - lane, words + LANES + last_row - lane
            _push(layout, state, tile - layout.across, top, bottom, 1, none, none, select, count, signed)
        if row < layout.down - 1:
            select = _load(_ONE_LANE, 7)
            top, bottom = words + LANES, words + LANES + last_row
            _push(layout, state, tile + layout.across, bottom, top, 1, none, none, select, count, signed)


@njit(cache=True)
def _visit(layout, state, control, tile, iterations, budget, signed):
    """Iterate a block until it settles, ``iterations`` are done or the budget is spent; the budget left."""
    step, slot, base = layout.tile, layout.planes * layout.tile, tile * layout.tile
    width, done = state.width[tile], control[DONE_ITERATIONS]
    for plane in range(width + 2):
        for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
            lanes = _load(state.residual, plane * layout.plane + base + word)
            _store(state.ring, plane * step + word, lanes)
    current = 0
    while width > 0 and done < iterations and budget > 0:
        computed, made = width, 0
        before = current
        while made < SLOTS and width > 0 and done < iterations:
            target = (current + 1) % (SLOTS + 1)
            if not _iterate(
                layout, state.ring, state.mask, base, current * slot, target * slot, computed, signed
            ):
                width = _trimmed(layout, state.ring, target * slot, step, computed + 2, 2, signed) - 2
            current = target
            made += 1
            done += 1
        zero = (SLOTS + 1) * slot
        s0 = before * slot
        s1 = (before + 1) % (SLOTS + 1) * slot if made > 1 else zero
        s2 = (before + 2) % (SLOTS + 1) * slot if made > 2 else zero
        s3 = (before + 3) % (SLOTS + 1) * slot if made > 3 else zero
        control[VISIT_WIDTH] = _accumulate(
            layout, state, (s0, s1, s2, s3), computed, control[VISIT_WIDTH], signed
        )
        budget -= made * layout.columns * layout.rows
    for plane in range(width + 2):
        for word in range(layout.stride + LANES, (layout.columns + 1) * layout.stride, LANES):
            lanes = _load(state.ring, current * slot + plane * step + word)
            _store(state.residual, plane * layout.plane + base + word, lanes)
    state.width[tile] = width
    control[DONE_ITERATIONS] = done
    return budget


@njit(cache=True)
def _has_room(layout, state, control, tile, iterations):
    """Whether a visit cannot need more planes than there is room for, here or in a neighbouring block."""
    bits = 8
    while iterations > 0:
        bits += 1
        iterations >>= 1
    need = max(state.width[tile] + bits, state.odometer_width[tile] + 2, control[VISIT_WIDTH] + 8)
    row, column = tile // layout.across, tile % layout.across
    if row > 0:
        need = max(need, state.width[tile - layout.across] + 8)
    if row < layout.down - 1:
        need = max(need, state.width[tile + layout.across] + 8)
    if column > 0:
        need = max(need, state.width[tile - 1] + 8)
    if column < layout.across - 1:
        need = max(need, state.width[tile + 1] + 8)
    return need <= layout.planes


@njit(cache=True)
def _repeats(layout, state, control):
    """Whether r is what it was at an earlier sweep (Brent's method), so that the sweeps would never end."""
    tiles = layout.down * layout.across
    same = True
    for tile in range(tiles):
        if state.width[tile] != state.snapshot_width[tile]:
            same = False
            break
        for plane in range(state.width[tile] + 2):
            at = plane * layout.plane + tile * layout.tile
            for word in range(at, at + layout.tile):
                if state.residual[word] != state.snapshot[word]:
                    same = False
                    break
            if not same:
                break
        if not same:
            break
    if same:
        return True
    control[SINCE] += 1
    if control[SINCE] >= control[POWER]:
        control[SINCE] = 0
        control[POWER] *= 2
        state.snapshot_width[:] = state.width
        for tile in range(tiles):
            for plane in range(state.width[tile] + 2):
                at = plane * layout.plane + tile * layout.tile
                state.snapshot[at : at + layout.tile] = state.residual[at : at + layout.tile]
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

    Returns the status (RUNNING: call again; CONVERGED; GROW: more planes are needed, then call again; CYCLE) and the
    number of visits written. A visit may be left half done, and is gone on with in the next call.
    """
    done = 0
    while done < len(counts) and budget > 0:
        tile = control[POSITION]
        if state.width[tile] == 0 and control[DONE_ITERATIONS] == 0:
            counts[done] = 1
        else:
            if not _has_room(layout, state, control, tile, iterations):
                return GROW, done
            budget = _visit(layout, state, control, tile, iterations, budget, signed)
            settled = state.width[tile] == 0 and control[DONE_ITERATIONS] < iterations
            if state.width[tile] > 0 and control[DONE_ITERATIONS] < iterations:
                return RUNNING, done
            counts[done] = control[DONE_ITERATIONS] + settled
            count = control[VISIT_WIDTH]
            _add_visit(layout, state, tile, count, signed)
            _push_all(layout, state, tile, count, signed)
            control[DONE_ITERATIONS] = control[VISIT_WIDTH] = 0
            if not (published and settled):
                control[UNSETTLED] = 1
        done += 1
        budget -= 1
        control[POSITION] += 1
        if control[POSITION] == layout.down * layout.across:
            control[POSITION] = 0
            control[SWEEPS] += 1
            if control[UNSETTLED] == 0:
                return CONVERGED, done
            control[UNSETTLED] = 0
            if signed and _repeats(layout, state, control):
                return CYCLE, done
    return RUNNING, done


@njit(cache=True)
def trim(layout, state, signed):
    """Lower every width to what r needs, which the visits rely on: a block of width 0 is settled, any other is not."""
    for tile in range(layout.down * layout.across):
        base, count = tile * layout.tile, state.width[tile] + 2
        state.width[tile] = _trimmed(layout, state.residual, base, layout.plane, count, 2, signed) - 2
