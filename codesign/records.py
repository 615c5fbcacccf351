"""Records of what happens while a simulation runs.

A record is a frozen dataclass with ``time`` (picoseconds from 0) and ``source`` (the component or link that emits it).
A record is written when its activity ends. Components emit records, and all listeners (a list in memory, an MCAP file)
receive all of them and change nothing. Without a listener no record is built. The records of a run are the same at
every granularity of simulation.

Arrays are NumPy arrays. Each declares its dtype and shape (``ArrayOf``), and a writer chooses the encoding. The first
paragraph of a class docstring becomes the description of its schema in traces, so a change to it changes the bytes of
traces.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

ENDED, PREEMPTED, BROKEN_OFF, UNFINISHED = "ended", "preempted", "broken off", "unfinished"
"""The outcomes of a task, or of a stretch of it."""


@dataclass(frozen=True)
class ArrayOf:
    """The form of an array in a record: its dtype, and the length of each side. None is any length.

    A field names it with ``Annotated``, as type hints of NumPy are no interface: their inner form differs by version.

    >>> str(ArrayOf("int32", (None, 2)))
    'int32, n × 2'
    """

    dtype: str
    shape: tuple[int | None, ...]

    def __str__(self) -> str:
        sides = " × ".join(
            "nm"[place] if side is None else str(side) for place, side in enumerate(self.shape)
        )
        return f"{self.dtype}, {sides}"


Cells = Annotated[NDArray[np.int32], ArrayOf("int32", (None, 2))]
Points = Annotated[NDArray[np.float64], ArrayOf("float64", (None, 2))]
Place = Annotated[NDArray[np.float64], ArrayOf("float64", (3,))]
Counts = Annotated[NDArray[np.int32], ArrayOf("int32", (None,))]
Flags = Annotated[NDArray[np.bool_], ArrayOf("bool", (None,))]
Ranges = Annotated[NDArray[np.float32], ArrayOf("float32", (None,))]
FlagGrid = Annotated[NDArray[np.bool_], ArrayOf("bool", (None, None))]
ValueGrid = Annotated[NDArray[np.float64], ArrayOf("float64", (None, None))]


@dataclass(frozen=True)
class Record:
    """Anything that happened: when (ps), and who says so.

    ``IN_CELLS``: the fields of a class that hold places, n × 2, (row, column) in cells. ``TIMES``: those that hold
    times, ps, besides ``time``.
    """

    IN_CELLS: ClassVar[tuple[str, ...]] = ()
    TIMES: ClassVar[tuple[str, ...]] = ()

    time: int
    source: str

    def moved(self, rows: int, columns: int) -> Self:
        """The record with all its places so many rows down and columns right: from a cropped map to the whole map."""
        if not (self.IN_CELLS and (rows or columns)):
            return self
        places = {name: vars(self)[name] for name in self.IN_CELLS}
        return replace(
            self, **{name: here + np.array([rows, columns], here.dtype) for name, here in places.items()}
        )


@dataclass(frozen=True)
class MapRecord(Record):
    """The map and the goals a planner starts from.

    ``free``: bool array, rows × columns. ``goals``: int32 array, n × 2, (row, column). ``resolution``: metres a cell,
    or None.

    All places of a run are counted in the whole map, and ``free`` may be a part of it. ``row``, ``column``: the first
    cell of the part. ``origin``: (x, y, yaw) of its lower left corner, metres and radians, or None. ``radius``: of the
    bodies of the robots, cells; 0 where it is not known. ``unknown``: bool array, rows × columns, of the cells that the
    source of the map calls unknown; None where it has no such cells.
    """

    IN_CELLS = ("goals",)

    free: FlagGrid
    goals: Cells
    resolution: float | None
    row: int = 0
    column: int = 0
    origin: Place | None = None
    radius: float = 0.0
    unknown: FlagGrid | None = None

    @property
    def corner(self) -> tuple[int, int]:
        """The first row and column of the part."""
        return self.row, self.column


@dataclass(frozen=True)
class TaskRecord(Record):
    """A task that ran on ``source`` from ``time`` to ``end`` (ps), for ``cycles`` clock cycles.

    ``outcome``: "ended"; "preempted", where a more urgent task took its core at ``end``, and its next record goes on;
    "broken off", where it was interrupted at ``end``; or "unfinished", where the run ended first.
    """

    TIMES = ("end",)

    task: str
    end: int
    cycles: int
    outcome: str = ENDED


@dataclass(frozen=True)
class MessageRecord(Record):
    """A message over link ``source``: asked for at ``time``, first on the wire at ``begin``, delivered at ``end`` (ps).

    ``outcome``: "delivered" or "dropped". For a dropped message ``reason`` says why, and ``end`` is when it was given
    up (``begin`` too, where it never was on the wire). ``bits``: of the sender, without framing and checksum.
    ``attempts``: how often it was on the wire. ``damaged``: it was delivered with wrong bits that were not detected.
    """

    TIMES = ("begin", "end")

    sender: str
    receiver: str
    name: str
    bits: int
    begin: int
    end: int
    outcome: str = "delivered"
    reason: str | None = None
    attempts: int = 1
    damaged: bool = False


@dataclass(frozen=True)
class VisitsRecord(Record):
    """Consecutive visits of one stage, coalesced: ``time`` is the start of the first, ``end`` that of the last (ps).

    ``block``: int32, the raster number of each visited block. ``iterations``: int32, its iterations, including the last
    one, which changes nothing. A visit takes iterations × (``precision`` + 2) cycles.
    """

    TIMES = ("end",)

    end: int
    stage: int
    precision: int
    block: Counts
    iterations: Counts


@dataclass(frozen=True)
class StageRecord(Record):
    """A stage that converged at ``time``, with its costs and the potential it left.

    ``potential``: float64 array, rows × columns, the exact field rounded for display. It is not the result. The trace
    of a mission leaves it out: 0 × 0.
    """

    TIMES = ("begin",)

    begin: int
    stage: int
    precision: int
    sweeps: int
    visits: int
    iterations: int
    cycles: int
    local_maxima: int
    potential: ValueGrid


@dataclass(frozen=True)
class FieldRecord(Record):
    """A field that a planner left: one value a cell, ``values``, float64 array, rows × columns.

    ``name``: the quantity (``distance``, ``potential``, ``arrival``). ``unit``: its unit (``cells``, ``steps``, ``1``).
    A cell without a value, such as one that no wave reached, has NaN or infinity. The field is rounded for display. The
    trace of a mission leaves it out: 0 × 0.
    """

    name: str
    unit: str
    values: ValueGrid


@dataclass(frozen=True)
class TrajectoryRecord(Record):
    """The way from one start to a goal: ``points``, float64 n × 2, (row, column) in cells; ``arrived`` or not."""

    IN_CELLS = ("points",)

    points: Points
    arrived: bool


@dataclass(frozen=True)
class RobotRecord(Record):
    """The robot ``source`` at the begin of a drive: its ``radius`` (m), its greatest ``speed`` (m/s), and its sensor.

    ``reach``: of the sensor, m. ``rays``: how many rays it has over the full circle; 0 for a sensor of a radius.
    ``hidden``: int32 n × 2, (row, column), obstacles that the robot's map does not show. ``knows``: whether it has a
    map at the begin.
    """

    IN_CELLS = ("hidden",)

    radius: float
    speed: float
    reach: float
    rays: int
    hidden: Cells
    knows: bool


@dataclass(frozen=True)
class GoalRecord(Record):
    """Where robot ``source`` is to go from now on: any of ``cells``, int32 n × 2, (row, column).

    It has no cells where the robot chooses its goals itself.
    """

    IN_CELLS = ("cells",)

    cells: Cells


@dataclass(frozen=True)
class PoseRecord(Record):
    """Where a robot is: ``row`` and ``column`` in cells (whole numbers are middles), ``heading`` in radians from the
    direction of growing columns towards that of growing rows, ``speed`` in m/s."""

    row: float
    column: float
    heading: float
    speed: float

    def moved(self, rows: int, columns: int) -> Self:
        """The record with its place so many rows down and columns right."""
        if not (rows or columns):
            return self
        return replace(self, row=self.row + rows, column=self.column + columns)


@dataclass(frozen=True)
class ObstacleRecord(Record):
    """Cells of the true map that became an obstacle (``appeared``) or free again: int32 n × 2, (row, column)."""

    IN_CELLS = ("cells",)

    cells: Cells
    appeared: bool


@dataclass(frozen=True)
class BeliefRecord(Record):
    """What the robot learnt of the map: ``cells``, int32 n × 2, (row, column), and ``blocked``, bool, one each.

    ``seen``: the time of the scan that showed the cells, ps; None in files without it.
    """

    IN_CELLS = ("cells",)
    TIMES = ("seen",)

    cells: Cells
    blocked: Flags
    seen: int | None = None


@dataclass(frozen=True)
class PlanRecord(Record):
    """A plan of a drive that is ready at ``time``; ``source`` made it. All times in ps.

    ``number``: counts the plans of the drive from 1. ``asked``: the time of the map of the plan. ``seen``: the time of
    the last scan in that map. ``loaded``: when the map had reached the planner. ``planned``: when the plan was
    complete.
    """

    TIMES = ("asked", "seen", "loaded", "planned")

    number: int
    asked: int
    seen: int
    loaded: int
    planned: int


@dataclass(frozen=True)
class CommandRecord(Record):
    """A command that robot ``source`` takes up at ``time`` (ps), as it arrived.

    ``plan``: the number of its plan. ``seen``: the time of its scan, ps. ``composed``: when it was made and given to
    the links, ps. ``points``: the path, float64 n × 2, (row, column) in cells, from the position of the robot at
    ``seen``. ``end``: the arc length of the path, cells, at which the robot is to stop.
    """

    IN_CELLS = ("points",)
    TIMES = ("seen", "composed")

    plan: int
    seen: int
    composed: int
    points: Points
    end: float


@dataclass(frozen=True)
class MissionRecord(Record):
    """Something that happened in a mission: ``event`` names its kind, ``text`` says what.

    Events: ``plan_requested``, ``plan_ready``, ``no_way``, ``deadline_missed``, ``safety_stop``, ``contact``,
    ``obstacle_waits``, ``goal_reached``, ``livelock``, ``ended``.
    """

    event: str
    text: str


@dataclass(frozen=True)
class PositionsRecord(Record):
    """Where all robots are after an update: ``positions``, float64 n × 2, (row, column) in cells."""

    IN_CELLS = ("positions",)

    update: int
    positions: Points


@dataclass(frozen=True)
class ScanRecord(Record):
    """What a sensor of rays measured: ``ranges``, float32, cells along each ray to the obstacle that ended it.

    A drive records one scan each 5 s, its ranges rounded to 1/64 of a cell. Ray i of n points 2π i / n from the
    direction of growing columns towards that of growing rows. A ray that met no obstacle within ``reach`` (cells) has
    infinity. ``row``, ``column``: where the sensor was, cells.
    """

    row: float
    column: float
    reach: float
    ranges: Ranges

    def moved(self, rows: int, columns: int) -> Self:
        """The record with its place so many rows down and columns right."""
        return replace(self, row=self.row + rows, column=self.column + columns)


@dataclass(frozen=True)
class SampleRecord(Record):
    """A quantity of ``source`` from its last sample up to ``time``: its greatest value, or its share, in ``unit``.

    Quantities: ``queue`` (messages at a link, waiting or on the wire), ``fifo.SENDER`` (words in the FIFO of a sender
    at a link), ``busy`` (share of that time in which ``source`` was busy, 0 to 1). A sample is made at a change, but at
    most each 1 us, and each 64th of the time up to then. A value that stays is not repeated.
    """

    quantity: str
    unit: str
    value: float


@dataclass(frozen=True)
class UtilisationRecord(Record):
    """How much of a span ``source`` was busy: ``busy`` of ``span`` picoseconds, the span ending at ``time``."""

    busy: int
    span: int


@dataclass(frozen=True)
class SummaryRecord(Record):
    """The result of the run, as the JSON-ready mapping that ``hwsw run --json`` prints."""

    result: dict[str, Any]


class Listener(Protocol):
    """Receives every record of a run, in the order of emission."""

    def __call__(self, record: Record) -> None:
        """Take one record."""


class Recorder(ABC):
    """A listener that does without some classes of records. A run does not make records that no listener wants."""

    @property
    @abstractmethod
    def unwanted(self) -> frozenset[type[Record]]:
        """The classes of records that it ignores."""

    @abstractmethod
    def __call__(self, record: Record) -> None:
        """Take one record. It may be of a class that another listener wants."""


def unwanted_by(listeners: Sequence[Listener]) -> frozenset[type[Record]]:
    """The classes of records that none of the listeners wants. A plain callable wants them all."""
    each = [item.unwanted if isinstance(item, Recorder) else frozenset[type[Record]]() for item in listeners]
    return frozenset.intersection(*each) if each else frozenset()


def recorded_by(listeners: Sequence[Listener], kind: type[Record]) -> bool:
    """Whether a ``Recorder`` wants records of this class. Samples are made for recorders alone."""
    return any(isinstance(item, Recorder) and kind not in item.unwanted for item in listeners)
