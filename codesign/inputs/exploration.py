"""What is explored: axes, objectives and constraints."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from typing import Annotated, Any, Self

from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema, InitErrorDetails, core_schema

from codesign.errors import InputError, choose_hint, clip, show
from codesign.figures import FIGURES, RENAMED, ResultFigure
from codesign.models import Location, RefusalError, SpecModel, raise_all, refusal_details, refused
from codesign.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, parse_quantity

MAX_AXES = 16
MAX_VALUES = 1000
MAX_POINTS = 1_000_000

_AXIS = re.compile(r"platform|[A-Za-z_][A-Za-z0-9_-]*(\.[A-Za-z_][A-Za-z0-9_-]*)+")


DEFAULT_OBJECTIVES = tuple(
    FIGURES[name] for name in ("plan_time_worst_s", "slices", "block_rams", "energy_j", "share_reaching_goal")
)

FLEET_OBJECTIVES = (FIGURES["first_plan_s"], *DEFAULT_OBJECTIVES[1:])
"""The objectives of an exploration of fleets that names none: a fleet has no plan of its own."""

MISSION_OBJECTIVES = tuple(
    FIGURES[name] for name in ("mission_time_s", "mission_energy_j", "slices", "block_rams")
)
"""The objectives of an exploration of drives that names none: what replans cost is in the time."""


def declared(name: Any) -> ResultFigure:
    """The figure of that name; a figure stays what it is.

    Raises:
        RefusalError: no figure is declared under this name.
    """
    if isinstance(name, ResultFigure):
        return name
    if isinstance(name, str) and name in FIGURES:
        return FIGURES[name]
    word = clip(str(name), 60)
    hint = f"renamed: write {RENAMED[word]}" if word in RENAMED else choose_hint(word, FIGURES)
    raise RefusalError(f"{show(name)} is not accepted", hint)


class _ByName:
    """How models read and write a declared figure: as its name. The schema lists what is declared when it is asked."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            declared, serialization=core_schema.to_string_ser_schema()
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"type": "string", "enum": list(FIGURES)}


FigureName = Annotated[ResultFigure, _ByName()]

_DIMENSIONS = {"s": Dimension.TIME, "W": Dimension.POWER, "J": Dimension.ENERGY, "m": Dimension.LENGTH}

Limit = Annotated[float | None, WithJsonSchema({"type": ["number", "string"]})]


class Constraint(SpecModel):
    """A bound on a figure. Written with a unit (``5 ms``) for time, power, energy and length; held in s, W, J, m."""

    figure: FigureName = Field(description="The figure that is bounded.")
    at_least: Limit = Field(default=None, description="Its lower bound: 10 ms, 2 W, 1 J, or a bare number.")
    at_most: Limit = Field(default=None, description="Its upper bound, alike.")

    @field_validator("at_least", "at_most", mode="before")
    @classmethod
    def _with_unit(cls, value: Any, info: ValidationInfo) -> Any:
        figure = info.data.get("figure")
        if figure is None:
            return None  # The figure is refused: how its limit is written follows from the right one.
        # A spec that was dumped and is read again has plain numbers, and no document behind it.
        dimension = _DIMENSIONS.get(figure.unit)
        if dimension is None or value is None or not (info.context or {}).get("document"):
            return value
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
    """Axes, objectives and constraints. Each combination of values of the axes is a design point.

    ``axes``: raw values by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD``, ``LINK.FIELD``, ``ROLE.FIELD``,
    ``platform``, ``workload.variant``, or a key of ``workload.problem`` or ``workload.scenario``, in file order.
    """

    axes: Annotated[
        dict[str, Annotated[tuple[Any, ...], Field(min_length=1, max_length=MAX_VALUES)]], Field()
    ] = Field(
        default={},
        max_length=MAX_AXES,
        description="Values to try by axis: TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD, ROLE.FIELD, platform,"
        " workload.variant, ...",
    )
    objectives: Annotated[tuple[FigureName, ...], Field(min_length=1)] = Field(
        default=DEFAULT_OBJECTIVES,
        description="Figures that span the front, each in its own direction; of drives by default"
        f" {', '.join(figure.name for figure in MISSION_OBJECTIVES)}.",
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
        refusals = []
        for axis, values in value.items():
            if not _AXIS.fullmatch(axis):
                hint = (
                    "write TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD or platform, such as relax.iterations"
                )
                refusals.append(refusal_details(RefusalError(f"{clip(axis)!r} is no axis", hint), (axis,)))
            texts = [json.dumps(each, sort_keys=True) for each in values]
            refusals += _repeated(texts, (axis,))
        points = math.prod(len(values) for values in value.values())
        if points > MAX_POINTS:
            sizes = " x ".join(str(len(values)) for values in value.values())
            what = f"{sizes} = {points:,} points are too many"
            refusals.append(refusal_details(RefusalError(what, f"at most {MAX_POINTS:,}")))
        raise_all("Exploration", refusals)
        return value

    @field_validator("objectives", mode="after")
    @classmethod
    def _distinct_objectives(cls, value: tuple[ResultFigure, ...]) -> tuple[ResultFigure, ...]:
        raise_all("Exploration", _repeated([figure.name for figure in value]))
        return value


def _repeated(texts: Sequence[str], location: Location = ()) -> list[InitErrorDetails]:
    """A refusal of each entry that stands in the list before."""
    refusals, seen = [], set()
    for index, text in enumerate(texts):
        if text in seen:
            refusal = RefusalError(f"{clip(text)} is listed twice", "list it once")
            refusals.append(refusal_details(refusal, (*location, index)))
        seen.add(text)
    return refusals
