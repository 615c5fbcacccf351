"""What a run, or a point of an exploration, comes to: named figures with units.

``hwsw run --json`` prints a ``Result``; ``hwsw schema result`` prints its JSON Schema. Times are integer picoseconds.
A design that does not fit is a result too: ``feasible`` is false, ``reasons`` says by what and what would mend it, and
the figures that only a run gives are None.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from codesign.figures import Status, label
from codesign.planners.interface import Quality, RobotsQuality
from codesign.spec.exploration import ResultFigure
from codesign.system.mission_result import LinkUse, Mission
from codesign.system.scenarios.fleet_figures import FleetFigures


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)


class Source(_Model):
    """Where a figure comes from, with its interval where a law was fitted or a value assumed."""

    value: float
    unit: str
    status: Status
    source: str
    low: float
    high: float


class ResourceItem(_Model):
    """One line of a demand."""

    name: str
    amount: int
    status: Status
    source: str


class ResourceUse(_Model):
    """One kind of resource of the part, asked for and there; ``gap`` = demand - budget, 0 where it fits."""

    resource: str
    demand: int
    budget: int
    gap: int
    items: tuple[ResourceItem, ...]


class Reason(_Model):
    """Why a design point cannot be built, or is not wanted: ``demand`` passes ``limit`` by ``gap``.

    All three are in ``unit``; what is whole, as counts are, is an integer.
    """

    kind: Literal["resource", "bound", "clock", "constraint", "mapping"]
    name: str
    demand: int | float
    limit: int | float
    gap: int | float
    unit: str
    levers: tuple[str, ...] = ()

    @field_validator("demand", "limit", "gap")
    @classmethod
    def _whole_as_integer(cls, value: int | float) -> int | float:
        # Above 2^53 a double is whole only because it is too coarse to be anything else.
        return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 2**53 else value

    def __str__(self) -> str:
        text = f"{label(self.name)}: {self.demand:g} against {self.limit:g} {self.unit}".rstrip()
        return f"{text} ({'; '.join(self.levers)})" if self.levers else text


class StageUse(_Model):
    """One stage of the relaxation; ``cycles`` = iterations × (precision + 2), block switches left out."""

    stage: int
    precision: int
    sweeps: int
    visits: int
    iterations: int
    cycles: int
    local_maxima: int


class Times(_Model):
    """When things were done, in ps from the start of the run.

    ``map_loaded_ps``: the map stands in the component that plans. ``planned_ps``: the plan stands. ``first_plan_ps``:
    the first decision reached the one who asked.
    """

    map_loaded_ps: int
    planned_ps: int
    first_plan_ps: int


class Clock(_Model):
    """The clock the design runs at and the fastest that the law of its size and the part allow, Hz."""

    hz: int
    limit: Source


class Power(_Model):
    """Power while planning, W."""

    static: Source
    dynamic: Source


class Energy(_Model):
    """Energy up to the first plan, J: static power over the whole time, dynamic power over the busy time."""

    fpga_j: float
    processors_j: float
    links_j: float = 0.0
    memories_j: float = 0.0
    total_j: float


class Result(_Model):
    """All the figures of one design point on one workload."""

    schema_version: Literal[1] = 1
    platform: str
    workload: str
    planner: str
    style: str
    component: str
    places: dict[str, str] = Field(default={}, description="component of each task")
    external_memory: str | None = Field(
        default=None, description="the memory beside the FPGA that holds what does not fit in block RAM"
    )
    part: str | None
    parameters: dict[str, dict[str, Any]] = Field(description="parameters of each task")
    blocks: int | None = Field(default=None, description="number of blocks of the partition")
    feasible: bool
    reasons: tuple[Reason, ...] = ()
    resources: tuple[ResourceUse, ...] = ()
    clock: Clock | None = None
    power: Power | None = None
    processor: dict[str, Source] = Field(
        default={}, description="cost of the kernel (ps a unit) and power (W) of the processor that plans"
    )
    time: Times | None = None
    cycles: dict[str, int] | None = Field(
        default=None,
        description="clock cycles of the planning component by phase; of a fleet those of the first robot's board",
    )
    stages: tuple[StageUse, ...] | None = None
    precision: int | None = Field(default=None, description="fractional bits of the final field")
    energy: Energy | None = None
    utilisation: dict[str, float] | None = Field(
        default=None,
        description="busy share of each component and link; of a fleet's FPGAs that of the first robot's board",
    )
    links: dict[str, LinkUse] | None = Field(default=None, description="messages of each link")
    quality: Quality | RobotsQuality | None = None
    mission: Mission | None = Field(default=None, description="figures of a drive")
    fleet: FleetFigures | None = Field(default=None, description="figures of a fleet")
    details: dict[str, float | str] = Field(default={}, description="figures that only this planner has")

    def figure(self, name: ResultFigure) -> float | None:
        """One figure by the name that objectives and constraints use, in the unit of ``ResultFigure``; None: no run."""
        resources = {use.resource: float(use.demand) for use in self.resources}
        if name.value in resources:
            return resources[name.value]
        grid = self.quality if isinstance(self.quality, Quality) else None
        robots = self.quality if isinstance(self.quality, RobotsQuality) else None
        figures: dict[ResultFigure, float | None] = {
            ResultFigure.TIME: None if self.time is None else self.time.first_plan_ps / 1e12,
            ResultFigure.CYCLES: None if self.cycles is None else float(sum(self.cycles.values())),
            ResultFigure.POWER: None
            if self.power is None
            else self.power.static.value + self.power.dynamic.value,
            ResultFigure.ENERGY: None if self.energy is None else self.energy.total_j,
            ResultFigure.PRECISION: None if self.precision is None else float(self.precision),
            ResultFigure.PATH_LENGTH_RATIO: None
            if self.quality is None
            else self.quality.path_length_ratio_mean,
        }
        if grid is not None:
            figures |= {
                ResultFigure.SHARE_REACHING_GOAL: grid.share_reaching_goal,
                ResultFigure.LOCAL_MAXIMA: grid.local_maxima,
                ResultFigure.WRONG_CELLS: grid.wrong_cells,
                ResultFigure.CLEARANCE: grid.clearance_mean,
            }
        if robots is not None:
            figures |= {
                ResultFigure.COLLISIONS: robots.collisions,
                ResultFigure.CLOSEST_APPROACH: robots.closest_approach,
                ResultFigure.TIME_TO_TARGETS: robots.time_to_targets_s,
            }
        if self.mission is not None:
            figures |= self.mission.figures()
        value = figures.get(name)
        return None if value is None else float(value)
