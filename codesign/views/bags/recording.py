"""The contents of a recorded bag about a robot's run, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import Frame

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
