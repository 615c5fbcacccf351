"""Reading traces, ours and others': nothing in a file is trusted, and a cut file gives all that is complete.

The file is read from its start, not by the index at its end: what stands in the data is what counts, a cut
file has no index, and records come in the order in which they were emitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from codesign.errors import TraceError, choose_hint
from codesign.records import Record
from codesign.trace.encoding import RECORD_TYPES, decode, parse_json
from codesign.trace.mcap import RESULT_ATTACHMENT
from codesign.trace.scan import DamagedError, scan

MAX_ATTACHED_BYTES = 2**26
"""Bytes of all attachments and metadata together."""

MAX_NAMED = 10_000
"""Channels, attachments and metadata records of a file, each."""


@dataclass
class Channel:
    """A channel: its topic, its schema's name, how many messages it has, and whose they are.

    ``record`` is the name of the record class and ``source`` the component; both are empty in a file that is
    not ours.
    """

    topic: str
    schema: str
    record: str
    source: str
    messages: int = 0


@dataclass(frozen=True)
class Attachment:
    """A named piece of data in the file."""

    media_type: str
    data: bytes


@dataclass
class Trace:
    """An opened trace.

    - ``size``: bytes. ``library``: who wrote the file, as it says itself.
    - ``channels``: in the order of their first appearance.
    - ``begin``, ``end``: the first and the last time of a message, ps, known to the nanosecond; None without
      messages.
    - ``metadata``: texts by name of the metadata record. ``attachments``: by name.
    - ``fault``: None for a whole file, or else why reading stopped before its end.
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

    @property
    def complete(self) -> bool:
        """Whether the file is whole, its checksums included."""
        return self.fault is None

    @property
    def messages(self) -> int:
        """Messages in all channels."""
        return sum(channel.messages for channel in self.channels)

    @property
    def record_messages(self) -> int:
        """Messages that are records known to this version: as many as ``records`` gives."""
        return sum(channel.messages for channel in self.channels if channel.record in RECORD_TYPES)

    @property
    def result(self) -> Any:
        """The result of the run, as JSON gives it; None where the file has none.

        Raises:
            TraceError: what the file holds in its place is no JSON.
        """
        attachment = self.attachments.get(RESULT_ATTACHMENT)
        if attachment is None:
            return None
        try:
            return parse_json(attachment.data)
        except TraceError as fault:
            raise TraceError(fault.what, f"{self.path}: {RESULT_ATTACHMENT}", fault.hint) from fault

    def records(self, topics: Sequence[str] = (), kinds: Sequence[type[Record]] = ()) -> Iterator[Record]:
        """The records of the run in the order of emission; of those topics, and of those classes, where any are named.

        A topic may be a pattern (``/fpga/*``). Messages whose record class this version does not know, and those
        made for viewers, are left out. In a cut file the records end where the file does.

        Raises:
            TraceError: no topic matches, a message is not what its channel says, or the file has changed.
        """
        known = sorted({channel.topic for channel in self.channels})
        for topic in topics:
            if not any(fnmatchcase(name, topic) for name in known):
                raise TraceError(f"no topic {topic!r}", str(self.path), choose_hint(topic, known))
        channels = _Channels()
        names = {kind.__name__ for kind in kinds or RECORD_TYPES.values()}
        try:
            for item in scan(self.path):
                found = channels.message(item)
                if found is not None and found[0].record in names:
                    yield from self._decoded(*found, topics)
        except DamagedError as fault:
            if self.complete:
                raise TraceError(f"has changed since it was opened: {fault}", str(self.path)) from fault

    def _decoded(self, channel: Channel, message: Any, topics: Sequence[str]) -> Iterator[Record]:
        record_type = RECORD_TYPES.get(channel.record)
        if record_type is None or (topics and not any(fnmatchcase(channel.topic, topic) for topic in topics)):
            return
        try:
            yield decode(record_type, message.data)
        except TraceError as fault:
            place = f"{self.path}: {channel.topic[:80]!r}: message {message.sequence}"
            raise TraceError(fault.what, place, "the file was damaged, or not written by hwsw") from fault


def open_trace(path: str | Path) -> Trace:
    """Open an MCAP file and read it through once: what is in it, and whether it is whole.

    Raises:
        TraceError: the file cannot be read, is no MCAP file, is too large, or holds nothing that can be read.
    """
    trace = Trace(Path(path))
    channels = _Channels()
    attached = 0
    try:
        for item in scan(trace.path):
            found = channels.message(item)
            if found is not None:
                _count(trace, *found)
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
    trace.channels = list(channels.by_id.values())
    if trace.fault and not (trace.channels or trace.metadata or trace.attachments):
        raise TraceError(
            f"holds nothing that can be read: {trace.fault}",
            str(path),
            "record the run again: hwsw run --trace",
        )
    return trace


def _count(trace: Trace, channel: Channel, message: Any) -> None:
    channel.messages += 1
    time = message.log_time * 1000
    trace.begin = time if trace.begin is None else min(trace.begin, time)
    trace.end = time if trace.end is None else max(trace.end, time)


def _attach(trace: Trace, item: Any) -> int:
    """Keep a header, attachment or metadata record; returns how many bytes that takes."""
    from mcap.records import Attachment as McapAttachment
    from mcap.records import Header, Metadata

    if isinstance(item, Header):
        trace.library = item.library
    elif isinstance(item, McapAttachment):
        trace.attachments[item.name] = Attachment(item.media_type, item.data)
        return len(item.data) + len(item.name)
    elif isinstance(item, Metadata):
        trace.metadata[item.name] = item.metadata
        return len(item.name) + sum(len(key) + len(text) for key, text in item.metadata.items())
    return 0


class _Channels:
    """The channels of a file as they appear, by their number."""

    def __init__(self) -> None:
        self.by_id: dict[int, Channel] = {}
        self._schemas: dict[int, str] = {0: ""}

    def message(self, item: Any) -> tuple[Channel, Any] | None:
        """A message with its channel; schemas and channels are taken note of, and all else is None."""
        from mcap.records import Channel as McapChannel
        from mcap.records import Message, Schema

        if isinstance(item, Message):
            if item.channel_id not in self.by_id:
                raise DamagedError(f"a message of channel {item.channel_id}, which is not declared")
            return self.by_id[item.channel_id], item
        if isinstance(item, Schema):
            self._schemas[item.id] = item.name
        elif isinstance(item, McapChannel):
            if item.schema_id not in self._schemas or len(self.by_id) > MAX_NAMED:
                raise DamagedError(f"a channel of schema {item.schema_id}, which is not declared")
            names = item.metadata.get("record", ""), item.metadata.get("source", "")
            self.by_id.setdefault(item.id, Channel(item.topic, self._schemas[item.schema_id], *names))
        return None
