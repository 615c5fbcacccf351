"""The pictures of one run, from its records, and of the map of a workload."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import spans_of
from codesign.ground.errors import SpecError
from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.ground.records import MapRecord, Record, Subject
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_count, format_time
from codesign.inputs import Workload
from codesign.system import problem_of
from codesign.system.problem_map import Places, grid_faults
from codesign.views.report.canvas import MARKS, Format, Picture, canvas, drawn, legend, marker_size, style, with_palette
from codesign.views.report.timelines import bars_of, mission_timeline_picture, timeline_picture
from codesign.views.report.wording import labelled, prefix, quantity_text

colours = late("matplotlib.colors")

# Maps as pictures: a plan with its field and paths, a drive with all that happened, and a mission at one moment.

_LARGEST_SIDE = 1200
_MOST_LINES = 64

_CAME = "obstacle that came"

_WALL = "#4d4d4d"
_PATH = "#d1495b"
_GOAL = "#1a9850"

Points = NDArray[np.float64]


@dataclass
class _Layers:
    """The layers that are drawn over the map, bottom first."""

    free: NDArray[np.bool_]
    goals: NDArray[np.int32]
    came: NDArray[np.bool_]
    came_name: str = _CAME
    unknown: NDArray[np.bool_] | None = None
    lines: list[Points] = field(default_factory=list)
    way: Points | None = None
    marks: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    robots: Points | None = None
    corner: tuple[int, int] = (0, 0)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the cells, in rows and columns of the whole map."""
        return extent_of(self.free.shape, self.corner)


def extent_of(shape: tuple[int, ...], corner: tuple[int, int]) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of a map in rows and columns; ``corner``: its first row and column."""
    (row, column), (rows, columns) = corner, shape
    return column - 0.5, column + columns - 0.5, row + rows - 0.5, row - 0.5


def drive_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The true map with every obstacle that came, the paths of the robots, and the events at their places.

    None where no robot reports its place, or there is no map.
    """
    groups = map_reduce(records, lambda record: record.ROLE.about)

    def about(subject: Subject) -> list[Any]:
        return list(groups.get(subject, ()))

    places = [(pose.source, (pose.time, pose.row, pose.column)) for pose in about(Subject.POSE)]
    places += [
        (f"{update.source} {robot}", (update.time, *place))
        for update in about(Subject.FLEET)
        for robot, place in enumerate(update.positions[:_MOST_LINES].tolist())
    ]
    if not about(Subject.MAP) or not places:
        return None
    start: MapRecord = about(Subject.MAP)[-1]
    came = np.zeros(start.free.shape, bool)
    for change in about(Subject.CHANGE):
        if change.appeared:
            here = change.cells - np.array(start.corner)
            came[here[:, 0], here[:, 1]] = True
    tracks = map_reduce(places, itemgetter(0), itemgetter(1), lambda track: np.array(track, np.float64))
    layers = _Layers(start.free, start.goals, came, "obstacle at some time", corner=start.corner)
    layers.lines = [track[:, 1:] for track in tracks.values()]
    marked = (each for each in about(Subject.EVENT) if each.event in MARKS and each.source in tracks)
    layers.marks = map_reduce(marked, lambda each: each.event, lambda each: _place(tracks[each.source], each.time))
    length = sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in layers.lines)
    facts = [f"{counted(len(tracks), 'robot')}, {quantity_text(length, '')} cells driven"]
    facts += [f"{MARKS[event][0]}: {len(where)}" for event, where in layers.marks.items()]
    return _drawn(layers, "Where the robots drove" if len(tracks) > 1 else "Where the robot drove", facts, format)


def _place(track: Points, time: int) -> tuple[float, float]:
    """Row and column at a time, between the places of a track (time, row, column)."""
    return float(np.interp(time, track[:, 0], track[:, 1])), float(np.interp(time, track[:, 0], track[:, 2]))


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
    corner: tuple[int, int] = (0, 0),
    format: Format = "png",
) -> Picture:
    """A mission at one moment: the obstacles, the cells that the robot does not know, its path, and its place.

    Args:
        time: ps. start, free: bool, rows × columns: the cells that were free at the start, and that are now.
        goals: int32, n × 2. unknown: bool, rows × columns: the cells that the robot does not know.
        way, driven, robots: float64, n × 2 each, (row, column) in cells; the robot stands where ``driven`` ends.
        corner: the first row and column of the arrays of cells.
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
        corner=corner,
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
    return drawn(
        picture,
        format,
        title=title,
        alt=f"Map of {rows} by {columns} cells: {', '.join(facts)}",
        caption=f"{title}: {', '.join(facts)}",
    )


def _extent(layers: _Layers) -> tuple[float, float, float, float]:
    """Top, left, bottom and right of the map and of what was driven, which in a fleet may lead out of it."""
    first, shape = np.array(layers.corner, np.float64), np.array(layers.free.shape)
    corners = [np.array([first, first + shape - 1.0]), *(line for line in layers.lines if len(line))]
    points = np.concatenate(corners)
    (top, left), (bottom, right) = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    return float(top), float(left), float(bottom), float(right)


def _draw_cells(axes: Any, layers: _Layers) -> None:
    rows, columns = layers.free.shape
    step = max(1, max(rows, columns) // _LARGEST_SIDE)
    shades = np.ones((rows, columns, 3), np.float32)
    shown = [("wall", ~layers.free, "#3b3f45"), (layers.came_name, layers.came & layers.free, "#f4a259")]
    if layers.unknown is not None:
        shown.insert(0, ("not known", layers.unknown, "#d9dee4"))
        shown.insert(2, ("wall not known", layers.unknown & ~layers.free, "#8b929b"))
    for name, cells, colour in shown:
        if cells.any():
            shades[cells] = colours.to_rgb(colour)
            axes.plot([], [], "s", color=colour, label=name)
    axes.imshow(shades[::step, ::step], extent=layers.extent, interpolation="nearest")


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


def plan_picture(start: MapRecord, records: Sequence[Record], *, format: Format = "png") -> Picture:
    """The map of a plan, with the last field and the paths that the records hold."""
    groups = map_reduce(records, lambda record: record.ROLE.about)
    stages, paths, fields = (
        list[Any](groups.get(subject, ())) for subject in (Subject.STAGE, Subject.PATH, Subject.FIELD)
    )
    potential, shades, title = None, "", "Map"
    if stages:
        potential = stages[-1].potential
        title = f"Map, and the field after the stage of {stages[-1].precision} bits"
    elif fields and fields[-1].values.shape == start.free.shape:
        potential, shades = fields[-1].values, labelled(label(fields[-1].name), fields[-1].unit)
        title = f"Map, and the field of {label(fields[-1].name)}"
    if paths:
        arrived = sum(path.arrived for path in paths)
        title += f"; {counted(len(paths), 'path')} drawn, {arrived} of them to the goal"
    return map_picture(
        start.free,
        [(int(row), int(column)) for row, column in start.goals],
        potential=potential,
        shades=shades,
        trajectories=[path.points for path in paths if len(path.points)],
        title=title,
        corner=start.corner,
        format=format,
    )


def map_picture(
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    *,
    potential: NDArray[np.floating[Any]] | None = None,
    shades: str = "",
    trajectories: Sequence[NDArray[np.float64]] = (),
    starts: Sequence[tuple[int, int]] = (),
    title: str = "Map",
    corner: tuple[int, int] = (0, 0),
    format: Format = "png",
) -> Picture:
    """The map, with the potential (by its logarithm) or another field, the paths to the goal and the goals where given.

    Args:
        free: bool, rows × columns. goals, starts: (row, column) pairs.
        potential: rows × columns, values of 0 and above; cells at 0 stay white.
        shades: what the values are, where they are no potential: they are shown as they are, and finite ones only.
        corner: the first row and column of ``free``; goals and paths are counted in the whole map.
        trajectories: float64, n × 2 each, (row, column) in cells.
    """
    rows, columns = free.shape
    step = max(1, max(rows, columns) // _LARGEST_SIDE)
    extent = extent_of(free.shape, corner)
    width = 8.0
    with style():
        picture, axes = canvas((width, min(12.0, max(2.5, width * rows / columns + 1.1))))
        obstacles = np.ma.masked_where(free, np.ones(free.shape))[::step, ::step]
        if potential is not None:
            values = _logarithm(potential, free)
            if shades:
                values = np.ma.masked_where(~(free & np.isfinite(potential)), potential)
            coloured = axes.imshow(values[::step, ::step], extent=extent, cmap="viridis", interpolation="nearest")
            picture.colorbar(coloured, ax=axes, pad=0.02, shrink=0.8).set_label(shades or "potential, log₁₀")
        axes.imshow(obstacles, extent=extent, cmap="gray", vmin=-0.35, vmax=4, interpolation="nearest")
        if obstacles.count():
            axes.plot([], [], "s", color=_WALL, label="wall")
        _draw_paths(axes, trajectories, begins=not starts)
        _draw_points(axes, starts, "o", color=_PATH, markersize=3.5, label="start")
        _draw_points(axes, goals, "*", color=_GOAL, markersize=12, markeredgecolor="white", label="goal")
        axes.set(xlabel="column", ylabel="row", xlim=extent[:2], ylim=extent[2:])
        legend(picture)
    shown = [f"{rows} by {columns} cells", counted(len(goals), "goal")]
    shown += [counted(len(starts), "start")] if starts else []
    shown += [f"the {shades or 'potential'} as colour"] if potential is not None else []
    shown += [f"{counted(len(trajectories), 'path')} drawn"] if trajectories else []
    return drawn(picture, format, title=title, alt=f"Map of {', '.join(shown)}")


def _draw_paths(axes: Any, paths: Sequence[NDArray[np.float64]], *, begins: bool) -> None:
    """Each path, outlined so that it is seen on every colour; ``begins``: its start is marked, and in the legend."""
    for number, path in enumerate(paths):
        name = "path" if number == 0 else None
        axes.plot(path[:, 1], path[:, 0], color="white", linewidth=2.2, alpha=0.8)
        axes.plot(path[:, 1], path[:, 0], color=_PATH, linewidth=1.2, label=name)
        if begins:
            axes.plot(path[:1, 1], path[:1, 0], "o", color=_PATH, markersize=3.5, label=name and "start")


def _draw_points(axes: Any, points: Sequence[tuple[int, int]], marker: str, **shown: Any) -> None:
    if len(points):
        rows, columns = zip(*points, strict=True)
        axes.plot(columns, rows, marker, linestyle="none", **shown)


def _logarithm(potential: NDArray[np.floating[Any]], free: NDArray[np.bool_]) -> Any:
    values = np.asarray(potential, dtype=np.float64)
    shown = free & (values > 0)
    return np.ma.masked_where(~shown, np.log10(np.where(shown, values, 1.0)))


def run_pictures(records: Iterable[Record]) -> tuple[Picture, ...]:
    """The pictures of a page that these records allow, in reading order; none for a run that never began."""
    all_records = tuple(records)
    pictures = (run_map_picture(all_records), run_timeline_picture(all_records))
    return tuple(with_palette(picture) for picture in pictures if picture is not None)


def run_map_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The map of a run: of a mission what was driven, of a plan its field and paths; None without a map."""
    all_records = tuple(records)
    drive = drive_picture(all_records, format=format)
    if drive is not None:
        return drive
    maps: list[Any] = [record for record in all_records if record.ROLE.about is Subject.MAP]
    return plan_picture(maps[-1], all_records, format=format) if maps else None


def run_timeline_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The busy times of components and links: of a mission as shares, of a plan each span; None without work."""
    all_records = tuple(records)
    busy = mission_timeline_picture(all_records, format=format)
    if busy is not None:
        return busy
    bars = bars_of(all_records)
    return timeline_picture(bars, format=format) if bars else None


def workload_map_picture(workload: Workload, *, format: Format = "png") -> Picture:
    """The map of a workload with its goals and starts, cropped and prepared as it is planned on.

    Raises:
        SpecError: the map cannot be read, or a place on it is wrong. InputError: the workload has no map.
    """
    problem_of(workload)
    grid, faults = grid_faults(workload, None)
    if grid is None:
        raise SpecError(faults)
    places = Places(workload, grid)
    if places.faults:
        raise SpecError(places.faults)
    problem = places.problem()
    (row, column), shape = problem.corner, problem.free.shape
    goals, starts = ([(each[0] + row, each[1] + column) for each in cells] for cells in (problem.goals, problem.starts))
    counts = f"{counted(len(goals), 'goal')}, {counted(len(starts), 'start')}"
    title = f"The map of {workload.name}: {shape[0]} by {shape[1]} cells, {counts}"
    return map_picture(problem.free, goals, starts=starts, title=title, corner=problem.corner, format=format)


_MOST_STAGES = 2000


def schedule_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """A bar for each stage, as wide as its time and as high as its precision; None without a stage.

    A line joins the local maxima that the stages left. Of a long mission the first 2,000 stages are drawn.
    """
    every = [span for span in spans_of(records) if span.kind == "stage"]
    stages = every[:_MOST_STAGES]
    if not stages:
        return None
    size, unit = prefix([stages[-1].end / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    begins = np.array([stage.begin for stage in stages]) / scale
    ends = np.array([stage.end for stage in stages]) / scale
    with style():
        figure, axes = canvas((8.0, 3.4))
        axes.bar(
            begins, [stage.details["precision"] for stage in stages], ends - begins, align="edge", color="#a6c8e4",
            edgecolor="#2166ac", linewidth=0.6, label="stage",
        )  # fmt: skip
        axes.set(xlabel=f"time ({unit})", ylabel="precision (bits)", xlim=(0, ends[-1]))
        beside = axes.twinx()
        beside.spines["right"].set_visible(True)
        beside.plot(
            ends, [stage.details["local_maxima"] for stage in stages], "o-", color="#d1495b", markersize=3.5,
            linewidth=1.0, clip_on=False, label="local maxima left",
        )  # fmt: skip
        beside.set_yscale("symlog", linthresh=1)
        beside.yaxis.set_major_formatter(_whole)
        beside.set(ylabel="local maxima", ylim=(0, None))
        legend(figure)
    last = stages[-1]
    facts = f"{counted(len(stages), 'stage')} of at most {max(stage.details['precision'] for stage in stages)} bits"
    left = f"{format_count(int(last.details['local_maxima']))} local maxima after the last"
    more = f"; {format_count(len(every) - len(stages))} later stages are not drawn" * (len(every) > len(stages))
    title = "The stages of the relaxation"
    alt = f"{facts} over {format_time(last.end)}, {left}"
    return drawn(figure, format, title, alt, f"{title}: {alt}{more}")


def _whole(value: float, _place: int | None = None) -> str:
    return f"{value:,.0f}"
