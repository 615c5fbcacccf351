"""A mission as pictures: where the robot drove, the obstacles that came, and how busy each component and link was."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.records import (
    MapRecord,
    MissionRecord,
    ObstacleRecord,
    PoseRecord,
    PositionsRecord,
    Record,
)
from codesign.report.mission_timeline import MARKS, legend, marker_size
from codesign.report.plots import Format, Picture, canvas, picture_bytes, style
from codesign.report.wording import prefix, quantity_text, share_text
from codesign.units import counted, format_time

_LARGEST_SIDE = 1200
_MOST_LINES = 64

_CAME = "obstacle that came"

Points = NDArray[np.float64]


@dataclass
class _Layers:
    """What is drawn over the map, bottom first."""

    free: NDArray[np.bool_]
    goals: NDArray[np.int32]
    came: NDArray[np.bool_]
    came_name: str = _CAME
    unknown: NDArray[np.bool_] | None = None
    lines: list[Points] = field(default_factory=list)
    way: Points | None = None
    marks: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    robots: Points | None = None


def drive_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The true map with every obstacle that came, the paths of the robots, and the events at their places.

    None where no robot reports its place, or there is no map.
    """
    start: MapRecord | None = None
    came = np.zeros((0, 0), bool)
    places: dict[str, list[tuple[int, float, float]]] = {}
    events: list[MissionRecord] = []
    for record in records:
        if isinstance(record, MapRecord):
            start, came = record, np.zeros(record.free.shape, bool)
        elif isinstance(record, ObstacleRecord) and record.appeared:
            came[record.cells[:, 0], record.cells[:, 1]] = True
        elif isinstance(record, PoseRecord):
            places.setdefault(record.source, []).append((record.time, record.row, record.column))
        elif isinstance(record, PositionsRecord):
            for robot, (row, column) in enumerate(record.positions[:_MOST_LINES].tolist()):
                places.setdefault(f"{record.source} {robot}", []).append((record.time, row, column))
        elif isinstance(record, MissionRecord):
            events.append(record)
    if start is None or not places:
        return None
    tracks = {source: np.array(track, np.float64) for source, track in places.items()}
    layers = _Layers(start.free, start.goals, came, "obstacle at some time")
    layers.lines = [track[:, 1:] for track in tracks.values()]
    for event in events:
        track = tracks.get(event.source)
        if event.event in MARKS and track is not None:
            row, column = (float(np.interp(event.time, track[:, 0], track[:, axis])) for axis in (1, 2))
            layers.marks.setdefault(event.event, []).append((row, column))
    length = sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in layers.lines)
    facts = [f"{counted(len(tracks), 'robot')}, {quantity_text(length, '')} cells driven"]
    facts += [f"{MARKS[event][0]}: {len(where)}" for event, where in layers.marks.items()]
    return _drawn(
        layers, "Where the robots drove" if len(tracks) > 1 else "Where the robot drove", facts, format
    )


def moment_picture(
    time: int,
    start: NDArray[np.bool_],
    free: NDArray[np.bool_],
    *,
    goals: NDArray[np.int32],
    unknown: NDArray[np.bool_] | None = None,
    way: Points | None = None,
    driven: Points | None = None,
    robots: Points | None = None,
    format: Format = "png",
) -> Picture:
    """A mission at one moment: the obstacles, the cells that the robot does not know, its path, and its place.

    Args:
        time: ps. start, free: bool, rows × columns: the cells that were free at the start, and that are now.
        goals: int32, n × 2. unknown: bool, rows × columns: the cells that the robot does not know.
        way, driven, robots: float64, n × 2 each, (row, column) in cells; the robot stands where ``driven`` ends.
    """
    drives = driven is not None and len(driven) > 0
    layers = _Layers(
        start,
        goals,
        start & ~free,
        unknown=unknown,
        lines=[driven] if drives and driven is not None else [],
        way=way,
        robots=driven[-1:] if drives and driven is not None else robots,
    )
    facts = [f"{int((start & ~free).sum())} cells blocked since the start"]
    return _drawn(layers, f"The mission at {format_time(time)}", facts, format)


def _drawn(layers: _Layers, title: str, facts: Sequence[str], format: Format) -> Picture:
    rows, columns = layers.free.shape
    with style():
        picture, axes = canvas((8.0, min(12.0, max(2.6, 8.0 * rows / max(columns, 1) + 1.1))))
        _draw_cells(axes, layers)
        many = len(layers.lines) > 1
        for number, line in enumerate(layers.lines):
            colour = f"C{number % 10}" if many else "#2166ac"
            axes.plot(
                line[:, 1], line[:, 0], color=colour, linewidth=1.0 if many else 1.4, zorder=3,
                label="driven" if number == 0 else None,
            )  # fmt: skip
            axes.plot(line[:1, 1], line[:1, 0], "o", color=colour, markersize=4, zorder=3)
        if layers.way is not None and len(layers.way):
            axes.plot(layers.way[:, 1], layers.way[:, 0], "--", color="#d1495b", linewidth=1.2, label="path")
        _draw_marks(axes, layers)
        top, left, bottom, right = _extent(layers)
        axes.set(xlabel="column", ylabel="row", xlim=(left, right), ylim=(bottom, top))
        legend(picture)
        data = picture_bytes(picture, format)
    return Picture(
        title=title,
        alt=f"Map of {rows} by {columns} cells: {', '.join(facts)}",
        format=format,
        data=data,
        caption=f"{title}: {', '.join(facts)}",
    )


def _extent(layers: _Layers) -> tuple[float, float, float, float]:
    """Top, left, bottom and right of the map and of what was driven, which in a fleet may lead out of it."""
    rows, columns = layers.free.shape
    corners = [
        np.array([[0.0, 0.0], [rows - 1.0, columns - 1.0]]),
        *(line for line in layers.lines if len(line)),
    ]
    points = np.concatenate(corners)
    (top, left), (bottom, right) = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    return float(top), float(left), float(bottom), float(right)


def _draw_cells(axes: Any, layers: _Layers) -> None:
    from matplotlib.colors import to_rgb

    rows, columns = layers.free.shape
    step = max(1, max(rows, columns) // _LARGEST_SIDE)
    shades = np.ones((rows, columns, 3), np.float32)
    shown = [("wall", ~layers.free, "#3b3f45"), (layers.came_name, layers.came & layers.free, "#f4a259")]
    if layers.unknown is not None:
        shown.insert(0, ("not known", layers.unknown, "#d9dee4"))
        shown.insert(2, ("wall not known", layers.unknown & ~layers.free, "#8b929b"))
    for name, cells, colour in shown:
        if cells.any():
            shades[cells] = to_rgb(colour)
            axes.plot([], [], "s", color=colour, label=name)
    axes.imshow(
        shades[::step, ::step], extent=(-0.5, columns - 0.5, rows - 0.5, -0.5), interpolation="nearest"
    )


def _draw_marks(axes: Any, layers: _Layers) -> None:
    if len(layers.goals):
        axes.plot(
            layers.goals[:, 1], layers.goals[:, 0], "*", color="#1a9850", markersize=12,
            markeredgecolor="white", linestyle="none", zorder=4, label="goal",
        )  # fmt: skip
    for event, places in layers.marks.items():
        words, marker, colour = MARKS[event]
        points = np.array(places)
        axes.plot(
            points[:, 1], points[:, 0], marker, color=colour, markersize=marker_size(marker), linestyle="none",
            zorder=5, markeredgecolor="white", markeredgewidth=0.5, label=f"{words} ({len(points)})",
        )  # fmt: skip
    if layers.robots is not None and len(layers.robots):
        axes.plot(
            layers.robots[:, 1], layers.robots[:, 0], "o", color="#2166ac", markersize=8,
            markeredgecolor="white", linestyle="none", zorder=6, label="robot",
        )  # fmt: skip


def account_picture(accounts: Mapping[str, Any], *, format: Format = "png") -> Picture | None:
    """Where the time of each component and link went, as stacked bars; None where there are none.

    ``accounts``: by name, with ``compute_s``, ``transfer_s`` and ``idle_s``, which make up the mission, and ``wait_s``,
    a bar of its own below.
    """
    if not accounts:
        return None
    names = list(accounts)
    size, unit = prefix([max(_total(account) for account in accounts.values())], "s")
    kinds = (("compute", "#2166ac"), ("transfer", "#4dac26"), ("idle", "#e6e9ed"))
    with style():
        picture, axes = canvas((8.0, 1.3 + 0.42 * len(names)))
        rows, left = np.arange(len(names)), np.zeros(len(names))
        for kind, colour in kinds:
            widths = np.array([getattr(accounts[name], f"{kind}_s") for name in names]) / size
            axes.barh(rows, widths, left=left, color=colour, height=0.56, label=kind)
            left += widths
        # What waits does so side by side, and while others are served: it is no part of the bar.
        waits = np.array([accounts[name].wait_s for name in names]) / size
        axes.barh(rows + 0.38, waits, color="#f4a259", height=0.14, label="others wait for it")
        for row, name in enumerate(names):
            axes.text(left[row], row, f"  {share_text(_busy(accounts[name]))} busy", va="center", fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.margins(x=0.14)
        axes.set_xlim(left=0.0)
        axes.set(xlabel=f"time ({unit})", ylim=(len(names) - 0.5, -0.5))
        legend(picture)
        data = picture_bytes(picture, format)
    return Picture(
        title="Where the time of each component and link went",
        alt=f"Stacked bars of compute, transfer and idle of {', '.join(names)}, waits below; figures stand in a table",
        format=format,
        data=data,
    )


def _busy(account: Any) -> float:
    """The share of the mission in which it computed or carried: all but its idle time."""
    worked = float(account.compute_s + account.transfer_s)
    return worked / (worked + account.idle_s) if worked else 0.0


def _total(account: Any) -> float:
    return float(account.compute_s + account.transfer_s + account.idle_s)
