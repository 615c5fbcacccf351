"""The potentials: the arrival of the wave at each cell (Möller and Paschke 1998, "Computation of Potential Vectors").

A wave starts from the source cells at time 0 and passes from cell to cell with a delay of 2 cycles for a straight
step and 3 for a diagonal one. The time of its arrival is the potential. The potentials equal the distances of
Dijkstra's algorithm on the graph with weights 2 and 3, bit for bit. ``reference`` computes the same in a few plain
lines, and clocks the circuit cycle by cycle.

The error against the true distance: a path of a straight and b diagonal steps has octile length a + √2 b and potential
2 (a + 1.5 b), and a + √2 b ≤ a + 1.5 b ≤ (1.5 / √2)(a + √2 b). So half the potential, and the octile length of the
tracked path, lie between the shortest octile length and 1.0607 times it. The potential meets the upper bound on every
path of diagonal steps alone. The length approaches the bound where a detour of almost only straight steps ties with
such a path.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, MapError
from codesign.ground.late import late
from codesign.planners.wavefront.plan.grid import UNREACHED, WaveMap, check_cells, check_delays, check_map

kernels = late("codesign.planners.wavefront.plan.kernels")

NO_LIMIT = 2**31 - 2
MAX_OCTILE_RATIO = 1.5 / 2**0.5
"""Half the potential over the shortest octile length is at most this, and at least 1 (see the module)."""


def propagate(
    free: NDArray[np.bool_],
    sources: Iterable[Sequence[int]],
    *,
    stop: Sequence[int] | None = None,
    limit: int | None = None,
    corner_cutting: bool = True,
    extra_delay: NDArray[np.integer] | None = None,
    delays: Sequence[int] | None = None,
) -> NDArray[np.int32]:
    """The potential of every cell: int32 of the map's shape, ``UNREACHED`` (-1) on obstacles and beyond the wave.

    >>> free = np.array([[1, 1, 1], [1, 0, 1]], dtype=bool)
    >>> propagate(free, [(1, 0)])
    array([[ 2,  3,  5],
           [ 0, -1,  6]], dtype=int32)

    Args:
        free: bool, rows × columns, or layers × rows × columns.
        sources: the reference cells (Z = 1).
        stop: the wave ends with the cycle that reaches this cell. Cells farther away stay unreached; cells at the same
            distance are reached. The circuit takes ``stop_cycle`` cycles.
        limit: the wave ends after this potential.
        corner_cutting: True if a diagonal step may pass between obstacles, as in the paper; without, the cells beside
            it must be free too.
        extra_delay: cycles, 0 to 63, that the wave needs to enter each cell beyond the step's own ("special
            penalties", section "Conclusion").
        delays: of steps along one axis, along two (and three); 2, 3 (and 4) by default.

    Raises:
        MapError: a map, source or stop that cannot be used, or a stop that no path joins to a source.
        InputError: another argument.
    """
    wave_map = check_map(free, delays, corner_cutting, extra_delay)
    cells = check_cells(sources, wave_map.free, "sources")
    stops = np.zeros((0, wave_map.free.ndim), np.int64)
    if stop is not None:
        stops = check_cells([stop], wave_map.free, "stop")
    return run_wave(wave_map, cells, stops, limit)[0]


def run_wave(
    wave_map: WaveMap, sources: NDArray[np.int64], stops: NDArray[np.int64], limit: int | None = None
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Potentials, and the reached cells as flat padded indices in order of time.

    The wave ends once all ``stops`` (n × axes) are reached. Without a stop it runs until it has died.

    Raises:
        MapError: the wave dies before it reaches a stop. InputError: an impossible limit.
    """
    if limit is not None and not 0 <= limit <= NO_LIMIT:
        raise InputError(f"the limit is {limit}", "limit", "give a potential from 0 on")
    potentials = wave_map.pad(np.where(wave_map.free, np.int32(kernels.OPEN), np.int32(kernels.CLOSED)), kernels.CLOSED)
    seeds = wave_map.indices(sources)
    stop_indices = wave_map.indices(stops)
    order = kernels.spread(
        potentials,
        seeds,
        np.zeros(len(seeds), np.int32),
        *wave_map.arrays,
        stop_indices,
        NO_LIMIT if limit is None else limit,
    )
    if limit is None and (missed := np.flatnonzero(potentials[stop_indices] < 0)).size:
        what = f"cell {tuple(stops[missed[0]].tolist())} cannot be reached from any source"
        raise MapError(what, "stop", "the wave would never arrive; choose another cell, or no stop")
    return wave_map.unpad(np.maximum(potentials, UNREACHED)), order


def stop_cycle(stop_potential: int) -> int:
    """Cycles until the circuit may stop: D_stop + 1, one after the wave's arrival.

    The counter is then above every potential. The registers that are still open hold this value: infinity.

    >>> stop_cycle(1355)
    1356
    """
    return stop_potential + 1


def register_bits(largest: int) -> int:
    """Bits of a register and of the counter that hold 0 to ``largest`` and infinity, which is ``largest`` + 1.

    >>> register_bits(1355), register_bits(2046), register_bits(2047)
    (11, 11, 12)
    """
    return (largest + 1).bit_length()


def longest_distance(shape: Sequence[int], delays: Sequence[int] | None = None) -> int:
    """The largest potential of any cell in an empty map: between opposite corners ("length of the diagonal line").

    765 for 256 × 256 nodes, 255 diagonal steps; the paper ends its obstacle map at 768, three cycles for each
    of 256 nodes.

    >>> longest_distance((256, 256))
    765
    """
    sides = sorted(side - 1 for side in shape)
    along = check_delays(delays, len(sides))
    cheapest = list(along)
    for axes in range(1, len(sides)):
        cheapest[axes] = min(along[axes], cheapest[axes - 1] + along[0])
    # Steps along every axis cross the shortest side. Steps along one axis less cross the rest of the next side.
    total = crossed = 0
    for axis, side in enumerate(sides):
        total += cheapest[len(sides) - axis - 1] * (side - crossed)
        crossed = side
    return total


def obstacle_potentials(free: NDArray[np.bool_], *, delays: Sequence[int] | None = None) -> NDArray[np.int32]:
    """Distance of every cell from the nearest obstacle, p^d: int32 of the map's shape, 0 on obstacles.

    All nodes are free space (F = 1) and every obstacle is a source (section "Safe Paths"). No obstacle is outside of
    the map. The wave ends at ``longest_distance``. A map without obstacles holds ``longest_distance`` + 1 everywhere,
    the value of the open registers of the circuit.

    Raises:
        MapError: a map that cannot be used.
    """
    wave_map, obstacles = obstacle_map(free, delays)
    if not len(obstacles):
        return np.full(wave_map.free.shape, longest_distance(wave_map.free.shape, delays) + 1, np.int32)
    return run_wave(wave_map, obstacles, np.zeros((0, wave_map.free.ndim), np.int64))[0]


def obstacle_map(free: NDArray[np.bool_], delays: Sequence[int] | None = None) -> tuple[WaveMap, NDArray[np.int64]]:
    """The map and sources of the wave from all obstacles: all nodes free, and the obstacles, n × axes."""
    wave_map = check_map(free, delays)
    return WaveMap(np.ones_like(wave_map.free), wave_map.neighbours, None), np.argwhere(~wave_map.free)


def near_obstacles(free: NDArray[np.bool_], distance: int, delay: int) -> NDArray[np.uint8]:
    """Extra delays: ``delay`` cycles for every free cell with an obstacle potential of at most ``distance``."""
    return np.where(obstacle_potentials(free) <= distance, np.uint8(delay), np.uint8(0))
