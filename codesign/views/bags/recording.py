"""The places of frames in each other over time, for many times at once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.models import Frame

# What a recorded bag holds of a robot's run, as arrays.

Seconds = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RecordedMap:
    """An OccupancyGrid: ``cells`` int8, rows × columns, the highest row first, as 0 to 100 or -1."""

    time: float
    cells: NDArray[np.int8]
    frame: Frame
    frame_id: str

    def same_as(self, other: RecordedMap) -> bool:
        """True if both are the same map."""
        return self.frame == other.frame and np.array_equal(self.cells, other.cells)


@dataclass(eq=False)
class Series:
    """Poses over time: ``times`` (s) rising, ``places`` n × 3 (m), ``turns`` n × 4 (quaternions x, y, z, w).

    ``moving``: false where the transform is static.
    """

    times: Seconds
    places: NDArray[np.float64]
    turns: NDArray[np.float64]
    moving: bool = True


@dataclass(frozen=True, eq=False)
class Scans:
    """Laser scans: ``ranges`` float32 n × rays (m; NaN and infinities where nothing was met), ``first`` n (rad).

    ``step``: rad from ray to ray. ``span``: (least, greatest) range, m. ``every``: one of so many scans was kept.
    ``period``: s between two scans of the bag.
    """

    times: Seconds
    ranges: NDArray[np.float32]
    first: NDArray[np.float64]
    step: float
    span: tuple[float, float]
    frame_id: str
    every: int
    period: float


@dataclass(frozen=True)
class RecordedGoal:
    """A goal: when it was given (s), in which frame, and where (m)."""

    time: float
    frame_id: str
    place: tuple[float, float, float]


@dataclass(frozen=True)
class RecordedPlan:
    """A plan of the robot's own planner: when (s), its frame, its first and its last point, its length (m)."""

    time: float
    frame_id: str
    first: tuple[float, float, float]
    last: tuple[float, float, float]
    length: float


@dataclass(eq=False)
class Recording:
    """All that was read of a bag. Times are seconds since ``begin``, the first message of the bag (ns).

    ``topics``: the names that were read, by role. ``namespace``: of the robot, "" for the root.
    ``edges``: poses of frames by (parent, child). ``speeds``: n × 3 of /odom: time, m/s, rad/s. ``commands``: times.
    ``remarks``: what was assumed or left out, each a sentence.
    """

    path: Path
    topics: Mapping[str, str] = field(default_factory=dict)
    namespace: str = ""
    begin: int = 0
    length: float = 0.0
    map: RecordedMap | None = None
    edges: dict[tuple[str, str], Series] = field(default_factory=dict)
    odometry: tuple[str, str] | None = None
    speeds: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    scans: Scans | None = None
    goals: list[RecordedGoal] = field(default_factory=list)
    plans: list[RecordedPlan] = field(default_factory=list)
    commands: Seconds = field(default_factory=lambda: np.zeros(0))
    remarks: list[str] = field(default_factory=list)


Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of a frame in another: ``turns`` n × 3 × 3, ``places`` n × 3, n the number of times."""

    turns: Floats
    places: Floats

    @property
    def yaws(self) -> Floats:
        """The angle by which each is turned around z, radians."""
        return np.arctan2(self.turns[:, 1, 0], self.turns[:, 0, 0])

    def points(self, local: Floats) -> Floats:
        """Points n × k × 3 of the inner frame, in the outer frame."""
        return np.asarray(np.einsum("nij,nkj->nki", self.turns, local) + self.places[:, None, :])


Edge = tuple[str, str]


def chain(edges: Iterable[Edge], outer: str, inner: str) -> list[Edge] | None:
    """The steps (from, to) from frame ``outer`` to ``inner``, along edges or against them; None where none leads there.

    >>> chain([("world", "map"), ("world", "odom"), ("odom", "base")], "map", "base")
    [('map', 'world'), ('world', 'odom'), ('odom', 'base')]
    """
    both = (step for parent, child in edges for step in ((parent, child), (child, parent)))
    beside = map_reduce(both, itemgetter(0), itemgetter(1))
    before, waiting = {outer: outer}, deque([outer])
    while waiting and inner not in before:
        here = waiting.popleft()
        for frame in beside.get(here, ()):
            if frame not in before:
                before[frame] = here
                waiting.append(frame)
    if inner not in before:
        return None
    found = []
    while inner != outer:
        found.append((before[inner], inner))
        inner = before[inner]
    return found[::-1]


def known_times(edges: Mapping[Edge, Series], path: list[Edge]) -> Floats:
    """The times, rising, at which a moving edge of ``path`` has a message: empty where none moves."""
    series = (edges.get(step) or edges[step[::-1]] for step in path)
    moving = [each.times for each in series if each.moving]
    return np.unique(np.concatenate(moving)) if moving else np.zeros(0)


def root_of(edges: Iterable[Edge], inner: str) -> str:
    """The outermost frame around ``inner``."""
    parents = {child: parent for parent, child in edges}
    here = inner
    for _ in parents:
        here = parents.get(here, here)
    return here


def poses(edges: Mapping[Edge, Series], path: list[Edge], times: Floats) -> Poses:
    """The poses of the last frame of ``path`` in its first, at each time. ``path``: steps as ``chain`` gives them.

    Between two messages a place is interpolated, and so is a turn. Before the first and after the last, the nearest
    holds.
    """
    turns = np.tile(np.eye(3), (len(times), 1, 1))
    places = np.zeros((len(times), 3))
    for step in path:
        series = edges.get(step) or edges[step[::-1]]
        moved = np.column_stack([np.interp(times, series.times, series.places[:, axis]) for axis in range(3)])
        turned = _matrices(_turns_at(series, times))
        if step not in edges:  # against the edge: x' = Rᵀ (x - p)
            turned = turned.transpose(0, 2, 1)
            moved = -np.einsum("nij,nj->ni", turned, moved)
        places = np.einsum("nij,nj->ni", turns, moved) + places
        turns = np.einsum("nij,njk->nik", turns, turned)
    return Poses(turns, places)


def _turns_at(series: Series, times: Floats) -> Floats:
    """Quaternions at the times, n × 4. Those of neighbours are given one sign, as q and -q are the same turn."""
    turns = series.turns.copy()
    # Each step that flips the sign flips all that follow.
    turns[1:] *= np.cumprod(np.where((turns[1:] * turns[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))[:, None]
    mixed = np.column_stack([np.interp(times, series.times, turns[:, axis]) for axis in range(4)])
    length = np.linalg.norm(mixed, axis=1, keepdims=True)
    return np.asarray(mixed / np.where(length > 1e-9, length, 1.0))


def _matrices(turns: Floats) -> Floats:
    x, y, z, w = turns.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=1,
    )
