"""What components say while a simulation runs.

A record is a frozen dataclass with ``time`` (picoseconds from 0) and ``source`` (the component or link that speaks).
Components emit records; listeners (a list in memory, an MCAP file) take them all alike and never answer. With no
listener nothing is built. The records of a run are the same at every granularity of simulation.

Arrays are NumPy arrays with the dtype that each field names; a writer encodes them as it likes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

ENDED, BROKEN_OFF, UNFINISHED = "ended", "broken off", "unfinished"
"""What becomes of a task."""


@dataclass(frozen=True)
class Record:
    """Anything that happened: when (ps), and who says so."""

    time: int
    source: str


@dataclass(frozen=True)
class MapRecord(Record):
    """The map and the goals a planner starts from.

    ``free``: bool array, rows × columns. ``goals``: int32 array, n × 2, (row, column). ``resolution``: metres a cell,
    or None.
    """

    free: NDArray[np.bool_]
    goals: NDArray[np.int32]
    resolution: float | None


@dataclass(frozen=True)
class TaskRecord(Record):
    """A task that ran on ``source`` from ``time`` to ``end`` (ps), for ``cycles`` clock cycles.

    ``outcome``: "ended"; "broken off", where it was interrupted at ``end``; or "unfinished", where the run ended first.
    """

    task: str
    end: int
    cycles: int
    outcome: str = ENDED


@dataclass(frozen=True)
class MessageRecord(Record):
    """A message over link ``source``: asked for at ``time``, first on the wire at ``begin``, delivered at ``end`` (ps).

    ``outcome``: "delivered" or "dropped"; one that was dropped says why in ``reason``, and ``end`` is when it was given
    up (``begin`` too, where it never was on the wire). ``bits``: what the sender gave, without framing and checksum.
    ``attempts``: how often it was on the wire. ``damaged``: it was delivered with wrong bits that nobody noticed.
    """

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

    ``block``: int32, the raster number of each visited block. ``iterations``: int32, its iterations, the last one that
    changed nothing included. A visit takes iterations × (``precision`` + 2) cycles.
    """

    end: int
    stage: int
    precision: int
    block: NDArray[np.int32]
    iterations: NDArray[np.int32]


@dataclass(frozen=True)
class StageRecord(Record):
    """A stage that converged at ``time``, with its costs and the potential it left.

    ``potential``: float64 array, rows × columns, the exact field rounded for the eye. It is not the result. The trace
    of a mission leaves it out: 0 × 0.
    """

    begin: int
    stage: int
    precision: int
    sweeps: int
    visits: int
    iterations: int
    cycles: int
    local_maxima: int
    potential: NDArray[np.float64]


@dataclass(frozen=True)
class FieldRecord(Record):
    """A field that a planner left: one value a cell, ``values``, float64 array, rows × columns.

    ``name`` says of what (``distance``, ``potential``, ``arrival``), ``unit`` in what (``cells``, ``steps``, ``1``).
    A cell without a value, as one that no wave reached, holds NaN or infinity. The field is rounded for the eye. The
    trace of a mission leaves it out: 0 × 0.
    """

    name: str
    unit: str
    values: NDArray[np.float64]


@dataclass(frozen=True)
class TrajectoryRecord(Record):
    """The way from one start to a goal: ``points``, float64 n × 2, (row, column) in cells; ``arrived`` or not."""

    points: NDArray[np.float64]
    arrived: bool


@dataclass(frozen=True)
class PoseRecord(Record):
    """Where a robot is: ``row`` and ``column`` in cells (whole numbers are middles), ``heading`` in radians from the
    direction of growing columns towards that of growing rows, ``speed`` in m/s."""

    row: float
    column: float
    heading: float
    speed: float


@dataclass(frozen=True)
class ObstacleRecord(Record):
    """Cells of the true map that became an obstacle (``appeared``) or free again: int32 n × 2, (row, column)."""

    cells: NDArray[np.int32]
    appeared: bool


@dataclass(frozen=True)
class BeliefRecord(Record):
    """What the robot learnt of the map: ``cells``, int32 n × 2, (row, column), and ``blocked``, bool, one each.

    ``seen``: when the scan was taken that showed it, ps; None in files that do not say.
    """

    cells: NDArray[np.int32]
    blocked: NDArray[np.bool_]
    seen: int | None = None


@dataclass(frozen=True)
class PlanRecord(Record):
    """A plan of a drive that is ready at ``time``; ``source`` made it. All times in ps.

    ``number``: counts the drive's plans from 1. ``asked``: when the map that it is made from was taken. ``seen``: when
    the last scan in that map was taken. ``loaded``: when the map had reached the planner. ``planned``: when the plan
    stood.
    """

    number: int
    asked: int
    seen: int
    loaded: int
    planned: int


@dataclass(frozen=True)
class CommandRecord(Record):
    """A command that robot ``source`` takes up at ``time`` (ps), as it arrived.

    ``plan``: the number of the plan that it follows. ``seen``: when the scan was taken that it is made from, ps.
    ``composed``: when it was made and handed to the links, ps. ``points``: the way, float64 n × 2, (row, column) in
    cells, from where the robot was at ``seen``. ``end``: the arc length of it, cells, at which the robot is to stand.
    """

    plan: int
    seen: int
    composed: int
    points: NDArray[np.float64]
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

    update: int
    positions: NDArray[np.float64]


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
    """Takes every record of a run, in the order of emission."""

    def __call__(self, record: Record) -> None:
        """Take one record."""
