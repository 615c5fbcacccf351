"""Files written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from codesign.errors import RunError


def write_atomically(path: Path, content: bytes) -> None:
    """Write ``content`` beside ``path`` and put it in its place at once; what stood there stays until then.

    Raises:
        RunError: the folder is missing or cannot be written to, or the disk is full.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name[:64]}.", suffix=".part", dir=path.parent)
    except OSError as error:
        raise RunError(
            f"cannot write: {error.strerror}",
            str(path),
            "name a file in a folder that is there and can be written to",
        ) from error
    part = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        part.chmod(_file_mode())
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise RunError(
            f"cannot write: {error.strerror}", str(path), "free some space, or name another file"
        ) from error
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _file_mode() -> int:
    # mkstemp gives 0o600; a report should be as readable as any file its user writes.
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
