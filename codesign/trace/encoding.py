"""Encode records as JSON messages with JSON schemas, and decode them. Both follow from the fields of the classes.

An array is ``{"dtype", "shape", "data"}`` with little-endian bytes in base64. The chunks of the file compress it. A
record with a grid becomes a ``foxglove.Grid``. A pose or an event of a mission becomes the message of
``foxglove.STANDARDS``. The record's other fields are beside the standard ones. A field that is None is left out. A
missing field gets its default where it has one. The schemas use only what Foxglove's reader of JSON schemas accepts:
every property has one type, and every object has its properties.

Decoding trusts no content: sizes are bounded and checked against shapes, and types against the fields.
"""

from __future__ import annotations

import base64
import json
import math
import types
import typing
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from codesign import records
from codesign.errors import TraceError
from codesign.records import (
    BeliefRecord,
    FieldRecord,
    MapRecord,
    MissionRecord,
    Record,
    StageRecord,
    SummaryRecord,
    TrajectoryRecord,
    VisitsRecord,
)
from codesign.trace.foxglove import STANDARDS, Floor
from codesign.trace.grid import GRID_PROPERTIES, GRID_REQUIRED, decode_base64, decode_grid, encode_grid

MAX_ELEMENTS = 2**24
"""Most elements of an array: the cells of the largest map."""

MAX_MESSAGE_BYTES = 2**28 - 2**22
"""Most bytes of a message. The base64 of ``MAX_ELEMENTS`` float64 values takes 171 MiB of them.

The chunk around it stays below the limit of readers (``scan.MAX_RECORD_BYTES``).
"""

MAX_INTEGER = 2**63 - 1
"""The largest whole number of a record. As picoseconds it is 106 days of simulated time."""

MAX_SEPARATORS = 1_000_000
"""Most commas, brackets and braces of a message. They bound the objects that parsing makes."""

RECORD_TYPES: dict[str, type[Record]] = {
    name: item
    for name, item in vars(records).items()
    if isinstance(item, type) and issubclass(item, Record) and item is not Record
}
"""Every class of record by its name: the classes that a reader can decode."""

RUN_LEVEL = (MapRecord, TrajectoryRecord, MissionRecord, SummaryRecord)
"""Records of the run as a whole: their topics do not begin with the source."""

GRIDS: dict[type[Record], str] = {MapRecord: "free", StageRecord: "potential", FieldRecord: "values"}
"""The field of a record that viewers show as a grid."""

BARE = frozenset(GRIDS) - {MapRecord}
"""Record classes with a grid that may be left out: fields of plans. A mission has hundreds of them."""

# The shapes of the records' arrays, by field. None: any length.
_SHAPES: dict[str, tuple[int | None, ...]] = {
    "goals": (None, 2),
    "points": (None, 2),
    "block": (None,),
    "iterations": (None,),
    "cells": (None, 2),
    "blocked": (None,),
    "positions": (None, 2),
    "origin": (3,),
}
_JSON_TYPES: dict[object, str] = {int: "integer", float: "number", str: "string", bool: "boolean"}
_PYTHON_TYPES: dict[str, tuple[type, ...]] = {
    "integer": (int,),
    "number": (int, float),
    "string": (str,),
    "boolean": (bool,),
    "mapping": (dict,),
}


@dataclass(frozen=True)
class FieldPlan:
    """How a field is encoded: its JSON type, or ``array`` with a ``dtype``, ``mapping`` or ``grid``.

    ``default``: its value where a message lacks it, as messages of older files may.
    """

    name: str
    kind: str
    optional: bool = False
    dtype: np.dtype[Any] | None = None
    has_default: bool = False
    default: Any = None

    @property
    def required(self) -> bool:
        """Whether every message has it."""
        return not (self.optional or self.has_default)


_PLANS: dict[type[Record], tuple[FieldPlan, ...]] = {}


def topic_of(record_type: type[Record], source: str) -> str:
    """The topic of a record: ``/fpga/stage``, or ``/map`` for a record of the run as a whole.

    >>> topic_of(StageRecord, "fpga"), topic_of(MapRecord, "host")
    ('/fpga/stage', '/map')
    """
    kind = record_type.__name__.removesuffix("Record").lower()
    return f"/{kind}" if issubclass(record_type, RUN_LEVEL) else f"/{source}/{kind}"


def is_bare(record: Record) -> bool:
    """Whether the grid of this record is left out of its message. It is then decoded as an array of 0 × 0."""
    return type(record) in BARE and not getattr(record, GRIDS[type(record)]).size


def bared(record: Record) -> Record:
    """The record without its grid, where the grid may be left out."""
    if type(record) not in BARE:
        return record
    empty: dict[str, Any] = {GRIDS[type(record)]: np.zeros((0, 0))}
    return replace(record, **empty)


def schema_name(record_type: type[Record], bare: bool = False) -> str:
    """The name of a record's schema. ``bare``: the grid is left out."""
    if record_type in GRIDS and not bare:
        return "foxglove.Grid"
    standard = STANDARDS.get(record_type)
    return f"codesign.{record_type.__name__}" if standard is None else standard.schema


def schema_of(record_type: type[Record], bare: bool = False) -> bytes:
    """The JSON schema of a record's messages, UTF-8. All records with grids share one."""
    if record_type in GRIDS and not bare:
        properties = dict(GRID_PROPERTIES)
        for each in GRIDS:
            properties.update(_properties(each))
        required = [*GRID_REQUIRED, *(item.name for item in fields(Record))]
        about = "A grid; what else its record holds stands beside it"
    else:
        standard = STANDARDS.get(record_type)
        shown = {} if standard is None else standard.properties
        properties = {**shown, **_properties(record_type)}
        plans = [plan for plan in plan_of(record_type) if plan.required and plan.kind != "grid"]
        required = [*shown, *(plan.name for plan in plans)]
        about = (record_type.__doc__ or record_type.__name__).split("\n\n")[0]
    schema = {
        "title": schema_name(record_type, bare),
        "description": about,
        "type": "object",
        "properties": properties,
        "required": required,
    }
    return json.dumps(schema, ensure_ascii=False).encode()


_NO_FLOOR = Floor()


def encode(record: Record, floor: Floor = _NO_FLOOR) -> bytes:
    """The message of a record, UTF-8 JSON. ``floor``: the map of the record's grids and positions.

    Raises:
        TraceError: a value does not agree with the type of its field, or an array is too large.
    """
    message: dict[str, Any] = {}
    if record.time < 0:
        _refuse(type(record), f"time {record.time}, before the run began")
    for plan in plan_of(type(record)):
        value = getattr(record, plan.name)
        if (value is None and plan.optional) or (plan.kind == "grid" and is_bare(record)):
            continue
        if plan.kind == "grid":
            _bound(value.size, record, plan)
            if value.dtype != plan.dtype:
                raise TraceError(f"no grid: {plan.name} is {value.dtype} in place of {plan.dtype}")
            name = record.name if isinstance(record, FieldRecord) else plan.name
            message.update(encode_grid(value, record.time, floor, name))
        elif plan.kind == "array":
            message[plan.name] = _encode_array(record, plan, value)
        else:
            if isinstance(value, int) and abs(value) > MAX_INTEGER:
                _refuse_integer(record, plan.name, value)
            message[plan.name] = value
    standard = STANDARDS.get(type(record))
    if standard is not None:
        message.update(standard.fill(record, floor))
    return packed(type(record).__name__, message)


_JSON = json.JSONEncoder(allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def packed(name: str, message: dict[str, Any]) -> bytes:
    """A message as JSON, UTF-8. ``name``: of its class, for errors.

    Raises:
        TraceError: JSON cannot hold it, or it takes more than ``MAX_MESSAGE_BYTES``.
    """
    try:
        text = _JSON.encode(message).encode()
    except (TypeError, ValueError, RecursionError) as fault:
        raise TraceError(f"a {name} cannot be written as JSON: {fault}") from fault
    if len(text) > MAX_MESSAGE_BYTES:
        raise TraceError(f"no {name}: {len(text)} bytes of JSON, more than a reader accepts")
    return text


def decode(record_type: type[Record], message: bytes) -> Record:
    """The record of a message.

    Raises:
        TraceError: the message is no ``record_type``.
    """
    data = parse_json(message)
    if not isinstance(data, dict):
        _refuse(record_type, "not a JSON object")
    values = {plan.name: _decode_field(record_type, plan, data) for plan in plan_of(record_type)}
    record = record_type(**values)
    if record.time < 0:
        _refuse(record_type, f"time {record.time}")
    if isinstance(record, VisitsRecord) and record.block.shape != record.iterations.shape:
        _refuse(record_type, "the numbers of blocks and of iterations differ")
    if isinstance(record, BeliefRecord) and len(record.cells) != len(record.blocked):
        _refuse(record_type, "the numbers of cells and of blocked flags differ")
    return record


def parse_json(text: bytes) -> Any:
    """The value of a JSON text of bounded size and depth, without NaN and infinities.

    Raises:
        TraceError: the text is not such JSON.
    """
    separators = sum(text.count(mark) for mark in (b",", b"[", b"{"))
    if separators > MAX_SEPARATORS:
        raise TraceError(f"a JSON text with {separators} values", None, "the file was not written by hwsw")
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as fault:
        raise TraceError(f"not JSON of a trace: {str(fault)[:120]}") from fault


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


def plan_of(record_type: type[Record]) -> tuple[FieldPlan, ...]:
    """How each field of a record class is encoded.

    Raises:
        TraceError: a trace cannot hold the type of a field.
    """
    if record_type not in _PLANS:
        hints = typing.get_type_hints(record_type)
        grid = GRIDS.get(record_type)
        _PLANS[record_type] = tuple(
            _defaulted(_plan(record_type, item.name, hints[item.name], grid), item.default)
            for item in fields(record_type)
        )
    return _PLANS[record_type]


def _plan(record_type: type[Record], name: str, hint: Any, grid: str | None) -> FieldPlan:
    optional = False
    if isinstance(hint, types.UnionType):
        options = [option for option in typing.get_args(hint) if option is not types.NoneType]
        optional, hint = True, options[0] if len(options) == 1 else None
    if hint in _JSON_TYPES:
        return FieldPlan(name, _JSON_TYPES[hint], optional)
    origin = typing.get_origin(hint)
    if origin is dict:
        return FieldPlan(name, "mapping", optional)
    if origin is np.ndarray:
        dtype = np.dtype(typing.get_args(typing.get_args(hint)[1])[0])
        return FieldPlan(name, "grid" if name == grid else "array", optional, dtype)
    raise TraceError(f"a trace cannot hold {record_type.__name__}.{name}, a {hint}")


def _defaulted(plan: FieldPlan, default: Any) -> FieldPlan:
    return plan if default is MISSING else replace(plan, has_default=True, default=default)


def _properties(record_type: type[Record]) -> dict[str, Any]:
    return {plan.name: _property(plan) for plan in plan_of(record_type) if plan.kind != "grid"}


def _property(plan: FieldPlan) -> dict[str, Any]:
    if plan.kind == "mapping":
        return {"type": "object", "properties": {}}
    if plan.kind != "array":
        return {"type": plan.kind}
    return {
        "type": "object",
        "properties": {
            "dtype": {"type": "string"},
            "shape": {"type": "array", "items": {"type": "integer"}},
            "data": {"type": "string", "contentEncoding": "base64"},
        },
        "required": ["dtype", "shape", "data"],
    }


def _encode_array(record: Record, plan: FieldPlan, value: Any) -> dict[str, Any]:
    assert plan.dtype is not None
    array = np.asarray(value)
    _bound(array.size, record, plan)
    if not np.can_cast(array.dtype, plan.dtype, casting="safe"):
        _refuse(type(record), f"{plan.name} is {array.dtype} in place of {plan.dtype}")
    if not _has_shape(plan.name, list(array.shape)):
        _refuse(type(record), f"{plan.name} has shape {list(array.shape)}")
    data = array.astype(plan.dtype.newbyteorder("<")).tobytes()
    return {
        "dtype": plan.dtype.name,
        "shape": list(array.shape),
        "data": base64.b64encode(data).decode("ascii"),
    }


def _bound(size: int, record: Record, plan: FieldPlan) -> None:
    if size > MAX_ELEMENTS:
        _refuse(type(record), f"{plan.name} has {size} elements, more than 2^24")


def _decode_field(record_type: type[Record], plan: FieldPlan, data: dict[str, Any]) -> Any:
    if plan.kind == "grid":
        assert plan.dtype is not None
        if record_type in BARE and "data" not in data:
            return np.zeros((0, 0), plan.dtype)
        return decode_grid(data, plan.dtype, MAX_ELEMENTS)
    if plan.name not in data:
        if not plan.required:
            return plan.default
        _refuse(record_type, f"{plan.name} is missing")
    value = data[plan.name]
    if plan.kind == "array":
        return _decode_array(record_type, plan, value)
    # bool is a subclass of int in Python, but not a number in JSON.
    if type(value) not in _PYTHON_TYPES[plan.kind] or (
        type(value) in (int, float) and abs(value) > MAX_INTEGER
    ):
        _refuse(record_type, f"{plan.name} is no {plan.kind}")
    return float(value) if plan.kind == "number" else value


def _decode_array(record_type: type[Record], plan: FieldPlan, value: Any) -> NDArray[Any]:
    assert plan.dtype is not None
    if not isinstance(value, dict) or value.get("dtype") != plan.dtype.name:
        _refuse(record_type, f"{plan.name} is no {plan.dtype} array")
    shape = value.get("shape")
    if (
        not isinstance(shape, list)
        or len(shape) > 4
        or not all(type(side) is int and side >= 0 for side in shape)
    ):
        _refuse(record_type, f"{plan.name} has no shape")
    if not _has_shape(plan.name, shape):
        _refuse(record_type, f"{plan.name} has shape {shape[:4]}")
    size = math.prod(shape)
    if size > MAX_ELEMENTS:
        _refuse(record_type, f"{plan.name} has {size} elements, more than 2^24")
    data = decode_base64(value.get("data"))
    if len(data) != size * plan.dtype.itemsize:
        _refuse(record_type, f"{plan.name} has {len(data)} bytes for {size} elements")
    return np.frombuffer(data, plan.dtype.newbyteorder("<")).astype(plan.dtype).reshape(shape)


def _has_shape(name: str, shape: list[int]) -> bool:
    """Whether the field ``name`` may have this shape."""
    accepted = _SHAPES.get(name, (None,) * len(shape))
    return len(shape) == len(accepted) and all(
        side in (None, length) for side, length in zip(accepted, shape, strict=True)
    )


def _refuse_integer(record: Record, name: str, value: int) -> NoReturn:
    raise TraceError(
        f"no {type(record).__name__}: {name} has {value.bit_length()} bits, more than 63",
        None,
        "a trace holds 106 days of simulated time: record a shorter run, or run without a trace",
    )


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")
