"""Read traces of any origin. No content of a file is trusted, and a cut file gives its complete part.

The file is read from its start and not by the index at its end, for three reasons: the data count and not the index, a
cut file has no index, and records are in the order of emission.
"""

from __future__ import annotations

import base64
import binascii
import math
import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import lz4.frame  # type: ignore[import-untyped]
import numpy as np
import zstandard
from mcap import records
from mcap import records as mcap
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from numpy.typing import NDArray

from codesign.ground.errors import TraceError, choose_hint, printable
from codesign.ground.progress import Show, silent, tracked
from codesign.ground.records import RECORD_TYPES, ArrayOf, Record, SummaryRecord
from codesign.ground.units import counted, format_count, format_time
from codesign.version import __version__
from codesign.views.trace.listeners import FORMAT, RUN
from codesign.views.trace.messages import (
    MAX_ELEMENTS,
    FieldPlan,
    agrees,
    checked,
    decode,
    has_shape,
    message_class,
    parse_json,
    plan_of,
)

# Scan the records of an MCAP file in order. Each is bounded before it is read, and checked before it is used.

MAX_FILE_BYTES = 2**32
"""Most bytes of a file: 4 GiB."""

MAX_RECORD_BYTES = 2**28
"""Most bytes of a record, and of a decompressed chunk. A grid of 2^24 float64 cells fits."""

_MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")

_FOOTER, _MESSAGE, _CHUNK, _ATTACHMENT, _DATA_END = 0x02, 0x05, 0x06, 0x09, 0x0F


class DamagedError(Exception):
    """The file is cut or damaged here. All records before are good."""


def scan(path: Path, show: Show = silent) -> Iterator[Any]:
    """``Header, Schema, Channel, Message, Attachment, Metadata`` objects of ``mcap.records``, in file order.

    Chunks are decompressed, and indexes are left out. A file that is read to its end without an error is complete.
    ``show`` is told how many bytes were read.

    Raises:
        TraceError: the file cannot be opened, is too large, or is no MCAP file.
        DamagedError: the file is cut short or damaged.
    """
    try:
        if not path.is_file():
            what = "is no file" if path.exists() else "does not exist"
            raise TraceError(what, str(path), "name an MCAP file")
        with path.open("rb") as stream:
            size = path.stat().st_size
            if size > MAX_FILE_BYTES:
                raise TraceError(f"has {size} bytes, more than 4 GiB", str(path), "record a shorter run")
            if stream.read(len(_MAGIC)) != _MAGIC:
                what = "is no MCAP file" if size else "is empty"
                raise TraceError(what, str(path), "name a file that hwsw run --trace wrote")
            yield from _data(stream, size, show)
    except OSError as fault:
        raise TraceError(f"cannot be read: {fault.strerror or fault}", str(path)) from fault


def _data(stream: BinaryIO, size: int, show: Show) -> Iterator[Any]:
    """Everything after the magic bytes."""
    data_crc = zlib.crc32(_MAGIC)
    summary_crc: int | None = None
    frames = tracked(
        _frames(stream), show, "bytes of the trace read", size, size=lambda each: _HEAD.size + len(each[2])
    )
    for opcode, head, body in frames:
        if opcode == _FOOTER:
            _check_end(stream, head, body, summary_crc)
            return
        if summary_crc is not None:
            summary_crc = zlib.crc32(body, zlib.crc32(head, summary_crc))
        elif opcode == _DATA_END:
            _check(body, data_crc, "the data")
            summary_crc = 0
        else:
            data_crc = zlib.crc32(body, zlib.crc32(head, data_crc))
            if opcode == _CHUNK:
                for inner, _, content in _frames(BytesIO(_unpacked(body))):
                    yield from _parsed(inner, content)
            else:
                yield from _parsed(opcode, body)
    raise DamagedError("the file is cut short")


def _frames(stream: BinaryIO) -> Iterator[tuple[int, bytes, bytes]]:
    """Opcode, head and body of each record, up to the end of the stream."""
    while head := stream.read(_HEAD.size):
        if len(head) < _HEAD.size:
            raise DamagedError("the file is cut short")
        opcode, length = _HEAD.unpack(head)
        if length > MAX_RECORD_BYTES:
            raise DamagedError(f"a record of {length} bytes")
        body = stream.read(length)
        if len(body) < length:
            raise DamagedError("the file is cut short")
        yield opcode, head, body


_PARSERS: dict[int, Callable[[Any], Any]] = {
    0x01: records.Header.read,
    0x03: records.Schema.read,
    0x04: records.Channel.read,
    _ATTACHMENT: records.Attachment.read,
    0x0C: records.Metadata.read,
}


def _parsed(opcode: int, body: bytes) -> Iterator[Any]:
    """The record of a body, if ``scan`` returns records of its kind."""
    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == _MESSAGE:
            item = records.Message.read(stream, len(body))
        elif opcode in _PARSERS:
            item = _PARSERS[opcode](stream)
        else:
            return
    except (McapError, struct.error, ValueError, OverflowError) as fault:
        raise DamagedError(f"a record that cannot be parsed: {fault}") from fault
    if stream.count != len(body):
        raise DamagedError("a record with inconsistent lengths")
    if opcode == _ATTACHMENT:
        _check(body[-4:], zlib.crc32(body[:-4]), "an attachment")
    yield item


def _unpacked(body: bytes) -> bytes:
    """The bytes of a chunk, checked against its size and checksum."""
    try:
        chunk = records.Chunk.read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, ValueError, OverflowError) as fault:
        raise DamagedError(f"a chunk that cannot be parsed: {fault}") from fault
    if chunk.uncompressed_size > MAX_RECORD_BYTES:
        raise DamagedError(f"a chunk of {chunk.uncompressed_size} bytes")
    data = _decompressed(chunk.compression, chunk.data, chunk.uncompressed_size)
    if len(data) != chunk.uncompressed_size:
        raise DamagedError("a chunk with a wrong size")
    _check(chunk.uncompressed_crc.to_bytes(4, "little"), zlib.crc32(data), "a chunk")
    return data


def _decompressed(compression: str, data: bytes, size: int) -> bytes:
    """At most ``size`` + 1 decompressed bytes, whatever size the data claim."""
    if compression == "":
        return data
    if compression == "zstd":
        window = zstandard.ZstdDecompressor(max_window_size=MAX_RECORD_BYTES)
        try:
            with window.stream_reader(data) as reader:
                return bytes(reader.read(size + 1))
        except zstandard.ZstdError as fault:
            raise DamagedError(f"a chunk that cannot be decompressed: {fault}") from fault
    if compression == "lz4":
        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
        except RuntimeError as fault:
            raise DamagedError(f"a chunk that cannot be decompressed: {fault}") from fault
    raise DamagedError(f"a chunk with the unknown compression {compression[:20]!r}")


def _check(written: bytes, computed: int, what: str) -> None:
    """Check a little-endian checksum. 0: none was written."""
    if len(written) != 4 or int.from_bytes(written, "little") not in (0, computed):
        raise DamagedError(f"{what} with a wrong checksum")


def _check_end(stream: BinaryIO, head: bytes, body: bytes, summary_crc: int | None) -> None:
    if summary_crc is None or len(body) != 20 or stream.read(len(_MAGIC) + 1) != _MAGIC:
        raise DamagedError("a damaged end of the file")
    _check(body[16:], zlib.crc32(body[:16], zlib.crc32(head, summary_crc)), "the index")


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
