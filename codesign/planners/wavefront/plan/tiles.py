"""A map in tiles, one after the other on an array of one tile: exact potentials, and the visits of tiles.

A visit runs the wave in one tile from its own sources and from the cells around the tile. These cells emit at the
times of their potentials. The result of a visit is the shortest distance for the present potentials outside. If a
border cell changes, the tiles beside it are visited (again); the tile with the earliest change is first. Potentials
only fall and are lengths of real paths, so the visits end. Then equation 1 holds everywhere: the potentials are as on
the whole map at once.

What a visit changes, it changes to more than the change that it was pending for. So pending changes come in order of
time, and potentials up to the present one are final. A wave that waits for a stop therefore ends where the pending
change reaches the stop's potential: its visits are the first ones of the wave to its own end, and the farthest start
takes longest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.planners.wavefront.plan.grid import UNREACHED, WaveMap

kernels = late("codesign.planners.wavefront.plan.kernels")

NEVER = np.iinfo(np.int32).max
"""The potential that a wave to its own end waits for."""
NO_LIMIT = np.iinfo(np.int64).max
NONE_SURE = np.zeros((0, 4), np.int64)


@dataclass(frozen=True)
class Visits:
    """The visits of tiles, one value each, in order; int64.

    ``tile``: raster number. ``since``: the change that it was pending for, rising. ``span``: cycles from the first
    emission to the last emission or arrival, which is at ``last``. ``until``: no change from here on is followed.
    ``left``: cycles of visits that were given up, at least.
    """

    tile: NDArray[np.int64]
    since: NDArray[np.int64]
    span: NDArray[np.int64]
    last: NDArray[np.int64]
    until: int = NEVER
    left: int = 0

    @property
    def largest(self) -> int:
        """The largest potential that any visit met, which may be above the final ones."""
        return int(self.last.max(initial=0))

    def before(self, until: int) -> Visits:
        """The visits of a wave that waits for a stop with this potential, no farther away than these visits go."""
        first = slice(0, int(np.searchsorted(self.since, until)))
        return Visits(self.tile[first], self.since[first], self.span[first], self.last[first], until)


def run_tiles(
    wave_map: WaveMap,
    sources: NDArray[np.int64],
    tile: Sequence[int],
    until: int = NEVER,
    exchange: int = 0,
    most_cycles: int = NO_LIMIT,
    sure: NDArray[np.int64] = NONE_SURE,
) -> tuple[NDArray[np.int32], Visits]:
    """Potentials as by ``wave.run_wave``, and the visits. The map has two axes; ``tile``: rows, columns.

    ``until``: the potential of the farthest stop. Cells farther away are ``UNREACHED``. The visits that take more than
    ``most_cycles``, with ``exchange`` each beside the wave, are given up: ``Visits.until`` is then smaller, and the
    potentials are not all final. ``sure``: visits that are sure (``VisitBounds.sure``), by which that is known sooner.
    """
    shape, beside = wave_map.padded_shape, wave_map.neighbours
    free = wave_map.pad(np.where(wave_map.free, np.int32(NEVER), np.int32(kernels.CLOSED)), kernels.CLOSED)
    source = np.zeros(shape, np.bool_)
    source[tuple(sources.T + 1)] = True
    potentials = free.reshape(shape)
    tiles = math.prod(-(-(cells - 2) // side) for cells, side in zip(shape, tile, strict=True))
    visits, to_come = kernels.visit_tiles(
        potentials,
        source,
        wave_map.arrays[3],
        (int(tile[0]), int(tile[1])),
        beside.steps,
        beside.delays,
        beside.beside,
        until,
        exchange,
        most_cycles,
        sure,
        np.searchsorted(sure[:, 0], np.arange(tiles + 1)),
    )
    number, since, begin, last = visits.T
    answer = potentials[1:-1, 1:-1]
    answer[tuple(sources.T)] = 0
    answer = np.where((answer < 0) | (answer > until) | (answer == NEVER), np.int32(UNREACHED), answer)
    ended = to_come < 0
    return answer, Visits(number, since, last - begin, last, until if ended else int(since[-1]), max(0, int(to_come)))
