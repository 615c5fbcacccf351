"""Certificates as files: a zip of two JSON texts and a ``.npy`` file for each column, sealed by a digest.

The comment at the end of the zip is the SHA-256 of all bytes before it, so no byte can change unseen. The members
and their directory are the file: no byte stands before, between or behind them. Reading is bounded: what is read
follows from the head, and what the head asks for has a limit.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from codesign.ground.errors import CertificateError, clip, reason_of
from codesign.ground.files import is_special, write_atomically
from codesign.study.certificates.form import Certificate, Definition, Digests, Head, layout

DEFINITION, HEAD, DIGESTS = TEXTS = ("definition.json", "head.json", "digests.json")

MAX_FILE = 2**30
_MAX_TEXT = 2**24
_MAX_COLUMNS = 2**31 - 2**27
"""Most bytes of the columns. A zip tells the sizes of larger members in another way."""

_SEAL = 64
_LOCAL, _ENTRY, _END = 30, 46, 22
"""Bytes of a zip: before the name of a member, of its entry of the directory without the name, behind the directory."""

_AGAIN = "write it again: hwsw explore … --certify FILE"
_FIXED_DATE = (1980, 1, 1, 0, 0, 0)


def write_certificate(certificate: Certificate, path: Path) -> None:
    """Write a certificate, completely or not at all. Equal certificates are equal files.

    Raises:
        RunError: the file cannot be written.
    """
    write_atomically(path, packed(certificate))


def packed(certificate: Certificate) -> bytes:
    """The bytes of the file."""
    definition, head = certificate.texts
    members = {DEFINITION: definition, HEAD: head, DIGESTS: certificate.digests.model_dump_json().encode()}
    for name, (kind, shape) in layout(certificate.definition, certificate.head).items():
        values = np.ascontiguousarray(certificate.columns[name], kind)
        members[f"{name}.npy"] = _npy_header(kind, shape) + values.tobytes()
    return sealed(members)


def sealed(members: Mapping[str, bytes]) -> bytes:
    """A zip with these members, and its seal."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name, _FIXED_DATE), content, zipfile.ZIP_DEFLATED, 1)
        archive.comment = b"0" * _SEAL
    body = buffer.getvalue()[:-_SEAL]
    return body + hashlib.sha256(body).hexdigest().encode()


def read_certificate(path: Path) -> Certificate:
    """Read a certificate; whether its claims hold is another question (``check``).

    Raises:
        CertificateError: the file cannot be read, is no certificate, or was changed since it was written.
    """
    try:
        if is_special(path):
            raise CertificateError("is no regular file", str(path), "name a certificate")
        with path.open("rb") as file:
            content = file.read(MAX_FILE + 1)
    except (OSError, ValueError) as fault:
        raise CertificateError(f"cannot be read: {reason_of(fault)}", str(path), "name a certificate") from fault
    try:
        return unpacked(content)
    except CertificateError as fault:
        raise CertificateError(fault.what, str(path), fault.hint) from fault


def unpacked(content: bytes) -> Certificate:
    """The certificate of the bytes of a file.

    Raises:
        CertificateError: they are none.
    """
    if len(content) > MAX_FILE:
        raise CertificateError(f"is larger than {MAX_FILE // 2**20} MiB", hint="no certificate is so large")
    if not content.startswith(b"PK\x03\x04"):
        raise CertificateError("is no certificate", hint="hwsw explore … --certify FILE writes one")
    view = memoryview(content)
    if hashlib.sha256(view[:-_SEAL]).hexdigest().encode() != content[-_SEAL:]:
        raise CertificateError("was changed or cut off since it was written: its seal is broken", hint=_AGAIN)
    try:
        return _certificate(_Members(content))
    except (
        *(zipfile.BadZipFile, zlib.error, struct.error, EOFError, NotImplementedError, RuntimeError),
        *(ValueError, KeyError, TypeError, OverflowError, RecursionError, OSError, MemoryError),
    ) as fault:
        if isinstance(fault, ValidationError):
            first = fault.errors()[0]
            what = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
        else:
            what = str(fault)
        raise CertificateError(f"is no certificate of version 1: {clip(what)}", hint=_AGAIN) from fault


class _Members:
    """The members of a zip that is nothing but them."""

    def __init__(self, content: bytes) -> None:
        self._content = memoryview(content)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            self._held = {each.orig_filename: each for each in archive.infolist()}
            comment = archive.comment
        place, directory = 0, 0
        for name, each in self._held.items():
            lengths = struct.unpack_from("<HH", content, each.header_offset + 26)
            if each.header_offset != place or lengths != (len(name), 0) or each.extra or each.comment:
                raise ValueError(f"bytes of no member stand beside {name}")
            place += _LOCAL + len(name) + each.compress_size
            directory += _ENTRY + len(name)
        if len(comment) != _SEAL or len(content) != place + directory + _END + _SEAL:
            raise ValueError("bytes of no member stand before or behind its directory")

    @property
    def names(self) -> list[str]:
        """The names of the members, in their order."""
        return list(self._held)

    def read(self, name: str, most: int) -> bytes:
        """A member of at most so many bytes."""
        info = self._held[name]
        begin = info.header_offset + _LOCAL + len(name)
        unpacker = zlib.decompressobj(-zlib.MAX_WBITS)
        content = unpacker.decompress(self._content[begin : begin + info.compress_size], most + 1)
        if len(content) > most:
            raise ValueError(f"{name} is larger than {most} bytes")
        if not unpacker.eof or unpacker.unused_data or zlib.crc32(content) != info.CRC:
            raise ValueError(f"{name} is not what was packed")
        return content


def _certificate(members: _Members) -> Certificate:
    names = members.names
    if tuple(names[:3]) != TEXTS:
        raise ValueError(f"it does not begin with {', '.join(TEXTS)}")
    texts = members.read(DEFINITION, _MAX_TEXT), members.read(HEAD, _MAX_TEXT)
    definition, head = Definition.model_validate(_json(texts[0])), Head.model_validate(_json(texts[1]))
    digests = Digests.model_validate(_json(members.read(DIGESTS, _MAX_TEXT)))
    columns = layout(definition, head)
    if names[3:] != [f"{name}.npy" for name in columns]:
        raise ValueError(f"its columns are not {', '.join(columns)}")
    total = sum(math.prod(shape) * np.dtype(kind).itemsize for kind, shape in columns.values())
    if total > _MAX_COLUMNS:
        raise ValueError(f"its columns are larger than {_MAX_COLUMNS // 2**20} MiB")
    read = {name: _column(members, name, kind, shape) for name, (kind, shape) in columns.items()}
    return Certificate(definition, head, read, texts, digests)


def _column(members: _Members, name: str, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    header, dtype = _npy_header(kind, shape), np.dtype(kind)
    size = len(header) + math.prod(shape) * dtype.itemsize
    content = members.read(f"{name}.npy", size)
    if not content.startswith(header) or len(content) != size:
        raise ValueError(f"{name}.npy is not {kind} of shape {shape}")
    return np.frombuffer(content, dtype, offset=len(header)).reshape(shape)


def _npy_header(kind: str, shape: tuple[int, ...]) -> bytes:
    """The bytes before the values in a ``.npy`` file of version 1.0."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    padded = text + " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(padded)) + padded.encode()


def _json(text: bytes) -> Any:
    def refuse(constant: str) -> Any:
        raise ValueError(f"{constant} is no number of JSON")

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a key of its JSON stands twice")
        return dict(pairs)

    return json.loads(text.decode(), parse_constant=refuse, object_pairs_hook=once)
