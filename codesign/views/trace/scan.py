"""Scan the records of an MCAP file in order. Each is bounded before it is read, and checked before it is used.

The ``mcap`` library's own readers trust lengths: a record may claim 2^64 bytes, and a chunk may decompress to any size.
So only its record parsers are used here.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError

from codesign.ground.errors import TraceError
from codesign.ground.progress import Show, silent, tracked

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
