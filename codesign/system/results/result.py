"""The named figures of a run, or of a point of an exploration, with their units.

``hwsw run --json`` prints a ``Result``; ``hwsw schema result`` prints its JSON Schema. Times are in seconds.
A design that does not fit is a result too: ``feasible`` is false, ``reasons`` says by what and what would mend it, and
the figures that only a run gives are None.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, field_validator

from codesign.ground.errors import clip
from codesign.ground.figures import FIGURES, Figure, ResultFigure, described, figure_of, label
from codesign.ground.files import date_of_writing
from codesign.ground.notebooks import InNotebooks, data_frame
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.derived import DerivedFigure, derived_interval
from codesign.planners.interface import Quality, RobotsQuality
from codesign.system.results.mission import LinkUse, Mission
from codesign.system.results.model import ResultModel
from codesign.system.results.terms import Terms
from codesign.version import __version__

if TYPE_CHECKING:
    from pandas import DataFrame

# What a fleet's run comes to: how fast the updates follow each other, what sets their pace, and what the display saw.

Pacemaker = Literal["fpga", "line", "time_step"]
PACEMAKERS: tuple[Pacemaker, ...] = ("fpga", "line", "time_step")


class Spread(ResultModel):
    """Some spans of time: their median, 95th percentile and worst, s; each is one of them."""

    median_s: float = Field(description="median, s")
    share_95_s: float = Field(title="95th percentile", description="95th percentile, s")
    worst_s: float = Field(description="worst, s")


class Frames(ResultModel):
    """The coordinates of all robots in messages to the display, one message an update.

    ``made`` = ``skipped`` + ``dropped`` + ``shown`` + ``under_way``. A free-running fleet skips none, it waits.
    """

    receiver: str = Field(description="the component that draws them")
    bits: int = Field(title="bits of a frame", description="bits of one message, framing left out")
    made: int = Field(description="messages made, one an update")
    skipped: int = Field(description="not sent, as the one before was not in the line's FIFO yet")
    dropped: dict[str, int] = Field(description="lost, by reason")
    shown: int = Field(description="drawn")
    late: int = Field(
        title="of these later than a time step",
        description="of those shown, later than a time step after their update was decided",
    )
    under_way: int = Field(title="under way at the end", description="at the end of the run")
    age: Spread | None = Field(description="from the decision of an update to its picture")


class FleetFigures(ResultModel):
    """The figures of one run of scenario ``fleet``."""

    robots: int = Field(description="robots of the fleet")
    fpgas: int = Field(
        title="FPGAs", description="one for each robot, all alike: the platform file declares one of them"
    )
    ended: str = Field(description="why the run ended")
    completed: bool = Field(description="whether all robots stand at their targets and no two touched on the way")
    updates: int = Field(description="updates of all velocities that were done")
    span_s: float = Field(
        title="time of all updates", description="from the begin of the first update to the end of the last, s"
    )
    robots_s: float = Field(
        title="time that passed for the robots",
        description="time that passed for the robots, s: of a fleet in real time the same as span_s; a free-running"
        " fleet simulates its robots, and takes them one time step on with every update",
    )
    arrived_s: float | None = Field(
        title="time until the last arrival",
        description="from the begin of the first update until the last arrival of a robot, s, by the clock of span_s;"
        " None where none arrived",
    )
    time_step_s: float = Field(description="time step of the planner, s")
    decide: Spread | None = Field(description="from the begin of an update until the last robot has decided")
    period: Spread | None = Field(description="from the begin of an update to its end, where the next one begins")
    updates_a_second: float = Field(description="that were done")
    reachable_a_second: float = Field(
        title="updates a second that FPGAs and line allow, at most",
        description="an upper bound of what FPGA and line allow in the long run: the lesser of the two rates, each by"
        " its mean. A FIFO shorter than a frame, and decisions that vary, keep a fleet below it",
    )
    pace: Pacemaker | None = Field(description="what most of the time went into")
    shares: dict[Pacemaker, float] = Field(
        description="shares of the time: robots decided, waited for the line, waited for the time step"
    )
    missed_updates: int = Field(
        title="updates longer than the time step",
        description="that took longer to decide than the time step; in real time they act late",
    )
    frames: Frames | None = Field(description="messages of coordinates to the display; None where there is none")
    fpga_busy_s: float = Field(
        title="busy time of all FPGAs together", description="the sum over the FPGAs of all robots, s"
    )
    fpga_utilisation: tuple[float, float] = Field(description="of the least and the most busy FPGA")


def spread(spans: Sequence[int]) -> Spread | None:
    """Median, 95th percentile and worst of some spans, ps; None of none."""
    if not spans:
        return None
    ordered = sorted(spans)

    def rank(percent: int) -> float:
        return ordered[max(0, -(-len(ordered) * percent // 100) - 1)] / PICOSECONDS_PER_SECOND

    return Spread(median_s=rank(50), share_95_s=rank(95), worst_s=rank(100))


# Where figures come from: version, digests of specs and map, seeds, and the date of what is written.


class Provenance(ResultModel):
    """The inputs that made a result or a study. The same specs give the same, but for the date of what is written."""

    codesign: str = Field(default=__version__, description="version of hwsw")
    platform_digests: dict[str, str] = Field(
        default={}, description="SHA-256 of each platform by its name: of all that can change a result"
    )
    workload_digest: str | None = Field(
        default=None, description="SHA-256 of the workload: of all that can change a result"
    )
    calibration_digests: dict[str, str] = Field(
        default={}, description="SHA-256 of the calibration of each FPGA that names one, as PLATFORM.COMPONENT"
    )
    map_digest: str | None = Field(
        default=None, description="SHA-256 of the cells of the map; null without one, or where an axis moves it"
    )
    seeds: dict[str, int] = Field(
        default={}, description="each seed of the workload by the path of its key, but those that an axis moves"
    )
    date: str | None = Field(
        default=None, description="the day on which it was written, UTC, or that of SOURCE_DATE_EPOCH; else null"
    )

    def stamped(self) -> Provenance:
        """The same with the date of today, for what is written now."""
        return self.model_copy(update={"date": date_of_writing()})

    @property
    def constants(self) -> dict[str, str]:
        """The texts that identify it besides its platforms, for columns of CSV and for traces."""
        texts = {
            "codesign": self.codesign,
            "workload_digest": self.workload_digest,
            "map_digest": self.map_digest,
            "seeds": " ".join(f"{path}={seed}" for path, seed in self.seeds.items()),
            "date": self.date,
        }
        return {name: text for name, text in texts.items() if text}


# What was asked of a planner, and the time from each request to its answer.

TaskName = Literal["path", "field", "replan", "robots"]


class TaskFigures(ResultModel):
    """A task, and what it took. A request begins as the map is sent, and ends as the answer is received."""

    task: TaskName = Field(
        description="what was asked; robots: the paths of all robots at once, of a planner with a problem of its own"
    )
    text: str = Field(title="what the planner does", description="what the planner does for it")
    map: str = Field(default="", description="the map, in words")
    question: str = Field(
        default="",
        description="digest of map, goals, starts, task and change: results with one digest were asked the same",
    )
    starts: int = Field(description="starts of the problem")
    reach: float | None = Field(
        default=None,
        title="share of the free cells that reach a goal",
        description="share of the free cells of the whole map with a path to a goal across the sides of cells",
    )
    changed_cells: int | None = Field(default=None, description="cells that change, of task replan")
    plan_time_mean_s: float = Field(title="request to answer, mean", description=described("plan_time_mean_s"))
    plan_time_95_s: float = Field(title="request to answer, 95th percentile", description=described("plan_time_95_s"))
    plan_time_worst_s: float = Field(title="request to answer, worst", description=described("plan_time_worst_s"))
    map_mean_s: float = Field(
        title="until the map is there, mean",
        description="the part of it until the map, or its change, stands in the component that plans, mean, s",
    )
    planning_mean_s: float = Field(
        title="planning, mean", description="the part of it from there until the plan stands, mean, s"
    )
    answer_mean_s: float = Field(
        title="answering, mean", description="the part of it from there until the answer is received, mean, s"
    )
    arrive: Annotated[float | None, Field(title="share of the starts that arrive", description=described("arrive"))] = (
        None
    )


def reach_text(shares: Sequence[float]) -> str:
    """From how much of the free space a path leads to a goal, over one map or several, as a clause.

    >>> reach_text([1.3e-5, 1.0])
    'a path leads to a goal from 0.0013 % to 100 % of the free cells'
    """
    texts = dict.fromkeys(
        ">99.9 %" if 0.999 < share < 1 else f"{100 * share:.3g} %" for share in (min(shares), max(shares))
    )
    return f"a path leads to a goal from {' to '.join(texts)} of the free cells"


def times_of(requests: Sequence[tuple[Any, Any, Any]]) -> dict[str, Any]:
    """The times of a ``TaskFigures``.

    ``requests``: ps for the map, the planning and the answer of each, in any order: whole numbers, or int64 arrays with
    an entry a machine. Each time is then a number, or an array of float64.

    >>> float(times_of([(10**12, 2 * 10**12, 0), (10**12, 4 * 10**12, 0)])["plan_time_mean_s"])
    4.0
    """
    # Requests × parts (× machines). Sums of whole picoseconds: no figure depends on the order of the starts.
    parts = np.array(requests, np.int64)
    totals = parts.sum(axis=1)
    means = parts.sum(axis=0) / len(requests) / PICOSECONDS_PER_SECOND
    return {
        "plan_time_mean_s": totals.sum(axis=0) / len(requests) / PICOSECONDS_PER_SECOND,
        "plan_time_95_s": np.quantile(totals, 0.95, axis=0) / PICOSECONDS_PER_SECOND,
        "plan_time_worst_s": totals.max(axis=0) / PICOSECONDS_PER_SECOND,
        **dict(zip(("map_mean_s", "planning_mean_s", "answer_mean_s"), means, strict=True)),
    }


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

    @classmethod
    def over(cls, kind: Any, name: str, demand: float, limit: float, unit: str, levers: tuple[str, ...] = ()) -> Self:
        """The reason that something passes its limit, or falls short of what is needed."""
        gap = abs(demand - limit)
        return cls(kind=kind, name=name, demand=demand, limit=limit, gap=gap, unit=unit, levers=levers)

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
