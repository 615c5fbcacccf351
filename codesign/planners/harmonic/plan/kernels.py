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

``planes`` does the arithmetic of a group, ``visits`` the work of a block, ``borders`` the exchange between blocks;
here are the sweeps. Numba keeps the compiled ``advance`` and ``lift`` until *this* file changes, and sees no edit in
the functions that they call. So CALLED_DIGEST is here, and a test compares it with those files. After an edit there,
the new digest here makes numba compile anew.
"""

from __future__ import annotations

from numba import njit

from codesign.planners.harmonic.plan.borders import add_visit, push_all
from codesign.planners.harmonic.plan.lanes import get, load, put, store
from codesign.planners.harmonic.plan.layout import LANES
from codesign.planners.harmonic.plan.visits import trim, visit_block

CALLED = ("borders", "lanes", "layout", "planes", "visits")
CALLED_DIGEST = "38af34f02e3233e5"

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
    """True if r equals the snapshot."""
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
