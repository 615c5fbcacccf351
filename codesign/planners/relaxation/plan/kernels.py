"""Compiled sweeps over the layout of ``solve``, many nodes at a time: bit for bit the same as loops in raster order.

Limits of a node and sweep: in raster order every node waits for its western neighbour: two additions, a multiplication
and an addition, 12 to 16 cycles. Nodes of a diagonal have no such chain. Their limit is the traffic between registers
and the nearest cache: five loads (itself and four neighbours, hardly ever aligned), a mask and a store, about ten
64-byte lines for 8 nodes of 8 bytes, 1.2 to 1.4 cycles a node. ``benchmarks/bench_relaxation`` measures this limit as
one pass of the same stencil without any order, and compares the sweeps with it.

The largest change is kept as the bits of a double that is not negative. These bits order as integers do: a maximum of
integers is computed in vectors, a maximum of doubles is not. No multiplication is fused with an addition, so that every
machine gives the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

RUNNING, CONVERGED, STAGNATED = 0, 1, 2

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]
Around = tuple[Doubles, Doubles, Doubles, Doubles]
"""The values north, west, east and south of some nodes."""


@njit(cache=True, error_model="numpy", nogil=True)
def _verdict(top: Any, ending: tuple[float, int, float], watch: Doubles) -> Any:
    """The change of a sweep from its bits, and whether the run is over.

    ``ending``: tolerance, patience, floor. ``watch``: the least change so far, and the sweeps since then.
    """
    # Algorithm 1 runs "until ‖u(k+1) - u(k)‖ < ε". The paper has no other end, but in doubles the last bits may go
    # round for ever: hence STAGNATED, once the change is small (``floor``) and has stopped falling.
    tolerance, patience, floor = ending
    change = np.int64(top).view(np.float64)
    if change < tolerance:
        return change, CONVERGED
    if change < watch[0]:
        watch[0] = change
        watch[1] = 0.0
        return change, RUNNING
    watch[1] += 1.0
    return change, STAGNATED if watch[1] >= patience and watch[0] <= floor else RUNNING


@njit(cache=True, error_model="numpy", nogil=True)
def _in_place(here: Doubles, movable: Mask, around: Around, quarter: float, keep: float) -> Any:
    """One diagonal of a sweep in place; the largest change as bits."""
    north, west, east, south = around
    top = np.int64(0)
    for k in range(here.size):
        # u' = ω/4 (N + W + E + S) + (1 - ω) u, the solution of (D - ωL) u' = ((1 - ω) D + ωT) u for one node
        # (equation 13). Always in these pairs: a sum of doubles in another order has other bits.
        old = here[k]
        new = quarter * ((north[k] + west[k]) + (east[k] + south[k])) + keep * old
        new = new if movable[k] else old
        here[k] = new
        change = np.float64(abs(new - old)).view(np.int64)
        top = max(top, change)
    return top


@njit(cache=True, error_model="numpy", nogil=True)
def _apart(target: Doubles, here: Doubles, movable: Mask, around: Around, quarter: float, keep: float) -> Any:
    """The same as ``_in_place``, with the new values in ``target``."""
    north, west, east, south = around
    top = np.int64(0)
    for k in range(target.size):
        old = here[k]
        # Level 1 and Jacobi (ω = 1): the same formula, with old and new values in different arrays.
        new = quarter * ((north[k] + west[k]) + (east[k] + south[k])) + keep * old
        new = new if movable[k] else old
        target[k] = new
        change = np.float64(abs(new - old)).view(np.int64)
        top = max(top, change)
    return top


@njit(cache=True, error_model="numpy", nogil=True)
def _mean(
    here: Doubles, first: Doubles, second: Doubles, movable: Mask, around: Around, quarter: float, keep: float
) -> Any:
    """Levels 2 and 3 on one diagonal: computes ``second``; ``here`` becomes the mean of ``first`` and ``second``."""
    north, west, east, south = around
    top = np.int64(0)
    for k in range(here.size):
        old = here[k]
        other = quarter * ((north[k] + west[k]) + (east[k] + south[k])) + keep * old
        other = other if movable[k] else old
        second[k] = other
        # Level 3: u(k+1) = (u1 + u2) / 2.
        new = 0.5 * (first[k] + other)
        here[k] = new
        change = np.float64(abs(new - old)).view(np.int64)
        top = max(top, change)
    return top


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _around(before: Doubles, after: Doubles, p: int, q: int, n: int) -> Any:
    """N and W of ``n`` nodes, from ``p`` of ``before`` on; E and S, from ``q`` of ``after`` on."""
    return before[p : p + n], before[p + 1 : p + 1 + n], after[q : q + n], after[q + 1 : q + 1 + n]


@njit(cache=True, error_model="numpy", nogil=True)
def _diagonal(base: NDArray[np.int64], rows: int, columns: int, d: int) -> Any:
    """The first row and number of the nodes of diagonal ``d``, and the places of its first node, of N and of E."""
    #        N                 diagonal d - 1: N at base[d - 1] + i - 1, W at base[d - 1] + i
    #     W  x  E              diagonal d: node (i, d - i) at base[d] + i, for the n rows from ``low`` inside the ring
    #        S                 diagonal d + 1: E at base[d + 1] + i, S at base[d + 1] + i + 1
    low = max(1, d - columns + 2)
    n = min(rows - 2, d - 1) - low + 1
    return low, n, base[d] + low, base[d - 1] + low - 1, base[d + 1] + low


@njit(cache=True, error_model="numpy", nogil=True)
def in_place_sweeps(
    values: Doubles,
    movable: Mask,
    base: NDArray[np.int64],
    shape: tuple[int, int],
    colours: int,
    omega: float,
    sweeps: int,
    ending: tuple[float, int, float],
    watch: Doubles,
) -> Any:
    """Sweeps in raster order (``colours`` 1), or over the red nodes and then the black ones (2).

    Args:
        values: float64, packed; changed in place.
        movable: bool, packed; the nodes that are computed.
        base, shape: the layout.
        omega: over-relaxation.
        sweeps: their greatest number.
        ending: tolerance, patience, floor of ``_verdict``. watch: its state.

    Returns:
        Sweeps done, the change of the last, and the state (RUNNING, CONVERGED, STAGNATED).
    """
    # When a diagonal is computed, N and W are new, E and S old, as in raster order; red nodes are the even diagonals.
    rows, columns = shape
    quarter, keep = omega / 4.0, 1.0 - omega
    change, state, done = 0.0, RUNNING, 0
    while done < sweeps and state == RUNNING:
        top = np.int64(0)
        for colour in range(colours):
            for d in range(2 + colour, rows + columns - 3, colours):
                _, n, o, p, q = _diagonal(base, rows, columns, d)
                around = _around(values, values, p, q, n)
                top = max(top, _in_place(values[o : o + n], movable[o : o + n], around, quarter, keep))
        done += 1
        change, state = _verdict(top, ending, watch)
    return done, change, state


@njit(cache=True, error_model="numpy", nogil=True)
def jacobi_sweeps(
    values: Doubles,
    spare: Doubles,
    movable: Mask,
    base: NDArray[np.int64],
    shape: tuple[int, int],
    sweeps: int,
    ending: tuple[float, int, float],
    watch: Doubles,
) -> Any:
    """All nodes at once from the old values; as ``in_place_sweeps``. ``spare`` equals ``values`` on fixed nodes."""
    rows, columns = shape
    change, state, done = 0.0, RUNNING, 0
    # All of u(k) is still needed while u(k+1) is written, so two arrays take turns.
    source, target = values, spare
    while done < sweeps and state == RUNNING:
        top = np.int64(0)
        for d in range(2, rows + columns - 3):
            _, n, o, p, q = _diagonal(base, rows, columns, d)
            around = _around(source, source, p, q, n)
            top = max(top, _apart(target[o : o + n], source[o : o + n], movable[o : o + n], around, 0.25, 0.0))
        source, target = target, source
        done += 1
        change, state = _verdict(top, ending, watch)
    # After an odd number of sweeps the last values are in the other array.
    if done % 2:
        values[:] = spare
    return done, change, state


@njit(cache=True, error_model="numpy", nogil=True)
def mean_sweeps(
    values: Doubles,
    first: Doubles,
    movable: Mask,
    base: NDArray[np.int64],
    shape: tuple[int, int],
    wall: float,
    acceleration: tuple[float, float],
    sweeps: int,
    ending: tuple[float, int, float],
    watch: Doubles,
) -> Any:
    """The two-level arithmetic mean, equation 13; as ``in_place_sweeps``.

    Level 2 runs backwards over the diagonals. Only the next diagonal needs its values, and no later diagonal needs the
    old values of a diagonal. So level 3 runs in the same pass.

    Args:
        first: float64, packed; the values of level 1, equal to ``values`` on fixed nodes.
        wall: the value of the ring. acceleration: ω and r. The rest as in ``in_place_sweeps``.
    """
    rows, columns = shape
    omega, r = acceleration
    # u1 takes an array; of u2 two diagonals do, indexed by the row i: E of a node at i, S at i + 1 of ``following``.
    following, second = np.full(rows, wall), np.full(rows, wall)
    change, state, done = 0.0, RUNNING, 0
    while done < sweeps and state == RUNNING:
        # Level 1, forwards: N and W of u1, E and S of u(k).
        for d in range(2, rows + columns - 3):
            _, n, o, p, q = _diagonal(base, rows, columns, d)
            around, own = _around(first, values, p, q, n), slice(o, o + n)
            _apart(first[own], values[own], movable[own], around, omega / 4.0, 1.0 - omega)
        top = np.int64(0)
        following[:] = wall
        # Level 2, backwards: N and W of u(k), which level 3 has not reached yet, E and S of u2.
        for d in range(rows + columns - 4, 1, -1):
            low, n, o, p, _ = _diagonal(base, rows, columns, d)
            around, own = _around(values, following, p, low, n), slice(o, o + n)
            bits = _mean(values[own], first[own], second[low : low + n], movable[own], around, r / 4.0, 1.0 - r)
            top = max(top, bits)
            # The ring at both ends of the diagonal, which the next one reads.
            second[low - 1] = wall
            second[low + n] = wall
            second, following = following, second
        done += 1
        change, state = _verdict(top, ending, watch)
    return done, change, state


@njit(cache=True, error_model="numpy", nogil=True)
def half_sweeps(
    values: Doubles,
    first: Doubles,
    movable: Mask,
    columns: int,
    odd: int,
    wall: float,
    acceleration: tuple[float, float],
    sweeps: int,
    ending: tuple[float, int, float],
    watch: Doubles,
) -> Any:
    """The arithmetic mean over half of the nodes, each with its four diagonal neighbours; as ``mean_sweeps``.

    Args:
        values, first, movable: rows × half of the columns: node (i, 2k + offset) at [i, k], the offset of row i being
            (``odd`` + i) mod 2. columns: of the padded grid.
    """
    rows = values.shape[0]
    omega, r = acceleration
    # NW  .  NE      The Laplacian on the grid turned by 45°, of nodes of one colour. A row keeps every second node, so
    #  .  x  .       that column 2k + offset is at k, and in the rows above and below, of the other offset, its western
    # SW  .  SE      neighbour is at k + offset - 1, its eastern at k + offset. A row begins at k = 1 - offset.
    following, second = np.full(values.shape[1], wall), np.full(values.shape[1], wall)
    change, state, done = 0.0, RUNNING, 0
    while done < sweeps and state == RUNNING:
        for i in range(1, rows - 1):
            k = 1 - (odd + i) % 2
            own = slice(k, (columns - 3 + k) // 2 + 1)
            around = _around(first[i - 1], values[i + 1], 0, 0, own.stop - k)
            _apart(first[i, own], values[i, own], movable[i, own], around, omega / 4.0, 1.0 - omega)
        top = np.int64(0)
        following[:] = wall
        second[:] = wall
        for i in range(rows - 2, 0, -1):
            k = 1 - (odd + i) % 2
            own = slice(k, (columns - 3 + k) // 2 + 1)
            around = _around(values[i - 1], following, 0, 0, own.stop - k)
            top = max(top, _mean(values[i, own], first[i, own], second[own], movable[i, own], around, r / 4.0, 1.0 - r))
            second, following = following, second
        done += 1
        change, state = _verdict(top, ending, watch)
    return done, change, state


@njit(cache=True, error_model="numpy", nogil=True)
def count_flat(
    values: Doubles, passable: Mask, judged: Mask, base: NDArray[np.int64], shape: tuple[int, int], sign: float
) -> Any:
    """Nodes of ``judged`` with no lower neighbour among the four that are ``passable``.

    Args:
        values, passable, judged: packed. base, shape: the layout. sign: -1 looks for a higher neighbour instead.
    """
    rows, columns = shape
    count = 0
    for d in range(2, rows + columns - 3):
        _, n, o, p, q = _diagonal(base, rows, columns, d)
        for k in range(n):
            # The descent of section V moves to the lowest neighbour, so one must be strictly lower.
            here = sign * values[o + k]
            lower = (
                (passable[p + k] and sign * values[p + k] < here)
                or (passable[p + 1 + k] and sign * values[p + 1 + k] < here)
                or (passable[q + k] and sign * values[q + k] < here)
                or (passable[q + 1 + k] and sign * values[q + 1 + k] < here)
            )
            count += judged[o + k] and not lower
    return count
