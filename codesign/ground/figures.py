"""Figures: a number with its unit, its interval and its source; and the figures of a result that designs are judged by.

Every number that a report shows is one of four kinds, and says which:

- ``published``: stands in a paper or a datasheet,
- ``calibrated``: fitted to published or measured rows; the fit and its residuals are in the repo,
- ``measured``: counted or timed on RTL of this package, in synthesis or on a machine,
- ``assumed``: nobody has shown it; the source says what it was taken from.
"""

from __future__ import annotations

import re
from calendar import monthrange
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from functools import lru_cache, partial
from typing import Any, ClassVar, Literal

from codesign.ground.errors import InputError, choose_hint, clip, show
from codesign.ground.units import counted


class Status(StrEnum):
    """The source of a figure, strongest first."""

    PUBLISHED = "published"
    CALIBRATED = "calibrated"
    MEASURED = "measured"
    ASSUMED = "assumed"


@dataclass(frozen=True)
class Figure:
    """One number with its source, wherever one stands: in parts, platforms, laws, demands and results.

    ``low`` and ``high`` bound it where a law was fitted or a value assumed; both are ``value`` for an exact figure.

    >>> Figure(5, "s", Status.ASSUMED, "guess").interval
    (5, 5)
    """

    # How a model that holds figures reads and writes them.
    __pydantic_config__: ClassVar = {"extra": "forbid", "json_schema_serialization_defaults_required": True}

    value: int | float = field(metadata={"description": "the figure"})
    unit: str = field(metadata={"description": "its unit"})
    status: Status = field(metadata={"description": "published, calibrated, measured or assumed"})
    source: str = field(metadata={"description": "where it is from"})
    low: int | float | None = field(default=None, metadata={"description": "least that it may be"})
    high: int | float | None = field(default=None, metadata={"description": "most that it may be"})

    def __post_init__(self) -> None:
        if self.low is None:
            object.__setattr__(self, "low", self.value)
        if self.high is None:
            object.__setattr__(self, "high", self.value)

    @property
    def interval(self) -> tuple[float, float]:
        """The lowest and the highest value that the source allows."""
        assert self.low is not None, "set where it was not given"
        assert self.high is not None, "set where it was not given"
        return self.low, self.high

    def per(self, divisor: float, unit: str) -> Figure:
        """The same figure in a unit that is ``divisor`` times as large."""
        low, high = self.interval
        return Figure(self.value / divisor, unit, self.status, self.source, low / divisor, high / divisor)


@dataclass(frozen=True)
class Price(Figure):
    """A price. ``date``: the day, month or year in which it was seen (``2023-06-15``, ``2023-06``, ``2023``)."""

    date: str | None = field(default=None, metadata={"description": "the day, month or year in which it was seen"})


def last_day(day: str) -> date:
    """The last day of a day, a month or a year that is written as in ``Price``.

    Raises:
        ValueError: it is none.

    >>> last_day("2023"), last_day("2024-02")
    (datetime.date(2023, 12, 31), datetime.date(2024, 2, 29))
    """
    year, month, *_ = (int(part) for part in (*day.split("-"), "12"))
    return date.fromisoformat(day) if len(day) > len("2024-02") else date(year, month, monthrange(year, month)[1])


def age_text(day: str, today: str) -> str:
    """The day, month or year of a price, with its age where that is surely a year or more.

    >>> age_text("2023", "2026-11-24"), age_text("2026-05", "2026-11-24")
    ('of 2023, over 2 years old', 'of 2026-05')
    """
    years = (last_day(today) - last_day(day)).days // 365
    return f"of {day}, over {counted(years, 'year')} old" if years >= 1 else f"of {day}"


_SUFFIXES = {"_m_s": "m/s", "_s": "s", "_j": "J", "_m": "m"}


def named_unit(name: str) -> tuple[str, str]:
    """The name of a figure in words, and the unit that it ends with; ``1`` where it ends with none.

    >>> named_unit("mission_time_s"), named_unit("local_maxima")
    (('mission time', 's'), ('local maxima', '1'))
    """
    suffix = next((suffix for suffix in _SUFFIXES if name.endswith(suffix)), "")
    return name.removesuffix(suffix).replace("_", " "), _SUFFIXES.get(suffix, "1")


Counted = Literal["measure", "count", "share"]


@dataclass(frozen=True)
class ResultFigure:
    """The declaration of a figure of a result: all that files, studies, tables and docs need to know of it.

    - ``name``: its name in YAML, in JSON and in CSV, which is the name of its field in the result.
    - ``within``: the record of the result that has the field, as a dotted path; "" for the result itself. A field that
      is made of parts, such as cycles by phase, counts as their sum.
    - ``description``: what it is, as JSON Schema and docs say it. ``label``: what tables and plots call it; by default
      its name in words.
    - ``unit``: of its value; by default the unit in its name, else ``1``, for a number of things or a share. A limit of
      s, W, J or m is written with a unit.
    - ``maximise``: True if more of it is better. ``counted``: a count is a whole number, a share is told as percent.
    - ``of_whole_path``: a mission that ended before its goals has none: the earlier it failed, the less it would be.
    - ``value``: computes it from the result, where it has no field of its own.
    """

    name: str
    within: str
    description: str
    label: str = ""
    unit: str = ""
    maximise: bool = False
    counted: Counted = "measure"
    of_whole_path: bool = False
    value: Callable[[Any], float | None] | None = None

    def __post_init__(self) -> None:
        words, unit = named_unit(self.name)
        object.__setattr__(self, "label", self.label or words)
        object.__setattr__(self, "unit", self.unit or unit)

    def __str__(self) -> str:
        return self.name

    def __reduce__(self) -> tuple[Callable[[str], ResultFigure], tuple[str]]:
        # Worker processes get a figure by its name: ``value`` may be a lambda, which cannot be pickled.
        return _declared, (self.name,)

    @property
    def path(self) -> str:
        """Its place in a result, such as ``quality.clearance_mean``."""
        return f"{self.within}.{self.name}".lstrip(".")

    @property
    def column(self) -> str:
        """The name of its column in CSV and data frames: its name, which ends with its unit. It names the figure too.

        >>> FIGURES["power"].column, FIGURES["energy_j"].column, FIGURES["slices"].column
        ('power_w', 'energy_j', 'slices')
        >>> ResultFigure("pace", "derived", "", unit="/ s s").column
        'pace_per_s_s'
        """
        suffix = "_" + re.sub(r"\W+", "_", self.unit.lower().replace("/ ", "per ").removesuffix(")"))
        said = named_unit(self.name)[1] == self.unit or self.name.endswith(suffix)
        return self.name if said or self.unit == "1" or not self.name.isidentifier() else f"{self.name}{suffix}"

    @property
    def is_resource(self) -> bool:
        """True if it is a resource of a chip. A design without a chip takes none of it."""
        return self.within == "resources"

    @property
    def direction(self) -> Literal["maximise", "minimise"]:
        """The direction that is better: more of it, or less."""
        return "maximise" if self.maximise else "minimise"

    @property
    def aim(self) -> str:
        """The aim of an exploration for it, in words: ``least time``."""
        return f"{'most' if self.maximise else 'least'} {self.label}"


_RESOURCES = {"slices": "", "lut4": "LUT4", "flip_flops": "flip-flops", "block_rams": "block RAMs", "multipliers": ""}
RESOURCES = tuple(_RESOURCES)
"""The kinds of resource that a part is budgeted in. They are never added up over kinds."""

_count = partial(ResultFigure, counted="count")

FIGURES: dict[str, ResultFigure] = {
    figure.name: figure
    for figure in (
        *(
            ResultFigure(
                f"plan_time_{name}_s",
                "task",
                f"from a request to its answer, {text} over the starts; of task field, until the component that decides"
                " holds an answer for every cell",
                label,
            )
            for name, text, label in (
                ("worst", "worst", "worst plan time"),
                ("mean", "mean", "mean plan time"),
                ("95", "95th percentile", "plan time at 95 %"),
            )
        ),
        ResultFigure(
            "first_plan_s",
            "time",
            "when the first decision reached the component that asked for it, from the start of the run; of a plan, for"
            " its first start",
            "first plan time",
        ),
        ResultFigure(
            "arrive",
            "task",
            "share of the starts that can arrive, by the planner's own moves, from which following the plan arrives",
            "starts that arrive",
            maximise=True,
            counted="share",
        ),
        _count("cycles", "", "clock cycles of the component that plans, over all phases"),
        *(
            _count(name, "resources", f"{text or name} that the design takes of its part", text)
            for name, text in _RESOURCES.items()
        ),
        ResultFigure("power", "", "static and dynamic power of the FPGA while it plans", "FPGA power", unit="W"),
        ResultFigure(
            "energy_j", "energy", "energy a plan, mean over the starts; of a drive or a fleet, of the whole run"
        ),
        ResultFigure(
            "share_reaching_goal",
            "quality",
            "share of the planned cells from which following the plan arrives",
            maximise=True,
            counted="share",
        ),
        _count("local_maxima", "quality", "planned cells with no strictly greater neighbour: no way up"),
        _count("wrong_cells", "quality", "cells whose value is not the one that the planner's arithmetic settles at"),
        ResultFigure(
            "path_length_ratio_mean",
            "quality",
            "length of the path over that of the shortest one, mean over the starts or robots that arrived",
            "path length ratio",
        ),
        ResultFigure(
            "clearance_mean",
            "quality",
            "distance from the path to the nearest obstacle, mean",
            "clearance",
            unit="cells",
            maximise=True,
        ),
        ResultFigure(
            "turning_mean",
            "quality",
            "changes of direction along the path, added up, mean over the starts that arrived: 90 for a right angle",
            "turning",
            unit="deg",
        ),
        _count("collisions", "quality", "pairs of robots that touched, at an update or between two"),
        ResultFigure(
            "closest_approach",
            "quality",
            "least distance between two robots less their radii; negative in a collision",
            unit="cells",
            maximise=True,
        ),
        ResultFigure(
            "time_to_targets_s", "quality", "driving time of the last robot that arrived, by the clock of the robots"
        ),
        _count("precision", "", "fractional bits of the final field", unit="bits"),
        ResultFigure("mission_time_s", "mission", "simulated time at the end of the mission", of_whole_path=True),
        ResultFigure(
            "mission_energy_j", "mission.energy", "energy of the mission, the robot's body included", of_whole_path=True
        ),
        ResultFigure(
            "distance_ratio", "mission", "distance driven over the shortest path, at least 1", of_whole_path=True
        ),
        _count("replans", "mission", "plans asked for because of what was seen on the way, and answered"),
        ResultFigure(
            "replan_latency_95_s",
            "mission",
            "from the scan that asked for a plan to the answer, 95th percentile",
            "replan latency",
        ),
        _count("missed_deadlines", "mission", "turns without an answer by the deadline"),
        _count("safety_stops", "mission", "times that the robot braked because an answer was overdue"),
        _count("contacts", "mission", "times that the robot ran against something, and stood"),
        ResultFigure(
            "clearance_least_m",
            "mission",
            "least distance from the robot's middle to an obstacle of the true map, over all its path and time",
            "mission clearance",
            maximise=True,
        ),
        ResultFigure(
            "known_share",
            "mission",
            "share of the map's cells that the robot knows at the end",
            maximise=True,
            counted="share",
        ),
    )
}
"""Every figure that may be an objective or a constraint, by name. To add one, declare it here, and fill its field."""


def named(figure: ResultFigure | str) -> ResultFigure:
    """The declared figure of a name. A name that is not declared is one that an exploration derived, with no unit."""
    if isinstance(figure, ResultFigure):
        return figure
    return FIGURES.get(figure) or ResultFigure(figure, "derived", "", figure.replace("_", " "), "1")


def found(word: object, known: Mapping[str, ResultFigure] = FIGURES) -> ResultFigure | None:
    """The figure of a name, or of the name of its column; None where no figure has it. A figure stays what it is."""
    if isinstance(word, ResultFigure) or not isinstance(word, str):
        return word if isinstance(word, ResultFigure) else None
    return known.get(word) or next((each for each in known.values() if each.column == word), None)


def figure_of(word: ResultFigure | str, known: Mapping[str, ResultFigure] = FIGURES) -> ResultFigure:
    """The figure of a name, or of the name of its column (``power_w``). A figure stays what it is.

    Raises:
        InputError: no figure has this name.

    >>> figure_of("power_w").name
    'power'
    """
    figure = found(word, known)
    if figure is None:
        text = clip(str(word), 60)
        raise InputError(f"{show(text)} is no figure", None, choose_hint(text, known))
    return figure


def _declared(name: str) -> ResultFigure:
    return FIGURES[name]


SHORT_NAMES = {
    "time": "plan_time_worst_s",
    "first_plan": "first_plan_s",
    "energy": "energy_j",
    "path_length_ratio": "path_length_ratio_mean",
    "clearance": "clearance_mean",
    "turning": "turning_mean",
    "time_to_targets": "time_to_targets_s",
    "mission_time": "mission_time_s",
    "mission_energy": "mission_energy_j",
    "replan_latency": "replan_latency_95_s",
    "mission_clearance": "clearance_least_m",
}
"""Short names that limits as text accept (``time < 100 ms``). Elsewhere the remedy says the name of the figure."""


def described(name: str, more: str = "") -> str:
    """The description of a declared figure with its unit, for the field of the result that holds it."""
    figure = FIGURES[name]
    unit = "" if figure.unit == "1" else f", {figure.unit}"
    return f"{figure.description}{unit}{more}"


@lru_cache(maxsize=4096)
def label(name: str) -> str:
    """A name of the model (a resource, a figure, a phase), or words with such names among them, in a reader's words.

    >>> label("share_reaching_goal"), label("block_rams"), label("first_plan_s at most")
    ('share reaching goal', 'block RAMs', 'first plan time at most')

    An expression stays as it was written.

    >>> label("sqrt(slices * block_rams) below: division by zero in slices / block_rams")
    'sqrt(slices * block_rams) below: division by zero in slices / block_rams'
    """
    return ": ".join(part if _EXPRESSION.search(part) else _words(part) for part in name.split(": "))


_EXPRESSION = re.compile(r"(^| )[-+*/] |\b(sqrt|log|abs|min|max)\(")


def _words(name: str) -> str:
    return " ".join(FIGURES[word].label if word in FIGURES else word.replace("_", " ") for word in name.split(" "))


def weakest(*statuses: Status) -> Status:
    """The status of a figure made from others: the status of its weakest ingredient.

    >>> weakest(Status.PUBLISHED, Status.ASSUMED)
    <Status.ASSUMED: 'assumed'>
    """
    order = list(Status)
    return max(statuses, key=order.index)
