"""The protobuf messages of records: their fields and descriptors follow from the record classes.

The message of ``VisitsRecord`` is ``codesign.VisitsRecord``. The number of a field is its place in the class, from 1.
New fields are added at the end, so numbers stay (``docs/reference/trace.proto`` holds them all):

    int     int64            n × 2 and 1-d int32 arrays     repeated sint32, packed, row by row
    float   double           1-d bool arrays                repeated bool, packed
    str     string           n × 2 and 1-d float64 arrays   repeated double, packed, row by row
    bool    bool             all other arrays               codesign.Array: shape, dtype, little-endian bytes
    dict    string, JSON

Times are stored in few bytes. The log time of a message is the ``time`` of its record in ns, and the message has the
``picoseconds`` that are left. All other times of a record (``TIMES``) are sint64: ps after ``time``.

A field that may be None, or that has a default, has presence: where a message lacks it, it has its default.
"""

from __future__ import annotations

import typing
from dataclasses import MISSING, dataclass, fields
from types import NoneType, UnionType
from typing import Any

from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError
from google.protobuf.message_factory import GetMessageClass

from codesign.ground.errors import TraceError
from codesign.ground.records import ArrayOf, Record
from codesign.views.trace.arrays import PACKED_TYPES, is_packed

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
        kind = "packed" if is_packed(array) else "array"
    elif typing.get_origin(annotation) is dict:
        kind = "mapping"
    elif annotation in _PLAIN:
        kind = _PLAIN[annotation]
    else:
        raise TraceError(
            f"no {record_type.__name__}: {name} has the type {annotation}, which no message holds",
            None,
            "name int, float, str, bool, dict, or an array with its form: Annotated[..., ArrayOf(dtype, shape)]",
        )
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
