"""Maps as the kernels take them: padded, flat, with offsets in place of directions; and their limits."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, MapError, outside_map

UNREACHED = -1
"""The potential of a cell that the wave did not reach before it ended, and of every obstacle."""

DELAYS = (2, 3)
"""Delays of a straight and of a diagonal step, in cycles (section "Hardware", footnote 1)."""

CLOCKWISE = ((-1, 0), (0, 1), (1, 0), (0, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
"""The neighbours on a flat map in the order in which paths prefer them: straight ones first, from north on."""

MAX_CELLS = 1 << 24
MAX_DELAY = 64
MAX_EXTRA_DELAY = 63
"""With MAX_DELAY and MAX_CELLS no potential reaches 2^31."""


@dataclass(frozen=True)
class Neighbours:
    """The neighbours of a cell: ``steps`` n × axes (int32), their ``delays`` (rising), ``beside`` n × m × axes.

    ``beside``: the cells that must be free as well, as offsets from the cell that the step leaves. Rows of zeros fill
    up shorter lists. m is 0 where corners may be cut.
    """

    steps: NDArray[np.int32]
    delays: NDArray[np.int32]
    beside: NDArray[np.int32]

    @property
    def corner_cutting(self) -> bool:
        """True if a diagonal step may pass between obstacles."""
        return int(self.beside.shape[1]) == 0

    def flat(self, shape: Sequence[int]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """``steps`` and ``beside`` as offsets in a flat array of ``shape``."""
        strides = np.array([int(np.prod(shape[axis + 1 :])) for axis in range(len(shape))], np.int32)
        return (self.steps @ strides).astype(np.int32), (self.beside @ strides).astype(np.int32)


def neighbours(axes: int, delays: Sequence[int] = DELAYS, corner_cutting: bool = True) -> Neighbours:
    """All neighbours in ``axes`` dimensions, straight ones first; a step along k axes takes ``delays[k - 1]``."""
    steps = [step for step in itertools.product((-1, 0, 1), repeat=axes) if any(step)]
    if axes == 2:
        steps = list(CLOCKWISE)
    steps.sort(key=lambda step: sum(map(abs, step)))
    beside: list[list[tuple[int, ...]]] = []
    for step in steps:
        corners = [
            corner for corner in itertools.product(*({0, part} for part in step)) if any(corner) and corner != step
        ]
        beside.append([] if corner_cutting else sorted(corners))
    width = max(map(len, beside))
    padded = [corners + [(0,) * axes] * (width - len(corners)) for corners in beside]
    return Neighbours(
        np.array(steps, np.int32),
        np.array([delays[sum(map(abs, step)) - 1] for step in steps], np.int32),
        np.array(padded, np.int32).reshape(len(steps), width, axes),
    )


@dataclass(frozen=True, eq=False)
class WaveMap:
    """A checked map: ``free`` (bool, two or three axes), its neighbours, and the extra delay of each cell or None."""

    free: NDArray[np.bool_]
    neighbours: Neighbours
    extra: NDArray[np.uint8] | None

    @cached_property
    def padded_shape(self) -> tuple[int, ...]:
        """The shape with one closed cell on every side."""
        return tuple(side + 2 for side in self.free.shape)

    def pad(self, values: NDArray[Any], fill: int) -> NDArray[Any]:
        """``values`` over the map, flat, with ``fill`` on the padding."""
        padded = np.full(self.padded_shape, fill, values.dtype)
        padded[self._inner] = values
        return padded.ravel()

    def unpad(self, flat: NDArray[Any]) -> NDArray[Any]:
        """The map's own cells of a padded flat array, as a new array."""
        return flat.reshape(self.padded_shape)[self._inner].copy()

    def indices(self, cells: NDArray[np.int64]) -> NDArray[np.int32]:
        """Flat padded indices of n × axes cells."""
        return np.asarray(np.ravel_multi_index(tuple((cells + 1).T), self.padded_shape), np.int32)

    def cells(self, indices: NDArray[np.int32]) -> NDArray[np.int64]:
        """n × axes cells of flat padded indices."""
        return np.stack(np.unravel_index(indices, self.padded_shape), axis=1).astype(np.int64) - 1

    @cached_property
    def arrays(self) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.uint8]]:
        """``offsets``, ``delays``, ``beside`` and ``extra`` as the kernels take them."""
        offsets, beside = self.neighbours.flat(self.padded_shape)
        extra = np.zeros(0, np.uint8) if self.extra is None else self.pad(self.extra, 0)
        return offsets, self.neighbours.delays, beside, extra

    @property
    def _inner(self) -> tuple[slice, ...]:
        return (slice(1, -1),) * self.free.ndim


def check_map(free: Any, delays: Any = None, corner_cutting: bool = True, extra_delay: Any = None) -> WaveMap:
    """The checked map of a wave. Raises MapError for an unusable map, InputError for another unusable argument."""
    cells = _check_free(free)
    steps = neighbours(cells.ndim, check_delays(delays, cells.ndim), bool(corner_cutting))
    return WaveMap(cells, steps, _check_extra(extra_delay, cells))


def _check_free(free: Any) -> NDArray[np.bool_]:
    array = np.asarray(free)
    if array.ndim not in (2, 3):
        raise MapError(f"the map has {array.ndim} dimensions, not 2 or 3", "free")
    sides = " × ".join(str(side) for side in array.shape)
    if array.size == 0:
        raise MapError(f"the map is empty: {sides} cells", "free", "a map needs at least one cell")
    if array.size > MAX_CELLS:
        raise MapError(f"the map has {sides} cells, more than {MAX_CELLS}", "free", "use a coarser map")
    if array.dtype != np.bool_:
        raise MapError(f"the map holds {array.dtype}, not bool", "free", "True for free, False for obstacles")
    return array


def check_delays(delays: Any, axes: int) -> tuple[int, ...]:
    """The delays of steps along 1, 2 (and 3) axes; by default 2, 3 (and 4)."""
    if delays is None:
        return tuple(range(2, 2 + axes))
    numbers = _whole_numbers(delays, "delays")
    if len(numbers) != axes or not all(1 <= number <= MAX_DELAY for number in numbers):
        raise InputError(
            f"delays {delays!r:.80} are not {axes} numbers from 1 to {MAX_DELAY}", "delays", "such as (2, 3)"
        )
    if list(numbers) != sorted(numbers):
        raise InputError(f"delays {delays!r:.80} fall", "delays", "a diagonal step is not shorter than a straight one")
    return numbers


def _check_extra(extra: Any, free: NDArray[np.bool_]) -> NDArray[np.uint8] | None:
    if extra is None:
        return None
    array = np.asarray(extra)
    if array.shape != free.shape or array.dtype.kind not in "iu":
        what = f"extra_delay holds {array.dtype} of shape {array.shape}"
        raise InputError(what, "extra_delay", f"give whole numbers of shape {free.shape}")
    least, most = int(array.min()), int(array.max())
    if least < 0 or most > MAX_EXTRA_DELAY:
        value = least if least < 0 else most
        raise InputError(f"an extra delay of {value} cycles", "extra_delay", f"from 0 to {MAX_EXTRA_DELAY}")
    return array.astype(np.uint8)


def check_cells(cells: Any, free: NDArray[np.bool_], name: str) -> NDArray[np.int64]:
    """The cells as n × axes (int64), n ≥ 1, each inside the map and free.

    Raises:
        MapError: none, no tuples of whole numbers, outside of the map, or on an obstacle.
    """
    if not isinstance(cells, Iterable):
        raise MapError(f"{cells!r:.80} is not a list of cells", name)
    checked = [_whole_numbers(cell, name) for cell in cells]
    if not checked:
        raise MapError("no cell is given", name, "give at least one free cell")
    sides = " × ".join(str(side) for side in free.shape)
    for cell in checked:
        if len(cell) != free.ndim:
            raise MapError(f"{cell} is not a cell of a map of {sides}", name)
        if not all(0 <= part < side for part, side in zip(cell, free.shape, strict=True)):
            what, hint = outside_map(cell, free.shape)
            raise MapError(what, name, hint)
        if not free[cell]:
            raise MapError(f"cell {cell} is on an obstacle", name, "move it to a free cell")
    return np.array(checked, np.int64)


def tile_count(map_shape: Sequence[int], tile: Sequence[int]) -> int:
    """Tiles that cover a map, partial ones counted."""
    return -(-map_shape[0] // tile[0]) * -(-map_shape[1] // tile[1])


def _whole_numbers(values: Any, name: str) -> tuple[int, ...]:
    try:
        return tuple(operator.index(value) for value in values)
    except TypeError:
        raise MapError(f"{values!r:.80} is not a tuple of whole numbers", name) from None
