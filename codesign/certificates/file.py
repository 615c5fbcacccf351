"""Certificates as files: a zip of two JSON texts and a ``.npy`` file for each column, sealed by a digest.

The comment at the end of the zip is the SHA-256 of all bytes before it, so no byte can change unseen. Reading is
bounded: what is read follows from the head, and what the head asks for has a limit.
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

from codesign.certificates.form import Certificate, Definition, Digests, Head, layout
from codesign.errors import CertificateError, clip
from codesign.files import is_special, write_atomically

DEFINITION, HEAD, DIGESTS = TEXTS = ("definition.json", "head.json", "digests.json")

MAX_FILE = 2**30
_MAX_TEXT = 2**24
_MAX_COLUMNS = 2**31
_SEAL = 64
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
    members = {
        DEFINITION: definition,
        HEAD: head,
        DIGESTS: certificate.digests.model_dump_json().encode(),
    }
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
        reason = getattr(fault, "strerror", None) or str(fault)
        raise CertificateError(f"cannot be read: {reason}", str(path), "name a certificate") from fault
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
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _certificate(archive)
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


def _certificate(archive: zipfile.ZipFile) -> Certificate:
    names = archive.namelist()
    if tuple(names[:3]) != TEXTS:
        raise ValueError(f"it does not begin with {', '.join(TEXTS)}")
    texts = _member(archive, DEFINITION, _MAX_TEXT), _member(archive, HEAD, _MAX_TEXT)
    definition, head = Definition.model_validate(_json(texts[0])), Head.model_validate(_json(texts[1]))
    digests = Digests.model_validate(_json(_member(archive, DIGESTS, _MAX_TEXT)))
    columns = layout(definition, head)
    if names[3:] != [f"{name}.npy" for name in columns]:
        raise ValueError(f"its columns are not {', '.join(columns)}")
    total = sum(math.prod(shape) * np.dtype(kind).itemsize for kind, shape in columns.values())
    if total > _MAX_COLUMNS:
        raise ValueError(f"its columns are larger than {_MAX_COLUMNS // 2**20} MiB")
    read = {name: _column(archive, name, kind, shape) for name, (kind, shape) in columns.items()}
    return Certificate(definition, head, read, texts, digests)


def _column(archive: zipfile.ZipFile, name: str, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    header, dtype = _npy_header(kind, shape), np.dtype(kind)
    size = len(header) + math.prod(shape) * dtype.itemsize
    content = _member(archive, f"{name}.npy", size)
    if not content.startswith(header) or len(content) != size:
        raise ValueError(f"{name}.npy is not {kind} of shape {shape}")
    return np.frombuffer(content, dtype, offset=len(header)).reshape(shape)


def _npy_header(kind: str, shape: tuple[int, ...]) -> bytes:
    """What stands before the values in a ``.npy`` file of version 1.0."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    padded = text + " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(padded)) + padded.encode()


def _member(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    with archive.open(name) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{name} is larger than {most} bytes")
    return content


def _json(text: bytes) -> Any:
    def refuse(constant: str) -> Any:
        raise ValueError(f"{constant} is no number of JSON")

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a key of its JSON stands twice")
        return dict(pairs)

    return json.loads(text.decode(), parse_constant=refuse, object_pairs_hook=once)
