"""Field types of specs: names, cells, and figures with their units and where they come from."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Annotated, Any, ClassVar

from pydantic import (
    BeforeValidator,
    Field,
    PlainSerializer,
    StringConstraints,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
)

from codesign.ground.errors import InputError, show
from codesign.ground.figures import Figure, Price, Status, last_day
from codesign.ground.models import NAME_PATTERN, RefusalError, SpecModel, refused
from codesign.ground.units import SCALES, Dimension, parse_quantity

MAX_COUNT = 10**15
MIN_FACTOR, MAX_FACTOR = 1e-6, 1e6
MOST_LOAD = 0.99
"""With more, no program gets anything done."""

DECLARED = "declared"
"""Source of a figure in short form, until its file and line are put in."""

Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN, max_length=64)]
"""A name: letters, digits, ``_`` and ``-``, not beginning with a digit."""


def _counted_from_zero(value: Any) -> Any:
    if isinstance(value, int) and value < 0:
        raise RefusalError(
            f"{value} is not a row or column of a map", "rows and columns are counted from 0 at the top left"
        )
    return value


_Coordinate = Annotated[int, Field(ge=0), BeforeValidator(_counted_from_zero)]

Cell = tuple[_Coordinate, _Coordinate]
"""(row, column) of a cell, from 0 at the top left."""


class _FullFigure(SpecModel):
    makes: ClassVar[type[Figure]] = Figure

    value: Any
    status: Status
    source: Annotated[str, Field(min_length=1)]
    low: Any = None
    high: Any = None


def _day(value: Any) -> str:
    text = str(value) if isinstance(value, int | str) and not isinstance(value, bool) else ""
    try:
        if not re.fullmatch(DAY_PATTERN, text):
            raise ValueError
        last_day(text)
    except ValueError:
        hint = "write a day, a month or a year: 2026-11-24, 2026-11 or 2026"
        raise RefusalError(f"{show(value)} is no date", hint) from None
    return text


DAY_PATTERN = r"[0-9]{4}(-[0-9]{2}){0,2}"
DAY_SCHEMA = {"anyOf": [{"type": "string", "pattern": f"^{DAY_PATTERN}$"}, {"type": "integer"}]}

Day = Annotated[str, BeforeValidator(_day), WithJsonSchema(DAY_SCHEMA)]
"""A day, a month or a year: ``2026-11-24``, ``2026-11``, ``2026``."""


class _FullPrice(_FullFigure):
    makes = Price

    date: Day | None = None


class _OwnPrice(_FullPrice):
    status: Status = Status.ASSUMED
    source: Annotated[str, Field(min_length=1)] = DECLARED


def _reader(read: Callable[[Any], Any], unit: str, full_form: type[_FullFigure] = _FullFigure) -> WrapValidator:
    def validate(value: Any, _handler: Callable[[Any], Any], info: ValidationInfo) -> Figure:
        if isinstance(value, Figure):
            return value
        if not isinstance(value, dict):
            return full_form.makes(read(value), unit, Status.ASSUMED, DECLARED)
        full = full_form.model_validate(value, context=info.context)
        value_, low, high = (_read_at(read, full, key) for key in ("value", "low", "high"))
        for key, bound in (("low", low), ("high", high)):
            outside = bound is not None and (bound > value_ if key == "low" else bound < value_)
            if outside:
                side = "above" if key == "low" else "below"
                raise RefusalError(f"{getattr(full, key)} is {side} the value {full.value}", f"correct {key}", (key,))
        return full.makes(**{**vars(full), "value": value_, "unit": unit, "low": low, "high": high})

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


def _json_schema(short: dict[str, Any], what: str, full_form: type[_FullFigure] = _FullFigure) -> WithJsonSchema:
    numbers = dict.fromkeys(("value", "low", "high"), short)
    status = {"enum": [str(status) for status in Status]}
    properties = {"source": {"type": "string", "minLength": 1}, "date": DAY_SCHEMA, "status": status} | numbers
    keys = full_form.model_fields
    full = {
        "type": "object",
        "properties": {key: properties[key] for key in keys},
        "required": [key for key, field in keys.items() if field.is_required()],
        "additionalProperties": False,
    }
    return WithJsonSchema({"anyOf": [short, full], "description": what})


def _quantity_text(dimension: Dimension) -> dict[str, Any]:
    """The JSON Schema of a number with a unit."""
    scale = SCALES[dimension]
    units = "|".join(re.escape(unit) for unit in scale.units)
    pattern = rf"^[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)? *({units})$"
    return {"type": "string", "pattern": pattern, "examples": [scale.example]}


_AS_MAPPING = PlainSerializer(lambda figure: {**vars(figure), "status": str(figure.status)})


def _measured(
    dimension: Dimension, unit: str, scale: Fraction = Fraction(1), full_form: type[_FullFigure] = _FullFigure
) -> tuple[Any, ...]:
    """The annotations that make a field a figure of a dimension, with its value in ``unit``."""
    what = f"A {dimension} with its unit, or a mapping that also cites where it comes from."
    schema = _json_schema(_quantity_text(dimension), what, full_form)
    return _reader(_quantity(dimension, scale), unit, full_form), _AS_MAPPING, schema


def _counted(least: int) -> tuple[Any, ...]:
    """The annotations that make a field a figure that is a whole number."""
    short = {"type": "integer", "minimum": least, "maximum": MAX_COUNT}
    schema = _json_schema(short, "A whole number, or a mapping that also cites where it comes from.")
    return _reader(_count(least), "1"), _AS_MAPPING, schema


def _ratio(least: float, most: float, what: str) -> tuple[Any, ...]:
    """The annotations that make a field a figure that is a factor or a share."""

    def read(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise RefusalError(f"{show(value)} is not a number", "write it without a unit, such as 0.5")
        if not least <= value <= most:
            raise RefusalError(f"{value} is out of bounds", f"from {least:g} to {most:,g}")
        return float(value)

    short = {"type": "number", "minimum": least, "maximum": most}
    schema = _json_schema(short, f"A number {what}, or a mapping that also cites where it comes from.")
    return _reader(read, "1"), _AS_MAPPING, schema


def _chosen(dimension: Dimension) -> tuple[Any, ...]:
    """The annotations that make a field a bare quantity: a choice of the user's, which has no source."""
    read = _quantity(dimension)

    def validate(value: Any, _handler: Callable[[Any], Any]) -> int | float:
        return read(value)

    return WrapValidator(validate), WithJsonSchema(_quantity_text(dimension))


TimeFigure = Annotated[Figure, *_measured(Dimension.TIME, "ps")]
"""A time; ``Figure.value`` is an int, ps."""

FrequencyFigure = Annotated[Figure, *_measured(Dimension.FREQUENCY, "Hz")]
"""A frequency; ``Figure.value`` is an int, Hz."""

PowerFigure = Annotated[Figure, *_measured(Dimension.POWER, "W")]
"""A power; ``Figure.value`` in W."""

SlicePowerFigure = Annotated[Figure, *_measured(Dimension.POWER, "W/(slice Hz)", Fraction(1, 10**6))]
"""Dynamic power, written for one slice and MHz; ``Figure.value`` in W for one slice and Hz."""

LengthFigure = Annotated[Figure, *_measured(Dimension.LENGTH, "m")]
"""A length; ``Figure.value`` in m."""

SpeedFigure = Annotated[Figure, *_measured(Dimension.SPEED, "m/s")]
"""A speed; ``Figure.value`` in m/s."""

AccelerationFigure = Annotated[Figure, *_measured(Dimension.ACCELERATION, "m/s^2")]
"""An acceleration; ``Figure.value`` in m/s²."""

TurnRateFigure = Annotated[Figure, *_measured(Dimension.TURN_RATE, "rad/s")]
"""A rate of turning; ``Figure.value`` in rad/s."""

PriceFigure = Annotated[Price, *_measured(Dimension.MONEY, "USD", full_form=_FullPrice)]
"""A price; ``Price.value`` in US dollars."""

OwnPriceFigure = Annotated[Price, *_measured(Dimension.MONEY, "USD", full_form=_OwnPrice)]
"""The same in a file of prices: without a status it is assumed, without a source declared there."""

FactorFigure = Annotated[Figure, *_ratio(MIN_FACTOR, MAX_FACTOR, "above 0")]
"""A number above 0 that something else is multiplied with; ``Figure.value`` is a float."""

ShareFigure = Annotated[Figure, *_ratio(0.0, MOST_LOAD, f"from 0 to {MOST_LOAD:g}")]
"""A share that leaves something, such as the load of a processor; ``Figure.value`` is a float."""

DataFigure = Annotated[Figure, *_measured(Dimension.DATA, "b")]
"""An amount of data; ``Figure.value`` is an int, bits."""

CountFigure = Annotated[Figure, *_counted(0)]
"""A number of things, 0 included; ``Figure.value`` is an int."""

PositiveFigure = Annotated[Figure, *_counted(1)]
"""A number of things, at least 1; ``Figure.value`` is an int."""

Duration = Annotated[int, *_chosen(Dimension.TIME)]
"""A time that the user chooses, ps."""

Length = Annotated[float, *_chosen(Dimension.LENGTH)]
"""A length that the user chooses, m."""

Speed = Annotated[float, *_chosen(Dimension.SPEED)]
"""A speed that the user chooses, m/s."""
