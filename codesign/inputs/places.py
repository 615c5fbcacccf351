"""Places on a map as users write them: cells, points in metres, and lines of MovingAI's scenario files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
    field_validator,
    model_validator,
)

from codesign.ground.errors import InputError, show
from codesign.ground.models import RefusalError, SpecModel, details_of, raise_all, refused
from codesign.ground.units import Dimension, parse_quantity
from codesign.inputs.fields import Cell
from codesign.inputs.map_spec import beside, named

FARTHEST = 1e9
"""Metres: the largest coordinate, as for all lengths."""


def _read_metres(value: Any, _handler: Any) -> float:
    if isinstance(value, str):
        sign, text = (-1.0, value.strip()[1:]) if value.strip().startswith("-") else (1.0, value)
        try:
            return sign * float(parse_quantity(text, Dimension.LENGTH))
        except InputError as wrong:
            raise refused(wrong) from None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise RefusalError(f"{show(value)} is not a coordinate", "write metres, such as 12.5 or 12.5 m")
    if abs(value) > FARTHEST:
        raise RefusalError(f"{show(value)} is out of bounds", f"from -{FARTHEST:g} to {FARTHEST:g} m")
    return float(value)


_METRES_TEXT = {"type": "string", "pattern": "^-?[0-9.eE+-]+ *(um|mm|cm|m|km)$", "examples": ["12.5 m"]}
Metres = Annotated[float, WrapValidator(_read_metres), WithJsonSchema({"anyOf": [{"type": "number"}, _METRES_TEXT]})]


class Point(SpecModel):
    """A point in metres in the frame of the map: x to the right, y up, from map_server's origin."""

    x: Metres = Field(description="Metres to the right.")
    y: Metres = Field(description="Metres up.")

    def __str__(self) -> str:
        return point_text(self.x, self.y)


def as_list(value: Any, handler: Callable[[Any], Any], title: str) -> Any:
    """The value validated by a union of a list with models. Only the list reports faults, as no model is meant."""
    try:
        return handler(value)
    except ValidationError as error:
        # The first step of each location is the branch of the union.
        lines = [line for line in details_of(error) if str(line["loc"][0]).startswith(("tuple", "constrained"))]
        raise_all(title, [{**line, "loc": line["loc"][1:]} for line in lines])
        raise


def _choose_place(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict):
        return Point.model_validate(value, context=info.context)
    return value if isinstance(value, Point) else as_list(value, handler, "Place")


Place = Annotated[Cell | Point, WrapValidator(_choose_place)]
"""A cell (row, column), or a point in metres."""

_PLACE = re.compile(r" *(-?[0-9]{1,9}(?:\.[0-9]{1,9})?) *(m?) *, *(-?[0-9]{1,9}(?:\.[0-9]{1,9})?) *(m?) *")


def parse_place(text: str, option: str) -> tuple[int, int] | Point:
    """A place from the command line: ``40,60`` is row and column, ``12.5,3.0`` and ``12m,3m`` are x and y in metres.

    Raises:
        InputError: it is neither, at ``option``.
    """
    match = _PLACE.fullmatch(text)
    if match is None:
        hint = "write ROW,COLUMN as in 40,60, or X,Y in metres as in 12.5,3.0 or 12m,3m"
        raise InputError(f"{text!r:.60} is no place", option, hint)
    first, first_unit, second, second_unit = match.groups()
    if first_unit or second_unit or "." in first + second or "-" in first + second:
        return Point(x=float(first), y=float(second))
    return int(first), int(second)


def place_value(place: tuple[int, int] | Point) -> list[int] | dict[str, float]:
    """A place as YAML has it."""
    return {"x": place.x, "y": place.y} if isinstance(place, Point) else list(place)


def cell_text(cell: tuple[int, int]) -> str:
    """A cell as messages show it."""
    return f"({cell[0]}, {cell[1]})"


def point_text(x: float, y: float) -> str:
    """A point as messages show it.

    >>> point_text(12.5, -3.0)
    '{x: 12.5 m, y: -3 m}'
    """
    return f"{{x: {round(x, 6):g} m, y: {round(y, 6):g} m}}"


class ScenarioLine(SpecModel):
    """A problem of a MovingAI ``.scen`` file: its start and goal, with the length of the shortest path."""

    scen: Annotated[str, Field(min_length=1, max_length=4096)] = Field(
        description="Path of the .scen file, relative to the workload file."
    )
    line: Annotated[int, Field(ge=2, le=2**20)] | None = Field(
        default=None, description="The line of the file; the first problem is in line 2."
    )
    bucket: Annotated[int, Field(ge=0, le=2**20)] | None = Field(
        default=None, description="In place of a line: the first problem of this bucket."
    )
    same_goal: bool = Field(
        default=False, description="Whether the starts of all other problems with the same goal are taken too."
    )
    _path: Path = PrivateAttr()

    @property
    def path(self) -> Path:
        """The path of the file, seen from the current folder."""
        return self._path

    @property
    def key(self) -> str:
        """The key that chooses the problem."""
        return "bucket" if self.line is None else "line"

    @field_validator("scen", mode="before")
    @classmethod
    def _names_a_file(cls, value: Any) -> Any:
        return named(value, ".scen file")

    @model_validator(mode="after")
    def _one_line(self, info: ValidationInfo) -> Self:
        if (self.line is None) == (self.bucket is None):
            what = "names neither line nor bucket" if self.line is None else "names both line and bucket"
            raise RefusalError(what, "write line: 2 or more, or bucket: 0 or more")
        self._path = beside(info, self.scen, ("scen",), "a .scen file of MovingAI")
        return self
