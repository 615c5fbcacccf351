"""Records of what happens while a simulation runs.

A record is a frozen dataclass with ``time`` (picoseconds from 0) and ``source`` (the component or link that emits it).
A record is written when its activity ends. Components emit records, and all listeners (a list in memory, an MCAP file)
receive all of them and change nothing. Without a listener no record is built. The records of a run are the same at
every granularity of simulation.

Each class declares its role (``Role``): what it is about, when it begins and ends, which level of a trace holds it. Its
methods say what it is in words (``described``) and what was done when (``acts``). Traces, pages, pictures, exports and
bags walk over roles, so a new record is one class.

Arrays are NumPy arrays. Each declares its dtype and shape (``ArrayOf``), and a writer chooses the encoding. The first
paragraph of a class docstring becomes the description of its schema in traces, so a change to it changes the bytes of
traces.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum, StrEnum
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from codesign.ground.activity import Activity, Change, Detail, Kind, Mark, Span, Value
from codesign.ground.errors import printable
from codesign.ground.units import counted, format_count, format_data, format_time

ENDED, PREEMPTED, BROKEN_OFF, UNFINISHED = "ended", "preempted", "broken off", "unfinished"
"""The outcomes of a task, or of a stretch of it."""

DELIVERED = "delivered"


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
        sides = " × ".join("nm"[place] if side is None else str(side) for place, side in enumerate(self.shape))
        return f"{self.dtype}, {sides}"


Cells = Annotated[NDArray[np.int32], ArrayOf("int32", (None, 2))]
Points = Annotated[NDArray[np.float64], ArrayOf("float64", (None, 2))]
Place = Annotated[NDArray[np.float64], ArrayOf("float64", (3,))]
Counts = Annotated[NDArray[np.int32], ArrayOf("int32", (None,))]
Flags = Annotated[NDArray[np.bool_], ArrayOf("bool", (None,))]
Ranges = Annotated[NDArray[np.float32], ArrayOf("float32", (None,))]
FlagGrid = Annotated[NDArray[np.bool_], ArrayOf("bool", (None, None))]
ValueGrid = Annotated[NDArray[np.float64], ArrayOf("float64", (None, None))]


class Level(StrEnum):
    """The amount that a trace holds. Each level holds what the one before holds, and more.

    - ``mission``: the map, obstacles, beliefs, plans, paths, poses, events, busy shares of the whole run, the result.
    - ``messages``: tasks, messages, commands, scans, and samples of queues, FIFOs and busy shares.
    - ``blocks``: the stages, visits and fields of plans.
    - ``iterations``: each visit in a record of its own.
    """

    MISSION = "mission"
    MESSAGES = "messages"
    BLOCKS = "blocks"
    ITERATIONS = "iterations"


class Subject(Enum):
    """The subject of a record, for all who draw it, with the attributes that they read of it."""

    MAP = ("free", "goals", "resolution", "corner", "origin", "radius", "unknown")
    CHANGE = ("cells", "appeared")
    BELIEF = ("cells", "blocked")
    STAGE = ("stage", "precision", "sweeps", "visits", "local_maxima", "potential")
    FIELD = ("name", "unit", "values")
    PATH = ("points", "arrived")
    POSE = ("row", "column", "heading", "speed")
    FLEET = ("positions",)
    SCAN = ("row", "column", "ranges")
    ROBOT = ("radius", "reach", "rays", "hidden", "knows")
    GOALS = ("cells",)
    EVENT = ("event", "text")
    PLAN = ("number",)
    RESULT = ("result",)
    OTHER = ()


@dataclass(frozen=True)
class Role:
    """The meaning of the records of a class, for all who show, draw, count or keep them.

    - ``about``: what they are drawn as. ``level``: the lowest level of a trace that holds them.
    - ``begin``, ``end``: the fields with the times between which it happened. Both are ``time`` of a moment.
    - ``work``: the kind of the span that they are, if they are one. ``lane``: its row, and ``label``: its name, with
      the fields in braces. ``counts``: the fields that are told with it.
    - ``grid``: the field with a grid of the whole map. ``alike``: fields of one length, with the words for them.
    - ``of_run``: they are of the run as a whole, so their topic does not begin with their source.
    """

    about: Subject = Subject.OTHER
    level: Level = Level.MISSION
    begin: str = "time"
    end: str = "time"
    work: Kind | None = None
    lane: str = "{source}"
    label: str = ""
    counts: tuple[str, ...] = ()
    grid: str = ""
    alike: Mapping[str, str] = field(default_factory=dict)
    of_run: bool = False

    @property
    def spare_grid(self) -> str:
        """The field with a grid that may be left out: a plan's. A mission has hundreds of them."""
        return "" if self.about is Subject.MAP else self.grid


@dataclass(frozen=True)
class Record:
    """Anything that happened: when (ps), and who says so.

    ``ROLE``: what its class says. ``IN_CELLS``: the fields of a class that hold places, n × 2, (row, column) in cells.
    ``TIMES``: those that hold times, ps, besides ``time``.
    """

    ROLE: ClassVar[Role] = Role()
    IN_CELLS: ClassVar[tuple[str, ...]] = ()
    TIMES: ClassVar[tuple[str, ...]] = ()

    time: int
    source: str

    def moved(self, rows: int, columns: int) -> Self:
        """The record with all its places so many rows down and columns right: from a cropped map to the whole map."""
        if not (self.IN_CELLS and (rows or columns)):
            return self
        places = {name: vars(self)[name] for name in self.IN_CELLS}
        return replace(self, **{name: here + np.array([rows, columns], here.dtype) for name, here in places.items()})

    @classmethod
    def called(cls) -> str:
        """The name of the class in one word, such as ``visits``."""
        return cls.__name__.removesuffix("Record").lower()

    def between(self) -> tuple[int, int]:
        """The times at which it began and ended, ps."""
        return getattr(self, self.ROLE.begin), getattr(self, self.ROLE.end)

    def described(self) -> tuple[str, str]:
        """The event and its details, on one line of a terminal."""
        values = [
            f"{item.name} {printable(str(getattr(self, item.name)), 40)}"
            for item in fields(self)
            if item.name not in ("time", "source") and not isinstance(getattr(self, item.name), np.ndarray)
        ]
        return self.called(), ", ".join(values)

    def acts(self) -> Iterable[Activity]:
        """The spans, marks and values that it says."""
        role, own = self.ROLE, vars(self)
        if role.work is None:
            return ()
        where, name = role.lane.format_map(own), role.label.format_map(own)
        outcome = own.get("outcome", ENDED)
        return (
            Span(
                role.work, self.source, where, name, *self.between(), self.told(),
                outcome="" if outcome == ENDED else outcome,
            ),
        )  # fmt: skip

    def told(self) -> dict[str, Detail]:
        """The details that are told with its span, by name."""
        return {name: vars(self)[name] for name in self.ROLE.counts}

    def lasted(self) -> Iterable[tuple[str, int]]:
        """The names and durations (ps) of what it tells besides its spans."""
        return ()

    def signals(self) -> Mapping[str, Sequence[Change]]:
        """The numbers that changed in its time, by name: (time in ps, new value) each."""
        return {}

    def bare(self) -> Self:
        """The record without a grid that may be left out: an array of 0 × 0 in its place."""
        grid: dict[str, Any] = {self.ROLE.spare_grid: np.zeros((0, 0))}
        return replace(self, **grid) if self.ROLE.spare_grid else self

    def singles(self) -> Iterator[Record]:
        """A record for each thing that it says."""
        yield self


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

    ROLE = Role(Subject.MAP, grid="free", of_run=True)
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

    def described(self) -> tuple[str, str]:
        """Its size, and how much of it is free."""
        rows, columns = self.free.shape
        scale = "" if self.resolution is None else f", {self.resolution:g} m a cell"
        part = f" from {self.corner} on" if any(self.corner) else ""
        cells = f"{rows} × {columns} cells{part}, {format_count(int(self.free.sum()))} free"
        return "map", f"{cells}, {counted(len(self.goals), 'goal')}{scale}"


@dataclass(frozen=True)
class TaskRecord(Record):
    """A task that ran on ``source`` from ``time`` to ``end`` (ps), for ``cycles`` clock cycles.

    ``outcome``: "ended"; "preempted", where a more urgent task took its core at ``end``, and its next record goes on;
    "broken off", where it was interrupted at ``end``; or "unfinished", where the run ended first.
    """

    ROLE = Role(level=Level.MESSAGES, end="end", work="task", label="{task}", counts=("cycles",))
    TIMES = ("end",)

    task: str
    end: int
    cycles: int
    outcome: str = ENDED

    def described(self) -> tuple[str, str]:
        """Its cycles, and how it ended if not by itself."""
        outcome = "" if self.outcome == ENDED else f", {printable(self.outcome, 40)}"
        return f"task {self.task}", f"{counted(self.cycles, 'cycle')}{outcome}"


@dataclass(frozen=True)
class MessageRecord(Record):
    """A message over link ``source``: asked for at ``time``, first on the wire at ``begin``, delivered at ``end`` (ps).

    ``outcome``: "delivered" or "dropped". For a dropped message ``reason`` says why, and ``end`` is when it was given
    up (``begin`` too, where it never was on the wire). ``bits``: of the sender, without framing and checksum.
    ``attempts``: how often it was on the wire. ``damaged``: it was delivered with wrong bits that were not detected.
    """

    ROLE = Role(
        level=Level.MESSAGES, begin="begin", end="end",
        work="message", lane="{source}: {sender} to {receiver}", label="{name}",
    )  # fmt: skip
    TIMES = ("begin", "end")

    sender: str
    receiver: str
    name: str
    bits: int
    begin: int
    end: int
    outcome: str = DELIVERED
    reason: str | None = None
    attempts: int = 1
    damaged: bool = False

    def described(self) -> tuple[str, str]:
        """Its ends and size, how long it waited, and what became of it."""
        waited = self.begin - self.time
        details = f"{printable(self.sender, 40)} to {printable(self.receiver, 40)}, {format_data(self.bits)}"
        details += f", waited {format_time(waited)}" if waited else ""
        details += f", {self.attempts} attempts" if self.attempts > 1 else ""
        details += ", damage not detected" if self.damaged else ""
        if self.outcome != DELIVERED:
            details += f", {printable(self.outcome, 40)}: {printable(self.reason or 'no reason', 120)}"
        return f"message {self.name}", details

    def acts(self) -> Iterable[Activity]:
        """A span in which it waits for the link, and one in which it is on the wire."""
        link, ends, role, own = self.source, (self.sender, self.receiver), self.ROLE, vars(self)
        if self.begin > self.time:
            yield Span("wait", link, f"{link}: waiting", self.name, self.time, self.begin, {}, *ends)
        details: dict[str, Detail] = {"from": self.sender, "to": self.receiver}
        details |= {name: own[name] for name in ("bits", "outcome", "attempts")}
        details |= {} if self.reason is None else {"reason": self.reason}
        lane, outcome = role.lane.format_map(own), "" if self.outcome == DELIVERED else self.outcome
        yield Span("message", link, lane, self.name, *self.between(), details, *ends, outcome)


@dataclass(frozen=True)
class VisitsRecord(Record):
    """Consecutive visits of one stage, coalesced: ``time`` is the start of the first, ``end`` the end of the last (ps).

    ``block``: int32, the raster number of each visited block. ``iterations``: int32, its iterations, including the last
    one, which changes nothing. A visit takes iterations × (``precision`` + 2) cycles.
    """

    ROLE = Role(
        level=Level.BLOCKS, end="end", work="visits", lane="{source}: visits", label="stage {stage}",
        alike={"block": "blocks", "iterations": "iterations"},
    )  # fmt: skip
    TIMES = ("end",)

    end: int
    stage: int
    precision: int
    block: Counts
    iterations: Counts

    def described(self) -> tuple[str, str]:
        """The numbers of visits, of blocks and of iterations."""
        details = f"p = {self.precision}: {counted(self.block.size, 'visit')}"
        if self.block.size:
            each, blocks = self.iterations, counted(len(np.unique(self.block)), "block")
            total = counted(int(each.sum(dtype=np.int64)), "iteration")
            details += f" of {blocks}, {total}, {each.min()} to {each.max()} each"
        return f"visits of stage {self.stage}", details

    def told(self) -> dict[str, Detail]:
        """The precision, and the numbers of visits and iterations."""
        total = int(self.iterations.sum(dtype=np.int64))
        return {"precision": self.precision, "visits": len(self.block), "iterations": total}

    def _times(self) -> list[int]:
        """The begin of each visit and the end of the last, ps, rounded down: all iterations take equally long."""
        # Whole numbers of Python: a product of ps and iterations may have more than 64 bits.
        done = np.concatenate([[0], np.cumsum(self.iterations, dtype=np.int64)]).tolist()
        return [self.time + (self.end - self.time) * each // max(1, done[-1]) for each in done]

    def signals(self) -> Mapping[str, Sequence[Change]]:
        """The block of each visit, and its iterations."""
        begins = self._times()[:-1]
        return {
            "block": list(zip(begins, self.block.tolist(), strict=True)),
            "iterations": list(zip(begins, self.iterations.tolist(), strict=True)),
        }

    def singles(self) -> Iterator[Record]:
        """A record for each visit."""
        for place, (begin, end) in enumerate(pairwise(self._times())):
            part = slice(place, place + 1)
            yield replace(self, time=begin, end=end, block=self.block[part], iterations=self.iterations[part])


@dataclass(frozen=True)
class StageRecord(Record):
    """A stage that converged at ``time``, with its costs and the potential it left.

    ``potential``: float64 array, rows × columns, the exact field rounded for display. It is not the result. The trace
    of a mission leaves it out: 0 × 0.
    """

    ROLE = Role(
        Subject.STAGE, Level.BLOCKS, begin="begin", work="stage", lane="{source}: stages", label="stage {stage}",
        counts=("precision", "sweeps", "iterations", "cycles", "local_maxima"), grid="potential",
    )  # fmt: skip
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

    def described(self) -> tuple[str, str]:
        """Its costs, and the local maxima that it left."""
        names = ("sweep", "visit", "iteration", "cycle")
        costs = [counted(vars(self)[f"{name}s"], name) for name in names if vars(self)[f"{name}s"]]
        left = counted(self.local_maxima, "local maximum", "local maxima")
        return f"stage {self.stage}", f"p = {self.precision}: {', '.join(costs)}; {left}"


@dataclass(frozen=True)
class FieldRecord(Record):
    """A field that a planner left: one value a cell, ``values``, float64 array, rows × columns.

    ``name``: the quantity (``distance``, ``potential``, ``arrival``). ``unit``: its unit (``cells``, ``steps``, ``1``).
    A cell without a value, such as one that no wave reached, has NaN or infinity. The field is rounded for display. The
    trace of a mission leaves it out: 0 × 0.
    """

    ROLE = Role(Subject.FIELD, Level.BLOCKS, grid="values")

    name: str
    unit: str
    values: ValueGrid

    def described(self) -> tuple[str, str]:
        """The number of cells with a value, and the span of the values."""
        if not self.values.size:
            return f"field {self.name}", "its values are left out in a mission"
        values = self.values[np.isfinite(self.values)]
        unit = "" if self.unit in ("", "1") else f" {printable(self.unit, 40)}"
        span = f", {values.min():.4g} to {values.max():.4g}{unit}" if values.size else ""
        return f"field {self.name}", f"{format_count(values.size)} cells with a value{span}"

    def acts(self) -> Iterable[Activity]:
        """A mark."""
        return (Mark(self.time, self.source, f"field {self.name}"),)


@dataclass(frozen=True)
class TrajectoryRecord(Record):
    """The way from one start to a goal: ``points``, float64 n × 2, (row, column) in cells; ``arrived`` or not."""

    ROLE = Role(Subject.PATH, of_run=True)
    IN_CELLS = ("points",)

    points: Points
    arrived: bool

    def described(self) -> tuple[str, str]:
        """Its ends, its length, and whether it arrives."""
        if not len(self.points):
            return "trajectory", "empty"
        with np.errstate(all="ignore"):
            steps = np.diff(self.points, axis=0)
            length = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
        ends = " to ".join(f"({row:.4g}, {column:.4g})" for row, column in self.points[[0, -1]])
        how = "arrives" if self.arrived else "does not arrive"
        return "trajectory", f"{ends}, {length:.4g} cells long, {how}"


@dataclass(frozen=True)
class RobotRecord(Record):
    """The robot ``source`` at the begin of a drive: its ``radius`` (m), its greatest ``speed`` (m/s), and its sensor.

    ``reach``: of the sensor, m. ``rays``: how many rays it has over the full circle; 0 for a sensor of a radius.
    ``hidden``: int32 n × 2, (row, column), obstacles that the robot's map does not show. ``knows``: whether it has a
    map at the begin.
    """

    ROLE = Role(Subject.ROBOT)
    IN_CELLS = ("hidden",)

    radius: float
    speed: float
    reach: float
    rays: int
    hidden: Cells
    knows: bool

    def described(self) -> tuple[str, str]:
        """Its size, speed and sensor."""
        rays = counted(self.rays, "ray") if self.rays else "all within a radius"
        body = f"radius {self.radius:.4g} m, at most {self.speed:.4g} m/s"
        return "robot", f"{body}, sees {self.reach:.4g} m with {rays}"


@dataclass(frozen=True)
class GoalRecord(Record):
    """The goal of robot ``source`` from now on: any of ``cells``, int32 n × 2, (row, column).

    It has no cells if the robot chooses its goals itself.
    """

    ROLE = Role(Subject.GOALS)
    IN_CELLS = ("cells",)

    cells: Cells

    def described(self) -> tuple[str, str]:
        """The first of its cells."""
        cells = ", ".join(f"({row}, {column})" for row, column in self.cells[:3].tolist())
        more = f" and {len(self.cells) - 3} more" if len(self.cells) > 3 else ""
        return "goal", f"{cells}{more}" if cells else "the robot chooses its goals"


@dataclass(frozen=True)
class PoseRecord(Record):
    """The pose of a robot: ``row`` and ``column`` in cells (whole numbers are middles), ``heading`` in radians from the
    direction of growing columns towards growing rows, ``speed`` in m/s."""

    ROLE = Role(Subject.POSE)

    row: float
    column: float
    heading: float
    speed: float

    def moved(self, rows: int, columns: int) -> Self:
        """The record with its place so many rows down and columns right."""
        if not (rows or columns):
            return self
        return replace(self, row=self.row + rows, column=self.column + columns)

    def described(self) -> tuple[str, str]:
        """Its place and speed."""
        return "pose", f"row {self.row:.2f}, column {self.column:.2f}, {self.speed:.3g} m/s"

    def acts(self) -> Iterable[Activity]:
        """The speed from now on."""
        return (Value(self.time, f"{self.source}: speed", self.speed, "m/s"),)


@dataclass(frozen=True)
class ObstacleRecord(Record):
    """Cells of the true map that became an obstacle (``appeared``) or free again: int32 n × 2, (row, column)."""

    ROLE = Role(Subject.CHANGE)
    IN_CELLS = ("cells",)

    cells: Cells
    appeared: bool

    def described(self) -> tuple[str, str]:
        """The number of cells that changed, and how."""
        return ("obstacle", f"{counted(len(self.cells), 'cell')} {'blocked' if self.appeared else 'free again'}")


@dataclass(frozen=True)
class BeliefRecord(Record):
    """The cells that the robot learnt: ``cells``, int32 n × 2, (row, column), and ``blocked``, bool, one each.

    ``seen``: the time of the scan that showed the cells, ps; None in files without it.
    """

    ROLE = Role(Subject.BELIEF, alike={"cells": "cells", "blocked": "blocked flags"})
    IN_CELLS = ("cells",)
    TIMES = ("seen",)

    cells: Cells
    blocked: Flags
    seen: int | None = None

    def described(self) -> tuple[str, str]:
        """The number of cells that it learnt."""
        blocked = format_count(int(self.blocked.sum()))
        return "belief", f"{counted(len(self.cells), 'cell')} learnt, {blocked} blocked"


@dataclass(frozen=True)
class PlanRecord(Record):
    """A plan of a drive that is ready at ``time``; ``source`` made it. All times in ps.

    ``number``: counts the plans of the drive from 1. ``asked``: the time of the map of the plan. ``seen``: the time of
    the last scan in that map. ``loaded``: when the map had reached the planner. ``planned``: when the plan was
    complete.
    """

    ROLE = Role(Subject.PLAN, begin="asked")
    TIMES = ("asked", "seen", "loaded", "planned")

    number: int
    asked: int
    seen: int
    loaded: int
    planned: int

    def described(self) -> tuple[str, str]:
        """Its number, and its last scan."""
        return f"plan {self.number}", f"last scan at {format_time(self.seen)}"


@dataclass(frozen=True)
class CommandRecord(Record):
    """A command that robot ``source`` takes up at ``time`` (ps), as it arrived.

    ``plan``: the number of its plan. ``seen``: the time of its scan, ps. ``composed``: when it was made and given to
    the links, ps. ``points``: the path, float64 n × 2, (row, column) in cells, from the position of the robot at
    ``seen``. ``end``: the arc length of the path, cells, at which the robot is to stop.
    """

    ROLE = Role(level=Level.MESSAGES, begin="composed")
    IN_CELLS = ("points",)
    TIMES = ("seen", "composed")

    plan: int
    seen: int
    composed: int
    points: Points
    end: float

    def described(self) -> tuple[str, str]:
        """Its plan and scan, and how far the robot is to drive."""
        seen = format_time(self.seen)
        return "command", f"plan {self.plan}, seen at {seen}, to drive {self.end:.4g} cells"

    def lasted(self) -> Iterable[tuple[str, int]]:
        """The age of its scan."""
        return (("from the scan to the command", self.time - self.seen),)


@dataclass(frozen=True)
class MissionRecord(Record):
    """Something that happened in a mission: ``event`` names its kind, ``text`` says what.

    Events: ``plan_requested``, ``plan_ready``, ``no_way``, ``deadline_missed``, ``safety_stop``, ``contact``,
    ``obstacle_waits``, ``goal_reached``, ``livelock``, ``ended``.
    """

    ROLE = Role(Subject.EVENT, of_run=True)

    event: str
    text: str

    def described(self) -> tuple[str, str]:
        """Its kind, and what it says."""
        return self.event.replace("_", " "), printable(self.text, 200)

    def acts(self) -> Iterable[Activity]:
        """A mark over all rows. It begins or ends the time in which the robot waits for a plan."""
        asks, answers = self.event == "plan_requested", self.event in ("plan_ready", "no_way", "ended")
        name, told = self.event.replace("_", " "), {"source": self.source, "text": self.text}
        return (Mark(self.time, "", name, told, self.source, "asked" if asks else "answered" if answers else ""),)


@dataclass(frozen=True)
class PositionsRecord(Record):
    """The positions of all robots after an update: ``positions``, float64 n × 2, (row, column) in cells."""

    ROLE = Role(Subject.FLEET)
    IN_CELLS = ("positions",)

    update: int
    positions: Points

    def described(self) -> tuple[str, str]:
        """The number of robots."""
        return f"update {self.update}", counted(len(self.positions), "robot")


@dataclass(frozen=True)
class ScanRecord(Record):
    """The measurement of a sensor of rays: ``ranges``, float32, cells along each ray to the obstacle that ended it.

    A drive records one scan each 5 s, its ranges rounded to 1/64 of a cell. Ray i of n points 2π i / n from the
    direction of growing columns towards growing rows. A ray that met no obstacle within ``reach`` (cells) has
    infinity. ``row``, ``column``: where the sensor was, cells.
    """

    ROLE = Role(Subject.SCAN, Level.MESSAGES)

    row: float
    column: float
    reach: float
    ranges: Ranges

    def moved(self, rows: int, columns: int) -> Self:
        """The record with its place so many rows down and columns right."""
        return replace(self, row=self.row + rows, column=self.column + columns)

    def described(self) -> tuple[str, str]:
        """The number of its rays that met obstacles."""
        met, where = int(np.isfinite(self.ranges).sum()), f"row {self.row:.2f}, column {self.column:.2f}"
        return "scan", f"{counted(len(self.ranges), 'ray')} at {where}, {met} met obstacles"


@dataclass(frozen=True)
class SampleRecord(Record):
    """A quantity of ``source`` from its last sample up to ``time``: its greatest value, or its share, in ``unit``.

    Quantities: ``queue`` (messages at a link, waiting or on the wire), ``fifo.SENDER`` (words in the FIFO of a sender
    at a link), ``busy`` (share of that time in which ``source`` was busy, 0 to 1). A sample is made at a change, but at
    most each 1 us, and each 64th of the time up to then. A value that stays is not repeated.
    """

    ROLE = Role(level=Level.MESSAGES)

    quantity: str
    unit: str
    value: float

    def described(self) -> tuple[str, str]:
        """Its quantity and value."""
        unit = "" if self.unit == "1" else f" {printable(self.unit, 40)}"
        return "sample", f"{printable(self.quantity, 60)} {self.value:.4g}{unit}"


@dataclass(frozen=True)
class UtilisationRecord(Record):
    """The busy time of ``source`` in a span: ``busy`` of ``span`` picoseconds, the span ending at ``time``."""

    ROLE = Role()

    busy: int
    span: int

    def described(self) -> tuple[str, str]:
        """The busy time, and its share."""
        share = f"{self.busy / self.span:.1%} of {format_time(self.span)}" if self.span > 0 else "no time"
        return "utilisation", f"busy {format_time(self.busy)}, {share}"


@dataclass(frozen=True)
class SummaryRecord(Record):
    """The result of the run, as the JSON-ready mapping that ``hwsw run --json`` prints."""

    ROLE = Role(Subject.RESULT, of_run=True)

    result: dict[str, Any]

    def described(self) -> tuple[str, str]:
        """The number of its figures."""
        return "result", counted(len(self.result), "figure")


RECORD_TYPES: dict[str, type[Record]] = {kind.__name__: kind for kind in Record.__subclasses__()}
"""Every class of record by its name: the classes that a reader can decode."""

ACTIVITY_KINDS = tuple(kind for kind in RECORD_TYPES.values() if kind.ROLE.work or kind.acts is not Record.acts)
"""The records that say what is done when."""


def kinds_about(*subjects: Subject) -> tuple[type[Record], ...]:
    """The classes of the records that are about one of these."""
    return tuple(kind for kind in RECORD_TYPES.values() if kind.ROLE.about in subjects)


R = TypeVar("R", bound=Record)


class Listener(Protocol):
    """Receives every record of a run, in the order of emission."""

    def __call__(self, record: Record) -> None:
        """Take one record."""


class MemoryListener:
    """Keeps the records of a run in the order of emission, in ``records``."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def __call__(self, record: Record) -> None:
        """Keep one record."""
        self.records.append(record)

    def of(self, record_type: type[R]) -> list[R]:
        """The records of one class, in the order of emission."""
        return [record for record in self.records if isinstance(record, record_type)]


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
    each = [getattr(item, "unwanted", frozenset[type[Record]]()) for item in listeners]
    return frozenset.intersection(*each) if each else frozenset()


def recorded_by(listeners: Sequence[Listener], kind: type[Record]) -> bool:
    """True if a ``Recorder`` wants records of this class. Samples are made for recorders alone."""
    return any(kind not in getattr(item, "unwanted", (kind,)) for item in listeners)
