"""The files that are made of a bag: a workload, the map of map_server, and a table of the goals."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, printable
from codesign.maps.reach import nearest_free
from codesign.views.bags.obstacles import Drawn, Rule, draw_obstacles
from codesign.views.bags.reading import Topics
from codesign.views.bags.recording import (
    Edge,
    Floats,
    Poses,
    RecordedGoal,
    RecordedMap,
    Recording,
    chain,
    known_times,
    poses,
    root_of,
)

# What a workload needs to know of a recorded run: start, goals, obstacles, sensor, period and speeds.

Cell = tuple[int, int]

FREE_TO, OCCUPIED_FROM = 25, 65
"""Per cent of an OccupancyGrid: the most of a free cell, the least of an occupied one, as in Nav2's map_saver."""

_BASES = ("base_link", "base_footprint")
_NEAREST_FREE_M = 0.4
"""A start or goal on no free cell is moved to the nearest free one, at most so far."""

_FAST = 99.0
"""Percentile of the recorded speeds that counts as the limit: single values are noise."""


@dataclass(frozen=True)
class Given:
    """A goal of the run. Times in s since the begin of the mission; None: it never happened, or was not recorded.

    ``cell``: on the map. ``answered``: when the first plan after it was published; ``plans``: how many were, before
    the next goal. ``reached``: when the robot was near it. ``toured``: whether the workload has it. A goal from before
    the begin has a negative time.
    """

    time: float
    place: tuple[float, float]
    cell: Cell
    answered: float | None = None
    plans: int = 0
    reached: float | None = None
    toured: bool = True


@dataclass(frozen=True)
class Measured:
    """A figure with where it comes from; ``value`` None: the bag does not show it."""

    value: float | None
    source: str


@dataclass(frozen=True, eq=False)
class BagFacts:
    """The facts that a workload is written of. ``begin``: of the mission, s since the begin of the bag."""

    recording: Recording
    map: RecordedMap
    begin: float
    start: Cell
    start_source: str
    goals: tuple[Given, ...]
    goal_source: str
    obstacles: Drawn
    reach: Measured
    rays: Measured
    view: Measured
    period: Measured
    speed: Measured
    turn_rate: Measured
    remarks: tuple[str, ...] = field(default=())

    @property
    def toured(self) -> tuple[Cell, ...]:
        """The goals of the workload in order. Neighbours that are one cell are one goal."""
        cells = [each.cell for each in self.goals if each.toured]
        return tuple(cell for index, cell in enumerate(cells) if not index or cell != cells[index - 1])


@dataclass(frozen=True)
class Choices:
    """``rule`` of obstacles; ``near``: m from a goal at which it counts as reached."""

    topics: Topics = field(default_factory=Topics)
    rule: Rule = field(default_factory=Rule)
    near: float = 0.3


def trinary(cells: NDArray[np.int8]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(free, occupied) of the values of an OccupancyGrid, by the rule of Nav2's map_saver; the others are unknown."""
    free = (cells >= 0) & (cells <= FREE_TO)
    return free, (cells >= OCCUPIED_FROM) & (cells <= 100)


def facts_of(recording: Recording, choices: Choices) -> BagFacts:
    """The facts of a recording.

    Raises:
        InputError: no goal, or no place of the robot can be found, or one lies outside of the map.
    """
    return _Drawer(recording, choices).facts()


class _Drawer:
    def __init__(self, recording: Recording, choices: Choices) -> None:
        assert recording.map is not None, "reading refuses a bag without a map"
        self._bag, self._choices, self._map = recording, choices, recording.map
        self._topics = recording.topics
        self._where = printable(str(recording.path), None)
        self._free, occupied = trinary(self._map.cells)
        self._trinary = replace(self._map, cells=np.where(self._free, 0, np.where(occupied, 100, -1)).astype(np.int8))
        self._remarks = list(recording.remarks)
        self._base = self._base_frame()

    def facts(self) -> BagFacts:
        goals, goal_source = self._goals()
        given, begin, start = self._mission(goals)
        start_source = self._start_source()
        scans = self._bag.scans
        nothing = Measured(None, f"the bag has no {self._topics['scan']}")
        reach = rays = view = nothing
        if scans is not None:
            source = f"{len(scans.times):,} messages of {self._topics['scan']}"
            step = abs(scans.step)
            reach = Measured(scans.span[1], f"range_max of {source}")
            rays = Measured(float(max(1, round(2 * math.pi / step))), f"angle_increment of {source}")
            view = Measured(min(2 * math.pi, step * scans.ranges.shape[1]), f"rays times angle_increment of {source}")
        speed, turn_rate = self._speeds()
        return BagFacts(
            self._bag, self._trinary, begin, start, start_source, given, goal_source, self._obstacles(begin),
            reach, rays, view, self._period(), speed, turn_rate, tuple(self._remarks),
        )  # fmt: skip

    def _base_frame(self) -> str | None:
        named = self._choices.topics.base
        frames = {frame for edge in self._bag.edges for frame in edge}
        if named is not None:
            if named not in frames:
                listed = ", ".join(sorted(frames)[:20]) or "none"
                raise InputError(f"no transform leads to frame {named!r}", self._where, f"frames of the bag: {listed}")
            if not self._placed(named):
                hint = f"record {self._topics['tf']} or {self._topics['odom']}, or name a frame that moves"
                raise InputError(f"no transform of the bag moves frame {named!r}", self._where, hint)
            return named
        own = () if self._bag.odometry is None else (self._bag.odometry[1],)
        inside = tuple(f"{self._bag.namespace}/{frame}".lstrip("/") for frame in _BASES)
        placed = (frame for frame in (*own, *inside, *_BASES) if frame in frames and self._placed(frame))
        return next(placed, None)

    def _placed(self, frame: str) -> bool:
        """True if transforms say where a frame is on the map, or move it in the frame that counts as the map."""
        path, whole = self._path(frame)
        return whole or bool(path and len(known_times(self._bag.edges, path)))

    def _path(self, inner: str) -> tuple[list[Edge] | None, bool]:
        """The steps to a frame from the map's, and True; without any, from the outermost frame, and False."""
        edges = self._bag.edges
        path = chain(edges, self._map.frame_id, inner)
        return (path, True) if path is not None else (chain(edges, root_of(edges, inner), inner), False)

    def _to_map(self, inner: str, times: Floats) -> Poses | None:
        """The poses of a frame on the map. Without a transform to the map, the outermost frame counts as it."""
        edges, outer = self._bag.edges, self._map.frame_id
        inner = inner or outer
        path, whole = self._path(inner)
        if path is None:
            return None
        if not whole:
            root = root_of(edges, inner)
            self._remark(f"no transform leads from {outer} to {inner}: frame {root} is taken as {outer}")
        return poses(edges, path, times)

    def _goals(self) -> tuple[list[RecordedGoal], str]:
        """The goals; without any, the last points of the plans, or the last place of the robot."""
        topics, bag = self._topics, self._bag
        if bag.goals:
            return bag.goals, f"{len(bag.goals)} messages of {topics['goal']}"
        goals: list[RecordedGoal] = []
        for each in bag.plans:
            if not goals or math.dist(goals[-1].place, each.last) > self._choices.near:
                goals.append(RecordedGoal(each.time, each.frame_id, each.last))
        if goals:
            self._remark(f"the bag has no {topics['goal']}: the last points of {topics['plan']} are the goals")
            return goals, f"last points of {topics['plan']}"
        times = self._times()
        if self._base is None or not len(times):
            hint = f"record {topics['goal']}, {topics['plan']}, or {topics['tf']} with the frame of the robot"
            raise InputError(
                "shows no goal, no plan and no robot, so a mission cannot be made of it", self._where, hint
            )
        self._remark(
            f"the bag has neither {topics['goal']} nor {topics['plan']}: the last place of the robot is the goal"
        )
        place = self._robot(times[-1:]).places[0]
        goal = RecordedGoal(float(times[0]), self._map.frame_id, (float(place[0]), float(place[1]), 0.0))
        return [goal], f"last place of the robot by {topics['tf']}"

    def _times(self) -> Floats:
        """The times at which the place of the robot is known: of all moving transforms between it and the map."""
        path = None if self._base is None else self._path(self._base)[0]
        return np.zeros(0) if path is None else known_times(self._bag.edges, path)

    def _robot(self, times: Floats) -> Poses:
        assert self._base is not None
        found = self._to_map(self._base, times)
        assert found is not None, "the frame of the robot is one of the edges"
        return found

    def _start_source(self) -> str:
        topics = self._topics
        if self._base is not None:
            return f"the place of {self._base} by {topics['tf']} and {topics['odom']} at the first goal"
        return f"the first point of {topics['plan']}"

    def _start(self, time: float) -> Cell:
        """The cell of the robot at a time; without its frame, the first point of the next plan."""
        topics, plans = self._topics, self._bag.plans
        if self._base is not None:
            x, y, _ = self._robot(np.array([time])).places[0].tolist()
        elif plans:
            x, y, _ = next((each for each in plans if each.time >= time), plans[-1]).first
            self._remark(f"the bag has no transform to a robot: it starts at {self._start_source()}")
        else:
            hint = f"record {topics['tf']} or {topics['odom']}; --base-frame names the frame of the robot"
            raise InputError("does not show where the robot is", self._where, hint)
        return self._cell(x, y, "the start")

    def _mission(self, goals: list[RecordedGoal]) -> tuple[tuple[Given, ...], float, Cell]:
        """The goals, the begin of the mission and the start. It begins with the first goal that is not its start.

        Raises:
            InputError: each goal is where the robot stands.
        """
        given = list(self._given(goals))
        for index, each in enumerate(given):
            if not each.toured:
                continue
            start = self._start(each.time)
            if start != each.cell:
                moved = (
                    replace(
                        goal, time=goal.time - each.time,
                        answered=None if goal.answered is None else goal.answered - each.time,
                        reached=None if goal.reached is None else goal.reached - each.time,
                    )
                    for goal in given
                )  # fmt: skip
                return tuple(moved), each.time, start
            self._remark(f"goal {index + 1} is where the robot stands: the tour leaves it out")
            given[index] = replace(each, toured=False)
        x, y = given[-1].place
        hint = f"record {self._topics['goal']}; --goal-topic names another topic, --namespace another robot"
        what = f"has no goal but ({x:.3f}, {y:.3f}) m, where the robot stands, so there is no mission"
        raise InputError(what, self._where, hint)

    def _cell(self, x: float, y: float, what: str) -> Cell:
        """The free cell of a place, or the nearest to it."""
        row, column = self._map.frame.cell(x, y)
        rows, columns = self._free.shape
        if not (0 <= row < rows and 0 <= column < columns):
            side = self._map.frame.resolution
            size = f"{columns * side:g} × {rows * side:g} m"
            hint = "record the map that the robot drove on; --map-topic names another"
            raise InputError(f"{what} at ({x:.3f}, {y:.3f}) m lies outside of the map of {size}", self._where, hint)
        if self._free[row, column]:
            return row, column
        near = nearest_free(self._free, (row, column))
        away = math.inf if near is None else math.hypot(near[0] - row, near[1] - column) * self._map.frame.resolution
        if near is None or away > max(_NEAREST_FREE_M, 1.5 * self._map.frame.resolution):
            hint = "its map shows no free cell near: check that map and transforms belong together"
            raise InputError(f"{what} at ({x:.3f}, {y:.3f}) m lies on no free cell", self._where, hint)
        self._remark(f"{what} at ({x:.3f}, {y:.3f}) m lies on no free cell: cell {near}, {away:.2f} m away, is taken")
        return int(near[0]), int(near[1])

    def _given(self, goals: list[RecordedGoal]) -> Iterator[Given]:
        """Each goal with what followed it. Times are the bag's."""
        times = self._times()
        track = self._robot(times).places[:, :2] if len(times) else np.zeros((0, 2))
        for index, goal in enumerate(goals):
            moved = self._to_map(goal.frame_id, np.array([goal.time]))
            place = np.array(goal.place) if moved is None else moved.points(np.array([[goal.place]]))[0, 0]
            x, y = float(place[0]), float(place[1])
            end = goals[index + 1].time if index + 1 < len(goals) else math.inf
            plans = [each.time for each in self._bag.plans if goal.time <= each.time < end]
            # A goal that is read off a plan was given at an unknown time before it.
            answers = [time for time in plans if time > goal.time and self._bag.goals]
            near = np.hypot(track[:, 0] - x, track[:, 1] - y) <= self._choices.near
            at = times[near & (times >= goal.time) & (times < end)]
            replaced = not len(at) and index + 1 < len(goals) and len(track) > 0
            if replaced:
                self._remark(f"goal {index + 1} was replaced before the robot came near it: the tour leaves it out")
            yield Given(
                goal.time, (x, y), self._cell(x, y, f"goal {index + 1}"), answers[0] if answers else None,
                len(plans), float(at[0]) if len(at) else None, not replaced,
            )  # fmt: skip

    def _obstacles(self, begin: float) -> Drawn:
        scans, rule = self._bag.scans, self._choices.rule
        if scans is None or not len(scans.times) or scans.times[-1] <= begin:
            return Drawn((), rule)
        sensor = self._to_map(scans.frame_id, scans.times)
        if sensor is None or self._base is None:
            self._remark(f"no transform leads to frame {scans.frame_id} of the scans: no obstacles are drawn")
            return Drawn((), rule)
        return draw_obstacles(self._trinary, scans, sensor, self._robot(scans.times), begin, rule)

    def _period(self) -> Measured:
        """The period of the control loop: of the commands, else of the scans, else of the odometry."""
        topics, scans = self._topics, self._bag.scans
        if len(self._bag.commands) > 2:
            value = float(np.median(np.diff(self._bag.commands)))
            return Measured(value, f"median step of {len(self._bag.commands):,} messages of {topics['command']}")
        if scans is not None and scans.period > 0:
            return Measured(
                scans.period, f"median step of {topics['scan']}: a turn of the control loop begins with a scan"
            )
        if len(self._bag.speeds) > 2:
            value = float(np.median(np.diff(self._bag.speeds[:, 0])))
            return Measured(value, f"median step of {len(self._bag.speeds):,} messages of {topics['odom']}")
        return Measured(None, "the bag has no commands, scans or odometry")

    def _speeds(self) -> tuple[Measured, Measured]:
        """The greatest speed and turn rate: the 99th percentile of what was measured while it moved."""
        topics, speeds = self._topics, self._bag.speeds
        if len(speeds):
            source = f"{_FAST:g}th percentile of {len(speeds):,} messages of {topics['odom']}"
            rows = speeds[:, 1:]
        else:
            times = self._times()
            track = self._robot(times) if len(times) > 1 else None
            if track is None:
                nothing = Measured(None, f"the bag has neither {topics['odom']} nor {topics['tf']}")
                return nothing, nothing
            steps = np.maximum(np.diff(times), 1e-6)
            turns = (np.diff(track.yaws) + math.pi) % (2 * math.pi) - math.pi
            rows = np.column_stack([np.hypot(*np.diff(track.places[:, :2], axis=0).T) / steps, turns / steps])
            source = f"{_FAST:g}th percentile of the steps of {topics['tf']}"
        rows = np.abs(np.nan_to_num(rows, posinf=0.0, neginf=0.0))
        limits = []
        for column in (0, 1):
            moving = rows[rows[:, column] > 1e-3, column]
            limits.append(Measured(float(np.percentile(moving, _FAST)) if len(moving) else None, source))
        return limits[0], limits[1]

    def _remark(self, text: str) -> None:
        if text not in self._remarks:
            self._remarks.append(text)


_GREY = {0: 254, 100: 0, -1: 205}
"""Pixels of map_saver."""

LONGEST_MISSION_S = 600.0


def file_name(stem: str) -> str:
    """A name for files and the workload, of the name of a bag.

    >>> file_name("2026-11-22 run"), file_name("é")
    ('bag-2026-11-22-run', 'bag')
    """
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", stem).strip("-")[:48]
    return name if name[:1].isalpha() else f"bag-{name}".rstrip("-")


def map_files(facts: BagFacts, name: str) -> dict[str, bytes]:
    """The map as map_saver of Nav2 writes it, but with a ``free_thresh`` that leaves unknown cells unknown."""
    cells = facts.map.cells
    pixels = np.full(cells.shape, _GREY[-1], np.uint8)
    for value, grey in _GREY.items():
        pixels[cells == value] = grey
    rows, columns = cells.shape
    x, y, yaw = facts.map.frame.origin
    text = (
        f"image: {name}-map.pgm\nmode: trinary\nresolution: {facts.map.frame.resolution!r}\n"
        f"origin: [{x!r}, {y!r}, {yaw!r}]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    head = f"P5\n{columns} {rows}\n255\n".encode()
    return {f"{name}-map.pgm": head + pixels.tobytes(), f"{name}-map.yaml": text.encode()}


COLUMNS = ("goal", "given_s", "x_m", "y_m", "row", "column", "answered_after_s", "plans", "reached_s", "in_tour")


def goals_csv(facts: BagFacts) -> bytes:
    """The goals and what the recorded planner made of them, a line each."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for number, each in enumerate(facts.goals, 1):
        places = (f"{each.place[0]:.3f}", f"{each.place[1]:.3f}", *each.cell)
        answered, reached = latency(each), each.reached
        writer.writerow(
            (
                number, f"{each.time:.3f}", *places, "" if answered is None else f"{answered:.6f}", each.plans,
                "" if reached is None else f"{reached:.3f}", "yes" if each.toured else "no",
            )
        )  # fmt: skip
    return out.getvalue().encode()


def latency(goal: Given) -> float | None:
    """Seconds from a goal to the first plan after it."""
    return None if goal.answered is None else goal.answered - goal.time


def settings_of(facts: BagFacts, robot: str = "robot") -> dict[str, str]:
    """The measured figures of the robot as settings of ``hwsw run --set``, for a platform that calls it ``robot``."""
    settings = {}
    if facts.reach.value is not None:
        settings[f"{robot}.sensor.range"] = f"{_number(facts.reach.value)} m"
    if facts.rays.value is not None and facts.rays.value <= 4096:
        settings[f"{robot}.sensor.rays"] = f"{facts.rays.value:.0f}"
    if facts.speed.value is not None:
        settings[f"{robot}.kinematics.speed"] = f"{_number(facts.speed.value)} m/s"
    return settings


def workload_text(facts: BagFacts, name: str, planner: str, mapping: Mapping[str, Any], like: str) -> str:
    """The workload, each figure with its source as a comment."""
    bag, cells = facts.recording, facts.toured
    title = f"The run of the bag {_comment(bag.path.name)}"
    lines = [*_head_lines(facts, name), "kind: workload", f"name: {name}", f"description: {json.dumps(title)}", ""]
    lines += [f"planner: {_word(planner)} # with its mapping as in workload {_comment(like)}", "", "problem:"]
    rule = f"values to {FREE_TO} are free, those from {OCCUPIED_FROM} to 100 occupied"
    lines += [
        f"  # The map of {facts.map.time:.3f} s: {rule}.",
        f"  map: {{file: {name}-map.yaml}}",
        f"  goals: [{list(cells[0])}] # {_comment(facts.goal_source)}",
        f"  starts: [{list(facts.start)}] # {_comment(facts.start_source)}",
        "",
        "scenario:",
        "  type: drive",
        "  known: all",
    ]
    if facts.period.value is not None:
        lines.append(f"  control_period: {_time(facts.period.value)} # {_comment(facts.period.source)}")
    if len(cells) > 1:
        lines += ["  tour:", *(f"    - {list(cell)}" for cell in cells[1:])]
        lines.append("  tour_times: # when each was given, counted from the first goal")
        lines += [f"    - {_time(time)}" for time in _times(facts)[1:]]
    lines += _obstacle_lines(facts)
    limit = math.ceil(max(LONGEST_MISSION_S, 2 * bag.length))
    lines += [f"  limit: {limit} s # twice the bag, at least {LONGEST_MISSION_S:g} s", "", "mapping:"]
    lines += [f"  {_word(task)}: {json.dumps(place)}" for task, place in mapping.items()]
    return "\n".join(lines) + "\n"


def _word(text: str) -> str:
    return text if text.isidentifier() and text.isascii() else json.dumps(text)


def _head_lines(facts: BagFacts, name: str) -> list[str]:
    bag = facts.recording
    lines = [
        f"# Made of the bag {_comment(bag.path.name)}, {bag.length:.1f} s long. The mission begins at"
        f" {facts.begin:.3f} s, with the first goal.",
        *(f"# - {_comment(remark)}." for remark in facts.remarks),
        "#",
        "# The robot is that of the platform. The robot of the bag:",
        f"#   greatest speed: {_source(facts.speed, 'm/s')}",
        f"#   turn rate: {_source(facts.turn_rate, 'rad/s')}",
        f"#   range of the sensor: {_source(facts.reach, 'm')}",
        f"#   rays of a full turn: {_source(facts.rays, '')}",
        f"#   field of view: {_source(facts.view, 'rad')}; sensors of models see the full circle",
    ]
    settings = " ".join(f"--set {key}={value.replace(' ', '')}" for key, value in settings_of(facts).items())
    if settings:
        lines += [
            "# With it, on a platform that calls its robot robot:",
            f"#   hwsw run PLATFORM {name}.yaml {settings}",
        ]
    return lines


def _times(facts: BagFacts) -> list[float]:
    """The times at which the goals of the workload were given, s. Of neighbours that are one cell, the first counts."""
    toured = [each for each in facts.goals if each.toured]
    return [each.time for at, each in enumerate(toured) if not at or each.cell != toured[at - 1].cell]


def _obstacle_lines(facts: BagFacts) -> list[str]:
    drawn, rule = facts.obstacles, facts.obstacles.rule
    if not drawn.obstacles:
        return ["  # The scans show no obstacle that the map does not have."]
    stay = "to the end" if rule.stay is None else f"{rule.stay:g} s after the last hit"
    lines = [
        f"  # {drawn.hits:,} rays met cells that the map has free, more than {rule.margin:g} m from its obstacles.",
        f"  # Slots of {rule.slot:g} s; {rule.least} hits or more; cells within {rule.radius:g} m of the robot are"
        f" open; what is not seen again stays {stay}.",
    ]
    if drawn.left_out:
        lines.append(f"  # {drawn.left_out:,} smaller obstacles are left out.")
    always = [each for each in drawn.obstacles if each.at == 0.0 and each.until is None]
    start = facts.start
    hidden = [each for each in always if not _covers(each, start)]
    others = [each for each in drawn.obstacles if each not in hidden]
    if hidden:
        lines.append("  hidden: # there all the time")
        lines += [f"    - {{{_box(each)}}}" for each in hidden]
    if others:
        lines += ["  obstacles:", "    appearing:"]
        for each in others:
            until = "" if each.until is None else f", until: {_time(each.until)}"
            lines.append(f"      - {{at: {_time(each.at)}, {_box(each)}{until}}}")
    return lines


def _covers(each: Any, cell: tuple[int, int]) -> bool:
    rows, columns = cell[0] - each.row, cell[1] - each.column
    return bool(0 <= rows < each.rows and 0 <= columns < each.columns)


def _box(each: Any) -> str:
    size = "".join(f", {key}: {value}" for key, value in (("rows", each.rows), ("columns", each.columns)) if value > 1)
    return f"row: {each.row}, column: {each.column}{size}"


def _source(figure: Measured, unit: str) -> str:
    if figure.value is None:
        return _comment(f"not known: {figure.source}")
    return _comment(f"{_number(figure.value)} {unit}".rstrip() + f", {figure.source}")


def _comment(text: str) -> str:
    """A text of any origin as a comment or a quoted text: printable, in one line, without ``#`` and quotes."""
    return re.sub(r"[\"'\\#]", "_", printable(text, 300))


def _time(seconds: float) -> str:
    """A time to the microsecond.

    >>> _time(54.49902), _time(0.05), _time(0.0004)
    ('54.49902 s', '50 ms', '400 us')
    """
    whole = max(0, round(seconds * 1e6))
    if whole >= 10**6 or not whole:
        return f"{whole / 1e6:.6f}".rstrip("0").rstrip(".") + " s"
    return f"{whole} us" if whole % 1000 else f"{whole // 1000} ms"


def _number(value: float) -> str:
    return f"{value:.6g}"
