"""The type and the default of a key, in the words of the reference pages."""

from __future__ import annotations

import re
import types
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from enum import Enum
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from codesign.ground.figures import Figure, ResultFigure
from codesign.ground.units import Dimension, format_quantity
from codesign.inputs import fields as field_types
from codesign.maps import Radius

FIGURES = {
    "TimeFigure": "time",
    "FrequencyFigure": "frequency",
    "PowerFigure": "power",
    "SlicePowerFigure": "power",
    "LengthFigure": "length",
    "SpeedFigure": "speed",
    "AccelerationFigure": "acceleration",
    "TurnRateFigure": "rate of turning",
    "DataFigure": "amount of data",
    "PriceFigure": "price",
    "OwnPriceFigure": "price",
    "FactorFigure": "factor",
    "CountFigure": "count",
    "PositiveFigure": "count from 1",
}
"""The dimension of a figure of each type in ``codesign.inputs.fields``."""

QUANTITIES = {"Duration": "time", "Length": "length", "Speed": "speed", "Day": "day, month or year"}
"""The same of the plain quantities, which have no source, and of dates."""

SCALARS: Mapping[Any, str] = {
    int: "whole number",
    float: "number",
    bool: "`true` or `false`",
    str: "text",
    Any: "any value",
    types.NoneType: "null",
}


def type_text(annotation: Any, metadata: tuple[Any, ...] = ()) -> str:
    """The values that a type accepts, in words, such as ``whole number, from 1 to 1,024``."""
    if get_origin(annotation) is Annotated:
        inner, *more = get_args(annotation)
        return type_text(inner, (*more, *metadata))
    named = "[row, column]" if annotation == field_types.Cell else _named(metadata)
    if named is not None:
        return named
    return _generic_text(annotation, metadata) if get_args(annotation) else _class_text(annotation, metadata)


def _generic_text(annotation: Any, metadata: tuple[Any, ...]) -> str:
    """Of a union, a literal, a list, a mapping."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return " or ".join(f"`{each}`" for each in arguments)
    if origin is tuple and arguments[1:] != (Ellipsis,):
        return f"[{', '.join(map(type_text, arguments))}]"
    if origin in {tuple, list}:
        return _bounded(f"list of {_plural(type_text(arguments[0]))}", metadata, "entries")
    if origin is dict:
        return f"mapping of names to {_plural(type_text(arguments[1]))}"
    members = [each for each in arguments if each is not types.NoneType]
    return " or ".join(dict.fromkeys(type_text(each, metadata if len(members) == 1 else ()) for each in members))


def _class_text(annotation: Any, metadata: tuple[Any, ...]) -> str:
    """Of a model, an enumeration, a scalar."""
    if annotation is ResultFigure:
        return "name of a [figure](workload.md#figures)"
    if annotation is Radius:
        return "length or cells"
    is_class = isinstance(annotation, type)
    if is_class and (issubclass(annotation, BaseModel) or is_dataclass(annotation)):
        return "mapping"
    if is_class and issubclass(annotation, Enum):
        return " or ".join(f"`{member.value}`" for member in annotation)
    return _bounded(SCALARS.get(annotation, str(annotation)), metadata)


def _named(metadata: tuple[Any, ...]) -> str | None:
    """The name of a figure, a quantity, a name or a cell, by what its type in ``inputs.fields`` is annotated with."""
    for alias, text in {**FIGURES, **QUANTITIES}.items():
        wanted = get_args(getattr(field_types, alias))[1]
        if any(part is wanted for part in metadata):
            return text if alias in QUANTITIES else f"figure ({text})"
    pattern = get_args(field_types.Name)[1].pattern
    return "name" if any(getattr(part, "pattern", None) == pattern for part in _flat(metadata)) else None


def _flat(metadata: tuple[Any, ...]) -> Iterator[Any]:
    for part in metadata:
        yield part
        yield from getattr(part, "metadata", None) or ()


def _bounded(text: str, metadata: tuple[Any, ...], of: str = "") -> str:
    """The text with the bounds that the metadata of a field give."""
    bounds: dict[str, Any] = {}
    for part in _flat(metadata):
        for name in ("ge", "gt", "le", "lt", "min_length", "max_length"):
            value = getattr(part, name, None)
            if value is not None:
                bounds[name] = value
    least = bounds.get("min_length" if of else "ge")
    most = bounds.get("max_length" if of else "le")
    words = []
    if least is not None and least == most:
        words.append(_number(least))
    elif least is not None and most is not None:
        words.append(f"from {_number(least)} to {_number(most)}")
    elif least is not None:
        words.append(f"at least {_number(least)}")
    elif most is not None:
        words.append(f"at most {_number(most)}")
    if "gt" in bounds:
        words.append(f"above {_number(bounds['gt'])}")
    if "lt" in bounds:
        words.append(f"below {_number(bounds['lt'])}")
    if not words:
        return text
    return f"{text}, {' and '.join(words)}{' ' + of if of else ''}"


def _number(value: float) -> str:
    if isinstance(value, int) and value >= 2**20:
        for power in (24, 31, 32, 53, 63, 64):
            for less in (0, 1):
                if value == 2**power - less:
                    return f"2^{power}" + (" - 1" if less else "")
    return f"{value:,}" if isinstance(value, int) else f"{value:g}"


def _plural(text: str) -> str:
    first, comma, rest = text.partition(", ")
    if first.startswith(("figure", "name of")):
        return re.sub(r"^(figure|name)", r"\1s", text)
    plain = {"mapping": "mappings", "name": "names", "text": "texts", "number": "numbers"}
    plain |= {"whole number": "whole numbers", "any value": "values"}
    return plain.get(first, first) + (f" ({rest})" if comma and first in plain else comma + rest)


def default_text(info: FieldInfo) -> str:
    """The default of a key as a file has it; ``required`` where it has none."""
    if info.is_required():
        return "required"
    default = info.default
    if isinstance(default, BaseModel):
        default = {key: value for key, value in default.model_dump().items() if value not in (None, (), {})}
    if default in (None, (), {}):
        return "none"
    return f"`{_flow(_as_written(default, info))}`" if default != "" else "empty"


def _as_written(default: Any, info: FieldInfo) -> Any:
    """A figure or a time with its unit."""
    if isinstance(default, Figure):
        return f"{default.value:g} {default.unit}"
    if isinstance(default, int) and type_text(info.annotation, tuple(info.metadata)) == "time":
        return format_quantity(default, Dimension.TIME) if default else "0 s"
    return default


def _flow(value: Any) -> str:
    """A value as YAML writes it on one line."""
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_flow, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_flow(each)}' for key, each in value.items())}}}"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
