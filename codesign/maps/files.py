"""Map files: read as a whole within a bound, written as a whole or not at all."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path

from codesign.ground.errors import MapError, RunError, reason_of
from codesign.ground.files import write_atomically

MAX_FILE_BYTES = 64 * 2**20
"""The largest map file that is read. A 16-bit image of ``MAX_CELLS`` pixels takes half of it."""

_COUNT = re.compile(rb"[0-9]{1,9}")


def read_bytes(path: str | os.PathLike[str], limit: int = MAX_FILE_BYTES) -> bytes:
    """The content of a regular file of at most ``limit`` bytes.

    Raises:
        MapError: the file does not exist, is a directory or device, cannot be read, is empty or too large.
    """
    where = str(path)
    try:
        # A pipe or a device is refused before it is opened, because opening it may block for ever.
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise MapError("this is a directory or a device, not a file", where, "name the map file itself")
        with open(path, "rb") as file:
            # Python allocates as many bytes as it is asked to read, so no more than the file has.
            content = file.read(min(status.st_size, limit) + 1)
    except FileNotFoundError:
        raise MapError("the file does not exist", where, "check the path") from None
    except (OSError, ValueError) as error:
        raise MapError(f"the file cannot be read: {reason_of(error)}", where) from None
    if len(content) > limit:
        raise MapError(f"the file is above the limit of {limit} bytes", where, "crop or split it")
    if not content:
        raise MapError("the file is empty", where)
    return content


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write the file as a whole, or leave the old file.

    Raises:
        MapError: the file cannot be written.
    """
    try:
        write_atomically(Path(path), content)
    except RunError as error:
        raise MapError(error.what, str(path), error.hint) from None


def parse_count(text: bytes) -> int | None:
    """A whole number of at most nine ASCII digits, without sign or underscore; None otherwise."""
    return int(text) if _COUNT.fullmatch(text) else None


def show(content: bytes) -> str:
    """Bytes of a file as printable ASCII, cut to a length that fits a message."""
    return ascii(content[:40].decode("latin-1")) + ("..." if len(content) > 40 else "")
