"""Read traces of any origin. No content of a file is trusted, and a cut file gives its complete part.

The file is read from its start and not by the index at its end, for three reasons: the data count and not the index, a
cut file has no index, and records are in the order of emission.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from mcap import records as mcap
from numpy.typing import NDArray

from codesign.ground.errors import TraceError, choose_hint, printable
from codesign.ground.progress import Show, silent
from codesign.ground.records import RECORD_TYPES, ArrayOf, Record, SummaryRecord
from codesign.ground.units import counted, format_count, format_time
from codesign.version import __version__
from codesign.views.trace.arrays import has_shape
from codesign.views.trace.listeners import FORMAT, RUN
from codesign.views.trace.messages import checked, decode
from codesign.views.trace.scan import DamagedError, scan
from codesign.views.trace.schemas import FieldPlan, agrees, message_class, plan_of
from codesign.views.trace.values import MAX_ELEMENTS, parse_json

# Decode the messages of older traces: JSON, with arrays in base64 and maps as foxglove.Grid.

_MAX_INTEGER = 2**63 - 1
_PYTHON_TYPES: dict[str, tuple[type, ...]] = {
    "int64": (int,),
    "double": (int, float),
    "string": (str,),
    "bool": (bool,),
    "mapping": (dict,),
}


def decode_json(record_type: type[Record], message: bytes) -> Record:
    """The record of a message.

    Raises:
        TraceError: the message is no ``record_type``.
    """
    data = parse_json(message)
    if not isinstance(data, dict):
        _refuse(record_type, "not a JSON object")
    return checked(record_type(**{plan.name: _field(record_type, plan, data) for plan in plan_of(record_type)}))


def _field(record_type: type[Record], plan: FieldPlan, data: dict[str, Any]) -> Any:
    if plan.name == record_type.ROLE.grid:
        assert plan.array is not None
        if record_type.ROLE.spare_grid and "data" not in data:
            return np.zeros((0, 0), plan.array.dtype)
        return _grid(data, np.dtype(plan.array.dtype))
    if plan.name not in data:
        if plan.optional or plan.has_default:
            return plan.default
        _refuse(record_type, f"{plan.name} is missing")
    value = data[plan.name]
    if plan.array is not None:
        return _array(record_type, plan.name, plan.array, value)
    # bool is a subclass of int in Python, but not a number in JSON.
    if type(value) not in _PYTHON_TYPES[plan.kind] or (type(value) in (int, float) and abs(value) > _MAX_INTEGER):
        _refuse(record_type, f"{plan.name} is no {plan.kind}")
    return float(value) if plan.kind == "double" else value


def _array(record_type: type[Record], name: str, form: ArrayOf, value: Any) -> NDArray[Any]:
    if not isinstance(value, dict) or value.get("dtype") != form.dtype:
        _refuse(record_type, f"{name} is no {form.dtype} array")
    shape = value.get("shape")
    if not isinstance(shape, list) or not all(type(side) is int and side >= 0 for side in shape):
        _refuse(record_type, f"{name} has no shape")
    if not has_shape(form, shape):
        _refuse(record_type, f"{name} has shape {shape[:4]}")
    size, dtype = math.prod(shape), np.dtype(form.dtype)
    if size > MAX_ELEMENTS:
        _refuse(record_type, f"{name} has {size} elements, more than 2^24")
    data = _bytes(value.get("data"))
    if len(data) != size * dtype.itemsize:
        _refuse(record_type, f"{name} has {len(data)} bytes for {size} elements")
    return np.frombuffer(data, dtype.newbyteorder("<")).astype(dtype).reshape(shape)


def _grid(message: dict[str, Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """The array of a ``foxglove.Grid``: bool, where 1 is an obstacle, or float64. Its last row stands first."""
    itemsize = dtype.itemsize
    columns, text = message.get("column_count"), message.get("data")
    if type(columns) is not int or not 0 < columns <= MAX_ELEMENTS or not isinstance(text, str):
        raise TraceError("a grid without columns or data")
    if len(text) > MAX_ELEMENTS * itemsize * 4 // 3 + 4:
        raise TraceError(f"a grid of more than {MAX_ELEMENTS} cells")
    data = _bytes(text)
    if message.get("cell_stride") != itemsize or len(data) % (columns * itemsize):
        raise TraceError(f"a grid of {len(data)} bytes with {columns} columns of {itemsize} bytes")
    if dtype == np.dtype(bool):
        cells = np.frombuffer(data, np.uint8).reshape(-1, columns)
        if cells.size and cells.max() > 1:
            raise TraceError("a map with cells that are neither free nor occupied")
        free: NDArray[Any] = np.flipud(cells) == 0
        return free
    return np.flipud(np.frombuffer(data, "<f8").reshape(-1, columns)).astype(np.float64)


def _bytes(text: Any) -> bytes:
    if not isinstance(text, str):
        raise TraceError("an array without its base64 text")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as fault:
        raise TraceError(f"an array that is not base64: {fault}") from fault


def _refuse(record_type: type[Record], why: str) -> NoReturn:
    raise TraceError(f"no {record_type.__name__}: {why}")


MAX_ATTACHED_BYTES = 2**26
"""Most bytes of all attachments and metadata together."""

RESULT_ATTACHMENT = "result.json"
"""The place of the result in older files."""

MAX_NAMED = 10_000
"""Most channels of a file, and most attachments and metadata records."""


@dataclass
class Channel:
    """A channel: its topic, the name of its schema, its origin, its number of messages, and their encoding.

    ``record`` is the name of the record class and ``source`` the component. Both are empty in files of other programs.
    """

    topic: str
    schema: str
    record: str
    source: str
    messages: int = 0
    encoding: str = ""


@dataclass(frozen=True)
class Attachment:
    """Named data in the file."""

    media_type: str
    data: bytes


@dataclass(repr=False)
class Trace:
    """An opened trace.

    - ``size``: bytes. ``library``: the program that wrote the file, according to the file.
    - ``channels``: in the order of their first appearance.
    - ``begin``, ``end``: the first and the last time of a message, ps, to the nanosecond; None without
      messages.
    - ``metadata``: texts, by name of the metadata record. ``attachments``: by name.
    - ``fault``: why reading stopped before the end of the file; None for a complete file.
    - ``show``: is told how far the reading of records is. ``last_summary``: the message with the result.
      ``schemas``: the schemas of the file, by name. ``agreed``: the ones that were found equal to this version's.
    """

    path: Path
    size: int = 0
    library: str = ""
    channels: list[Channel] = field(default_factory=list)
    begin: int | None = None
    end: int | None = None
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, Attachment] = field(default_factory=dict)
    fault: str | None = None
    show: Show = field(default=silent, repr=False, compare=False)
    last_summary: tuple[Channel, Any] | None = field(default=None, repr=False, compare=False)
    schemas: dict[str, bytes] = field(default_factory=dict, repr=False, compare=False)
    agreed: set[str] = field(default_factory=set, repr=False, compare=False)

    def __repr__(self) -> str:
        fate = "" if self.complete else ", not complete"
        counts = f"{counted(len(self.channels), 'channel')}, {counted(self.messages, 'message')}"
        return f"Trace({printable(str(self.path))}: {counts}{fate})"

    @property
    def complete(self) -> bool:
        """True if the file is complete and its checksums are right."""
        return self.fault is None

    @property
    def messages(self) -> int:
        """Messages in all channels."""
        return sum(channel.messages for channel in self.channels)

    @property
    def record_messages(self) -> int:
        """The number of records that ``records`` returns: messages of record classes that this version knows."""
        return sum(channel.messages for channel in self.channels if channel.record in RECORD_TYPES)

    @property
    def result(self) -> Any:
        """The result of the run as parsed JSON; None where the file has none.

        Raises:
            TraceError: the attachment is no JSON, or a later version wrote the file.
        """
        self._check_format()
        if self.last_summary is not None:
            return vars(self._record(*self.last_summary))["result"]
        attachment = self.attachments.get(RESULT_ATTACHMENT)
        if attachment is None:
            return None
        try:
            return parse_json(attachment.data)
        except TraceError as fault:
            raise TraceError(fault.what, f"{self.path}: {RESULT_ATTACHMENT}", fault.hint) from fault

    def records(self, topics: Sequence[str] = (), kinds: Sequence[type[Record]] = ()) -> Iterator[Record]:
        """The records of the run in the order of emission, of the given topics and classes; by default of all.

        A topic may be a pattern (``/fpga/*``). Messages of record classes that this version does not know, and messages
        for viewers, are left out. In a cut file the records end at the cut.

        Raises:
            TraceError: no topic matches, a message does not agree with its channel, the file has changed, or a later
                version wrote it in a format that this one would misread.
        """
        self._check_format()
        present = sorted({channel.topic for channel in self.channels})
        for topic in topics:
            if not any(fnmatchcase(name, topic) for name in present):
                raise TraceError(f"no topic {topic!r}", str(self.path), choose_hint(topic, present))
        channels = _Channels()
        names = {kind.__name__ for kind in kinds or RECORD_TYPES.values()}
        try:
            for item in scan(self.path, self.show):
                message = channels.message(item)
                if message is not None and message[0].record in names:
                    yield from self._decoded(*message, topics)
        except DamagedError as fault:
            if self.complete:
                raise TraceError(f"has changed since it was opened: {fault}", str(self.path)) from fault

    def summary(self) -> dict[str, Any]:
        """The facts about the file, ready for JSON: times in ps, sizes in bytes."""
        return {
            "path": str(self.path),
            "size": self.size,
            "complete": self.complete,
            "fault": self.fault,
            "library": self.library,
            "messages": self.messages,
            "begin": self.begin,
            "end": self.end,
            "channels": [asdict(channel) for channel in self.channels],
            "metadata": self.metadata,
            "attachments": self._attachment_sizes(),
        }

    def rows(self) -> list[tuple[str, str]]:
        """Name and value of each fact, for print. Texts of the file are made printable."""
        span = "no messages"
        if self.begin is not None and self.end is not None:
            span = f"{format_time(self.begin)} to {format_time(self.end)}"
        rows = [
            ("file", printable(str(self.path), None)),
            ("size", f"{format_count(self.size)} bytes"),
            ("complete", "yes" if self.fault is None else f"no, only the part before: {printable(self.fault)}"),
            ("written by", printable(self.library)),
            ("messages", format_count(self.messages)),
            ("simulated time", span),
        ]
        for name, texts in self.metadata.items():
            rows += [(f"{printable(name)}.{printable(key)}", printable(text)) for key, text in texts.items()]
        sizes = self._attachment_sizes().items()
        return rows + [(f"attachment {printable(name)}", f"{format_count(size)} bytes") for name, size in sizes]

    def channel_rows(self) -> list[tuple[str, str, int]]:
        """Topic, schema and number of messages of each channel, for print."""
        return [(printable(each.topic), printable(each.schema), each.messages) for each in self.channels]

    def _attachment_sizes(self) -> dict[str, int]:
        return {name: len(attachment.data) for name, attachment in self.attachments.items()}

    def _decoded(self, channel: Channel, message: Any, topics: Sequence[str]) -> Iterator[Record]:
        record_type = RECORD_TYPES.get(channel.record)
        if record_type is None or (topics and not any(fnmatchcase(channel.topic, topic) for topic in topics)):
            return
        yield self._record(channel, message)

    def _record(self, channel: Channel, message: Any) -> Record:
        kind = RECORD_TYPES[channel.record]
        message_class(kind)  # A fault of this installation is no fault of the file.
        try:
            if channel.encoding == "json":  # older files
                return decode_json(kind, message.data)
            self._check_schema(kind, channel.schema)
            return decode(kind, message.data, message.log_time)
        except TraceError as fault:
            place = f"{self.path}: {channel.topic[:80]!r}: message {message.sequence}"
            damaged = "the file was damaged, or not written by hwsw"
            hint = fault.hint or (damaged if self._version in ("", __version__) else self._other)
            raise TraceError(fault.what, place, hint) from fault

    def _check_schema(self, kind: type[Record], schema: str) -> None:
        """Another version may have written the records with other fields. A file without schemas is believed."""
        written = self.schemas.get(schema)
        if written and schema not in self.agreed:
            if not agrees(kind, written):
                raise TraceError(
                    f"{kind.__name__} has other fields in the file than in this version", None, self._other
                )
            self.agreed.add(schema)

    def _check_format(self) -> None:
        written = self.metadata.get(RUN, {}).get("format", FORMAT)[:9]
        if written.isdecimal() and int(written) > int(FORMAT):
            what = f"has format {written} of traces, and this version reads up to {FORMAT}"
            raise TraceError(what, str(self.path), self._other)

    @property
    def _version(self) -> str:
        return self.metadata.get(RUN, {}).get("codesign", "")

    @property
    def _other(self) -> str:
        """The remedy where another version wrote the file."""
        by = f"hwsw {printable(self._version)}" if self._version else "another version or program"
        return f"{by} wrote it, this is hwsw {__version__}: read it with what wrote it"


def open_trace(path: str | Path, show: Show = silent) -> Trace:
    """Open an MCAP file and read it once, for its contents and to check that it is complete.

    ``show`` is told how far it is, now and whenever the records are read.

    Raises:
        TraceError: the file cannot be read, is no MCAP file, is too large, or has no readable content.
    """
    trace = Trace(Path(path), show=show)
    channels = _Channels()
    attached = 0
    try:
        for item in scan(trace.path, show):
            message = channels.message(item)
            if message is not None:
                _count(trace, *message)
            else:
                attached += _attach(trace, item)
            if attached > MAX_ATTACHED_BYTES or len(trace.attachments) + len(trace.metadata) > MAX_NAMED:
                raise DamagedError("more attachments and metadata than a trace has")
    except DamagedError as fault:
        trace.fault = str(fault)
    try:
        trace.size = trace.path.stat().st_size
    except OSError as fault:
        raise TraceError(f"cannot be read: {fault.strerror or fault}", str(path)) from fault
    trace.channels, trace.schemas = list(channels.by_id.values()), channels.forms
    if trace.fault and not (trace.channels or trace.metadata or trace.attachments):
        raise TraceError(f"has no readable content: {trace.fault}", str(path), "record the run again: hwsw run --trace")
    return trace


def _count(trace: Trace, channel: Channel, message: Any) -> None:
    channel.messages += 1
    if channel.record == SummaryRecord.__name__:
        trace.last_summary = channel, message
    time = message.log_time * 1000
    trace.begin = time if trace.begin is None else min(trace.begin, time)
    trace.end = time if trace.end is None else max(trace.end, time)


def _attach(trace: Trace, item: Any) -> int:
    """Keep a header, attachment or metadata record. Returns its bytes."""
    if isinstance(item, mcap.Header):
        trace.library = item.library
    elif isinstance(item, mcap.Attachment):
        trace.attachments[item.name] = Attachment(item.media_type, item.data)
        return len(item.data) + len(item.name)
    elif isinstance(item, mcap.Metadata):
        trace.metadata[item.name] = item.metadata
        if item.name == RUN:
            trace.library = item.metadata.get("library", trace.library)
        return len(item.name) + sum(len(key) + len(text) for key, text in item.metadata.items())
    return 0


class _Channels:
    """The channels of a file in order of appearance, by number."""

    def __init__(self) -> None:
        self.by_id: dict[int, Channel] = {}
        self.forms: dict[str, bytes] = {}
        self._schemas: dict[int, str] = {0: ""}

    def message(self, item: Any) -> tuple[Channel, Any] | None:
        """A message with its channel, None for all other records. Schemas and channels are registered."""
        if isinstance(item, mcap.Message):
            if item.channel_id not in self.by_id:
                raise DamagedError(f"a message of channel {item.channel_id}, which is not declared")
            return self.by_id[item.channel_id], item
        if isinstance(item, mcap.Schema):
            self._schemas[item.id], self.forms[item.name] = item.name, item.data
        elif isinstance(item, mcap.Channel):
            if item.schema_id not in self._schemas or len(self.by_id) > MAX_NAMED:
                raise DamagedError(f"a channel of schema {item.schema_id}, which is not declared")
            names = item.metadata.get("record", ""), item.metadata.get("source", "")
            schema = self._schemas[item.schema_id]
            channel = Channel(item.topic, schema, *names, 0, item.message_encoding)
            self.by_id[item.id] = self.by_id.get(item.id, channel)
        return None
