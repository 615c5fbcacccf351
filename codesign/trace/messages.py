"""Encode records as protobuf messages, and decode them. Messages and their descriptors follow from the record classes.

The message of ``VisitsRecord`` is ``codesign.VisitsRecord``. The number of a field is its place in the class, from 1.
New fields are added at the end, so numbers stay (``docs/reference/trace.proto`` holds them all):

    int     int64            n × 2 and 1-d int32 arrays     repeated sint32, packed, row by row
    float   double           1-d bool arrays                repeated bool, packed
    str     string           n × 2 and 1-d float64 arrays   repeated double, packed, row by row
    bool    bool             all other arrays               codesign.Array: shape, dtype, little-endian bytes
    dict    string, JSON

An array of bool is stored as ``bits``, and one of float64 as ``float32`` where that loses nothing.

A field that may be None, or that has a default, has presence: where a message lacks it, it has its default.

Decoding trusts no content: sizes are bounded and checked against shapes.
"""

from __future__ import annotations

import json
import math
import types
import typing
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from codesign import records
from codesign.errors import TraceError
from codesign.records import BeliefRecord, Record, VisitsRecord
from codesign.trace.values import MAX_ELEMENTS, MAX_MESSAGE_BYTES, parse_json

if TYPE_CHECKING:
    from google.protobuf.descriptor_pb2 import FileDescriptorProto

RECORD_TYPES: dict[str, type[Record]] = {
    name: item
    for name, item in vars(records).items()
    if isinstance(item, type) and issubclass(item, Record) and item is not Record
}
"""Every class of record by its name: the classes that a reader can decode."""

RUN_LEVEL = (records.MapRecord, records.TrajectoryRecord, records.MissionRecord, records.SummaryRecord)
"""Records of the run as a whole: their topics do not begin with the source."""

PACKAGE = "codesign"
ARRAY = "Array"

_SHAPES: dict[str, tuple[int | None, ...]] = {
    "goals": (None, 2),
    "points": (None, 2),
    "block": (None,),
    "iterations": (None,),
    "cells": (None, 2),
    "blocked": (None,),
    "positions": (None, 2),
    "origin": (3,),
    "ranges": (None,),
    "hidden": (None, 2),
}
"""The shapes of arrays that are packed, by field. None: any length."""

_GRIDS = ("free", "unknown", "potential", "values")
"""The arrays of two dimensions."""

BITS = "bits"
"""Eight bool values a byte, the first in the highest bit."""

_STORED = {"bool": (BITS,), "float64": ("float64", "float32")}
"""How the values of an array may be stored; those of every other dtype as they are."""

_PLAIN: dict[object, str] = {int: "int64", float: "double", str: "string", bool: "bool"}
_PACKED = {"int32": "sint32", "bool": "bool", "float64": "double"}


_PLANS: dict[type[Record], tuple[FieldPlan, ...]] = {}
_CLASSES: dict[type[Record], Any] = {}


@dataclass(frozen=True)
class FieldPlan:
    """How a field is encoded: a type of protobuf, ``mapping``, ``packed`` or ``array``.

    ``optional``: it may be None. ``default``: its value where a message lacks it, as messages of older files may.
    """

    name: str
    number: int
    kind: str
    optional: bool = False
    dtype: np.dtype[Any] | None = None
    has_default: bool = False
    default: Any = None

    @property
    def is_array(self) -> bool:
        """Whether its value is an array."""
        return self.dtype is not None

    @property
    def shape(self) -> tuple[int | None, ...]:
        """The shape of a packed array. None: any length."""
        return _SHAPES[self.name]

    @property
    def type_name(self) -> str:
        """The type in a ``.proto`` file, with its label."""
        if self.kind == "array":
            return ARRAY
        if self.kind == "packed":
            assert self.dtype is not None
            return f"repeated {_PACKED[self.dtype.name]}"
        kind = "string" if self.kind == "mapping" else self.kind
        return f"optional {kind}" if self.optional or self.has_default else kind


def topic_of(record_type: type[Record], source: str) -> str:
    """The topic of a record: ``/fpga/stage``, or ``/map`` for a record of the run as a whole.

    >>> topic_of(records.StageRecord, "fpga"), topic_of(records.MapRecord, "host")
    ('/fpga/stage', '/map')
    """
    kind = record_type.__name__.removesuffix("Record").lower()
    return f"/{kind}" if issubclass(record_type, RUN_LEVEL) else f"/{source}/{kind}"


def schema_name(record_type: type[Record]) -> str:
    """The full name of a record's message."""
    return f"{PACKAGE}.{record_type.__name__}"


def plan_of(record_type: type[Record]) -> tuple[FieldPlan, ...]:
    """The plans of a class's fields, in the order of its fields.

    Raises:
        TraceError: a field has a type that no message holds.
    """
    if record_type not in _PLANS:
        hints = typing.get_type_hints(record_type)
        _PLANS[record_type] = tuple(
            _field_plan(record_type, item.name, number, hints[item.name], item.default)
            for number, item in enumerate(fields(record_type), 1)
        )
    return _PLANS[record_type]


def _field_plan(
    record_type: type[Record], name: str, number: int, annotation: object, default: object
) -> FieldPlan:
    has_default = default is not MISSING
    filler = default if has_default else None
    optional = isinstance(annotation, types.UnionType)
    if optional:
        annotation = next(item for item in typing.get_args(annotation) if item is not types.NoneType)
    if typing.get_origin(annotation) is dict:
        return FieldPlan(name, number, "mapping", optional, None, has_default, filler)
    if typing.get_origin(annotation) is np.ndarray:
        (item,) = typing.get_args(typing.get_args(annotation)[1])
        dtype = np.dtype(item)
        kind = "packed" if name in _SHAPES and dtype.name in _PACKED else "array"
        return FieldPlan(name, number, kind, optional, dtype, has_default, filler)
    if annotation not in _PLAIN:
        _refuse(record_type, f"{name} has the type {annotation}, which no message holds")
    return FieldPlan(name, number, _PLAIN[annotation], optional, None, has_default, filler)


def descriptor_set(record_type: type[Record]) -> bytes:
    """The ``FileDescriptorSet`` of a record's message: all that a decoder needs."""
    from google.protobuf.descriptor_pb2 import FileDescriptorSet

    return bytes(FileDescriptorSet(file=_files(record_type)).SerializeToString(deterministic=True))


def _files(record_type: type[Record]) -> list[FileDescriptorProto]:
    from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto

    def file(name: str, message: DescriptorProto, *needed: str) -> FileDescriptorProto:
        path = f"{PACKAGE}/{name}.proto"
        return FileDescriptorProto(
            name=path, package=PACKAGE, syntax="proto3", message_type=[message], dependency=needed
        )

    plans, message = plan_of(record_type), DescriptorProto(name=record_type.__name__)
    for plan in plans:
        label, _, kind = plan.type_name.rpartition(" ")
        field = message.field.add(
            name=plan.name,
            number=plan.number,
            label=FieldDescriptorProto.LABEL_REPEATED
            if label == "repeated"
            else FieldDescriptorProto.LABEL_OPTIONAL,
        )
        if kind == ARRAY:
            field.type, field.type_name = FieldDescriptorProto.TYPE_MESSAGE, f".{PACKAGE}.{ARRAY}"
        else:
            field.type = FieldDescriptorProto.Type.Value(f"TYPE_{kind.upper()}")
        if label == "optional":
            field.proto3_optional, field.oneof_index = True, len(message.oneof_decl)
            message.oneof_decl.add(name=f"_{plan.name}")
    if not any(plan.kind == "array" for plan in plans):
        return [file(record_type.__name__, message)]
    array = DescriptorProto(name=ARRAY)
    array.field.add(name="shape", number=1, label="LABEL_REPEATED", type="TYPE_UINT32")
    array.field.add(name="dtype", number=2, label="LABEL_OPTIONAL", type="TYPE_STRING")
    array.field.add(name="data", number=3, label="LABEL_OPTIONAL", type="TYPE_BYTES")
    return [file(ARRAY, array), file(record_type.__name__, message, f"{PACKAGE}/{ARRAY}.proto")]


def message_class(record_type: type[Record]) -> Any:
    """The class of a record's messages. Each has a pool of its own, as classes of plug-ins may share a name."""
    from google.protobuf.descriptor_pool import DescriptorPool
    from google.protobuf.message_factory import GetMessageClass

    if record_type not in _CLASSES:
        pool = DescriptorPool()
        for file in _files(record_type):
            pool.Add(file)
        _CLASSES[record_type] = GetMessageClass(pool.FindMessageTypeByName(schema_name(record_type)))
    return _CLASSES[record_type]


def encoder_of(record_type: type[Record]) -> Callable[[Any], bytes]:
    """A function from a record of the class to its message, bytes.

    It raises TraceError where a value does not agree with the type of its field, or is too large.
    """
    plans, message = plan_of(record_type), message_class(record_type)
    plain = [plan for plan in plans if not plan.is_array and plan.kind != "mapping"]
    names, get = [plan.name for plan in plain], attrgetter(*(plan.name for plan in plain))
    maybe = {plan.name for plan in plain if plan.optional}
    others = [(plan.name, plan, attrgetter(plan.name)) for plan in plans if plan not in plain]

    def encode(record: Any) -> bytes:
        texts = get(record)
        values = dict(zip(names, texts, strict=True))
        if record.time < 0:
            _refuse(record_type, f"time {record.time}, before the run began")
        if None in texts and any(values[name] is None for name in names if name not in maybe):
            _refuse(record_type, "a field without a value")
        for name, plan, value_of in others:
            values[name] = _packed(record_type, plan, value_of(record))
        try:
            data = message(**values).SerializeToString()
        except (TypeError, ValueError) as fault:
            _refuse_values(record_type, values, fault)
        if len(data) > MAX_MESSAGE_BYTES:
            _refuse(record_type, f"{len(data)} bytes, more than a reader accepts")
        return bytes(data)

    return encode


def encode(record: Record) -> bytes:
    """The message of a record.

    Raises:
        TraceError: a value does not agree with the type of its field, or an array is too large.
    """
    return encoder_of(type(record))(record)


def _packed(record_type: type[Record], plan: FieldPlan, value: Any) -> Any:
    if value is None and plan.optional:
        return None
    if plan.kind == "mapping":
        return _json(record_type, value)
    assert plan.dtype is not None
    array = np.asarray(value)
    if array.size > MAX_ELEMENTS:
        _refuse(record_type, f"{plan.name} has {array.size} elements, more than 2^24")
    if array.dtype != plan.dtype and not np.can_cast(array.dtype, plan.dtype, casting="safe"):
        _refuse(record_type, f"{plan.name} is {array.dtype} in place of {plan.dtype}")
    if not _has_shape(plan.name, array.shape):
        _refuse(record_type, f"{plan.name} has shape {list(array.shape)}")
    if plan.kind == "packed":
        return array.ravel().tolist()
    return _array_message(array.astype(plan.dtype, copy=False))


def _array_message(array: NDArray[Any]) -> dict[str, Any]:
    """The fields of ``codesign.Array``, in fewer bytes where that loses nothing: bits, or float32."""
    if array.dtype == bool:
        return {"shape": array.shape, "dtype": BITS, "data": np.packbits(array).tobytes()}
    if array.dtype == np.float64:
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            half = array.astype(np.float32)
        if np.array_equal(half, array, equal_nan=True):
            array = half
    little = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return {"shape": array.shape, "dtype": array.dtype.name, "data": little.tobytes()}


_JSON = json.JSONEncoder(allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def _json(record_type: type[Record], value: Any) -> str:
    try:
        return _JSON.encode(value)
    except (TypeError, ValueError, RecursionError) as fault:
        raise TraceError(f"a {record_type.__name__} cannot be written as JSON: {fault}") from fault


def decode(record_type: type[Record], message: bytes) -> Record:
    """The record of a message.

    Raises:
        TraceError: the message is no ``record_type``.
    """
    from google.protobuf.message import DecodeError

    if len(message) > MAX_MESSAGE_BYTES:
        _refuse(record_type, f"{len(message)} bytes")
    parsed = message_class(record_type)()
    try:
        parsed.ParseFromString(message)
    except (DecodeError, UnicodeError) as fault:
        raise TraceError(f"no {record_type.__name__}: not such a protobuf message") from fault
    values = {plan.name: _decode_field(record_type, plan, parsed) for plan in plan_of(record_type)}
    return checked(record_type(**values))


def checked(record: Record) -> Record:
    """The record, with arrays that fit each other.

    Raises:
        TraceError: they do not, or its time lies before 0.
    """
    if record.time < 0:
        _refuse(type(record), f"time {record.time}")
    if isinstance(record, VisitsRecord) and record.block.shape != record.iterations.shape:
        _refuse(type(record), "the numbers of blocks and of iterations differ")
    if isinstance(record, BeliefRecord) and len(record.cells) != len(record.blocked):
        _refuse(type(record), "the numbers of cells and of blocked flags differ")
    return record


def _decode_field(record_type: type[Record], plan: FieldPlan, parsed: Any) -> Any:
    value = getattr(parsed, plan.name)
    if plan.kind == "packed":
        return plan.default if plan.optional and not value else _decode_packed(record_type, plan, value)
    if (plan.optional or plan.has_default or plan.kind == "array") and not parsed.HasField(plan.name):
        if plan.optional or plan.has_default:
            return plan.default
        _refuse(record_type, f"{plan.name} is missing")
    if plan.kind == "array":
        return _decode_array(record_type, plan, value)
    if plan.kind == "mapping":
        mapping = parse_json(value.encode())
        if not isinstance(mapping, dict):
            _refuse(record_type, f"{plan.name} is no mapping")
        return mapping
    return value


def _decode_packed(record_type: type[Record], plan: FieldPlan, values: Any) -> NDArray[Any]:
    size, shape = len(values), plan.shape
    if size > MAX_ELEMENTS:
        _refuse(record_type, f"{plan.name} has {size} elements, more than 2^24")
    width = 2 if len(shape) == 2 else 1
    if size % width or (shape[0] is not None and size != shape[0]):
        _refuse(record_type, f"{plan.name} has {size} elements")
    array = np.fromiter(values, plan.dtype, size)
    return array.reshape(-1, 2) if width == 2 else array


def _decode_array(record_type: type[Record], plan: FieldPlan, value: Any) -> NDArray[Any]:
    assert plan.dtype is not None
    if value.dtype not in _STORED.get(plan.dtype.name, (plan.dtype.name,)):
        _refuse(record_type, f"{plan.name} is no {plan.dtype} array")
    if len(value.shape) > 4 or not _has_shape(plan.name, tuple(value.shape)):
        _refuse(record_type, f"{plan.name} has shape {list(value.shape[:4])}")
    size, data = math.prod(value.shape), value.data
    if size > MAX_ELEMENTS:
        _refuse(record_type, f"{plan.name} has {size} elements, more than 2^24")
    bits = value.dtype == BITS
    stored = np.dtype(np.uint8 if bits else value.dtype)
    if len(data) != (-(-size // 8) if bits else size * stored.itemsize):
        _refuse(record_type, f"{plan.name} has {len(data)} bytes for {size} elements")
    flat = np.frombuffer(data, stored.newbyteorder("<"))
    return (np.unpackbits(flat, count=size) if bits else flat).astype(plan.dtype).reshape(value.shape)


def _has_shape(name: str, shape: tuple[int, ...]) -> bool:
    """Whether the field ``name`` may have this shape."""
    if name in _GRIDS:
        return len(shape) == 2
    accepted = _SHAPES.get(name, (None,) * len(shape))
    return len(shape) == len(accepted) and all(
        side in (None, length) for side, length in zip(accepted, shape, strict=True)
    )


def _refuse_values(record_type: type[Record], values: dict[str, Any], fault: Exception) -> NoReturn:
    for name, value in values.items():
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise TraceError(
                f"no {record_type.__name__}: {name} has {value.bit_length()} bits, more than 63",
                None,
                "a trace holds 106 days of simulated time: record a shorter run, or run without a trace",
            ) from fault
    raise TraceError(f"a {record_type.__name__} cannot be written: {str(fault)[:200]}") from fault


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")
