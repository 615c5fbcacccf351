"""Listeners that keep the records of a run: in memory, or in an MCAP file.

The file is complete or absent, and the same records give the same bytes.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, TypeVar

from codesign.errors import TraceError
from codesign.files import is_special, landing, passing
from codesign.records import MapRecord, Record, SummaryRecord
from codesign.trace.encoding import GRIDS, bared, encode, is_bare, schema_name, schema_of, topic_of
from codesign.trace.foxglove import Floor, floor_of
from codesign.trace.views import Views

R = TypeVar("R", bound=Record)

LIBRARY = "hwsw-codesign"
FORMAT = "1"
"""Increased when a reader of the old format would misread the new one."""

CHUNK_BYTES = 2**16
"""A chunk is written when its records have so many bytes. A killed run loses at most the last chunk.

Stages resemble each other, so larger chunks compress better: the trace of the labyrinth (14 stages of 60 to 90 KB)
takes 329 KB, and 211 KB with chunks of 1 MiB.
"""

RUN = "run"
RUN_ATTACHMENT = "run.json"
RESULT_ATTACHMENT = "result.json"


class MemoryListener:
    """Keeps the records of a run in the order of emission, in ``records``."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def __call__(self, record: Record) -> None:
        """Keep one record."""
        self.records.append(record)

    def of(self, record_type: type[R]) -> list[R]:
        """The records of one class, in the order of emission."""
        return [record for record in self.records if isinstance(record, record_type)]


class McapListener:
    """Writes every record to an MCAP file.

    - ``path``: the file, overwritten at the end. ``identity``: texts that identify the run (names, digests, seed,
      version). They are written into the metadata ``run`` and the attachment ``run.json``. No clock, host or user is
      written.

    The file is written under a temporary name beside ``path`` (a dot, the name, ``.part``) and renamed by ``close``. As
    a context manager it closes at the end of the block. If an exception or Ctrl-C ends the block, the temporary file is
    removed: a trace is complete or absent. Only a killed process leaves its temporary file.

    The attachment ``result.json`` is the result of the ``SummaryRecord``.

    Raises:
        TraceError: the file cannot be made or written (missing folder, no permission, full disk). The temporary file is
            removed.
    """

    def __init__(self, path: str | Path, identity: Mapping[str, str] | None = None) -> None:
        from mcap.writer import Writer

        self.path = Path(path)
        # A symbolic link is followed and kept. A long name is cut, because the temporary name is longer.
        self._target = landing(self.path)
        self._part = self._target.with_name(f".{self._target.name[:16]}.{os.getpid()}-{id(self):x}.part")
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._count = 0
        self._floor = Floor()
        self._views = Views()
        self._finished = False
        self._stream: BinaryIO | None = None
        self._held = ExitStack()
        if self.path.is_dir():
            raise TraceError("is a folder", str(self.path), "name a file in it")
        if is_special(self.path):
            raise TraceError("is no regular file", str(self.path), "name a regular file: a trace needs one")
        with self._guard():
            self._held.enter_context(passing(self._part))
            self._stream = self._part.open("xb")
            self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, enable_data_crcs=True)
            self._writer.start(profile="", library=LIBRARY)
            run = {"format": FORMAT, **(identity or {})}
            self._writer.add_metadata(RUN, run)
        self.attach(RUN_ATTACHMENT, "application/json", _json(run))

    def __call__(self, record: Record) -> None:
        """Write one record, then the views of it, with its ``time`` rounded down to nanoseconds.

        Raises:
            TraceError: see the class. Also: a trace cannot hold the record, or the file is closed.
        """
        if isinstance(record, MapRecord):
            self._floor = floor_of(record)
        # A mission may plan a thousand times, so its fields are left out here and written by the views at intervals.
        written = bared(record) if self._views.mission else record
        message = encode(written, self._floor)
        self._count += 1
        self._write(self._record_channel(written), record.time, message)
        for view in self._views.of(record):
            metadata = {"source": view.source, "shows": type(record).__name__}
            self._write(
                self._channel(view.topic, view.schema, view.schema_json, metadata), record.time, view.data
            )
        if isinstance(record, SummaryRecord):
            self.attach(RESULT_ATTACHMENT, "application/json", _json(record.result))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, such as the text of a spec.

        Raises:
            TraceError: see the class.
        """
        with self._guard():
            self._writer.add_attachment(
                create_time=0, log_time=0, name=name, media_type=media_type, data=data
            )

    def close(self) -> None:
        """Finish the file and rename it to ``path``. A second call does nothing.

        Raises:
            TraceError: see the class.
        """
        if self._finished:
            return
        with self._guard():
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._close_stream()
            self._part.replace(self._target)
        self._finished = True
        self._held.close()

    def abort(self) -> None:
        """Remove the temporary file. After ``close`` it does nothing."""
        if self._finished:
            return
        self._finished = True
        with suppress(OSError):
            self._close_stream()
        self._held.close()

    def __enter__(self) -> McapListener:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    def _close_stream(self) -> None:
        if self._stream is not None:
            self._stream.close()

    def _write(self, channel: int, time: int, message: bytes) -> None:
        with self._guard():
            self._writer.add_message(
                channel_id=channel,
                log_time=time // 1000,
                publish_time=time // 1000,
                sequence=self._count,
                data=message,
            )

    def _record_channel(self, record: Record) -> int:
        kind, bare = type(record), is_bare(record)
        topic, schema = topic_of(kind, record.source), schema_name(kind, bare)
        channel = self._channels.get((topic, schema))
        if channel is not None:
            return channel
        metadata = {"record": kind.__name__, "source": record.source}
        if kind in GRIDS and not bare:
            metadata["grid"] = GRIDS[kind]
        return self._channel(topic, schema, schema_of(kind, bare), metadata)

    def _channel(self, topic: str, schema: str, schema_json: bytes, metadata: dict[str, str]) -> int:
        """The channel of a topic and a schema. A new channel, and a new schema, are registered."""
        key = topic, schema
        if key not in self._channels:
            with self._guard():
                if schema not in self._schemas:
                    self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", schema_json)
                self._channels[key] = self._writer.register_channel(
                    topic, "json", self._schemas[schema], metadata
                )
        return self._channels[key]

    @contextmanager
    def _guard(self) -> Iterator[None]:
        """Remove the temporary file where a write fails, and raise a ``TraceError``."""
        if self._finished:
            raise TraceError("is closed", str(self.path), "emit no record after the end of the run")
        try:
            yield
        except OSError as fault:
            self.abort()
            raise TraceError(
                f"cannot be written: {fault.strerror or fault}",
                str(self.path),
                "name a file in a folder that exists, can be written to and has free space",
            ) from fault


def _json(value: Any) -> bytes:
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n"
