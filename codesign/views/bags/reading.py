"""Read a recorded bag. No content of a file is trusted: sizes, numbers and clocks are checked."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError, InputError, nearest, printable
from codesign.ground.models import Frame
from codesign.ground.progress import Advance, Show, silent
from codesign.maps.grid import MAX_CELLS
from codesign.views.bags import library
from codesign.views.bags.recording import RecordedGoal, RecordedMap, RecordedPlan, Recording, Scans, Series, chain

# The topics of a bag that are read: named, or chosen by type and namespace.

NOTHING = "none"
"""The name that leaves a topic out."""


@dataclass(frozen=True)
class Role:
    """The role of a topic: its usual name, its types, words that its name needs, words that it must not have."""

    usual: str
    types: tuple[str, ...]
    needs: str = ""
    never: tuple[str, ...] = ()

    def fits(self, topic: str, kind: str) -> bool:
        """True if a topic may have the role."""
        last = topic.rsplit("/", 1)[-1]
        return kind in self.types and self.needs in last and not any(word in topic for word in self.never)


ROLES = {
    "map": Role("map", (library.OCCUPANCY_GRID,), "", ("costmap", "local_")),
    "tf": Role("tf", (library.TF_MESSAGE,)),
    "tf_static": Role("tf_static", (library.TF_MESSAGE,), "tf_static"),
    "scan": Role("scan", (library.LASER_SCAN,)),
    "odom": Role("odom", (library.ODOMETRY,)),
    "goal": Role("goal_pose", (library.POSE_STAMPED,), "goal"),
    "plan": Role("plan", (library.PATH,), "", ("local_",)),
    "command": Role("cmd_vel", (library.TWIST, library.TWIST_STAMPED)),
}
_SHARED = ("map", "tf", "tf_static")
_TELLING = ("odom", "command", "goal", "plan")


@dataclass(frozen=True)
class Topics:
    """The names of the topics that are read; None: chosen, ``none``: not read.

    ``base``: the frame of the robot; None: the one that the odometry names. ``namespace``: the robot's; None:
    found.
    """

    map: str | None = None
    tf: str | None = None
    tf_static: str | None = None
    scan: str | None = None
    odom: str | None = None
    goal: str | None = None
    plan: str | None = None
    command: str | None = None
    base: str | None = None
    namespace: str | None = None


@dataclass(frozen=True)
class Chosen:
    """The topics of a bag, by role: ``names`` of all that are read, the usual name of one that the bag has not.

    ``unread``: topics that fit a role and are not read.
    """

    names: Mapping[str, str]
    unread: tuple[str, ...]
    namespace: str

    def __getitem__(self, role: str) -> str:
        return self.names[role]


def choose_topics(wanted: Topics, present: Mapping[str, str], where: str) -> Chosen:
    """The topics that are read. ``present``: the type of each topic with a message.

    Raises:
        InputError: a named topic or namespace is not there, a type is wrong, or several topics fit alike.
    """
    wanted = replace(wanted, **{role: _named(wanted, role, present, where) for role in ROLES})
    space, others = _robot(wanted, present, where)
    names, unread = {}, []
    for role, rule in ROLES.items():
        named = getattr(wanted, role)
        fitting = [topic for topic, kind in present.items() if rule.fits(topic, kind)]
        if role == "tf":
            fitting = [topic for topic in fitting if not ROLES["tf_static"].fits(topic, present[topic])]
        around = role in _SHARED or wanted.namespace is None
        own = [topic for topic in fitting if _belongs(topic, space, others, around)]
        names[role] = named or _best(role, own, space, where) or f"{space}/{rule.usual}"
        if role not in (*_SHARED, "plan"):
            unread += [topic for topic in fitting if topic != names[role]]
        kind = present.get(names[role])
        if kind is not None and kind not in rule.types:
            what = f"topic {printable(names[role])} has messages of {printable(kind)}"
            raise InputError(what, where, f"accepted: {' or '.join(rule.types)}; name another topic")
    return Chosen(names, tuple(sorted(set(unread) - set(names.values()))), space)


def _named(wanted: Topics, role: str, present: Mapping[str, str], where: str) -> str | None:
    name: str | None = getattr(wanted, role)
    if name is None or name in present:
        return name
    if name == NOTHING:
        return f"/{ROLES[role].usual} (left out)"
    near = nearest(name, present)
    hint = f"did you mean {printable(near)}?" if near else f"topics: {_listed(present)}"
    if role != "map":
        hint += f"; {option_of(role)} {NOTHING} leaves it out"
    raise InputError(f"has no topic {printable(name)}", where, hint)


def _robot(wanted: Topics, present: Mapping[str, str], where: str) -> tuple[str, list[str]]:
    """The namespace of the robot, and the namespaces of other robots."""
    telling: list[tuple[str, str]] = []
    for role in _TELLING:
        for topic, kind in present.items():
            space, last = topic.rsplit("/", 1) if "/" in topic else ("", topic)
            if last == ROLES[role].usual and kind in ROLES[role].types:
                telling.append((space, role))
    spaces = map_reduce(telling, itemgetter(0), itemgetter(1), set)
    if wanted.namespace is not None:
        robot = "/" + wanted.namespace.strip("/")
        robot = "" if robot == "/" else robot
        if not any(topic.startswith(f"{robot}/") for topic in present):
            found = ", ".join(printable(space) or "/" for space in sorted(spaces)[:12]) or "none"
            what = f"has no topic in the namespace {printable(robot)}"
            raise InputError(what, where, f"namespaces of robots: {found}")
    else:
        open_roles = {role for role in _TELLING if getattr(wanted, role) is None}
        asked = [space for space, roles in spaces.items() if roles & open_roles]
        robot = min(asked, key=lambda space: space.count("/") if space else -1, default="")
        beside = [space for space in asked if not _inside(space, robot)]
        if beside:
            listed = ", ".join(printable(space) for space in sorted([robot, *beside])[:12])
            what = f"has topics of several robots: {listed}"
            raise InputError(what, where, f"name one: --namespace {printable(robot)}")
    own = spaces.get(robot, set())
    return robot, [
        space
        for space, roles in spaces.items()
        if space != robot and (roles & own or not _inside(space, robot)) and not _inside(robot, space)
    ]


def _inside(space: str, outer: str) -> bool:
    return f"{space}/".startswith(f"{outer}/")


def _belongs(topic: str, space: str, others: list[str], around: bool) -> bool:
    parent = topic.rsplit("/", 1)[0] if "/" in topic else ""
    if any(_inside(parent, other) for other in others):
        return False
    return _inside(parent, space) or (around and _inside(space, parent))


def _best(role: str, topics: list[str], space: str, where: str) -> str | None:
    """The topic that comes first, or None without any.

    Raises:
        InputError: several come first.
    """
    usual = ROLES[role].usual

    def rank(topic: str) -> tuple[int, int]:
        parent, last = topic.rsplit("/", 1) if "/" in topic else ("", topic)
        if last == usual and _inside(space, parent):
            return 0, len(space) - len(parent)
        return (1 if last == usual else 2), 0

    first = min(map(rank, topics), default=None)
    alike = sorted(topic for topic in topics if rank(topic) == first)
    if len(alike) > 1:
        what = f"has {len(alike)} topics that may be read as {usual}: {_listed(alike)}"
        raise InputError(what, where, f"name one: {option_of(role)} {printable(alike[0])}")
    return alike[0] if alike else None


def option_of(role: str) -> str:
    """The option that names the topic of a role.

    >>> option_of("tf_static")
    '--tf-static-topic'
    """
    return f"--{role.replace('_', '-')}-topic"


def _listed(topics: Mapping[str, str] | list[str]) -> str:
    return ", ".join(printable(topic) for topic in sorted(topics)[:12])


# The clocks of a bag: when a message was recorded, and the stamp in it.

SAME_CLOCK_S = 1.0
"""Stamps that are this near to the time of the bag, in the middle, are of the same clock."""

BACKWARDS_S = 0.1
"""Stamps of one topic that go back by less are put in order. More is a clock that was set."""

GAP_S, LONGEST_GAP_S = 5.0, 3600.0
"""A gap of the stamps that is remarked, and one that is a clock that was set."""


def common_clock(pairs: Sequence[tuple[float, float]], begin: int) -> float:
    """The delay of the stamps behind the times of the bag, s: their median, or 0 if both have one clock.

    ``pairs``: (time since ``begin``, stamp), s. Static transforms, and messages without a stamp, do not count.
    """
    late = [time + begin * 1e-9 - stamp for time, stamp in pairs if stamp > 0.0 and math.isfinite(stamp)]
    if not late:
        return 0.0
    middle = float(np.median(late))
    return middle if abs(middle) > SAME_CLOCK_S else 0.0


def checked_clock(
    rows: Sequence[tuple[float, ...]], begin: int, shift: float, where: str, name: str, remark: Callable[[str], None]
) -> NDArray[np.float64]:
    """The rows (time, stamp, ...) as (time by the clock of the bag since ``begin``, ...), in order of time.

    A row without a stamp has the time of its recording. A static transform has its own.

    Raises:
        InputError: the clock goes back, or ahead by more than ``LONGEST_GAP_S``.
    """
    if not rows:
        return np.zeros((0, 1))
    table = np.array(rows, np.float64)
    stamps = table[:, 1]
    stamped = np.isfinite(stamps) & (stamps > 0.0)
    times = np.where(stamped, stamps + (shift - begin * 1e-9), table[:, 0])
    if not np.isfinite(stamps).all():
        times = table[:, 0]
    steps = np.diff(times)
    if len(steps):
        back, ahead = int(steps.argmin()), int(steps.argmax())
        if steps[back] < -BACKWARDS_S:
            what = f"the clock of {name} goes back by {-steps[back]:,.3f} s after {times[back]:,.3f} s"
            hint = "cut the bag there, so that each part has one clock, and give one part"
            raise InputError(what, where, hint)
        if steps[ahead] > LONGEST_GAP_S:
            what = f"the clock of {name} jumps ahead by {steps[ahead]:,.0f} s after {times[ahead]:,.3f} s"
            hint = "cut the bag there, so that each part has one clock, and give one part"
            raise InputError(what, where, hint)
        if steps[ahead] > GAP_S and np.isfinite(stamps).all():
            remark(f"{name} has a gap of {steps[ahead]:.1f} s after {times[ahead]:.1f} s")
    order = np.argsort(times, kind="stable")
    return np.column_stack([times, table[:, 2:]])[order]


MAX_MESSAGES = 20_000_000
"""Most messages of the topics that are read."""

MAX_RANGES = 50_000_000
"""Most ranges that are kept: of more, one scan of every few."""

MAX_RAYS = 100_000
MAX_FRAMES = 1000
MAX_TEXT = 256
_SIDES = (1e-4, 1e3)
_FAR = 1e7
"""Metres: no robot is farther from the origin of its map."""

_MAGIC = b"\x89MCAP0\r\n"
_Row = tuple[float, ...]
_REINDEX = "a bag that was cut is repaired by: ros2 bag reindex DIR -s mcap"


def read_bag(path: Path, topics: Topics, last_map: bool = True, show: Show = silent) -> Recording:
    """Read the bag ``path``: a folder of rosbag2, or its file (.mcap, .db3).

    ``last_map``: of several maps, take the last one, else the first.

    Raises:
        InputError: it is no such bag, it is damaged, or it has no map. RunError: the library is missing.
    """
    ros = library.load("rosbag2")
    _check_kind(path)
    with _guarded(path, lambda: "cannot be read", _REINDEX):
        library.bound_decompression()
        reader: Any = ros.Reader(path)
        reader.open()
    try:
        return _Gatherer(path, topics, last_map, show).gather(reader)
    finally:
        with _guarded(path, lambda: "cannot be closed", None):
            reader.close()


def _check_kind(path: Path) -> None:
    where = printable(str(path), None)
    if not path.exists():
        raise InputError("does not exist", where, "name the folder of a ROS 2 bag, or its .mcap or .db3 file")
    if path.suffix == ".bag" and path.is_file():
        hint = f"convert it with a program of the package rosbags: rosbags-convert --src {where} --dst NEW_FOLDER"
        raise InputError("is a bag of ROS 1, and only those of ROS 2 are read", where, hint)
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        hint = "name the folder that ros2 bag record made, or run: ros2 bag reindex DIR -s mcap"
        raise InputError("has no metadata.yaml, so it is no folder of a ROS 2 bag", where, hint)
    if path.is_file() and path.suffix not in (".mcap", ".db3"):
        hint = "accepted: a folder with metadata.yaml, a .mcap or a .db3 file"
        raise InputError("is no ROS 2 bag", where, hint)
    if path.suffix == ".mcap" and path.is_file() and _is_other_mcap(path):
        hint = "a trace of hwsw becomes a bag by: hwsw trace export FILE --ros2 DIR"
        raise InputError("is an MCAP file, but its profile is not ros2", where, hint)


def _is_other_mcap(path: Path) -> bool:
    """True if an MCAP file has another profile: the first text of its header, which is its first record."""
    with _guarded(path, lambda: "cannot be read", None), path.open("rb") as file:
        head = file.read(32)
    profile = len(_MAGIC) + 9
    return head.startswith(_MAGIC) and head[profile : profile + 8] != b"\x04\0\0\0ros2"


@contextmanager
def _guarded(path: Path, what: Callable[[], str], hint: str | None) -> Iterator[None]:
    """Turn the errors of many kinds that the library raises at a damaged file into an error of ours."""
    try:
        yield
    except CodesignError:
        raise
    except Exception as fault:
        reason = " ".join(str(fault).split()) or type(fault).__name__
        raise InputError(f"{what()}: {printable(reason, 160)}", printable(str(path), None), hint) from fault


def _no_taker(_time: float, _message: Any) -> None:
    """Of commands the times alone are read."""


class _Gatherer:
    """Takes the messages of a bag one after another."""

    def __init__(self, path: Path, topics: Topics, last_map: bool, show: Show) -> None:
        self._where = printable(str(path), None)
        self._wanted, self._last_map, self._show = topics, last_map, show
        self._out = Recording(path)
        self._topics: Mapping[str, str] = {}
        self._maps = 0
        self._commands: list[float] = []
        self._odometry: list[_Row] = []
        self._scan_times: list[_Row] = []
        self._kept_times: list[_Row] = []
        self._edges: dict[tuple[str, str], list[_Row]] = defaultdict(list)
        self._scans: list[Any] = []
        self._seen_scans = 0
        self._every = 1
        self._done, self._under_way = 0, ""
        self._takers: dict[str, Callable[[float, Any], None]] = {}

    def gather(self, reader: Any) -> Recording:
        """All that the bag has of the topics."""
        chosen = self._connections(reader)
        count = sum(connection.msgcount for connection in chosen)
        if count > MAX_MESSAGES:
            hint = "cut the bag, or leave topics out: ros2 bag convert"
            raise InputError(f"has {count:,} messages, more than {MAX_MESSAGES:,}", self._where, hint)
        self._out.begin = int(reader.start_time)
        self._out.length = max(0.0, float(reader.duration) * 1e-9)
        scans = sum(each.msgcount for each in chosen if each.topic == self._topics["scan"])
        self._every = 0 if scans else 1
        with _guarded(self._out.path, lambda: f"is damaged at message {self._done + 1:,}{self._under_way}", _REINDEX):
            self._take_all(reader.messages(connections=chosen), count, scans)
        return self._finished()

    def _take_all(self, messages: Iterator[tuple[Any, int, bytes]], count: int, scans: int) -> None:
        read, begin = library.typestore().deserialize_cdr, self._out.begin
        for connection, time, data in messages:
            self._under_way = f", of {connection.topic}"
            seconds = (time - begin) * 1e-9
            if connection.topic == self._topics["command"]:
                self._commands.append(seconds)
            else:
                message: Any = read(data, connection.msgtype)
                if not self._every and connection.topic == self._topics["scan"]:
                    self._every = max(1, math.ceil(scans * len(message.ranges) / MAX_RANGES))
                self._takers[connection.topic](seconds, message)
            self._done += 1
            self._under_way = ""
            if self._done % 4096 == 0:
                self._show(Advance(self._done, max(self._done, count), "messages read"))

    def _connections(self, reader: Any) -> list[Any]:
        """The connections of the topics that are read, which are chosen here."""
        present = {each.topic: each.msgtype for each in reader.connections if each.msgcount}
        if not present:
            raise InputError("holds no message", self._where, "record the bag again")
        chosen = choose_topics(self._wanted, present, self._where)
        self._topics = self._out.topics = chosen.names
        self._out.namespace = chosen.namespace
        if chosen.names["map"] not in present:
            listed = ", ".join(printable(topic) for topic in sorted(present)[:12])
            what = f"has no topic {chosen.names['map']} of {library.OCCUPANCY_GRID}, and a workload needs a map"
            hint = f"record the topic of map_server too, or name it: --map-topic TOPIC; topics: {listed}"
            raise InputError(what, self._where, hint)
        if chosen.unread:
            listed = ", ".join(printable(topic) for topic in chosen.unread[:12])
            self._remark(f"topics that are not read, though their type fits: {listed}")
        takers = {
            "map": self._map, "tf": self._tf, "tf_static": self._tf_static, "scan": self._scan, "odom": self._odom,
            "goal": self._goal, "plan": self._plan, "command": _no_taker,
        }  # fmt: skip
        self._takers = {chosen.names[role]: taker for role, taker in takers.items()}
        return [each for each in reader.connections if each.topic in self._takers]

    def _map(self, time: float, message: Any) -> None:
        info = message.info
        rows, columns = int(info.height), int(info.width)
        if not (rows and columns) or rows * columns > MAX_CELLS or len(message.data) != rows * columns:
            what = f"a map of {rows} × {columns} cells with {len(message.data):,} values"
            raise InputError(what, self._where, f"a map has from 1 to {MAX_CELLS:,} cells, and a value for each")
        side, origin, turn = (float(info.resolution), info.origin.position, _quaternion(info.origin.orientation))
        if not _SIDES[0] <= side <= _SIDES[1] or not _near(origin.x, origin.y):
            raise InputError(f"a map with cells of {side:g} m at ({origin.x:g}, {origin.y:g})", self._where)
        if math.hypot(turn[0], turn[1]) > 1e-3:
            raise InputError("a map that does not lie flat", self._where, "its origin may turn around z alone")
        # A resolution is a float32: 0.05 arrives as 0.05000000074505806.
        side = float(np.format_float_positional(np.float32(side), unique=True))
        frame = Frame(rows, side, (float(origin.x), float(origin.y), 2 * math.atan2(turn[2], turn[3])))
        cells = np.asarray(message.data, np.int8).reshape(rows, columns)[::-1]
        new = RecordedMap(time, np.ascontiguousarray(cells), frame, _frame(message.header.frame_id) or "map")
        old = self._out.map
        if old is not None and new.same_as(old):
            return
        self._maps += 1
        if old is None or self._last_map:
            self._out.map = new

    def _tf(self, time: float, message: Any) -> None:
        for each in message.transforms:
            self._edge(time, _stamp(each.header.stamp), each)

    def _tf_static(self, time: float, message: Any) -> None:
        for each in message.transforms:
            self._edge(time, -math.inf, each)

    def _edge(self, time: float, stamp: float, each: Any) -> None:
        edge = _frame(each.header.frame_id), _frame(each.child_frame_id)
        if not all(edge) or edge[0] == edge[1]:
            return
        moved, turn = each.transform.translation, _quaternion(each.transform.rotation)
        if edge not in self._edges and len(self._edges) >= MAX_FRAMES:
            raise InputError(f"more than {MAX_FRAMES} frames", self._where)
        if _near(moved.x, moved.y, moved.z):
            self._edges[edge].append((time, stamp, moved.x, moved.y, moved.z, *turn))

    def _odom(self, time: float, message: Any) -> None:
        frames = _frame(message.header.frame_id), _frame(message.child_frame_id)
        place, twist = message.pose.pose.position, message.twist.twist
        self._out.odometry = self._out.odometry or frames
        if frames == self._out.odometry and _near(place.x, place.y, place.z):
            turn = _quaternion(message.pose.pose.orientation)
            speed = math.hypot(twist.linear.x, twist.linear.y)
            row = (time, _stamp(message.header.stamp), place.x, place.y, place.z, *turn, speed, twist.angular.z)
            self._odometry.append(row)

    def _scan(self, time: float, message: Any) -> None:
        self._seen_scans += 1
        self._scan_times.append((time, _stamp(message.header.stamp)))
        if (self._seen_scans - 1) % self._every:
            return
        if len(message.ranges) > MAX_RAYS:
            raise InputError(f"a scan of {len(message.ranges):,} rays, more than {MAX_RAYS:,}", self._where)
        first = self._scans[0] if self._scans else message
        shape = len(message.ranges), _frame(message.header.frame_id)
        if shape != (len(first.ranges), _frame(first.header.frame_id)):
            self._remark("scans of another frame or another number of rays than the first are left out")
            self._scan_times.pop()
            return
        self._scans.append(message)
        self._kept_times.append((time, _stamp(message.header.stamp)))

    def _goal(self, time: float, message: Any) -> None:
        place = message.pose.position
        if not _near(place.x, place.y):
            raise InputError(f"a goal at ({place.x:g}, {place.y:g})", self._where, "goals are in metres")
        self._out.goals.append(RecordedGoal(time, _frame(message.header.frame_id), (place.x, place.y, place.z)))

    def _plan(self, time: float, message: Any) -> None:
        points = np.array(
            [(each.pose.position.x, each.pose.position.y, each.pose.position.z) for each in message.poses]
        )
        if len(points) and np.isfinite(points).all():
            length = float(np.hypot(*np.diff(points[:, :2], axis=0).T).sum())
            first, last = (tuple(map(float, points[index])) for index in (0, -1))
            frame = _frame(message.header.frame_id)
            self._out.plans.append(RecordedPlan(time, frame, first, last, length))  # type: ignore[arg-type]

    def _remark(self, text: str) -> None:
        if text not in self._out.remarks:
            self._out.remarks.append(text)

    def _finished(self) -> Recording:
        out = self._out
        if out.map is None:
            raise InputError(f"has no message of {self._topics['map']}", self._where, "record the bag from its begin")
        if self._maps > 1:
            which = "last" if self._last_map else "first"
            name = f"{self._maps} different maps on {self._topics['map']}"
            self._remark(f"{name}: the {which} one is taken, of {out.map.time:.3f} s")
        clocks = [self._odometry, self._scan_times, *self._edges.values()]
        shift = common_clock([(row[0], row[1]) for rows in clocks for row in rows], out.begin)
        if shift:
            self._remark(
                f"the clock of the messages is {shift:+,.3f} s from that of the bag: all are put on that of the bag"
            )
        for (parent, child), rows in self._edges.items():
            name = f"{self._topics['tf']} from {parent} to {child}"
            moving = any(math.isfinite(row[1]) for row in rows)
            out.edges[parent, child] = _series(self._timed(rows, shift, name), moving)
        odom = self._timed(self._odometry, shift, self._topics["odom"])
        if len(odom):
            out.speeds = odom[:, [0, 8, 9]]
            assert out.odometry is not None
            # Where transforms join the two frames, the odometry says the same once more.
            if all(out.odometry) and chain(out.edges, *out.odometry) is None:
                out.edges[out.odometry] = _series(odom)
        out.commands = np.array(self._commands)
        out.scans = self._scans_of(shift)
        return out

    def _timed(self, rows: list[_Row], shift: float, name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        return checked_clock(rows, self._out.begin, shift, self._where, name, self._remark)

    def _scans_of(self, shift: float) -> Scans | None:
        times = self._timed(self._scan_times, shift, self._topics["scan"])
        if not self._scans:
            return None
        kept = self._timed(self._kept_times, shift, self._topics["scan"])[:, 0]
        first, rays = self._scans[0], len(self._scans[0].ranges)
        step, least, most = float(first.angle_increment), float(first.range_min), float(first.range_max)
        if rays < 1 or not 1e-6 <= abs(step) <= 7 or not 0 <= least < most <= _FAR:
            what = f"a scan of {rays} rays, {step:g} rad apart, from {least:g} to {most:g} m"
            raise InputError(what, self._where, "a scan needs rays, an increment, and range_min below range_max")
        if self._every > 1:
            self._remark(f"of {self._seen_scans:,} scans, one of {self._every} is used")
        period = float(np.median(np.diff(times[:, 0]))) if len(times) > 1 else 0.0
        ranges = np.stack([each.ranges for each in self._scans]).astype(np.float32)
        angles = np.array([each.angle_min for each in self._scans], np.float64)
        frame = _frame(first.header.frame_id)
        return Scans(kept, ranges, np.nan_to_num(angles), step, (least, most), frame, self._every, period)


def _series(rows: np.ndarray[Any, np.dtype[np.float64]], moving: bool = True) -> Series:
    return Series(rows[:, 0], rows[:, 1:4], rows[:, 4:8], moving)


def _stamp(stamp: Any) -> float:
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9


def _near(*values: float) -> bool:
    return all(math.isfinite(value) and abs(value) <= _FAR for value in values)


def _frame(name: str) -> str:
    return printable(name[:MAX_TEXT].lstrip("/"), MAX_TEXT)


def _quaternion(turn: Any) -> tuple[float, float, float, float]:
    """The unit quaternion; of one without a length, no turn."""
    values = (float(turn.x), float(turn.y), float(turn.z), float(turn.w))
    length = math.sqrt(sum(value * value for value in values)) if _near(*values) else 0.0
    if length < 1e-6:
        return 0.0, 0.0, 0.0, 1.0
    return values[0] / length, values[1] / length, values[2] / length, values[3] / length
