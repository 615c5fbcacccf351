"""Declared figures by name, and bounds on them."""

from __future__ import annotations

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
from pydantic_core import CoreSchema, core_schema

from codesign.errors import InputError, choose_hint, clip, show
from codesign.figures import FIGURES, RENAMED, ResultFigure
from codesign.models import RefusalError, SpecModel, refused
from codesign.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, parse_quantity


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
