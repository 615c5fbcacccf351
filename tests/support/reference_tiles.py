"""The visits of tiles as a plain loop, which waits for stops: what the kernel is held against, visit by visit."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.planners.wavefront.plan import kernels
from codesign.planners.wavefront.plan.grid import UNREACHED, WaveMap

HALO = -4
"""A cell around the tile: it emits when its time has come, and no wave enters it."""
NEVER = np.iinfo(np.int32).max


@dataclass
class _State:
    """The padded map during the visits. ``potentials``: OPEN, CLOSED, or a time so far. ``source``: the sources."""

    potentials: NDArray[np.int32]
    source: NDArray[np.bool_]
    extra: NDArray[np.uint8]


def run_tiles(
    wave_map: WaveMap, sources: NDArray[np.int64], stops: NDArray[np.int64], tile: Sequence[int]
) -> tuple[NDArray[np.int32], list[tuple[int, int, int, int]]]:
    """Potentials, and of each visit the tile, the change that it was pending for, its span and its last time."""
    rows, columns = wave_map.free.shape
    shape = wave_map.padded_shape
    free = np.where(wave_map.free, np.int32(kernels.OPEN), np.int32(kernels.CLOSED))
    source = np.zeros(shape, np.bool_)
    source[tuple(sources.T + 1)] = True
    extra = wave_map.arrays[3]
    state = _State(
        wave_map.pad(free, kernels.CLOSED).reshape(shape), source, extra.reshape(shape) if extra.size else extra
    )
    down_count, across = -(-rows // tile[0]), -(-columns // tile[1])
    pending = dict.fromkeys(((row // tile[0]) * across + column // tile[1] for row, column in sources.tolist()), 0)
    waiting = [(0, index) for index in sorted(pending)]
    stop_cells = tuple(stops.T + 1)
    visited: list[tuple[int, int, int, int]] = []
    while waiting:
        since, index = heapq.heappop(waiting)
        if pending.get(index) != since:
            continue
        # A stop that is a source is reached before any visit.
        at_stops = np.where(source[stop_cells], 0, state.potentials[stop_cells])
        if at_stops.size and at_stops.min() >= 0 and since >= at_stops.max():
            break
        del pending[index]
        corner = index // across * tile[0], index % across * tile[1]
        size = min(tile[0], rows - corner[0]), min(tile[1], columns - corner[1])
        begin, end, changes = _visit(wave_map, state, corner, size)
        visited.append((index, since, end - begin, end))
        for (down, right), time in changes.items():
            if not (0 <= index // across + down < down_count and 0 <= index % across + right < across):
                continue
            beside = index + down * across + right
            if time < pending.get(beside, NEVER):
                pending[beside] = time
                heapq.heappush(waiting, (time, beside))
    answer = state.potentials[1:-1, 1:-1]
    answer = np.where(source[1:-1, 1:-1], 0, np.where(answer < 0, np.int32(UNREACHED), answer))
    if len(stops):
        answer[answer > answer[tuple(stops.T)].max()] = UNREACHED
    return answer, visited


def _visit(
    wave_map: WaveMap, state: _State, corner: tuple[int, int], size: tuple[int, int]
) -> tuple[int, int, dict[tuple[int, int], int]]:
    """Run one tile; returns its first and last time, and the earliest change towards each tile beside it."""
    window = slice(corner[0], corner[0] + size[0] + 2), slice(corner[1], corner[1] + size[1] + 2)
    inner = slice(1, -1), slice(1, -1)
    potentials = state.potentials[window]
    before = potentials[inner].copy()
    # One more closed cell around, so that the halo has neighbours too.
    frame = np.full((size[0] + 4, size[1] + 4), kernels.CLOSED, np.int32)
    halo = frame[inner]
    halo[...] = np.where(potentials == kernels.CLOSED, np.int32(kernels.CLOSED), np.int32(HALO))
    halo[inner] = np.where(before == kernels.CLOSED, np.int32(kernels.CLOSED), np.int32(kernels.OPEN))
    times = np.where(potentials >= 0, potentials, NEVER)
    times[inner] = np.where(state.source[window][inner], 0, NEVER)
    emitting = np.argwhere(times < NEVER)
    at = times[tuple(emitting.T)]
    by_time = np.argsort(at, kind="stable")
    seeds = np.ravel_multi_index(tuple(emitting[by_time].T + 1), frame.shape).astype(np.int32)
    extra = np.zeros(0, np.uint8)
    if state.extra.size:
        extra = np.zeros(frame.shape, np.uint8)
        extra[inner] = state.extra[window]
        extra = extra.ravel()
    offsets, beside = wave_map.neighbours.flat(frame.shape)
    flat = frame.ravel()
    none = np.zeros(0, np.int32)
    kernels.spread(
        flat, seeds, at[by_time].astype(np.int32), offsets, wave_map.neighbours.delays, beside, extra, none, NEVER - 1
    )
    after = flat.reshape(frame.shape)[2:-2, 2:-2]
    after[(after < 0) & (after != kernels.CLOSED)] = kernels.OPEN
    potentials[inner] = after
    last = max(int(at.max()), int(after.max(initial=0)))
    changed = np.where((after >= 0) & (after != before), after, NEVER)
    return int(at.min()), last, _towards(changed)


def _towards(changed: NDArray[np.int32]) -> dict[tuple[int, int], int]:
    """The earliest change at the border (NEVER: none) that each of the eight tiles beside it can see."""
    sides = {-1: slice(0, 1), 0: slice(None), 1: slice(-1, None)}
    earliest_changes = {}
    for down, rows in sides.items():
        for right, columns in sides.items():
            earliest = int(changed[rows, columns].min())
            if (down or right) and earliest < NEVER:
                earliest_changes[down, right] = earliest
    return earliest_changes
