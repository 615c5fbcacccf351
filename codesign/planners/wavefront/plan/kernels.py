"""The wave over a flat padded array, and the paths back along it, compiled.

A map of any number of dimensions is padded by one closed cell on every side and laid out flat, so that a
neighbour is an index plus an offset and no bound is ever tested. ``potentials`` (int32) says everything of a
cell: OPEN (free, the wave may still enter), CLOSED (obstacle or padding), ENTERED (in a delay line longer
than the map's own), or the time the wave locked it.

The wave does what the circuit does: at time t it enters the open neighbours at the straight offsets of the
cells locked at t - 2 and at the diagonal offsets of those locked at t - 3. So every cell is locked once, in
order of time, without a queue that sorts, and nothing is ever taken back.

``order`` is the record of the wave. The cells of its last times, as many as the longest delay and one more, are slices
of it:

    order   .. | t - 3 | t - 2 | t - 1 | t .. used      slice of time s: begins[s % size] to ends[s % size]
               '-> diagonal    |
                       '-> straight
"""

from __future__ import annotations

import heapq
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Ints = NDArray[np.int32]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

OPEN, CLOSED, ENTERED = -1, -2, -3


@njit(cache=True, nogil=True)
def _lock_seeds(potentials: Ints, order: Ints, used: int, seeds: Ints, seed_times: Ints, seed: int, time: int) -> Any:
    """Lock the seeds of this time; returns how many cells are locked, and the next seed."""
    # p = 0 at a reference cell (equation 1), or the time at which a cell around a tile emits.
    while seed < seeds.size and seed_times[seed] == time:
        if potentials[seeds[seed]] < 0:
            potentials[seeds[seed]] = time
            order[used] = seeds[seed]
            used += 1
        seed += 1
    return used, seed


@njit(cache=True, nogil=True)
def _release(potentials: Ints, order: Ints, used: int, first: Ints, following: Ints, time: int) -> Any:
    """Lock the cells with an own line that ends now; returns how many are locked, and how many left their lines."""
    # The cells in delay lines of their own, in a list for each time at which a line ends; as many lists as the
    # longest line has flip-flops, and one more:
    #
    #   first[time % size] -> cell -> following[cell] -> .. -> -1
    slot = time % first.size
    cell = first[slot]
    first[slot] = -1
    left = 0
    while cell >= 0:
        # A seed may have locked it meanwhile.
        if potentials[cell] == ENTERED:
            potentials[cell] = time
            order[used] = cell
            used += 1
        left += 1
        cell = following[cell]
    return used, left


@njit(cache=True, nogil=True)
def _blocked(potentials: Ints, cell: int, beside: Ints) -> bool:
    """True if an obstacle stands beside a diagonal step from ``cell``."""
    #   from  b        b: the cells beside a diagonal step, CLOSED at an obstacle. In three dimensions there are more.
    #    b    cell
    for offset in beside:  # noqa: SIM110 - numba compiles no generator
        if offset != 0 and potentials[cell + offset] == CLOSED:
            return True
    return False


@njit(cache=True, nogil=True)
def _enter(
    potentials: Ints,
    order: Ints,
    used: int,
    origins: Ints,
    offset: int,
    beside: Ints,
    extra: Bytes,
    first: Ints,
    following: Ints,
    time: int,
) -> Any:
    """Step from ``origins`` by ``offset``; returns how many cells are locked, and how many entered own lines."""
    entered = 0
    for origin in origins:
        # The OR gate at the head of a node's delay line (figure 2): whichever neighbour comes first, the others
        # change nothing.
        cell = origin + offset
        if potentials[cell] != OPEN or (beside.size > 0 and _blocked(potentials, origin, beside)):
            continue
        if extra.size > 0 and extra[cell] > 0:
            slot = (time + extra[cell]) % first.size
            potentials[cell] = ENTERED
            following[cell] = first[slot]
            first[slot] = cell
            entered += 1
        else:
            potentials[cell] = time
            order[used] = cell
            used += 1
    return used, entered


@njit(cache=True, nogil=True)
def _all_reached(potentials: Ints, cells: Ints) -> bool:
    for cell in cells:  # noqa: SIM110
        if potentials[cell] < 0:
            return False
    return True


@njit(cache=True, nogil=True)
def spread(
    potentials: Ints,
    seeds: Ints,
    seed_times: Ints,
    offsets: Ints,
    delays: Ints,
    beside: Ints,
    extra: Bytes,
    stops: Ints,
    limit: int,
) -> Any:
    """Run the wave; fills ``potentials`` and returns the locked cells in order of time, int32.

    ``seeds``: cells locked at ``seed_times`` (rising), whatever stands there. ``offsets`` and ``delays`` (rising): the
    neighbours. ``beside``: K × M offsets from a cell that must be free for the step (0: none). ``extra``: delay of a
    cell's own line beyond the map's, empty for none. The wave ends with the time at which the last of ``stops`` is
    locked, after ``limit``, or when it has died.
    """
    # A cell locked at time t gives p = t, the value of the global counter. With delays of 2 (straight) and 3
    # (diagonal) a node's output comes to the register of its neighbour 2 or 3 cycles later:
    #
    #   p_j = min over neighbours i of p_i + w_ij        (equation 3, by time in place of addition)
    order = np.empty(potentials.size, np.int32)
    used = seed = waiting = quiet = 0
    longest = delays[-1]
    # Where in ``order`` the cells locked at each of the last times begin and end.
    begins, ends = np.zeros(longest + 1, np.int64), np.zeros(longest + 1, np.int64)
    first = np.full(int(extra.max()) + 1 if extra.size else 1, -1, np.int32)
    following = np.empty(extra.size, np.int32)
    time = int(seed_times[0])
    while time <= limit:
        begin = used
        used, seed = _lock_seeds(potentials, order, used, seeds, seed_times, seed, time)
        if waiting > 0:
            used, left = _release(potentials, order, used, first, following, time)
            waiting -= left
        for side in range(offsets.size):
            # Only cells that were locked exactly one delay ago send their wave now.
            since = (time - delays[side]) % begins.size
            origins = order[begins[since] : ends[since]]
            used, entered = _enter(
                potentials, order, used, origins, offsets[side], beside[side], extra, first, following, time
            )
            waiting += entered
        begins[time % begins.size], ends[time % begins.size] = begin, used
        if used > begin and stops.size > 0 and _all_reached(potentials, stops):
            break
        # After ``longest`` cycles in which nothing was locked every delay line of the map is empty. The wave is dead
        # unless a longer line still holds a cell, and the silence before the next seed is skipped.
        quiet = 0 if used > begin else quiet + 1
        time += 1
        if quiet >= longest and waiting == 0:
            if seed == seeds.size:
                break
            time = int(seed_times[seed])
            begins[:] = ends[:] = 0
            quiet = 0
    return order[:used]


@njit(cache=True, nogil=True)
def rounds(potentials: Ints, order: Ints, offsets: Ints, delays: Ints, beside: Ints, extra: Bytes) -> int:
    """Parallel updates by equation 3 until the last potential stands: the steps of the longest shortest path.

    Of several shortest paths to a cell, the path with the fewest steps counts. ``order``: cells by rising potential.
    """
    # Equation 3 for all nodes in parallel: a potential is final after as many rounds as its shortest path has steps.
    #
    #   steps_i = 1 + min over neighbours j with p_j + w_ji = p_i of steps_j
    steps = np.zeros(potentials.size, np.int32)
    most = 0
    for cell in order:
        own = potentials[cell] - (extra[cell] if extra.size else 0)
        fewest = np.int32(2147483647)
        for side in range(offsets.size):
            origin = cell + offsets[side]
            if potentials[origin] < 0 or potentials[origin] + delays[side] != own:
                continue
            if steps[origin] < fewest and not _blocked(potentials, cell, beside[side]):
                fewest = steps[origin]
        if potentials[cell] > 0 and fewest < 2147483647:
            steps[cell] = fewest + 1
            most = max(most, steps[cell])
    return most


@njit(cache=True, nogil=True)
def follow(
    potentials: Ints,
    distances: Ints,
    start: int,
    most_steps: int,
    offsets: Ints,
    delays: Ints,
    beside: Ints,
    extra: Bytes,
) -> Any:
    """The path from ``start`` down the potentials, int32 cells, ``start`` first.

    Without ``distances`` (empty) by equation 2: the first neighbour j in the order of ``offsets`` with
    p_i = p_j + w_ji. With them by equations 4 and 5: of the neighbours nearer to the source those farthest
    from the obstacles, and of these the nearest to the source, the first among equals.
    """
    safe = distances.size > 0
    path = np.empty(64, np.int32)
    path[0] = start
    used = 1
    cell = start
    while potentials[cell] > 0 and used <= most_steps:
        best = -1
        entry = extra[cell] if extra.size else 0
        for side in range(offsets.size):
            origin = cell + offsets[side]
            potential = potentials[origin]
            if potential < 0 or potential >= potentials[cell]:
                continue
            if _blocked(potentials, cell, beside[side]):
                continue
            # p_i = p_j + w_ji (equation 2), and the delay of the cell's own line where it has one.
            if not safe:
                if potential + delays[side] + entry == potentials[cell]:
                    best = origin
                    break
            # Equations 4 and 5 in one pass: the largest p^d first, then the smallest p^t; p^t < p_i^t was tested
            # above.
            elif (
                best < 0
                or distances[origin] > distances[best]
                or (distances[origin] == distances[best] and potential < potentials[best])
            ):
                best = origin
        if best < 0:
            break
        cell = best
        if used == path.size:
            longer = np.empty(2 * used, np.int32)
            longer[:used] = path
            path = longer
        path[used] = cell
        used += 1
    return path[:used]


NEVER = np.int32(2147483647)
"""The potential of a cell that no visit has reached yet, and the time of what is not awaited."""
HALO = -4
"""A free cell around a tile: no wave enters it."""


@njit(cache=True, nogil=True)
def _copy_tile(potentials: Ints, frame: Ints, extra: Bytes, own: Bytes, first: int) -> None:
    """A tile and the cells around it from the padded map into ``frame``; ``extra`` into ``own``."""
    rows, columns = frame.shape
    top, left = first // potentials.shape[1], first % potentials.shape[1]
    for row in range(rows):
        frame[row] = potentials[top + row, left : left + columns]
    for row in range(rows):
        for column in range(0, columns, 1 if row in (0, rows - 1) else columns - 1):
            frame[row, column] = CLOSED if frame[row, column] == CLOSED else HALO
    if extra.size > 0:
        for row in range(rows):
            begin = (top + row) * potentials.shape[1] + left
            own[row * columns : (row + 1) * columns] = extra[begin : begin + columns]


@njit(cache=True, nogil=True)
def _seed_tile(
    potentials: Ints, source: Mask, frame: Ints, own: Bytes, first: int, steps: Ints, delays: Ints, beside: Ints
) -> Any:
    """Lower the cells that a source or a cell around the tile reaches by a step: these, first and last emission."""
    rows, columns = frame.shape
    flat = frame.ravel()
    top, left = first // potentials.shape[1], first % potentials.shape[1]
    seeds = np.empty(rows * columns, np.int32)
    used, begin, last = 0, int(NEVER), 0
    for row in range(rows):
        inside = 0 < row < rows - 1
        for column in range(columns):
            if inside and 0 < column < columns - 1:
                if source[top + row, left + column]:
                    begin = 0
                    if frame[row, column] > 0:
                        frame[row, column] = 0
                        seeds[used] = row * columns + column
                        used += 1
                continue
            emission = potentials[top + row, left + column]
            if emission < 0 or emission == NEVER:
                continue
            begin, last = min(begin, emission), max(last, emission)
            for side in range(delays.size):
                to_row, to_column = row + steps[side, 0], column + steps[side, 1]
                if not (0 < to_row < rows - 1 and 0 < to_column < columns - 1):
                    continue
                cell = to_row * columns + to_column
                arrival = emission + delays[side] + (own[cell] if own.size > 0 else 0)
                if flat[cell] <= arrival or _blocked(flat, row * columns + column, beside[side]):
                    continue
                if flat[cell] == potentials[top + to_row, left + to_column]:
                    seeds[used] = cell
                    used += 1
                flat[cell] = arrival
    return seeds[:used], begin, last


@njit(cache=True, nogil=True)
def _lower_tile(frame: Ints, seeds: Ints, own: Bytes, offsets: Ints, delays: Ints, beside: Ints, slots: int) -> Ints:
    """The wave of a visit: lowers every cell of the flat ``frame`` that it reaches earlier; returns these.

    A cell is lowered once, as the wave comes in order of time. ``slots``: one more than the longest own line.
    """
    order, following = np.empty(frame.size, np.int32), np.empty(own.size, np.int32)
    first = np.full(slots, -1, np.int32)
    begins, ends = np.zeros(delays[-1] + 1, np.int64), np.zeros(delays[-1] + 1, np.int64)
    seeds = seeds[np.argsort(frame[seeds], kind="mergesort")]
    times = frame[seeds]
    used = seed = waiting = quiet = 0
    time = times[0] if times.size > 0 else 0
    while seed < seeds.size or waiting > 0 or quiet <= delays[-1]:
        begin = used
        while seed < seeds.size and times[seed] == time:
            # The wave may have come earlier meanwhile.
            if frame[seeds[seed]] == time:
                order[used] = seeds[seed]
                used += 1
            seed += 1
        cell = first[time % slots]
        first[time % slots] = -1
        while cell >= 0:
            order[used] = cell
            used, waiting, cell = used + 1, waiting - 1, following[cell]
        for side in range(delays.size):
            since = (time - delays[side]) % begins.size
            for origin in order[begins[since] : ends[since]]:
                cell = origin + offsets[side]
                entry = own[cell] if own.size > 0 else 0
                if frame[cell] <= time + entry or _blocked(frame, origin, beside[side]):
                    continue
                frame[cell] = time + entry
                if entry > 0:
                    following[cell] = first[(time + entry) % slots]
                    first[(time + entry) % slots] = cell
                    waiting += 1
                else:
                    order[used] = cell
                    used += 1
        begins[time % begins.size], ends[time % begins.size] = begin, used
        quiet = 0 if used > begin else quiet + 1
        time += 1
        # The silence before the next seed is skipped.
        if quiet > delays[-1] and waiting == 0 and seed < seeds.size:
            time = times[seed]
            begins[:] = ends[:] = 0
            quiet = 0
    return order[:used]


@njit(cache=True, nogil=True)
def _note_changes(lowered: Ints, frame: Ints, earliest: Ints, potentials: Ints) -> None:
    """Write ``frame`` back, into ``potentials``; ``earliest`` 3 × 3: the first change that each tile beside sees."""
    rows, columns = frame.shape
    earliest[:] = NEVER
    for cell in lowered:
        row, column = cell // columns, cell % columns
        time = frame[row, column]
        potentials[row, column] = time
        up, down, left, right = row == 1, row == rows - 2, column == 1, column == columns - 2
        if not (up or down or left or right):
            continue
        for vertical in range(3):
            for horizontal in range(3):
                if (up, True, down)[vertical] and (left, True, right)[horizontal]:
                    earliest[vertical, horizontal] = min(earliest[vertical, horizontal], time)


@njit(cache=True, nogil=True)
def _visit(
    potentials: Ints,
    source: Mask,
    extra: Bytes,
    corner: tuple[int, int],
    size: tuple[int, int],
    steps: Ints,
    delays: Ints,
    beside: Ints,
    earliest: Ints,
) -> Any:
    """Visit the tile of ``size`` at ``corner``; fills ``earliest``, returns the first and the last time."""
    frame = np.empty((size[0] + 2, size[1] + 2), np.int32)
    own = np.empty(frame.size if extra.size else 0, np.uint8)
    first = corner[0] * potentials.shape[1] + corner[1]
    _copy_tile(potentials, frame, extra, own, first)
    wide = np.int32(size[1] + 2)
    offsets, blocking = steps[:, 0] * wide + steps[:, 1], beside[:, :, 0] * wide + beside[:, :, 1]
    seeds, begin, last = _seed_tile(potentials, source, frame, own, first, steps, delays, blocking)
    slots = int(extra.max()) + 1 if extra.size else 1
    lowered = _lower_tile(frame.ravel(), seeds, own, offsets, delays, blocking, slots)
    window = potentials[corner[0] : corner[0] + size[0] + 2, corner[1] : corner[1] + size[1] + 2]
    _note_changes(lowered, frame, earliest, window)
    for time in frame.ravel():
        if last < time != NEVER:
            last = time
    return begin, last


@njit(cache=True, nogil=True)
def visit_tiles(
    potentials: Ints,
    source: Mask,
    extra: Bytes,
    tile: tuple[int, int],
    steps: Ints,
    delays: Ints,
    beside: Ints,
    until: int,
    exchange: int,
    most_cycles: int,
    sure: NDArray[np.int64],
    begins: NDArray[np.int64],
) -> Any:
    """Visit tiles until no change before ``until`` is pending; int64 n × 4, and cycles sure to come: -1 if none are.

    Of each visit: the tile, the pending change, the first emission, the last emission or arrival. ``potentials``, in
    and out, and ``source`` are padded; ``extra`` is flat, or empty. ``exchange``: cycles of a visit beside its wave.
    Where all visits take more than ``most_cycles`` it gives up. ``sure``: visits that are sure (``VisitBounds.sure``),
    of tile k from ``begins[k]`` on.
    """
    rows, columns = potentials.shape[0] - 2, potentials.shape[1] - 2
    down, across = -(-rows // tile[0]), -(-columns // tile[1])
    pending = np.full(down * across, NEVER, np.int32)
    for row in range(rows):
        for column in range(columns):
            if source[row + 1, column + 1]:
                pending[row // tile[0] * across + column // tile[1]] = 0
    # Numbers in the order of (pending change, tile), as their pairs.
    waiting = [np.int64(index) for index in range(pending.size) if pending[index] == 0]
    visits = [np.int64(0) for _ in range(0)]
    earliest = np.empty((3, 3), np.int32)
    cycles, met = 0, np.zeros(len(sure), np.bool_)
    # The cycles that are sure to come.
    left = (exchange + 1) * len(sure) + sure[:, 3].sum()
    while len(waiting) > 0:
        since, index = divmod(heapq.heappop(waiting), np.int64(pending.size))
        if pending[index] != since:
            continue
        if since >= until:
            break
        pending[index] = NEVER
        at, corner = (index // across, index % across), (index // across * tile[0], index % across * tile[1])
        size = min(tile[0], rows - corner[0]), min(tile[1], columns - corner[1])
        begin, last = _visit(potentials, source, extra, corner, size, steps, delays, beside, earliest)
        visits.extend((np.int64(index), since, np.int64(begin), np.int64(last)))
        cycles += exchange + last - begin + 1
        for each in range(begins[index], begins[index + 1]):
            if not met[each] and sure[each, 1] <= since <= sure[each, 2]:
                met[each] = True
                left -= exchange + 1 + sure[each, 3]
        if cycles + left > most_cycles:
            return np.array(visits).reshape(-1, 4), left
        for vertical in range(max(0, at[0] - 1), min(down, at[0] + 2)):
            for horizontal in range(max(0, at[1] - 1), min(across, at[1] + 2)):
                time, other = earliest[vertical - at[0] + 1, horizontal - at[1] + 1], vertical * across + horizontal
                if time < pending[other] and other != index:
                    pending[other] = time
                    heapq.heappush(waiting, np.int64(time) * pending.size + other)
    return np.array(visits).reshape(-1, 4), np.int64(-1)
