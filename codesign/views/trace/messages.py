"""Encode records as protobuf messages (``schemas`` has their fields), and decode them.

Decoding trusts no content: sizes are bounded and checked against shapes.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from operator import attrgetter
from typing import Any, NoReturn

from google.protobuf.message import DecodeError

from codesign.ground.errors import TraceError
from codesign.ground.records import Record
from codesign.views.trace.arrays import array_message, decode_array, decode_packed, packed
from codesign.views.trace.schemas import FieldPlan, message_class, plan_of
from codesign.views.trace.values import MAX_MESSAGE_BYTES, parse_json

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
    raise TraceError(
        f"no {record_type.__name__}: {name} has {value.bit_length()} bits, more than 63",
        None,
        "a trace holds 106 days of simulated time: record a shorter run, or run without a trace",
    )


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")
