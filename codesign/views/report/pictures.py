"""The pictures of one run, from its records, and of the map of a workload."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.activity import Span, share_over_time, spans_of, union
from codesign.ground.errors import SpecError
from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.ground.records import MapRecord, Record, Subject
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_count, format_time
from codesign.inputs import Workload
from codesign.system import problem_of
from codesign.system.problem_map import Places, grid_faults
from codesign.system.results.mission import Account
from codesign.views.report.canvas import MARKS, Format, Picture, canvas, drawn, legend, marker_size, style, with_palette
from codesign.views.report.scenario_tables import busy_share
from codesign.views.report.wording import labelled, prefix, quantity_text, share_text

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
    seen = ", ".join(facts)
    return drawn(picture, format, title, f"Map of {rows} by {columns} cells: {seen}", f"{title}: {seen}")


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


# The time lines of components and links: each span of a plan, the busy shares of a mission, the sums.

_MOST_BARS = 400
_BINS = 240

_NUMBER = re.compile(r"_\d+$")
_MOST_ALIKE = 8
_ANY = "any of"
_SPREAD_ROW = "; many components of a kind, such as the FPGAs of a fleet, share a row: it is busy where any of them is"

Bar = tuple[str, str, int, int]
"""The component or link, what it did, from, to (ps)."""


def bars_of(records: Iterable[Record]) -> list[Bar]:
    """The spans of work that a picture shows, longest first: a thousand slivers would make it heavy."""
    bars = [
        (span.where, _BARS[span.kind].format(span.what, label(span.what) + span.tail), *span.times)
        for span in spans_of(records)
        if span.kind in _BARS
    ]
    return sorted(bars, key=lambda bar: (bar[2] - bar[3], bar))[:_MOST_BARS]


_BARS = {"message": "message: {0}", "task": "{1}", "stage": "stages"}
"""The words of a bar, by the kind of its span: with the name, and with its words and its outcome."""


def timeline_picture(bars: Iterable[Bar], *, format: Format = "png") -> Picture:
    """The busy times of each component and link, and the work: a row for each, and a bar for each span of work."""
    shown = list(bars)
    sources = list(dict.fromkeys(bar[0] for bar in sorted(shown, key=lambda bar: (bar[2], bar[0]))))
    kinds = list(dict.fromkeys(bar[1] for bar in sorted(shown, key=lambda bar: (bar[2], bar[1]))))
    last = max(bar[3] for bar in shown)
    size, unit = prefix([last / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    with style():
        picture, axes = canvas((8.0, 0.9 + 0.42 * len(sources)))
        for number, kind in enumerate(kinds):
            _row_bars(axes, [bar for bar in shown if bar[1] == kind], sources, scale, kind, f"C{number % 10}")
        axes.set_yticks(range(len(sources)), sources)
        axes.set(xlabel=f"time ({unit})", xlim=(0, last / scale), ylim=(len(sources) - 0.5, -0.5))
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, fontsize=8)
    return drawn(
        picture,
        format,
        title="When each component and link was busy",
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}; utilisation stands in its table",
    )


def _row_bars(axes: Any, bars: list[Bar], sources: list[str], scale: float, kind: str, colour: str) -> None:
    # Only the first of a kind stands in the legend; an underscore keeps the others out.
    labels = itertools.chain([kind], itertools.repeat("_"))
    for row, source in enumerate(sources):
        spans = sorted((begin / scale, (end - begin) / scale) for busy, _, begin, end in bars if busy == source)
        if spans:
            # Shades alternate, so that neighbours can be told apart; the edge keeps slivers in sight.
            shades = [colours.to_rgba(colour, 0.55 if number % 2 else 0.9) for number in range(len(spans))]
            axes.broken_barh(
                spans, (row - 0.34, 0.68), facecolors=shades, edgecolors=colour, linewidth=0.6, label=next(labels)
            )


def mission_timeline_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The busy shares of each component and link over the mission, with plans and events; None without a mission.

    The mission is divided into 240 spans. Each shows the share of it in which work was under way, or a robot moved.
    Small shares are drawn darker than in proportion, so that they can be seen.
    """
    all_records = list(records)
    spans = spans_of(all_records)
    works = [(span.where, span.times) for span in spans if span.kind not in ("wait", "plan")]
    works += [(name, times) for name, poses in _poses(all_records).items() for times in _moves(poses)]
    events = [record for record in all_records if record.ROLE.about is Subject.EVENT]
    if not events or not works:
        return None
    last = max(*(event.time for event in events), *(times[1] for _, times in works), 0)
    if not last:
        return None
    size, unit = prefix([last / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    rows = _busy_rows(map_reduce(works, itemgetter(0), itemgetter(1)), last)
    sources, shares = list(rows), np.array(list(rows.values()))
    with style():
        picture, axes = canvas((9.0, 1.9 + 0.36 * len(sources)))
        shades = axes.imshow(
            shares, cmap="Blues", norm=colours.PowerNorm(0.35, 0, 1), aspect="auto", interpolation="nearest",
            extent=(0, last / scale, len(sources) - 0.5, -0.5),
        )  # fmt: skip
        picture.colorbar(shades, ax=axes, pad=0.02, ticks=[0, 0.01, 0.1, 0.5, 1]).set_label("busy share")
        _draw_events(axes, events, [span for span in spans if span.kind == "plan"], scale)
        axes.set_yticks([-1.0, *range(len(sources))], ["plans, events", *sources])
        axes.set(xlabel=f"time ({unit})", xlim=(0, last / scale), ylim=(len(sources) - 0.5, -1.6))
        legend(picture)
    busiest = max(sources, key=lambda source: float(shares[sources.index(source)].mean()), default="nothing")
    title = "How busy each component and link was"
    return drawn(
        picture,
        format,
        title=title,
        alt=f"Time line of {', '.join(sources)} over {format_time(last)}, {counted(len(events), 'event')};"
        f" the busiest is {busiest}",
        caption=f"{title}{_SPREAD_ROW if any(_ANY in source for source in sources) else ''}",
    )


def _poses(records: Iterable[Record]) -> dict[str, list[Any]]:
    """The poses of each robot."""
    poses = (record for record in records if record.ROLE.about is Subject.POSE)
    return map_reduce(poses, lambda record: record.source)


def _moves(poses: Sequence[Any]) -> list[tuple[int, int]]:
    """Between two poses a robot moved, unless it stood at both."""
    pairs = pairwise([poses[0], *poses])
    return [(before.time, after.time) for before, after in pairs if before.speed or after.speed]


def _busy_rows(spans: Mapping[str, list[tuple[int, int]]], last: int) -> dict[str, NDArray[np.float64]]:
    """The busy shares of each source, by name; many that differ by a number only share a row."""
    alike = map_reduce(sorted(spans), lambda source: _NUMBER.sub("", source))
    rows: dict[str, NDArray[np.float64]] = {}
    for stem, sources in alike.items():
        if len(sources) <= _MOST_ALIKE:
            for source in sorted(sources, key=_numbered):
                rows[source] = busy_shares(spans[source], last, _BINS)
        else:
            together = [span for source in sources for span in spans[source]]
            rows[f"{stem}, {_ANY} {len(sources)}"] = busy_shares(together, last, _BINS)
    return rows


def _numbered(source: str) -> int:
    """The number at the end of a name."""
    ending = _NUMBER.search(source)
    return int(ending[0][1:]) if ending else 0


def busy_shares(spans: Iterable[tuple[int, int]], end: int, bins: int) -> NDArray[np.float64]:
    """The share of each of ``bins`` equal parts of the time from 0 to ``end`` that the spans (ps) cover.

    What overlaps counts once.
    """
    return np.clip(share_over_time(union(spans), 0, end, bins), 0.0, 1.0)


def _draw_events(axes: Any, events: Sequence[Any], plans: Sequence[Span], scale: float) -> None:
    """Each plan as a bar from when it was asked for to its answer, and each event as a mark, above all rows."""
    bars = [(plan.begin / scale, (plan.end - plan.begin) / scale) for plan in plans]
    marked = (each for each in events if each.event in MARKS and each.event != "plan_requested")
    marks = map_reduce(marked, lambda each: each.event, lambda each: each.time / scale)
    if bars:
        axes.broken_barh(
            bars, (-0.9, 0.35), facecolors="#7b3294", edgecolors="#7b3294", linewidth=0.6, label="plan under way"
        )
    for event_name, times in marks.items():
        words, marker, colour = MARKS[event_name]
        axes.plot(
            times, [-1.2] * len(times), marker, color=colour, markersize=marker_size(marker), linestyle="none",
            clip_on=False, label=f"{words} ({len(times)})",
        )  # fmt: skip


def account_picture(accounts: Mapping[str, Account], *, format: Format = "png") -> Picture | None:
    """The time of each component and link by what it was spent on, as stacked bars; None if there are none.

    ``accounts``: by name, with ``compute_s``, ``transfer_s`` and ``idle_s``, which make up the mission, and ``wait_s``,
    a bar of its own below.
    """
    if not accounts:
        return None
    names = list(accounts)
    size, unit = prefix(
        [max(account.compute_s + account.transfer_s + account.idle_s for account in accounts.values())], "s"
    )
    kinds = (("compute", "#2166ac"), ("transfer", "#4dac26"), ("idle", "#e6e9ed"))
    with style():
        picture, axes = canvas((8.0, 1.3 + 0.42 * len(names)))
        rows, left = np.arange(len(names)), np.zeros(len(names))
        for kind, colour in kinds:
            widths = np.array([vars(accounts[name])[f"{kind}_s"] for name in names]) / size
            axes.barh(rows, widths, left=left, color=colour, height=0.56, label=kind)
            left += widths
        # What waits does so side by side, and while others are served: it is no part of the bar.
        waits = np.array([accounts[name].wait_s for name in names]) / size
        axes.barh(rows + 0.38, waits, color="#f4a259", height=0.14, label="others wait for it")
        for row, name in enumerate(names):
            axes.text(left[row], row, f"  {share_text(busy_share(accounts[name]))} busy", va="center", fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.margins(x=0.14)
        axes.set_xlim(left=0.0)
        axes.set(xlabel=f"time ({unit})", ylim=(len(names) - 0.5, -0.5))
        legend(picture)
    return drawn(
        picture,
        format,
        title="Where the time of each component and link went",
        alt=f"Stacked bars of compute, transfer and idle of {', '.join(names)}, waits below; figures stand in a table",
    )
