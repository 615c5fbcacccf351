"""Robots that share an arena without obstacles: their positions, targets and limits."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, choose_hint

FEWEST_ROBOTS, MOST_ROBOTS = 2, 64
LARGEST_ARENA = 4096.0
_TRIES = 20_000


@dataclass(frozen=True, eq=False)
class RobotsProblem:
    """n similar robots on a map without static obstacles (Dubey et al. 2013, sections III and VI).

    - ``positions``, ``targets``: float64 n × 2, (x, y) in cells; x grows with the column, y with the row.
    - ``radius``: of one robot, cells. ``speed``: the greatest, cells/s. ``acceleration``: the greatest, cells/s².
    - ``arena``: width and height, cells.

    Robots start at rest.

    Raises:
        InputError: fewer than 2 or more than 64 robots, a radius, speed or acceleration that is not above 0, a
            position or target outside, robots that start in collision, targets that cannot all be taken.
    """

    positions: NDArray[np.float64]
    targets: NDArray[np.float64]
    radius: float
    speed: float
    acceleration: float
    arena: tuple[float, float] = (300.0, 300.0)

    # A map's: the paper gives no metres, and the arena is never cropped nor read from a file.
    resolution: ClassVar[None] = None
    corner: ClassVar[tuple[int, int]] = (0, 0)
    origin: ClassVar[None] = None
    unknown: ClassVar[None] = None
    optimal_lengths: ClassVar[tuple[float, ...]] = ()

    def __post_init__(self) -> None:
        for name in ("positions", "targets"):
            array = np.array(getattr(self, name), np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
            if array.ndim != 2 or array.shape[1] != 2:
                raise InputError(f"an array of shape {array.shape} names no robots", name, "n × 2: (x, y) each")
        if not FEWEST_ROBOTS <= self.count <= MOST_ROBOTS:
            hint = f"from {FEWEST_ROBOTS} to {MOST_ROBOTS} robots"
            raise InputError(f"{self.count} robots", "positions", hint)
        if len(self.targets) != self.count:
            raise InputError(f"{len(self.targets)} targets for {self.count} robots", "targets", "one target a robot")
        for name in ("radius", "speed", "acceleration"):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0.0 < value <= LARGEST_ARENA):
                hint = f"above 0, at most {LARGEST_ARENA:g}"
                raise InputError(f"a robot with {name} {value:g} cannot be planned for", name, hint)
        if not all(math.isfinite(side) and 0.0 < side <= LARGEST_ARENA for side in self.arena):
            hint = f"sides above 0, at most {LARGEST_ARENA:g} cells"
            raise InputError(f"an arena of {self.arena[0]:g} × {self.arena[1]:g}", "arena", hint)
        self._check_places("positions", self.positions, "start in collision")
        self._check_places("targets", self.targets, "would end in collision")

    def _check_places(self, name: str, places: NDArray[np.float64], what: str) -> None:
        inside = np.isfinite(places).all(axis=1) & ((places >= 0.0) & (places <= self.arena)).all(axis=1)
        if not inside.all():
            robot = int(np.argmin(inside))
            x, y = places[robot]
            raise InputError(
                f"robot {robot} has ({x:g}, {y:g}), outside of the arena of {self.arena[0]:g} × {self.arena[1]:g}",
                name,
                "(x, y) in cells, from (0, 0)",
            )
        apart = distances(places)
        np.fill_diagonal(apart, np.inf)
        if apart.min() < 2.0 * self.radius:
            first, second = (int(index) for index in np.unravel_index(np.argmin(apart), apart.shape))
            raise InputError(
                f"robots {first} and {second} {what}: {apart.min():.4g} cells apart, with radii of {self.radius:g}",
                name,
                f"place them at least {2.0 * self.radius:g} cells apart, or make the radius smaller",
            )

    @property
    def count(self) -> int:
        """Number of robots."""
        return len(self.positions)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the whole problem: equal problems have equal digests, in every process."""
        text = f"robots {self.count} {self.radius!r} {self.speed!r} {self.acceleration!r} {self.arena!r}"
        content = self.positions.astype("<f8").tobytes() + self.targets.astype("<f8").tobytes()
        return hashlib.sha256(text.encode() + content).hexdigest()

    @property
    def rows(self) -> int:
        """Rows of the map: the height of the arena in whole cells."""
        return math.ceil(self.arena[1])

    @property
    def columns(self) -> int:
        """Columns of the map: the width of the arena in whole cells."""
        return math.ceil(self.arena[0])

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """The map, bool rows × columns: all free."""
        return np.ones((self.rows, self.columns), np.bool_)

    @property
    def goals(self) -> tuple[tuple[int, int], ...]:
        """The cell (row, column) of each target."""
        last = self.rows - 1, self.columns - 1
        return tuple((min(int(y), last[0]), min(int(x), last[1])) for x, y in self.targets)

    @property
    def starts(self) -> tuple[int, ...]:
        """The numbers of the robots, as ``trajectory`` takes them."""
        return tuple(range(self.count))


def distances(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance between each two of n places, float64 n × n."""
    offsets = places[:, None, :] - places[None, :, :]
    return np.asarray(np.sqrt((offsets**2).sum(axis=2)))


def circle(
    count: int, *, radius: float, arena: tuple[float, float], seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Robots evenly on a circle, each with its target at the opposite point: all paths cross in the middle.

    ``seed`` turns the circle; seed 0 leaves robot 0 to the right of the middle.
    """
    middle = np.array(arena) / 2.0
    reach = min(arena) / 2.0 - 2.0 * radius
    turn = np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * math.pi) if seed else 0.0
    angles = turn + 2.0 * math.pi * np.arange(count) / count
    spokes = reach * np.column_stack([np.cos(angles), np.sin(angles)])
    return middle + spokes, middle - spokes


def crossing(
    count: int, *, radius: float, arena: tuple[float, float], seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two groups with paths that cross at right angles: one from left to right, one from top to bottom.

    The robots of a group drive abreast in the middle seven tenths of the arena. ``seed`` lets each start up to a tenth
    of the arena further on its path. Where lanes would come closer than 2.5 radii, the robots of a group drive in
    several ranks, three radii apart. The more ranks there are, the less far they start on their paths.
    """
    random = np.random.Generator(np.random.PCG64(seed))
    groups = (count + 1) // 2, count // 2
    positions, targets = [], []
    for axis, members in enumerate(groups):
        along, across = arena[axis], arena[1 - axis]
        ranks = 1
        while 0.7 * across < 2.5 * radius * -(-members // ranks) and ranks < members:
            ranks += 1
        abreast = -(-members // ranks)
        lane, rank = np.arange(members) % abreast, np.arange(members) // abreast
        lanes = across * (0.15 + 0.7 * (lane + 0.5) / abreast)
        late = random.uniform(0.0, along / 10.0 / ranks, abreast)[lane]
        ahead = 3.0 * radius * rank
        begin = np.column_stack([2.0 * radius + late + ahead, lanes])
        end = np.column_stack([along - 2.0 * radius - 3.0 * radius * (ranks - 1) + ahead, lanes])
        positions.append(begin[:, ::-1] if axis else begin)
        targets.append(end[:, ::-1] if axis else end)
    return np.concatenate(positions), np.concatenate(targets)


def scattered(
    count: int, *, radius: float, arena: tuple[float, float], seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Starts and targets drawn anywhere in the arena, no two closer than three radii.

    Raises:
        InputError: the arena has no room for so many robots of that size.
    """
    random = np.random.Generator(np.random.PCG64(seed))
    return (_drawn(count, 3.0 * radius, radius, arena, random), _drawn(count, 3.0 * radius, radius, arena, random))


def _drawn(
    count: int, apart: float, border: float, arena: tuple[float, float], random: np.random.Generator
) -> NDArray[np.float64]:
    low, high = np.full(2, border), np.array(arena) - border
    if (high <= low).any():
        raise InputError(f"robots of radius {border:g} have no room in the arena", "radius", "a smaller radius")
    places: list[NDArray[np.float64]] = []
    for _ in range(_TRIES):
        place = random.uniform(low, high)
        if all(math.dist(place, other) >= apart for other in places):
            places.append(place)
            if len(places) == count:
                return np.array(places)
    what = f"{count} robots of radius {border:g} find no place in {arena[0]:g} × {arena[1]:g} cells"
    raise InputError(what, "count", "fewer or smaller robots, or a larger arena")


Arrangement = Callable[..., tuple[NDArray[np.float64], NDArray[np.float64]]]
ARRANGEMENTS: dict[str, Arrangement] = {"circle": circle, "crossing": crossing, "random": scattered}
"""Generators of starts and targets by name."""


def generate(
    arrangement: str,
    count: int,
    *,
    radius: float = 5.0,
    speed: float = 6.0,
    acceleration: float = 24.0,
    arena: tuple[float, float] = (300.0, 300.0),
    seed: int = 0,
) -> RobotsProblem:
    """A problem of ``count`` robots: ``circle``, ``crossing`` or ``random``.

    The default arena is the 300 × 300 map of section VI. Radius, speed and acceleration are not published:
    assumed, so that a run takes about the 500 updates of the paper.

    Raises:
        InputError: an unknown arrangement, or robots that cannot be placed so.
    """
    if arrangement not in ARRANGEMENTS:
        raise InputError(
            f"there is no arrangement {arrangement!r}", "arrangement", choose_hint(arrangement, ARRANGEMENTS)
        )
    if isinstance(count, bool) or not FEWEST_ROBOTS <= count <= MOST_ROBOTS:
        raise InputError(f"{count} robots", "count", f"from {FEWEST_ROBOTS} to {MOST_ROBOTS} robots")
    if not (radius > 0.0 and math.isfinite(radius)):
        raise InputError(f"a robot with radius {radius:g} cannot be planned for", "radius", "above 0")
    settings: dict[str, Any] = {"radius": radius, "arena": arena, "seed": seed}
    positions, targets = ARRANGEMENTS[arrangement](count, **settings)
    return RobotsProblem(positions, targets, radius, speed, acceleration, arena)
