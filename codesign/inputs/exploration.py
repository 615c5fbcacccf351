"""What is explored: axes, objectives and constraints."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, WithJsonSchema, field_validator, model_validator
from pydantic_core import InitErrorDetails

from codesign.errors import InputError, clip, show
from codesign.models import Location, RefusalError, SpecModel, raise_all, refusal_details, refused
from codesign.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, parse_quantity

MAX_AXES = 16
MAX_VALUES = 1000
MAX_POINTS = 1_000_000

_AXIS = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*(\.[A-Za-z_][A-Za-z0-9_-]*)+")


class ResultFigure(StrEnum):
    """A figure of a result that may be an objective or a constraint."""

    TIME = "time"
    CYCLES = "cycles"
    SLICES = "slices"
    LUT4 = "lut4"
    FLIP_FLOPS = "flip_flops"
    BLOCK_RAMS = "block_rams"
    MULTIPLIERS = "multipliers"
    POWER = "power"
    ENERGY = "energy"
    SHARE_REACHING_GOAL = "share_reaching_goal"
    LOCAL_MAXIMA = "local_maxima"
    WRONG_CELLS = "wrong_cells"
    PATH_LENGTH_RATIO = "path_length_ratio"
    CLEARANCE = "clearance"
    COLLISIONS = "collisions"
    CLOSEST_APPROACH = "closest_approach"
    TIME_TO_TARGETS = "time_to_targets"
    PRECISION = "precision"
    MISSION_TIME = "mission_time"
    MISSION_ENERGY = "mission_energy"
    DISTANCE_RATIO = "distance_ratio"
    REPLANS = "replans"
    REPLAN_LATENCY = "replan_latency"
    MISSED_DEADLINES = "missed_deadlines"
    SAFETY_STOPS = "safety_stops"
    CONTACTS = "contacts"
    MISSION_CLEARANCE = "mission_clearance"
    KNOWN_SHARE = "known_share"

    @property
    def unit(self) -> str:
        """The unit of its value; ``1`` for a number of things or a share."""
        return _UNITS.get(self, "1")

    @property
    def maximise(self) -> bool:
        """Whether more of it is better."""
        return self in _MOST_IS_BEST

    @property
    def is_count(self) -> bool:
        """Whether it counts things, so that every value is a whole number."""
        return self in _COUNTS

    @property
    def is_resource(self) -> bool:
        """Whether it is a resource of a chip, of which a design without one takes none."""
        return self in _RESOURCES

    @property
    def direction(self) -> str:
        """``maximise`` or ``minimise``."""
        return "maximise" if self.maximise else "minimise"


_UNITS = {
    ResultFigure.TIME: "s",
    ResultFigure.POWER: "W",
    ResultFigure.ENERGY: "J",
    ResultFigure.CLEARANCE: "cells",
    ResultFigure.CLOSEST_APPROACH: "cells",
    ResultFigure.TIME_TO_TARGETS: "s",
    ResultFigure.PRECISION: "bits",
    ResultFigure.MISSION_TIME: "s",
    ResultFigure.MISSION_ENERGY: "J",
    ResultFigure.REPLAN_LATENCY: "s",
    ResultFigure.MISSION_CLEARANCE: "m",
}
_MOST_IS_BEST = {
    ResultFigure.SHARE_REACHING_GOAL,
    ResultFigure.CLEARANCE,
    ResultFigure.CLOSEST_APPROACH,
    ResultFigure.MISSION_CLEARANCE,
    ResultFigure.KNOWN_SHARE,
}
_RESOURCES = {
    ResultFigure.SLICES,
    ResultFigure.LUT4,
    ResultFigure.FLIP_FLOPS,
    ResultFigure.BLOCK_RAMS,
    ResultFigure.MULTIPLIERS,
}
_COUNTS = {
    *_RESOURCES,
    ResultFigure.CYCLES,
    ResultFigure.LOCAL_MAXIMA,
    ResultFigure.WRONG_CELLS,
    ResultFigure.COLLISIONS,
    ResultFigure.PRECISION,
    ResultFigure.REPLANS,
    ResultFigure.MISSED_DEADLINES,
    ResultFigure.SAFETY_STOPS,
    ResultFigure.CONTACTS,
}
_DIMENSIONS = {
    ResultFigure.TIME: Dimension.TIME,
    ResultFigure.POWER: Dimension.POWER,
    ResultFigure.ENERGY: Dimension.ENERGY,
    ResultFigure.MISSION_TIME: Dimension.TIME,
    ResultFigure.REPLAN_LATENCY: Dimension.TIME,
    ResultFigure.MISSION_ENERGY: Dimension.ENERGY,
    ResultFigure.MISSION_CLEARANCE: Dimension.LENGTH,
}

DEFAULT_OBJECTIVES = (
    ResultFigure.TIME,
    ResultFigure.SLICES,
    ResultFigure.BLOCK_RAMS,
    ResultFigure.ENERGY,
    ResultFigure.SHARE_REACHING_GOAL,
)

MISSION_OBJECTIVES = (
    ResultFigure.MISSION_TIME,
    ResultFigure.MISSION_ENERGY,
    ResultFigure.SLICES,
    ResultFigure.BLOCK_RAMS,
)
"""The objectives of an exploration of drives that names none: what replans cost is in the time."""

Limit = Annotated[float | None, WithJsonSchema({"type": ["number", "string"]})]


class Constraint(SpecModel):
    """A bound on a figure. Written with a unit (``5 ms``) for time, power, energy and length; held in s, W, J, m."""

    figure: ResultFigure = Field(description="The figure that is bounded.")
    at_least: Limit = Field(default=None, description="Its lower bound: 10 ms, 2 W, 1 J, or a bare number.")
    at_most: Limit = Field(default=None, description="Its upper bound, alike.")

    @field_validator("at_least", "at_most", mode="before")
    @classmethod
    def _with_unit(cls, value: Any, info: ValidationInfo) -> Any:
        figure = info.data.get("figure")
        # A spec that was dumped and is read again has plain numbers, and no document behind it.
        if figure not in _DIMENSIONS or value is None or not (info.context or {}).get("document"):
            return value
        dimension = _DIMENSIONS[figure]
        if not isinstance(value, str):
            example = SCALES[dimension].example
            raise RefusalError(f"{show(value)} has no unit", f"write a number and a unit, such as {example}")
        try:
            parsed = parse_quantity(value, dimension)
        except InputError as error:
            raise refused(error) from None
        return float(parsed / PICOSECONDS_PER_SECOND if dimension is Dimension.TIME else parsed)

    @model_validator(mode="after")
    def _bounds_something(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise RefusalError("bounds nothing", "give at_least, at_most, or both")
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            raise RefusalError(
                "nothing is within these bounds", "at_least has to be below at_most", ("at_least",)
            )
        return self


class Exploration(SpecModel):
    """Axes, all combinations of whose values are design points; and what is good.

    ``axes``: raw values by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD``, ``LINK.FIELD``, ``workload.variant``, or a
    key of ``workload.problem`` or ``workload.scenario``, in file order.
    """

    axes: Annotated[
        dict[str, Annotated[tuple[Any, ...], Field(min_length=1, max_length=MAX_VALUES)]], Field()
    ] = Field(
        default={},
        max_length=MAX_AXES,
        description="Values to try by axis: TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD, workload.variant, ...",
    )
    objectives: Annotated[tuple[ResultFigure, ...], Field(min_length=1, max_length=len(ResultFigure))] = (
        Field(
            default=DEFAULT_OBJECTIVES,
            description="Figures that span the front, each in its own direction; of drives by default mission_time,"
            " mission_energy, slices and block_rams.",
        )
    )
    constraints: Annotated[tuple[Constraint, ...], Field(max_length=64)] = Field(
        default=(), description="Bounds that a point has to keep."
    )

    @property
    def points(self) -> int:
        """The number of combinations; 1 without an axis."""
        return math.prod(len(values) for values in self.axes.values())

    @field_validator("axes", mode="after")
    @classmethod
    def _distinct_points(cls, value: dict[str, tuple[Any, ...]]) -> dict[str, tuple[Any, ...]]:
        found = []
        for axis, values in value.items():
            if not _AXIS.fullmatch(axis):
                hint = "write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD, such as relax.iterations"
                found.append(refusal_details(RefusalError(f"{clip(axis)!r} is no axis", hint), (axis,)))
            texts = [json.dumps(each, sort_keys=True) for each in values]
            found += _repeated(texts, (axis,))
        points = math.prod(len(values) for values in value.values())
        if points > MAX_POINTS:
            sizes = " x ".join(str(len(values)) for values in value.values())
            what = f"{sizes} = {points:,} points are too many"
            found.append(refusal_details(RefusalError(what, f"at most {MAX_POINTS:,}")))
        raise_all("Exploration", found)
        return value

    @field_validator("objectives", mode="after")
    @classmethod
    def _distinct_objectives(cls, value: tuple[ResultFigure, ...]) -> tuple[ResultFigure, ...]:
        raise_all("Exploration", _repeated(value))
        return value


def _repeated(texts: Sequence[str], location: Location = ()) -> list[InitErrorDetails]:
    """A refusal of each entry that stands in the list before."""
    found, seen = [], set()
    for index, text in enumerate(texts):
        if text in seen:
            refusal = RefusalError(f"{clip(text)} is listed twice", "list it once")
            found.append(refusal_details(refusal, (*location, index)))
        seen.add(text)
    return found
