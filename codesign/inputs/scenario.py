"""The scenario of a workload: what the plan is used for."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, ClassVar, Literal, Self, TypeVar

from pydantic import Field, model_validator

from codesign.ground.models import RefusalError, SpecModel, choice
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.fields import Cell, Duration, Length, Name, Speed

MAX_OBSTACLES = 10_000
MAX_TOUR = 10_000

Count = Annotated[int, Field(ge=1, le=4096)]
Seed = Annotated[int, Field(ge=0, le=2**63 - 1)]

_MILLISECOND = PICOSECONDS_PER_SECOND // 1000
_MINUTE = 60 * PICOSECONDS_PER_SECOND


class _Scenario(SpecModel):
    """A scenario. ``tasks``: those that it adds to the planner's, in the order in which data flow through them."""

    tasks: ClassVar[tuple[str, ...]]


class PlanOnce(_Scenario):
    """One plan, from a map that does not change."""

    tasks = ("load", "command")

    type: Literal["plan_once"] = Field(default="plan_once", description="One plan, from a map that does not change.")


class Rectangle(SpecModel):
    """A rectangle of cells."""

    row: Annotated[int, Field(ge=0)] = Field(description="Its first row.")
    column: Annotated[int, Field(ge=0)] = Field(description="Its first column.")
    rows: Count = Field(default=1, description="How many rows.")
    columns: Count = Field(default=1, description="How many columns.")


R = TypeVar("R", bound=Rectangle)


class AppearingObstacle(Rectangle):
    """Cells that become an obstacle at some time."""

    at: Duration = Field(description="When it appears.")
    until: Duration | None = Field(default=None, description="When it disappears. Without it, it stays.")

    @model_validator(mode="after")
    def _goes_later(self) -> Self:
        if self.until is not None and self.until <= self.at:
            raise RefusalError("it is gone before it appears", "give a later time, or none", ("until",))
        return self


class MovingObstacle(SpecModel):
    """A rectangle that moves to and fro along a route, and waits for the robot."""

    size: tuple[Count, Count] = Field(default=(1, 1), description="Its rows and columns.")
    route: Annotated[tuple[Cell, ...], Field(min_length=2, max_length=1000)] = Field(
        description="Cells of its first row and column: it moves straight from one to the next, then back."
    )
    speed: Speed = Field(description="How fast it moves.")
    begin: Duration = Field(default=0, description="When it begins to move.")

    @model_validator(mode="after")
    def _goes(self) -> Self:
        if self.speed <= 0:
            raise RefusalError("an obstacle with a speed of 0 does not move", "list it as appearing", ("speed",))
        return self


class RandomObstacles(SpecModel):
    """Squares that appear at random times and places."""

    count: Annotated[int, Field(ge=1, le=MAX_OBSTACLES)] = Field(description="How many obstacles.")
    size: Count = Field(default=1, description="Side of each, cells.")
    begin: Duration = Field(default=0, description="When the first one may appear.")
    end: Duration = Field(description="When the last one has appeared.")
    stay: Duration | None = Field(default=None, description="How long each stays. Without it, they stay.")
    seed: Seed = Field(default=0, description="Chooses when and where.")

    @model_validator(mode="after")
    def _span(self) -> Self:
        if self.end < self.begin:
            raise RefusalError("the end lies before the begin", "give a later end", ("end",))
        if self.stay == 0:
            raise RefusalError("a stay of no time", "give a time above 0, or none: for good", ("stay",))
        return self


class Obstacles(SpecModel):
    """Obstacles that appear after the start."""

    appearing: Annotated[tuple[AppearingObstacle, ...], Field(max_length=MAX_OBSTACLES)] = Field(
        default=(), description="Obstacles that appear at given times."
    )
    moving: Annotated[tuple[MovingObstacle, ...], Field(max_length=MAX_OBSTACLES)] = Field(
        default=(), description="Obstacles that move."
    )
    random: RandomObstacles | None = Field(default=None, description="Obstacles that appear at random.")


class ReplanPolicy(StrEnum):
    """The state that a new plan starts from."""

    RESTART = "restart"
    LOWER_BOUND = "lower_bound"
    CONTINUE = "continue"


class ReplanTrigger(StrEnum):
    """The event that asks for a new plan."""

    BLOCKED = "blocked"
    CHANGE = "change"


class WhenBusy(StrEnum):
    """The fate of a plan under way when a newer one is asked for."""

    FINISH = "finish"
    RESTART = "restart"


class Replan(SpecModel):
    """The rules of a new plan: its trigger, and its start."""

    policy: ReplanPolicy | None = Field(
        default=None,
        description="What a new plan begins with. restart: nothing; lower_bound: a start from below, which task"
        " lower_bound makes; continue: the old values. Without it, the planner's first policy.",
    )
    trigger: ReplanTrigger = Field(
        default=ReplanTrigger.BLOCKED,
        description="When a new plan is asked for. blocked: when something new lies on the path; change: when"
        " anything new was seen.",
    )
    when_busy: WhenBusy = Field(
        default=WhenBusy.FINISH,
        description="What happens to a plan under way. finish: it is ended first; restart: it is broken off. Where"
        " something new is seen more often than a plan is made, restart never ends a plan.",
    )


class _Mission(_Scenario):
    limit: Duration = Field(default=60 * _MINUTE, description="Simulated time after which the mission is given up.")
    events: Annotated[int, Field(ge=1, le=10**10)] = Field(
        default=2_000_000,
        description="Events after which the mission is given up: messages, plans asked for, changes of the world, 20"
        " for each turn of a drive; messages and single decisions of a fleet.",
    )


class Drive(_Mission):
    """One robot senses, plans, drives, discovers and plans again."""

    tasks = ("sense", "load", "command", "move", "display")

    type: Literal["drive"] = Field(description="One robot senses, plans, drives, discovers and plans again.")
    robot: Name | None = Field(
        default=None, description="Name of the robot that drives. Without it, the only one of the platform."
    )
    purpose: Literal["reach", "explore"] = Field(
        default="reach",
        description="reach: drive to the goals; explore: drive to the frontiers of the known map until none can be"
        " reached.",
    )
    known: Literal["all", "none"] = Field(default="all", description="What the robot knows of the map at the start.")
    hidden: Annotated[tuple[Rectangle, ...], Field(max_length=MAX_OBSTACLES)] = Field(
        default=(), description="Obstacles that are there from the start, and that the robot does not know."
    )
    resolution: Length | None = Field(
        default=None, description="Metres a cell. It is required where the map does not say it."
    )
    control_period: Duration = Field(
        default=100 * _MILLISECOND, description="Time between two turns of the control loop."
    )
    deadline: Duration = Field(
        default=300 * _MILLISECOND,
        description="Time in which a turn must have its answer. Otherwise the turn is missed, and the robot brakes.",
    )
    tour: Annotated[tuple[Cell, ...], Field(max_length=MAX_TOUR)] = Field(
        default=(), description="Further goals, one after another, once the first is reached."
    )
    tour_times: Annotated[tuple[Duration, ...], Field(max_length=MAX_TOUR)] = Field(
        default=(),
        description="When each goal of the tour is given, at the earliest: until then the robot waits at the goal"
        " before. Without it, each is given when the one before is reached.",
    )
    obstacles: Obstacles = Field(default=Obstacles(), description="Obstacles that come after the start.")
    replan: Replan = Field(default=Replan(), description="When and how a new plan is made.")
    patience: Duration = Field(
        default=30 * PICOSECONDS_PER_SECOND,
        description="How long the robot may stand without a path before the mission is given up.",
    )

    def moved(self, rows: int, columns: int) -> Self:
        """The drive with all its cells so many rows up and columns to the left, as on a cropped map.

        It is not validated: a cell outside of the cropped map has negative numbers, or ones that are too large.
        """
        if not (rows or columns):
            return self

        def cells(places: tuple[Cell, ...]) -> tuple[Cell, ...]:
            return tuple((row - rows, column - columns) for row, column in places)

        def rectangles(places: tuple[R, ...]) -> tuple[R, ...]:
            return tuple(
                each.model_copy(update={"row": each.row - rows, "column": each.column - columns}) for each in places
            )

        obstacles = self.obstacles
        moving = tuple(each.model_copy(update={"route": cells(each.route)}) for each in obstacles.moving)
        changes = {"appearing": rectangles(obstacles.appearing), "moving": moving}
        return self.model_copy(
            update={
                "tour": cells(self.tour),
                "hidden": rectangles(self.hidden),
                "obstacles": obstacles.model_copy(update=changes),
            }
        )

    @model_validator(mode="after")
    def _sound_times(self) -> Self:
        if self.control_period < 1_000_000:
            raise RefusalError("a control period below 1 us", "give 1 us or more", ("control_period",))
        if self.resolution is not None and self.resolution <= 0:
            raise RefusalError("a resolution of 0", "metres a cell, above 0", ("resolution",))
        if self.tour_times and len(self.tour_times) != len(self.tour):
            what = f"{len(self.tour_times)} times for {len(self.tour)} goals of the tour"
            raise RefusalError(what, "give each goal of the tour its time, or none", ("tour_times",))
        return self


class Fleet(_Mission):
    """Many robots, each with an FPGA of its own, update by update. A line carries all coordinates to a display."""

    tasks = ("load", "command", "display")

    type: Literal["fleet"] = Field(description="Robots with an FPGA each, update by update.")
    pace: Literal["real_time", "free_running"] = Field(
        default="real_time",
        description="real_time: an update in each time step of the planner, and decisions that take longer act late;"
        " free_running: simulated robots, as fast as FPGAs and line allow.",
    )
    report: Literal["all", "none"] = Field(
        default="all", description="Whether the coordinates of each update are sent to the component of task display."
    )


SCENARIOS: dict[str, type[_Scenario]] = {"plan_once": PlanOnce, "drive": Drive, "fleet": Fleet}
Scenario = Annotated[PlanOnce | Drive | Fleet, choice("type", SCENARIOS)]
