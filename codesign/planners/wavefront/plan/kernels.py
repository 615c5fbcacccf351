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

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

OPEN, CLOSED, ENTERED = -1, -2, -3


@njit(cache=True, nogil=True)
def _lock_seeds(
    potentials: NDArray[np.int32],
    order: NDArray[np.int32],
    used: int,
    seeds: NDArray[np.int32],
    seed_times: NDArray[np.int32],
    seed: int,
    time: int,
) -> Any:
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
def _release(
    potentials: NDArray[np.int32],
    order: NDArray[np.int32],
    used: int,
    first: NDArray[np.int32],
    following: NDArray[np.int32],
    time: int,
) -> Any:
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
def _blocked(potentials: NDArray[np.int32], cell: int, beside: NDArray[np.int32]) -> bool:
    """True if an obstacle stands beside a diagonal step from ``cell``."""
    #   from  b        b: the cells beside a diagonal step, CLOSED at an obstacle. In three dimensions there are more.
    #    b    cell
    for offset in beside:  # noqa: SIM110 - numba compiles no generator
        if offset != 0 and potentials[cell + offset] == CLOSED:
            return True
    return False


@njit(cache=True, nogil=True)
def _enter(
    potentials: NDArray[np.int32],
    order: NDArray[np.int32],
    used: int,
    origins: NDArray[np.int32],
    offset: int,
    beside: NDArray[np.int32],
    extra: NDArray[np.uint8],
    first: NDArray[np.int32],
    following: NDArray[np.int32],
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
def _all_reached(potentials: NDArray[np.int32], cells: NDArray[np.int32]) -> bool:
    for cell in cells:  # noqa: SIM110
        if potentials[cell] < 0:
            return False
    return True


@njit(cache=True, nogil=True)
def spread(
    potentials: NDArray[np.int32],
    seeds: NDArray[np.int32],
    seed_times: NDArray[np.int32],
    offsets: NDArray[np.int32],
    delays: NDArray[np.int32],
    beside: NDArray[np.int32],
    extra: NDArray[np.uint8],
    stops: NDArray[np.int32],
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
def rounds(
    potentials: NDArray[np.int32],
    order: NDArray[np.int32],
    offsets: NDArray[np.int32],
    delays: NDArray[np.int32],
    beside: NDArray[np.int32],
    extra: NDArray[np.uint8],
) -> int:
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
    potentials: NDArray[np.int32],
    distances: NDArray[np.int32],
    start: int,
    most_steps: int,
    offsets: NDArray[np.int32],
    delays: NDArray[np.int32],
    beside: NDArray[np.int32],
    extra: NDArray[np.uint8],
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
