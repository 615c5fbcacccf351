"""Obstacles with times, of the scans of a recorded run.

The rule, with the parameters of ``Rule``:

1. A ray *hits* the cell a hundredth of a cell behind its measured point. A hit counts where the map has this cell free,
   and no obstacle of the map has its middle within ``margin`` of the middle of this cell.
2. Time is cut into slots of ``slot``. In a slot, a cell is *blocked* where it was hit. It is *open* where it was not
   hit, and the ray of a scan towards its middle went past it by a cell, or the middle of the robot was within
   ``radius`` of it.
3. A cell is an obstacle from the begin of the first slot in which it was blocked, to the begin of the next slot in
   which it was open. A cell that no scan had shown open before was there from the begin. One that no later scan showed
   open stays to the end, or for ``stay`` after its last hit.
4. An obstacle with fewer than ``least`` hits is left out, as noise.
5. Cells with the same times are joined to rectangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray
from scipy import ndimage

from codesign.views.bags.recording import Floats, Poses, RecordedMap, Scans

MAX_CANDIDATES = 20_000
"""Most cells that may become obstacles: of more, those with the most hits."""

MAX_RECTANGLES = 10_000
"""Most obstacles of a workload: of more, those that block the most cells for the longest time."""

_MOST_STATES = 20_000_000
"""Most cells times slots; and most cells times scans that are asked whether they saw past a cell."""

_AT_ONCE = 4_000_000
"""Ranges that are placed on the map at once."""

_BEHIND = 0.01


@dataclass(frozen=True)
class Rule:
    """``slot``, ``stay`` (s; None: to the end), ``margin``, ``radius`` (m) and ``least`` (hits): see the module."""

    slot: float = 1.0
    margin: float = 0.15
    radius: float = 0.2
    least: int = 3
    stay: float | None = None


@dataclass(frozen=True)
class Appeared:
    """A rectangle of cells that was an obstacle from ``at`` to ``until`` (s); None: to the end."""

    row: int
    column: int
    rows: int
    columns: int
    at: float
    until: float | None


@dataclass(frozen=True)
class Drawn:
    """The obstacles, the ``rule`` that was used, and how many of what was left out."""

    obstacles: tuple[Appeared, ...]
    rule: Rule
    hits: int = 0
    cells: int = 0
    left_out: int = 0


def draw_obstacles(plan: RecordedMap, scans: Scans, sensor: Poses, robot: Poses, begin: float, rule: Rule) -> Drawn:
    """The obstacles from ``begin`` (s) on. ``sensor``, ``robot``: poses in the frame of the map, one a scan."""
    open_cells = _away_from_obstacles(plan, rule.margin)
    seen, scan_of = _hits(plan, scans, sensor, open_cells)
    if not len(seen):
        return Drawn((), rule)
    cells, counts = np.unique(seen, return_counts=True)
    kept = cells[np.sort(np.argsort(-counts, kind="stable")[:MAX_CANDIDATES])]
    end = float(scans.times[-1])
    rule = replace(rule, slot=max(rule.slot, (end - begin) * len(kept) / _MOST_STATES))
    slots = max(1, math.floor((end - begin) / rule.slot) + 1)
    slot_of = np.floor((scans.times - begin) / rule.slot).astype(np.int64)
    # What was seen before the begin is of slot -1, which is kept as slot 0 of the table.
    slot_of = np.clip(slot_of, -1, slots - 1) + 1
    hits = np.zeros((slots + 1, len(kept)), np.int32)
    place = np.searchsorted(kept, seen)
    of_kept = (place < len(kept)) & (kept[np.minimum(place, len(kept) - 1)] == seen)
    np.add.at(hits, (slot_of[scan_of[of_kept]], place[of_kept]), 1)
    opened = _opened(plan, scans, sensor, robot, kept, slot_of, slots + 1, rule)
    spans = _spans(hits, opened & (hits == 0), rule)
    rectangles = [
        Appeared(*box, first * rule.slot, None if last is None else last * rule.slot)
        for (first, last), members in spans.items()
        for box in _rectangles(kept[members], plan.cells.shape[1])
    ]
    rectangles.sort(key=lambda each: (-_weight(each, end - begin), each.at, each.row, each.column))
    chosen = sorted(rectangles[:MAX_RECTANGLES], key=lambda each: (each.at, each.row, each.column))
    blocked = sum(each.rows * each.columns for each in chosen)
    return Drawn(tuple(chosen), rule, len(seen), blocked, len(rectangles) - len(chosen))


def _weight(each: Appeared, end: float) -> float:
    return each.rows * each.columns * ((end if each.until is None else each.until) - each.at)


def _away_from_obstacles(plan: RecordedMap, margin: float) -> NDArray[np.bool_]:
    """The free cells without an obstacle of the map within the margin."""
    occupied, free = plan.cells > 0, plan.cells == 0
    reach = margin / plan.frame.resolution
    if reach < 1.0 or not occupied.any():
        return np.asarray(free)
    return np.asarray(free & (ndimage.distance_transform_edt(~occupied) > reach))


def _hits(
    plan: RecordedMap, scans: Scans, sensor: Poses, open_cells: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The cells that were hit (raster numbers), and the scan of each hit."""
    rows, columns = plan.cells.shape
    rays = scans.ranges.shape[1]
    found_cells, found_scans = [], []
    behind = _BEHIND * plan.frame.resolution
    for first in range(0, len(scans.times), max(1, _AT_ONCE // rays)):
        part = slice(first, first + max(1, _AT_ONCE // rays))
        ranges = scans.ranges[part].astype(np.float64)
        met = np.isfinite(ranges) & (ranges >= scans.span[0]) & (ranges < scans.span[1]) & (ranges > 0.0)
        scan, ray = np.nonzero(met)
        length = ranges[scan, ray] + behind
        angle = scans.first[part][scan] + ray * scans.step
        local = np.column_stack([length * np.cos(angle), length * np.sin(angle)])
        turn, place = sensor.turns[part], sensor.places[part]
        x = turn[scan, 0, 0] * local[:, 0] + turn[scan, 0, 1] * local[:, 1] + place[scan, 0]
        y = turn[scan, 1, 0] * local[:, 0] + turn[scan, 1, 1] * local[:, 1] + place[scan, 1]
        row, column = cells_of(plan, x, y)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        row, column, scan = row[inside], column[inside], scan[inside]
        counts = open_cells[row, column]
        found_cells.append(row[counts] * columns + column[counts])
        found_scans.append(scan[counts] + first)
    if not found_cells:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.concatenate(found_cells), np.concatenate(found_scans)


def cells_of(plan: RecordedMap, x: Floats, y: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of points in metres, as ``Frame.cell`` has them; inside of the map or not."""
    left, below, yaw = plan.frame.origin
    right, up = x - left, y - below
    across = right * math.cos(yaw) + up * math.sin(yaw)
    along = up * math.cos(yaw) - right * math.sin(yaw)
    most = 2.0**40
    column = np.floor(np.clip(across / plan.frame.resolution + 1e-9, -most, most)).astype(np.int64)
    row = plan.frame.rows - 1 - np.floor(np.clip(along / plan.frame.resolution + 1e-9, -most, most)).astype(np.int64)
    return row, column


def _opened(
    plan: RecordedMap,
    scans: Scans,
    sensor: Poses,
    robot: Poses,
    cells: NDArray[np.int64],
    slot_of: NDArray[np.int64],
    slots: int,
    rule: Rule,
) -> NDArray[np.bool_]:
    """Bool, slots × cells: whether a scan of the slot saw past the cell, or the robot stood on it."""
    opened = np.zeros((slots, len(cells)), np.bool_)
    columns = plan.cells.shape[1]
    x, y = _middles(plan, cells // columns, cells % columns)
    every = max(1, math.ceil(len(scans.times) * len(cells) / _MOST_STATES))
    rays = scans.ranges.shape[1]
    turn = 2 * math.pi / abs(scans.step)
    for scan in range(0, len(scans.times), every):
        matrix, place = sensor.turns[scan], sensor.places[scan]
        right, up = x - place[0], y - place[1]
        ahead = matrix[0, 0] * right + matrix[1, 0] * up
        beside = matrix[0, 1] * right + matrix[1, 1] * up
        ray = np.rint((np.arctan2(beside, ahead) - scans.first[scan]) / scans.step)
        index = np.mod(ray, turn).astype(np.int64)
        looked = index < rays
        measured = scans.ranges[scan][np.minimum(index, rays - 1)]
        far = np.where(np.isnan(measured), 0.0, np.minimum(measured, scans.span[1]))
        distance = np.hypot(right, up)
        past = looked & (far > distance + plan.frame.resolution)
        under = np.hypot(x - robot.places[scan, 0], y - robot.places[scan, 1]) <= rule.radius
        opened[slot_of[scan]] |= past | under
    return opened


def _middles(plan: RecordedMap, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> tuple[Floats, Floats]:
    left, below, yaw = plan.frame.origin
    side = plan.frame.resolution
    right, up = (columns + 0.5) * side, (plan.frame.rows - rows - 0.5) * side
    x = left + right * math.cos(yaw) - up * math.sin(yaw)
    return x, below + right * math.sin(yaw) + up * math.cos(yaw)


def _spans(hits: NDArray[np.int32], opened: NDArray[np.bool_], rule: Rule) -> dict[tuple[int, int | None], list[int]]:
    """The cells (their numbers) of each span of slots, counted from the begin; None: to the end."""
    closed: list[tuple[tuple[int, int | None], int]] = []
    count = hits.shape[1]
    began, latest = np.full(count, -1), np.zeros(count, np.int64)
    stay = None if rule.stay is None else max(1, math.ceil(rule.stay / rule.slot))
    total = np.zeros(count, np.int64)
    shown_open = np.zeros(count, np.bool_)

    def close(which: NDArray[np.int64], slot: int | None) -> None:
        for cell in which.tolist():
            last = slot if stay is None else min(len(hits) if slot is None else slot, int(latest[cell]) + stay)
            if total[cell] >= rule.least and (last is None or last > began[cell]):
                closed.append(((int(began[cell]), last), cell))

    for index in range(len(hits)):
        slot = max(index - 1, 0)
        hit = hits[index] > 0
        fresh = hit & (began < 0)
        began[fresh & shown_open] = slot
        began[fresh & ~shown_open] = 0
        total += hits[index]
        latest[hit] = slot
        gone = opened[index] & (began >= 0)
        close(np.flatnonzero(gone), slot)
        began[gone] = -1
        total[gone] = 0
        shown_open |= opened[index]
    close(np.flatnonzero(began >= 0), None)
    return map_reduce(closed, itemgetter(0), itemgetter(1))


def _rectangles(cells: NDArray[np.int64], columns: int) -> Iterator[tuple[int, int, int, int]]:
    """The cells as rectangles (row, column, rows, columns): runs of a row, joined with equal runs below."""
    rows_of, columns_of = np.divmod(np.sort(cells), columns)
    breaks = np.flatnonzero((np.diff(rows_of) != 0) | (np.diff(columns_of) != 1)) + 1
    runs = [(int(part[0]), int(part[-1])) for part in np.split(np.arange(len(cells)), breaks)]
    under: dict[tuple[int, int], tuple[int, int]] = {}
    for first, last in runs:
        row, span = int(rows_of[first]), (int(columns_of[first]), int(columns_of[last]))
        above = under.pop(span, None)
        if above is not None and above[0] + above[1] != row:
            yield above[0], span[0], above[1], span[1] - span[0] + 1
            above = None
        under[span] = (row, 1) if above is None else (above[0], above[1] + 1)
    for span, (row, height) in under.items():
        yield row, span[0], height, span[1] - span[0] + 1
