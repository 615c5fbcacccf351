"""The named figures of a run, or of a point of an exploration, with their units.

``hwsw run --json`` prints a ``Result``; ``hwsw schema result`` prints its JSON Schema. Times are in seconds.
A design that does not fit is a result too: ``feasible`` is false, ``reasons`` says by what and what would mend it, and
the figures that only a run gives are None.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, field_validator

from codesign.ground.errors import clip
from codesign.ground.figures import FIGURES, Figure, ResultFigure, described, figure_of, label
from codesign.ground.notebooks import InNotebooks, data_frame
from codesign.inputs.derived import DerivedFigure, derived_interval
from codesign.planners.quality import Quality, RobotsQuality
from codesign.system.results.fleet import FleetFigures
from codesign.system.results.mission import LinkUse, Mission
from codesign.system.results.model import ResultModel
from codesign.system.results.provenance import Provenance
from codesign.system.results.task import TaskFigures
from codesign.system.results.terms import Terms

if TYPE_CHECKING:
    from pandas import DataFrame


class ResourceItem(ResultModel):
    """One line of a demand."""

    name: str = Field(description="what of the design it is for")
    figure: Figure = Field(description="how many, and by which law or table")


class ResourceUse(ResultModel):
    """One kind of resource of the part, asked for and there."""

    resource: str = Field(description="the kind, such as slices")
    demand: int = Field(description="how many the design takes")
    budget: int = Field(description="how many the part has")
    gap: int = Field(description="demand - budget where that is above 0, else 0")
    items: tuple[ResourceItem, ...] = Field(description="what the demand is made of")


class BoundUse(ResultModel):
    """A limit of the design that is no resource of the part, such as the memory of its processor."""

    name: str = Field(description="which limit")
    figure: Figure = Field(description="what the design comes to")
    limit: Figure = Field(description="what it may be, in the same unit")


class Reason(ResultModel):
    """The reason for which a design cannot be built, or is not wanted: ``demand`` passes ``limit`` by ``gap``.

    All three are in ``unit``; what is whole, as counts are, is an integer. Of a mapping, they are 1, 0 and 1: a
    platform cannot take the design, and ``name`` is the sentence that says why. If a constrained figure has no
    value, ``demand`` is 0, and ``name`` ends with the reason.
    """

    kind: Literal["resource", "bound", "clock", "constraint", "mapping", "quality"] = Field(
        description="what passes its limit: a resource, a bound of the design, a clock, a constraint, a mapping, or the"
        " quality of a plan"
    )
    name: str = Field(description="which of that kind")
    demand: int | float = Field(description="what it comes to, in unit")
    limit: int | float = Field(description="what it may be, in unit")
    gap: int | float = Field(description="by how much it passes the limit, in unit")
    unit: str = Field(description="unit of the three; empty for counts")
    levers: tuple[str, ...] = Field(default=(), description="what would mend it")

    @field_validator("demand", "limit", "gap")
    @classmethod
    def _whole_as_integer(cls, value: int | float) -> int | float:
        # Above 2^53 a double is whole only because it is too coarse to be anything else.
        return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 2**53 else value

    @property
    def words(self) -> str:
        """The fault in words, if it is no number; else "".

        >>> Reason(kind="constraint", name="cycles below: no such figure", demand=0, limit=9, gap=9, unit="").words
        'cycles below: no such figure'
        """
        if self.kind == "mapping":
            return self.name
        return label(self.name) if self.kind == "constraint" and ": " in self.name else ""

    def __str__(self) -> str:
        if self.words:
            return f"{self.words} ({'; '.join(self.levers)})" if self.levers else self.words
        text = f"{label(self.name)}: {self.demand:g} against {self.limit:g} {self.unit}".rstrip()
        return f"{text} ({'; '.join(self.levers)})" if self.levers else text


class StageUse(ResultModel):
    """One stage of the relaxation."""

    stage: int = Field(description="its number, from 0")
    precision: int = Field(description="fractional bits of its field")
    sweeps: int = Field(description="sweeps over all blocks until it settled")
    visits: int = Field(description="visits of single blocks")
    iterations: int = Field(description="iterations of the nodes, all visits together")
    cycles: int = Field(description="iterations × (precision + 2); block switches left out")
    local_maxima: int = Field(description="free cells without a path up at its end, pockets counted")
    promoted: bool = Field(
        default=False, description="whether it was left before it settled, after the sweeps of relax.promote"
    )


class Times(ResultModel):
    """The times of what was done for the first start, from the start of the run."""

    map_loaded_s: float = Field(title="map loaded", description="when the map stood in the component that plans, s")
    planned_s: float = Field(title="plan ready", description="when the plan stood, s")
    first_plan_s: float = Field(title="first decision received", description=described("first_plan_s"))


class Clock(ResultModel):
    """The clock of a design."""

    hz: int = Field(description="the clock that the design runs at, Hz")
    limit: Figure = Field(description="the fastest that the law of its size and the part allow, Hz")


class Power(ResultModel):
    """Power while planning, W."""

    static: Figure = Field(description="of the chip, whatever it does, W")
    dynamic: Figure = Field(description="of the design while it plans, W")


class Energy(ResultModel):
    """Energy a plan, J: static power over the whole time, dynamic power over the busy time.

    It is the mean over the starts; of a drive or a fleet, the energy of the whole run.
    """

    fpga_j: float = Field(
        title="FPGAs",
        description="of all FPGAs of the platform: static over the whole time, dynamic over the busy time, J",
    )
    idle_fpgas_j: float = Field(
        default=0.0, description="the part of it that FPGAs without any task drew: their static power, J"
    )
    processors_j: float = Field(description="of the processors, busy and idle, J")
    links_j: float = Field(default=0.0, description="of the links, busy and idle, J")
    memories_j: float = Field(default=0.0, description="of the external memories, busy and idle, J")
    energy_j: float = Field(description=described("energy_j", ": the sum of these"))
    not_declared: dict[str, tuple[str, ...]] = Field(
        default={},
        description="names of the links and memories whose power the platform does not declare: they count as 0 J",
    )


class DisplayUse(ResultModel):
    """The words that one display read from its memory."""

    frames: int = Field(description="frames drawn to their end")
    starved_words: int = Field(
        title="words that came too late", description="words that came too late to be drawn, as the memory is too slow"
    )
    port_share: float = Field(
        title="share of the memory's cycles",
        description="share of the memory's cycles that it took; 0 where it has a copy of its own",
    )


class Result(InNotebooks, ResultModel):
    """All the figures of one design point on one workload."""

    schema_version: Literal[2] = Field(default=2, description="version of this form")
    platform: str = Field(description="name of the platform")
    workload: str = Field(description="name of the workload")
    planner: str = Field(description="name of the planner")
    style: str = Field(description="architecture style of the planning task")
    component: str = Field(description="the component that plans")
    places: dict[str, str] = Field(default={}, description="component of each task")
    roles: dict[str, str] = Field(default={}, description="component or link of the platform that fills each role")
    external_memory: str | None = Field(
        default=None, description="the memory beside the FPGA that holds what does not fit in block RAM"
    )
    part: str | None = Field(description="part and speed grade of that component; None for a processor")
    parameters: dict[str, dict[str, Any]] = Field(description="parameters of each task, as the style runs with them")
    notes: tuple[str, ...] = Field(
        default=(),
        description="where the design does other work than its parameters let one expect, or its clock is not sure:"
        " key, then a sentence",
    )
    found: dict[str, dict[str, int | str | tuple[int, ...]]] = Field(
        default={},
        description="by task and parameter, a value that was left to a search, and the proof that no other is better",
    )
    blocks: int | None = Field(default=None, description="number of blocks of the partition")
    feasible: bool = Field(description="whether the design fits; where not, figures of a run are None")
    reasons: tuple[Reason, ...] = Field(default=(), description="why it does not fit, or is not wanted")
    resources: tuple[ResourceUse, ...] = Field(
        default=(), description="use of each kind of resource of the part; empty for a processor"
    )
    bounds: tuple[BoundUse, ...] = Field(
        default=(), description="limits of the design that are no resources of the part, met or not"
    )
    clock: Clock | None = Field(default=None, description="clock of the design, and its limit")
    power: Power | None = Field(default=None, description="power of the FPGA while it plans")
    idle_fpgas: dict[str, Figure] = Field(
        default={}, description="static power of each FPGA without any task, W; it is drawn all the time"
    )
    processor: dict[str, Figure] = Field(
        default={}, description="cost of the kernel (s a unit) and power (W) of the processor that plans"
    )
    task: TaskFigures | None = Field(
        default=None, description="what was asked, and the time from request to answer; None of a drive"
    )
    time: Times | None = Field(
        default=None, description="when things were done, up to the first plan: that for the first start"
    )
    cycles: dict[str, int] | None = Field(
        default=None,
        description="clock cycles of the planning component by phase, for the first start; of a fleet those of the"
        " first robot's board",
    )
    stages: tuple[StageUse, ...] | None = Field(
        default=None, description="stages of the relaxation, of planners that have them"
    )
    precision: int | None = Field(default=None, description=described("precision"))
    energy: Energy | None = Field(
        default=None, description="energy a plan, mean over the starts; of a drive or a fleet, of the whole run"
    )
    utilisation: dict[str, float] | None = Field(
        default=None,
        description="busy share of each component and link, for the first start; of a fleet's FPGAs that of the first"
        " robot's board",
    )
    links: dict[str, LinkUse] | None = Field(default=None, description="messages of each link, for the first start")
    displays: dict[str, DisplayUse] | None = Field(default=None, description="reads of each display")
    quality: Quality | RobotsQuality | None = Field(
        default=None,
        description="what the plan is worth for all starts; counts of cells are those of the first start's plan, or of"
        " a drive's first one",
    )
    mission: Mission | None = Field(default=None, description="figures of a drive")
    fleet: FleetFigures | None = Field(default=None, description="figures of a fleet")
    terms: Terms | None = Field(
        default=None, description="what the time and the energy of a plan are made of, and the figures they rest on"
    )
    details: dict[str, float | str] = Field(default={}, description="figures that only this planner has")
    provenance: Provenance | None = Field(
        default=None, description="version, digests, seeds; None of a point of an exploration, where the study has it"
    )

    def __repr__(self) -> str:
        fate = "feasible" if self.feasible else "; ".join(map(str, self.reasons)) or "infeasible"
        return f"Result({clip(self.platform)} × {clip(self.workload)}: {self.planner} {self.style}, {clip(fate, 200)})"

    __str__ = __repr__

    def frame(self) -> DataFrame:
        """The declared figures that this result has, a row each: figure, value, low, high, unit, description.

        ``low`` and ``high`` are the least and the greatest value inside all intervals (``interval``).

        Raises:
            InputError: pandas is not installed.
        """
        values = {figure: self.figure(figure) for figure in FIGURES.values()}
        held = [figure for figure, value in values.items() if value is not None]
        ends = [self.interval(figure) or (None, None) for figure in held]
        return data_frame(
            {
                "figure": [figure.name for figure in held],
                "value": [values[figure] for figure in held],
                "low": [low for low, _ in ends],
                "high": [high for _, high in ends],
                "unit": [figure.unit for figure in held],
                "description": [figure.description for figure in held],
            }
        )

    @property
    def simulated(self) -> bool:
        """True if the design was run. One that does not fit was not; one with a plan of too few starts was."""
        return self.utilisation is not None

    def figure(self, figure: ResultFigure | str) -> float | None:
        """The value of a figure, or of the declared figure of a name, in its unit; None where the run has none.

        Raises:
            InputError: no figure has this name.
        """
        figure = figure_of(figure)
        if figure.of_whole_path and self.mission is not None and not self.mission.reached:
            return None
        return figure.value(self) if figure.value is not None else _total(_held(self, figure.path))

    def interval(self, figure: ResultFigure | str) -> tuple[float, float] | None:
        """The least and the greatest value of a figure, inside the intervals of all figures that it rests on.

        None where it rests on none, or is no sum of terms (``Terms.open``).

        Raises:
            InputError: no figure has this name.
        """
        figure = figure_of(figure)
        if isinstance(figure, DerivedFigure):
            return derived_interval(
                figure, lambda name: self.figure(FIGURES[name]), lambda name: self.interval(FIGURES[name])
            )
        if figure.name == "power" and self.power is not None:
            ends = (self.power.static.interval, self.power.dynamic.interval)
            return sum(low for low, _ in ends), sum(high for _, high in ends)
        return None if self.terms is None else self.terms.interval(figure.name)


def _held(record: Any, path: str) -> Any:
    """The value at a dotted path in a record; None where the path ends early."""
    for step in path.split("."):
        if record is None:
            return None
        if isinstance(record, tuple):
            record = {use.resource: use.demand for use in record}
        record = (record if isinstance(record, Mapping) else vars(record)).get(step)
    return record


def _total(held: Any) -> float | None:
    """A number as it is; of parts, such as cycles by phase or static and dynamic power, the sum."""
    if held is None or isinstance(held, str):
        return None
    if isinstance(held, Power):
        return held.static.value + held.dynamic.value
    return float(sum(held.values()) if isinstance(held, Mapping) else held)
