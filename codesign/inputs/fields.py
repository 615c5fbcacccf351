"""Field types of specs: names, cells, and figures with their units and where they come from."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Annotated, Any

from pydantic import Field, PlainSerializer, StringConstraints, ValidationInfo, WithJsonSchema, WrapValidator

from codesign.errors import InputError, show
from codesign.figures import Figure, Status
from codesign.models import NAME_PATTERN, RefusalError, SpecModel, refused
from codesign.units import SCALES, Dimension, parse_quantity

MAX_COUNT = 10**15

DECLARED = "declared"
"""Source of a figure in short form, until its file and line are put in."""

Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN, max_length=64)]
"""A name: letters, digits, ``_`` and ``-``, not beginning with a digit."""

Cell = tuple[Annotated[int, Field(ge=0)], Annotated[int, Field(ge=0)]]
"""(row, column) of a cell, from 0 at the top left."""


def _plain(dimension: Dimension) -> WrapValidator:
    """The validator of a bare quantity: a choice of the user's, which has no source."""
    read = _quantity(dimension)

    def validate(value: Any, _handler: Callable[[Any], Any], info: ValidationInfo) -> int | float:  # noqa: ARG001
        return read(value)

    return WrapValidator(validate)


def _plain_schema(dimension: Dimension) -> WithJsonSchema:
    return WithJsonSchema(_quantity_text(dimension))


class _FullFigure(SpecModel):
    value: Any
    status: Status
    source: Annotated[str, Field(min_length=1)]
    low: Any = None
    high: Any = None


def _reader(read: Callable[[Any], Any], unit: str) -> WrapValidator:
    def validate(value: Any, _handler: Callable[[Any], Any], info: ValidationInfo) -> Figure:
        if isinstance(value, Figure):
            return value
        if not isinstance(value, dict):
            return Figure(read(value), unit, Status.ASSUMED, DECLARED)
        full = _FullFigure.model_validate(value, context=info.context)
        value_, low, high = (_read_at(read, full, key) for key in ("value", "low", "high"))
        for key, bound in (("low", low), ("high", high)):
            outside = bound is not None and (bound > value_ if key == "low" else bound < value_)
            if outside:
                side = "above" if key == "low" else "below"
                raise RefusalError(
                    f"{getattr(full, key)} is {side} the value {full.value}", f"correct {key}", (key,)
                )
        return Figure(value_, unit, full.status, full.source, low, high)

    return WrapValidator(validate)


def _read_at(read: Callable[[Any], Any], full: _FullFigure, key: str) -> Any:
    given = getattr(full, key)
    if given is None and key != "value":
        return None
    try:
        return read(given)
    except RefusalError as refusal:
        raise RefusalError(refusal.what, refusal.hint, (key,)) from None


def _quantity(dimension: Dimension, scale: Fraction = Fraction(1)) -> Callable[[Any], int | float]:
    example = SCALES[dimension].example

    def read(value: Any) -> int | float:
        if not isinstance(value, str):
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            what = f"{show(value)} has no unit" if is_number else f"{show(value)} is not a {dimension}"
            raise RefusalError(what, f"write a number and a unit, such as {example}")
        try:
            parsed = parse_quantity(value, dimension)
        except InputError as error:
            raise refused(error) from None
        return parsed if isinstance(parsed, int) else float(parsed * scale)

    return read


def _count(least: int) -> Callable[[Any], int]:
    def read(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise RefusalError(f"{show(value)} is not a whole number", "write it without a unit, such as 32")
        if not least <= value <= MAX_COUNT:
            raise RefusalError(f"{value} is out of bounds", f"from {least} to {MAX_COUNT:,}")
        return value

    return read


def _json_schema(short: dict[str, Any], what: str) -> WithJsonSchema:
    full = {
        "type": "object",
        "properties": {
            "value": short,
            "status": {"enum": [str(status) for status in Status]},
            "source": {"type": "string", "minLength": 1},
            "low": short,
            "high": short,
        },
        "required": ["value", "status", "source"],
        "additionalProperties": False,
    }
    return WithJsonSchema({"anyOf": [short, full], "description": what})


def _quantity_text(dimension: Dimension) -> dict[str, Any]:
    """The JSON Schema of a number with a unit."""
    scale = SCALES[dimension]
    units = "|".join(re.escape(unit) for unit in scale.units)
    pattern = rf"^[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)? *({units})$"
    return {"type": "string", "pattern": pattern, "examples": [scale.example]}


def _quantity_schema(dimension: Dimension) -> WithJsonSchema:
    return _json_schema(
        _quantity_text(dimension),
        f"A {dimension} with its unit, or a mapping that also cites where it comes from.",
    )


def _dump(figure: Figure) -> dict[str, Any]:
    low, high = figure.interval
    return {
        "value": figure.value,
        "unit": figure.unit,
        "status": str(figure.status),
        "source": figure.source,
        "low": low,
        "high": high,
    }


_AS_MAPPING = PlainSerializer(_dump)


def _count_schema(least: int) -> WithJsonSchema:
    short = {"type": "integer", "minimum": least, "maximum": MAX_COUNT}
    return _json_schema(short, "A whole number, or a mapping that also cites where it comes from.")


TimeFigure = Annotated[
    Figure, _reader(_quantity(Dimension.TIME), "ps"), _AS_MAPPING, _quantity_schema(Dimension.TIME)
]
"""A time; ``Figure.value`` is an int, ps."""

FrequencyFigure = Annotated[
    Figure, _reader(_quantity(Dimension.FREQUENCY), "Hz"), _AS_MAPPING, _quantity_schema(Dimension.FREQUENCY)
]
"""A frequency; ``Figure.value`` is an int, Hz."""

PowerFigure = Annotated[
    Figure, _reader(_quantity(Dimension.POWER), "W"), _AS_MAPPING, _quantity_schema(Dimension.POWER)
]
"""A power; ``Figure.value`` in W."""

SlicePowerFigure = Annotated[
    Figure,
    _reader(_quantity(Dimension.POWER, Fraction(1, 10**6)), "W/(slice Hz)"),
    _AS_MAPPING,
    _quantity_schema(Dimension.POWER),
]
"""Dynamic power, written for one slice and MHz; ``Figure.value`` in W for one slice and Hz."""

LengthFigure = Annotated[
    Figure, _reader(_quantity(Dimension.LENGTH), "m"), _AS_MAPPING, _quantity_schema(Dimension.LENGTH)
]
"""A length; ``Figure.value`` in m."""

SpeedFigure = Annotated[
    Figure, _reader(_quantity(Dimension.SPEED), "m/s"), _AS_MAPPING, _quantity_schema(Dimension.SPEED)
]
"""A speed; ``Figure.value`` in m/s."""

AccelerationFigure = Annotated[
    Figure,
    _reader(_quantity(Dimension.ACCELERATION), "m/s^2"),
    _AS_MAPPING,
    _quantity_schema(Dimension.ACCELERATION),
]
"""An acceleration; ``Figure.value`` in m/s²."""

TurnRateFigure = Annotated[
    Figure,
    _reader(_quantity(Dimension.TURN_RATE), "rad/s"),
    _AS_MAPPING,
    _quantity_schema(Dimension.TURN_RATE),
]
"""A rate of turning; ``Figure.value`` in rad/s."""

DataFigure = Annotated[
    Figure, _reader(_quantity(Dimension.DATA), "b"), _AS_MAPPING, _quantity_schema(Dimension.DATA)
]
"""An amount of data; ``Figure.value`` is an int, bits."""

CountFigure = Annotated[Figure, _reader(_count(0), "1"), _AS_MAPPING, _count_schema(0)]
"""A number of things, 0 included; ``Figure.value`` is an int."""

PositiveFigure = Annotated[Figure, _reader(_count(1), "1"), _AS_MAPPING, _count_schema(1)]
"""A number of things, at least 1; ``Figure.value`` is an int."""

Duration = Annotated[int, _plain(Dimension.TIME), _plain_schema(Dimension.TIME)]
"""A time that the user chooses, ps."""

Length = Annotated[float, _plain(Dimension.LENGTH), _plain_schema(Dimension.LENGTH)]
"""A length that the user chooses, m."""

Speed = Annotated[float, _plain(Dimension.SPEED), _plain_schema(Dimension.SPEED)]
"""A speed that the user chooses, m/s."""
