"""Encode records as protobuf messages (``schemas`` has their fields), and decode them.

Decoding trusts no content: sizes are bounded and checked against shapes.
"""

from __future__ import annotations

import json
import math
import typing
from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, fields
from operator import attrgetter
from types import NoneType, UnionType
from typing import Any, NoReturn

import numpy as np
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError
from google.protobuf.message_factory import GetMessageClass
from numpy.typing import NDArray

from codesign.ground.errors import TraceError
from codesign.ground.records import ArrayOf, Record

# The protobuf messages of records: their fields and descriptors follow from the record classes.

# The arrays of records in protobuf messages: packed fields, and codesign.Array.

# Bounds of what a trace holds, and JSON that is parsed within them.

MAX_ELEMENTS = 2**24
"""Most elements of an array: the cells of the largest map."""

MAX_MESSAGE_BYTES = 2**28 - 2**22
"""Most bytes of a message. ``MAX_ELEMENTS`` float64 values take 128 MiB of them.

The chunk around it stays below the limit of readers (``scan.MAX_RECORD_BYTES``).
"""

MAX_SEPARATORS = 1_000_000
"""Most commas, brackets and braces of a JSON text. They bound the objects that parsing makes."""


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


PACKED_TYPES = {"int32": "sint32", "bool": "bool", "float64": "double"}
"""The type of protobuf of a packed array, by dtype."""

BITS = "bits"
"""Eight bool values a byte, the first in the highest bit."""

PLANES = "planes"
"""Differences of float64 values, byte by byte."""

_STORED = {"bool": (BITS,), "float64": ("float64", "float32", PLANES)}
"""The forms in which the values of an array may be stored; values of every other dtype are stored as they are."""


def packed(name: str, form: ArrayOf, value: Any) -> NDArray[Any]:
    """The value of field ``name`` as an array of this form.

    Raises:
        TraceError: it does not agree with the dtype or the shape of the field, or is too large.
    """
    array, dtype = np.asarray(value), np.dtype(form.dtype)
    if array.size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {array.size} elements, more than 2^24")
    if array.dtype != dtype and not np.can_cast(array.dtype, dtype, casting="safe"):
        raise TraceError(f"{name} is {array.dtype} in place of {dtype}")
    if not has_shape(form, array.shape):
        raise TraceError(f"{name} has shape {list(array.shape)}")
    return array.astype(dtype, copy=False)


def array_message(array: NDArray[Any]) -> dict[str, Any]:
    """The fields of ``codesign.Array``, in few bytes."""
    if array.dtype == bool:
        return {"shape": array.shape, "dtype": BITS, "data": np.packbits(array).tobytes()}
    if array.dtype == np.float64:
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            half = array.astype(np.float32)
        if not np.array_equal(half, array, equal_nan=True):
            differences = np.diff(np.ascontiguousarray(array).view("<u8").ravel(), prepend=np.uint64(0))
            planes = differences.astype("<u8", copy=False).view(np.uint8).reshape(-1, 8).T
            return {"shape": array.shape, "dtype": PLANES, "data": planes.tobytes()}
        array = half
    little = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return {"shape": array.shape, "dtype": array.dtype.name, "data": little.tobytes()}


def decode_packed(name: str, form: ArrayOf, values: Any) -> NDArray[Any]:
    """The array of a packed field.

    Raises:
        TraceError: it is too large, or has no shape of the field.
    """
    size, shape = len(values), form.shape
    if size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {size} elements, more than 2^24")
    rows, odd = divmod(size, math.prod(side or 1 for side in shape[1:]))
    if odd or shape[0] not in (None, rows):
        raise TraceError(f"{name} has {size} elements")
    return np.fromiter(values, form.dtype, size).reshape(rows, *(side or 1 for side in shape[1:]))


def decode_array(name: str, form: ArrayOf, message: Any) -> NDArray[Any]:
    """The array of a ``codesign.Array``.

    Raises:
        TraceError: it is too large, or does not agree with the dtype or the shape of the field.
    """
    if message.dtype not in _STORED.get(form.dtype, (form.dtype,)):
        raise TraceError(f"{name} is no {form.dtype} array")
    if not has_shape(form, message.shape):
        raise TraceError(f"{name} has shape {list(message.shape[:4])}")
    size, data = math.prod(message.shape), message.data
    if size > MAX_ELEMENTS:
        raise TraceError(f"{name} has {size} elements, more than 2^24")
    bits, planes = message.dtype == BITS, message.dtype == PLANES
    stored = np.dtype(np.uint8 if bits else "<u8" if planes else message.dtype).newbyteorder("<")
    if len(data) != (-(-size // 8) if bits else size * stored.itemsize):
        raise TraceError(f"{name} has {len(data)} bytes for {size} elements")
    if planes:
        lowest_first = np.ascontiguousarray(np.frombuffer(data, np.uint8).reshape(8, -1).T)
        values = np.cumsum(lowest_first.view(stored).ravel(), dtype=np.uint64).view(np.float64)
        return values.reshape(message.shape)
    flat = np.frombuffer(data, stored)
    return (np.unpackbits(flat, count=size) if bits else flat).astype(form.dtype).reshape(message.shape)


def has_shape(form: ArrayOf, shape: Sequence[int]) -> bool:
    """True if an array of this form may have this shape."""
    return len(shape) == len(form.shape) and all(
        side in (None, length) for side, length in zip(form.shape, shape, strict=True)
    )


PACKAGE = "codesign"
ARRAY = "Array"

TIME, PICOSECONDS = "time", "picoseconds"
"""The time of a record, and what its message has of it: the picoseconds after the whole nanoseconds."""

_PLAIN: dict[object, str] = {int: "int64", float: "double", str: "string", bool: "bool"}

_PLANS: dict[type[Record], tuple[FieldPlan, ...]] = {}
_CLASSES: dict[type[Record], Any] = {}


@dataclass(frozen=True)
class FieldPlan:
    """The encoding of a field: a type of protobuf, ``mapping``, ``packed`` or ``array``.

    ``name``: of the record's field, ``stored``: of the message's field. ``after``: a time, stored as ps after the time
    of the record. ``optional``: it may be None. ``array``: the form of an array. ``default``: its value if a message
    lacks it, as messages of older files may.
    """

    name: str
    number: int
    kind: str
    optional: bool = False
    array: ArrayOf | None = None
    has_default: bool = False
    default: Any = None
    after: bool = False

    @property
    def stored(self) -> str:
        """The name in the message."""
        return PICOSECONDS if self.name == TIME else self.name

    @property
    def type_name(self) -> str:
        """The type in a ``.proto`` file, with its label."""
        if self.kind == "array":
            return ARRAY
        if self.kind == "packed":
            assert self.array is not None
            return f"repeated {PACKED_TYPES[self.array.dtype]}"
        if self.name == TIME:
            return "uint32"
        kind = "string" if self.kind == "mapping" else "sint64" if self.after else self.kind
        return f"optional {kind}" if self.optional or self.has_default else kind


def topic_of(record_type: type[Record], source: str) -> str:
    """The topic of a record: ``/fpga/stage``, or ``/map`` for a record of the run as a whole.

    >>> from codesign.ground.records import MapRecord, StageRecord
    >>> topic_of(StageRecord, "fpga"), topic_of(MapRecord, "host")
    ('/fpga/stage', '/map')
    """
    return f"/{record_type.called()}" if record_type.ROLE.of_run else f"/{source}/{record_type.called()}"


def schema_name(record_type: type[Record]) -> str:
    """The full name of a record's message."""
    return f"{PACKAGE}.{record_type.__name__}"


def plan_of(record_type: type[Record]) -> tuple[FieldPlan, ...]:
    """The plans of a class's fields, in the order of its fields.

    Raises:
        TraceError: a field has a type that no message holds.
    """
    if record_type not in _PLANS:
        hints = typing.get_type_hints(record_type, include_extras=True)
        _PLANS[record_type] = tuple(
            _field_plan(record_type, item.name, number, hints[item.name], item.default)
            for number, item in enumerate(fields(record_type), 1)
        )
    return _PLANS[record_type]


def _field_plan(record_type: type[Record], name: str, number: int, annotation: Any, default: object) -> FieldPlan:
    has_default = default is not MISSING
    filler = default if has_default else None
    optional = typing.get_origin(annotation) in (typing.Union, UnionType)
    if optional:
        annotation = next(item for item in typing.get_args(annotation) if item is not NoneType)
    array = next((each for each in getattr(annotation, "__metadata__", ()) if isinstance(each, ArrayOf)), None)
    if array is not None:
        kind = "packed" if (array.dtype in PACKED_TYPES and None not in array.shape[1:]) else "array"
    elif typing.get_origin(annotation) is dict:
        kind = "mapping"
    elif annotation in _PLAIN:
        kind = _PLAIN[annotation]
    else:
        what = f"no {record_type.__name__}: {name} has the type {annotation}, which no message holds"
        hint = "name int, float, str, bool, dict, or an array with its form: Annotated[..., ArrayOf(dtype, shape)]"
        raise TraceError(what, None, hint)
    after = name in record_type.TIMES
    return FieldPlan(name, number, kind, optional, array, has_default, filler, after)


def descriptor_set(record_type: type[Record]) -> bytes:
    """The ``FileDescriptorSet`` of a record's message: all that a decoder needs."""
    return bytes(FileDescriptorSet(file=_files(record_type)).SerializeToString(deterministic=True))


def agrees(record_type: type[Record], written: bytes) -> bool:
    """True if messages of the ``FileDescriptorSet`` of a file are such records.

    They are if each field of the class has its name and type there, or is absent and has a default. So a later version
    may add fields, and nothing else.
    """

    def fields_of(files: Any) -> dict[int, tuple[Any, ...]]:
        messages = (each for file in files for each in file.message_type if each.name == record_type.__name__)
        return {
            each.number: (each.name, each.type, each.type_name, each.label)
            for message in messages
            for each in message.field
        }

    try:
        there = fields_of(FileDescriptorSet.FromString(written).file)
    except DecodeError:
        return False
    here = fields_of(_files(record_type))
    bare = {plan.number for plan in plan_of(record_type) if plan.optional or plan.has_default}
    return all(there.get(number, form if number in bare else None) == form for number, form in here.items())


def _files(record_type: type[Record]) -> list[FileDescriptorProto]:
    def file(name: str, message: DescriptorProto, *needed: str) -> FileDescriptorProto:
        path = f"{PACKAGE}/{name}.proto"
        return FileDescriptorProto(
            name=path, package=PACKAGE, syntax="proto3", message_type=[message], dependency=needed
        )

    plans, message = plan_of(record_type), DescriptorProto(name=record_type.__name__)
    for plan in plans:
        label, _, kind = plan.type_name.rpartition(" ")
        field = message.field.add(
            name=plan.stored,
            number=plan.number,
            label=FieldDescriptorProto.LABEL_REPEATED if label == "repeated" else FieldDescriptorProto.LABEL_OPTIONAL,
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
    if record_type not in _CLASSES:
        pool = DescriptorPool()
        for file in _files(record_type):
            pool.Add(file)
        _CLASSES[record_type] = GetMessageClass(pool.FindMessageTypeByName(schema_name(record_type)))
    return _CLASSES[record_type]


LONGEST = 2**63
"""A trace holds times before this, ps."""

KEPT = 4096
"""Messages of a class that are kept at most, to be used again."""

_PICOSECONDS = [b"", *(bytes([8, n]) if n < 128 else bytes([8, n & 127 | 128, n >> 7]) for n in range(1, 1000))]
"""Field 1 of each message, by its value."""


def encoder_of(record_type: type[Record]) -> Callable[[Any], bytes]:
    """A function from a record of the class to its message, bytes.

    It raises TraceError where a value does not agree with the type of its field, or is too large.
    """
    plans, message = plan_of(record_type), message_class(record_type)
    plain = [plan for plan in plans if plan.array is None and plan.kind != "mapping"]
    names, get = [plan.stored for plan in plain], attrgetter(*(plan.name for plan in plain))
    maybe = {plan.stored for plan in plain if plan.optional}
    after = [(place, plan.name) for place, plan in enumerate(plain) if plan.after]
    others = [(plan.name, plan, attrgetter(plan.name)) for plan in plans if plan not in plain]
    # Times after that of the record repeat, so many messages differ in their picoseconds alone, the first field.
    # Floats are not kept: -0.0 equals 0.0, and is stored otherwise.
    keep = not others and all(plan.kind != "double" for plan in plain)
    kept: dict[tuple[Any, ...], bytes] = {}

    def encode(record: Any) -> bytes:
        texts = list(get(record))
        time = record.time
        try:
            if not 0 <= time < LONGEST:
                _refuse_time(record_type, time)
            for place, name in after:
                if (value := texts[place]) is not None:
                    if not -LONGEST <= value < LONGEST:
                        _refuse_size(record_type, name, value)
                    texts[place] = value - time
            texts[0] = 0
            picoseconds: bytes = _PICOSECONDS[time % 1000]
            if not keep:
                return picoseconds + content(record, texts)
            key = tuple(texts)
            data: bytes | None = kept.get(key)
        except TypeError as fault:
            _refuse_values(record_type, dict(zip(names, texts, strict=True)), fault)
        if data is None:
            if len(kept) >= KEPT:
                kept.clear()
            data = kept[key] = content(record, texts)
        return picoseconds + data

    def content(record: Any, texts: list[Any]) -> bytes:
        values = dict(zip(names, texts, strict=True))
        if None in texts and any(values[name] is None for name in names if name not in maybe):
            _refuse(record_type, "a field without a value")
        try:
            for name, plan, value_of in others:
                values[name] = _stored(record_type, plan, value_of(record))
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


def _stored(record_type: type[Record], plan: FieldPlan, value: Any) -> Any:
    if value is None and plan.optional:
        return None
    if plan.kind == "mapping":
        return _json(record_type, value)
    assert plan.array is not None
    try:
        array = packed(plan.name, plan.array, value)
    except TraceError as fault:
        _refuse(record_type, fault.what)
    return array.ravel().tolist() if plan.kind == "packed" else array_message(array)


_JSON = json.JSONEncoder(allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def _json(record_type: type[Record], value: Any) -> str:
    try:
        return _JSON.encode(value)
    except (TypeError, ValueError, RecursionError) as fault:
        raise TraceError(f"a {record_type.__name__} cannot be written as JSON: {fault}") from fault


def decode(record_type: type[Record], message: bytes, nanoseconds: int) -> Record:
    """The record of a message. ``nanoseconds``: the log time of the message.

    Raises:
        TraceError: the message is no ``record_type``.
    """
    if len(message) > MAX_MESSAGE_BYTES:
        _refuse(record_type, f"{len(message)} bytes")
    parsed = message_class(record_type)()
    try:
        parsed.ParseFromString(message)
    except (DecodeError, UnicodeError) as fault:
        raise TraceError(f"no {record_type.__name__}: not such a protobuf message") from fault
    time = nanoseconds * 1000 + parsed.picoseconds
    if parsed.picoseconds >= 1000 or time >= LONGEST:
        _refuse(record_type, f"{parsed.picoseconds} ps after {nanoseconds} ns")
    try:
        values = {plan.name: _decode_field(plan, parsed, time) for plan in plan_of(record_type)}
    except TraceError as fault:
        _refuse(record_type, fault.what)
    return checked(record_type(**values | {"time": time}))


def checked(record: Record) -> Record:
    """The record, with arrays that fit each other.

    Raises:
        TraceError: they do not, or its time lies before 0.
    """
    if record.time < 0:
        _refuse(type(record), f"time {record.time}")
    alike = record.ROLE.alike
    if len({len(getattr(record, name)) for name in alike}) > 1:
        _refuse(type(record), f"the numbers of {' and of '.join(alike.values())} differ")
    return record


def _decode_field(plan: FieldPlan, parsed: Any, time: int) -> Any:
    value = getattr(parsed, plan.stored)
    if plan.kind == "packed":
        assert plan.array is not None
        return plan.default if plan.optional and not value else decode_packed(plan.name, plan.array, value)
    if (plan.optional or plan.has_default or plan.kind == "array") and not parsed.HasField(plan.stored):
        if plan.optional or plan.has_default:
            return plan.default
        raise TraceError(f"{plan.name} is missing")
    if plan.kind == "array":
        assert plan.array is not None
        return decode_array(plan.name, plan.array, value)
    if plan.kind == "mapping":
        mapping = parse_json(value.encode())
        if not isinstance(mapping, dict):
            raise TraceError(f"{plan.name} is no mapping")
        return mapping
    if not plan.after:
        return value
    if not -LONGEST <= time + value < LONGEST:
        raise TraceError(f"{plan.name} is {value} ps after the time")
    return time + value


def _refuse_values(record_type: type[Record], values: dict[str, Any], fault: Exception) -> NoReturn:
    for name, value in values.items():
        if isinstance(value, int) and not -LONGEST <= value < LONGEST:
            _refuse_size(record_type, name, value)
    raise TraceError(f"a {record_type.__name__} cannot be written: {str(fault)[:200]}") from fault


def _refuse_time(record_type: type[Record], time: int) -> NoReturn:
    if time < 0:
        _refuse(record_type, f"time {time}, before the run began")
    _refuse_size(record_type, "time", time)


def _refuse_size(record_type: type[Record], name: str, value: int) -> NoReturn:
    hint = "a trace holds 106 days of simulated time: record a shorter run, or run without a trace"
    raise TraceError(f"no {record_type.__name__}: {name} has {value.bit_length()} bits, more than 63", None, hint)


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")
