"""The listener that keeps the records of a run in an MCAP file, with views of them for Foxglove and Rerun.

The file is complete or absent, and the same records give the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import foxglove
from foxglove import Channel, Context, Schema, channels
from foxglove.mcap import MCAPCompression, MCAPWriteOptions, MCAPWriter

from codesign.ground.errors import TraceError
from codesign.ground.files import WholeOrAbsent, is_special, part_of, put
from codesign.ground.records import RECORD_TYPES, Level, Record, Recorder, Subject
from codesign.views.trace.messages import encoder_of
from codesign.views.trace.robots import Encoded
from codesign.views.trace.schemas import descriptor_set, schema_name, topic_of
from codesign.views.trace.views import Views

LIBRARY = "hwsw-codesign"
FORMAT = "2"
"""Increased when a reader of the old format would misread the new one. Format 1 had messages in JSON."""

CHUNK_BYTES = 2**20
"""A chunk is written when its records have so many bytes. A killed run loses at most the last chunk."""

COMPRESSION = 5
"""The level of zstd: up to 17 % smaller than its default of 3. Level 7 makes 4 % of that again, for twice the time."""

BATCH = 512
"""So many records are kept before they are written, so a killed run loses them too."""

RUN = "run"
RUN_ATTACHMENT = "run.json"


class McapListener(WholeOrAbsent, Recorder):
    """Writes records to an MCAP file, and views of them for Foxglove and Rerun.

    - ``path``: the file, overwritten at the end. ``identity``: texts that identify the run (names, digests, seed,
      version). They are written into the metadata ``run`` and the attachment ``run.json``. No clock, host or user is
      written. ``level``: how much is written (``Level``).

    The file is written under a temporary name beside ``path`` (a dot, the name, ``.part``) and renamed by ``close``. As
    a context manager it closes at the end of the block. If an exception or Ctrl-C ends the block, the temporary file is
    removed: a trace is complete or absent. Only a killed process leaves its temporary file, and all its complete chunks
    can be read until another trace is written there.

    Raises:
        TraceError: the file cannot be made or written (missing folder, no permission, full disk). The temporary file is
            removed.
    """

    def __init__(
        self, path: str | Path, identity: Mapping[str, str] | None = None, level: Level = Level.BLOCKS
    ) -> None:
        super().__init__(path)
        self.level = level
        self._part = part_of(self._target)
        self._channels: dict[tuple[type, str], Any] = {}
        self._shown: dict[str, Any] = {}
        self._taken: list[Record] = []
        self._time = 0
        if self.path.is_dir():
            raise TraceError("is a folder", str(self.path), "name a file in it")
        if is_special(self.path):
            raise TraceError("is no regular file", str(self.path), "name a regular file: a trace needs one")
        self._views, levels = Views(self._show), list(Level)
        above = levels[levels.index(level) + 1 :]
        self._unwanted = frozenset(kind for kind in RECORD_TYPES.values() if kind.ROLE.level in above)
        self._file: _File | None = None
        with self._guard():
            self._hold(self._part)
            self._file = _File(self._part.open("xb", buffering=0))
            self._context, self._writer = _writer(self._file)
        run = {"format": FORMAT, "library": LIBRARY, "level": level.value, **(identity or {})}
        self._writer.write_metadata(RUN, run)
        self.attach(RUN_ATTACHMENT, "application/json", _json(run))

    @property
    def unwanted(self) -> frozenset[type[Record]]:
        """The classes of records that its level leaves out."""
        return self._unwanted

    def __call__(self, record: Record) -> None:
        """Take one record. Records are written by hundreds, which takes less time than one by one.

        Raises:
            TraceError: see the class. Also: a trace cannot hold a record, or the file is closed.
        """
        if self._finished:
            self._refuse_closed()
        kind = type(record)
        if kind not in self._unwanted:
            self._taken.append(record)
            if len(self._taken) >= BATCH or kind.ROLE.grid or kind.ROLE.about is Subject.RESULT:
                self._flush()

    def _flush(self) -> None:
        taken, self._taken = self._taken, []
        for record in taken:
            self._put(record)
        self._check()

    def _put(self, record: Record) -> None:
        """Write one record, then its views. Their times are rounded down to nanoseconds."""
        for each in record.singles() if self.level is Level.ITERATIONS else (record,):
            # A mission may plan a thousand times, so its fields are left out here and shown by the views at intervals.
            is_bare = self._views.mission and self.level is not Level.ITERATIONS
            self._write(each.bare() if is_bare else each)
        self._time = record.time
        self._views.of(record)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, such as the text of a spec.

        Raises:
            TraceError: see the class.
        """
        if self._finished:
            self._refuse_closed()
        self._writer.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=data)
        self._check()

    def _finish(self) -> None:
        self._flush()
        self._views.finish(self._time)
        self._writer.close()
        self._check()
        with self._guard():
            self._drop()
            put(self._part, self._target)

    def _drop(self) -> None:
        if self._file is not None:
            self._file.raw.close()

    def _write(self, record: Record) -> None:
        kind = type(record)
        key = kind, record.source
        pair = self._channels.get(key)
        if pair is None:
            # Records of the run as a whole share a topic, whatever their source is.
            topic = kind, topic_of(kind, record.source)
            if topic not in self._channels:
                self._channels[topic] = _record_channel(kind, record.source, self._context)
            pair = self._channels[key] = encoder_of(kind), self._channels[topic].log
        encode, log = pair
        log(encode(record), record.time // 1000)

    def _show(self, topic: str, message: Any, time: int) -> None:
        channel = self._shown.get(topic)
        if channel is None:
            channel = self._shown[topic] = _view_channel(message, topic, self._context)
        channel.log(message.data if isinstance(message, Encoded) else message, log_time=time // 1000)

    def _check(self) -> None:
        """Report what the file could not take."""
        if self._file is not None and self._file.fault is not None:
            with self._guard():
                raise self._file.fault

    def _refuse_closed(self) -> None:
        raise TraceError("is closed", str(self.path), "emit no record after the end of the run")

    @contextmanager
    def _guard(self) -> Iterator[None]:
        """Remove the temporary file where a write fails, and raise a ``TraceError``."""
        try:
            yield
        except OSError as fault:
            self.abort()
            raise TraceError(
                f"cannot be written: {fault.strerror or fault}",
                str(self.path),
                "name a file in a folder that exists, can be written to and has free space",
            ) from fault


class _File:
    """A file for the writer of the SDK, which would only log a failed write: the first fault is kept in ``fault``.

    What the writer gives after a fault, or after the file was closed, is dropped.
    """

    def __init__(self, raw: BinaryIO) -> None:
        self.raw = raw
        self.fault: OSError | None = None
        self._at = 0

    def write(self, data: bytes) -> int:
        """Write all of ``data``."""
        if self.fault is None and not self.raw.closed:
            try:
                rest = memoryview(data)
                while rest:
                    rest = rest[self.raw.write(rest) :]
            except OSError as fault:
                self.fault = fault
        self._at += len(data)
        return len(data)

    def seek(self, _offset: int, _whence: int = 0) -> int:
        """Where the file is. The writer does not move (``disable_seeking``)."""
        return self._at

    def flush(self) -> None:
        """Nothing: the file has no buffer."""


def _writer(file: _File) -> tuple[Context, MCAPWriter]:
    """A writer of whole chunks: the header of a chunk is never written before its content."""
    context = foxglove.Context()
    options = MCAPWriteOptions(
        compression=MCAPCompression.Zstd,
        compression_level=COMPRESSION,
        chunk_size=CHUNK_BYTES,
        profile="",
        disable_seeking=True,
        compression_threads=0,
    )
    return context, foxglove.open_mcap(file, context=context, writer_options=options)  # type: ignore[arg-type]


def _record_channel(kind: type[Record], source: str, context: Context) -> Any:
    return Channel(
        topic_of(kind, source),
        message_encoding="protobuf",
        schema=Schema(name=schema_name(kind), encoding="protobuf", data=descriptor_set(kind)),
        metadata={"record": kind.__name__, "source": source},
        context=context,
    ).base


def _view_channel(message: Any, topic: str, context: Context) -> Any:
    if isinstance(message, Encoded):
        schema = message.kind.get_schema()
        return Channel(topic, message_encoding="protobuf", schema=schema, context=context).base
    return vars(channels)[f"{type(message).__name__}Channel"](topic, context=context)


def _json(value: Any) -> bytes:
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n"
