"""A run over time as the script of a page takes it: columns, deflated, and a head that says where they stand.

Times are counted in ticks, a power of ten of picoseconds; places in parts of a cell; fields in levels of a logarithm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.report.columns import Columns, Entry
from codesign.report.scrub import Field, Scrub, Timed
from codesign.report.scrub_series import Track
from codesign.report.wording import number_scales

MOST_TICKS = 4_000_000
"""A run has no more ticks: they are too short to be seen."""

PARTS = 64
"""Parts of a cell that a place is rounded to."""

_HEADINGS = 256
_LEVELS = 254


def tick_of(end: int) -> int:
    """Picoseconds a tick: the least power of ten with which a run has at most ``MOST_TICKS``.

    >>> tick_of(3_999_999), tick_of(200 * 10**12)
    (1, 100000000)
    """
    tick = 1
    while end // tick > MOST_TICKS:
        tick *= 10
    return tick


def scrub_data(scrub: Scrub) -> dict[str, Any]:
    """The run, ready for JSON.

    - ``tick``: ps; ``end`` in ticks. ``rows``, ``columns``: of tiles; ``tile``: cells on its side; ``corner``: the
      first row and column. ``view``: top, left, bottom and right of what is drawn, cells.
    - ``free``, ``believed``: the tiles at the begin; ``changes``: what becomes of them.
    - ``robots``, ``paths``, ``goals``, ``events``, ``fields``, ``series``: those of ``Scrub``.
    - ``packed``: the columns; all else names its place there (``Columns``).
    """
    columns, tick = Columns(), tick_of(scrub.end)
    cells, changes = scrub.cells, scrub.cells.changes.coarsened(scrub.end)
    names = [track.name for track in scrub.tracks]
    return {
        "tick": tick,
        "end": max(1, scrub.end // tick),
        "rows": cells.free.shape[0],
        "columns": cells.free.shape[1],
        "tile": cells.tile,
        "corner": list(scrub.map.corner),
        "resolution": scrub.map.resolution,
        "view": _view(scrub),
        "isFleet": scrub.is_fleet,
        "free": columns.add(cells.free.ravel().astype(np.uint8)),
        "believed": None if cells.believed is None else columns.add(cells.believed.ravel()),
        "changes": {
            "time": columns.steps(changes.times // tick),
            "cell": columns.steps(changes.cells),
            "kind": columns.add(changes.kinds),
        },
        "robots": _robots(scrub.tracks, tick, columns),
        "paths": _timed(scrub.paths, names, tick, columns),
        "goals": _timed(scrub.goals, names, tick, columns),
        "targets": [[float(row), float(column)] for row, column in scrub.map.goals.tolist()],
        "events": [[event.time // tick, _place(names, event.robot), event.kind] for event in scrub.events],
        "fields": _fields(scrub.fields, cells.tile, tick, columns),
        "series": [
            {
                "name": each.name,
                "unit": each.unit,
                "counted": each.counted,
                "values": columns.add(np.round(each.values, 4)),
            }
            for each in scrub.series
        ],
        "scales": number_scales(),
        "packed": columns.packed,
    }


def _place(names: Sequence[str], name: str) -> int:
    """The number of a robot; -1 for another name."""
    return names.index(name) if name in names else -1


def _view(scrub: Scrub) -> list[float]:
    """Top, left, bottom and right of the map and of all places of robots, which may lead out of it; cells."""
    first = np.array(scrub.map.corner, np.float64)
    parts = [np.array([first - 0.5, first + np.array(scrub.map.free.shape) - 0.5])]
    for track in scrub.tracks:
        margin = track.radius
        parts += [np.column_stack([track.rows, track.columns]) + side for side in (-margin, margin)]
    points = np.concatenate(parts)
    return [*points.min(axis=0).tolist(), *points.max(axis=0).tolist()]


def _parts(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Places in parts of a cell; what lies absurdly far away is brought near."""
    return np.round(np.clip(values, -1e6, 1e6) * PARTS).astype(np.int64)


def _robots(tracks: Sequence[Track], tick: int, columns: Columns) -> list[dict[str, Any]]:
    times: dict[int, Entry] = {}
    robots = []
    for track in tracks:
        # The robots of a fleet share their times.
        time = times.get(id(track.times)) or columns.steps(track.times // tick)
        times[id(track.times)] = time
        robot: dict[str, Any] = {
            "name": track.name,
            "radius": track.radius,
            "arrived": None if track.arrived is None else track.arrived // tick,
            "time": time,
            "row": columns.steps(_parts(track.rows)),
            "column": columns.steps(_parts(track.columns)),
        }
        if track.headings is not None and track.speeds is not None:
            turns = np.round(track.headings / (2 * math.pi) * _HEADINGS).astype(np.int64) % _HEADINGS
            robot |= {"heading": columns.add(turns), "speed": columns.add(np.round(track.speeds, 4))}
        robots.append(robot)
    return robots


def _timed(each: Sequence[Timed], names: Sequence[str], tick: int, columns: Columns) -> dict[str, Any]:
    """Paths or goals: when, whose, how many points, and all points behind one another."""
    points = np.concatenate([np.zeros((0, 2)), *(one.points.reshape(-1, 2) for one in each)])
    return {
        "time": [one.time // tick for one in each],
        "robot": [_place(names, one.robot) for one in each],
        "count": [len(one.points) for one in each],
        "row": columns.steps(_parts(points[:, 0])),
        "column": columns.steps(_parts(points[:, 1])),
    }


def _fields(fields: Sequence[Field], tile: int, tick: int, columns: Columns) -> dict[str, Any] | None:
    """The fields of stages in levels: 0 for no value above 0, then 1 to 255 from ``low`` to ``high`` (log10)."""
    grids = [_greatest(each.values, tile) for each in fields]
    above = [grid[np.isfinite(grid) & (grid > 0)] for grid in grids]
    values = np.concatenate(above) if above else np.zeros(0)
    if not len(values):
        return None
    low, high = math.log10(values.min()), math.log10(values.max())
    levels = []
    for grid in grids:
        has_value = np.isfinite(grid) & (grid > 0)
        share = (np.log10(np.where(has_value, grid, 1.0)) - low) / max(high - low, 1e-12)
        levels.append(np.where(has_value, 1 + np.round(_LEVELS * np.clip(share, 0, 1)), 0).astype(np.uint8))
    return {
        "time": [each.time // tick for each in fields],
        "stage": [each.stage for each in fields],
        "levels": columns.add(np.concatenate([level.ravel() for level in levels])),
        "low": low,
        "high": high,
    }


def _greatest(values: NDArray[np.float64], tile: int) -> NDArray[np.float64]:
    """The greatest value in each tile."""
    if tile == 1:
        return values
    down, across = (np.arange(0, side, tile) for side in values.shape)
    most: NDArray[np.float64] = np.fmax.reduceat(np.fmax.reduceat(values, down, axis=0), across, axis=1)
    return most
