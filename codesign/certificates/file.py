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
from numpy.lib import format as npy
from numpy.typing import NDArray
from pydantic import ValidationError

from codesign.certificates.form import Certificate, Definition, Head, layout
from codesign.errors import CertificateError, clip
from codesign.files import is_special, write_atomically

DEFINITION, HEAD = "definition.json", "head.json"

MAX_FILE = 2**30
_MAX_TEXT = 2**24
_MAX_COLUMNS = 2**31
_MAX_NPY_HEADER = 2**10
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
    members = {
        DEFINITION: certificate.definition_text,
        HEAD: certificate.head.model_dump_json().encode(),
    }
    for name in layout(certificate.definition, certificate.head):
        buffer = io.BytesIO()
        npy.write_array(buffer, np.ascontiguousarray(certificate.columns[name]), (1, 0), allow_pickle=False)
        members[f"{name}.npy"] = buffer.getvalue()
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
    if names[:2] != [DEFINITION, HEAD]:
        raise ValueError(f"it does not begin with {DEFINITION} and {HEAD}")
    definition_text = _member(archive, DEFINITION, _MAX_TEXT)
    definition = Definition.model_validate(_json(definition_text))
    head = Head.model_validate(_json(_member(archive, HEAD, _MAX_TEXT)))
    columns = layout(definition, head)
    if names[2:] != [f"{name}.npy" for name in columns]:
        raise ValueError(f"its columns are not {', '.join(columns)}")
    total = sum(math.prod(shape) * np.dtype(kind).itemsize for kind, shape in columns.values())
    if total > _MAX_COLUMNS:
        raise ValueError(f"its columns are larger than {_MAX_COLUMNS // 2**20} MiB")
    read = {name: _column(archive, name, kind, shape) for name, (kind, shape) in columns.items()}
    return Certificate(definition, definition_text, head, read)


def _column(archive: zipfile.ZipFile, name: str, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    dtype = np.dtype(kind)
    size = math.prod(shape) * dtype.itemsize
    content = _member(archive, f"{name}.npy", size + _MAX_NPY_HEADER)
    buffer = io.BytesIO(content)
    if npy.read_magic(buffer) != (1, 0):
        raise ValueError(f"{name}.npy is not of version 1.0")
    held, fortran, its = npy.read_array_header_1_0(buffer, max_header_size=_MAX_NPY_HEADER)
    if (held, fortran, its) != (shape, False, dtype) or len(content) - buffer.tell() != size:
        raise ValueError(f"{name}.npy is not {dtype.str} of shape {shape}")
    return np.frombuffer(content, dtype, offset=buffer.tell()).reshape(shape)


def _member(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    with archive.open(name) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{name} is larger than {most} bytes")
    return content


def _json(text: bytes) -> Any:
    def refuse(constant: str) -> Any:
        raise ValueError(f"{constant} is no number of JSON")

    return json.loads(text.decode(), parse_constant=refuse)
