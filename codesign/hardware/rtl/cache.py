"""The cache of what tools made, in the user's folder, each under the digest of all that it depends on."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path

from codesign.ground.files import kept_folder, part_of, passing, put, scratch

MOST_BYTES = 512 * 2**20
"""Above it the entries that were unused for the longest time are removed."""

_YOUNG_S = 3600.0
"""An entry that was used within this time is never removed: another process may read it."""


def digest_of(*parts: str | bytes) -> str:
    """The digest of a sequence of texts."""
    whole = sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        whole.update(len(data).to_bytes(8, "little") + data)
    return whole.hexdigest()


@contextmanager
def kept(kind: str, digest: str, make: Callable[[Path], None]) -> Iterator[Path]:
    """The folder of an entry until the end of the block; ``make`` fills it where there is none.

    Where the cache cannot be written to, the folder is a temporary one.
    """
    folder = _folder(kind)
    if folder is not None and (folder / digest).is_dir():
        with suppress(OSError):
            os.utime(folder / digest)
        yield folder / digest
        return
    if folder is None:
        with scratch() as part:
            make(part)
            yield part
        return
    with passing(part_of(folder / digest)) as part:
        part.mkdir(mode=0o700)
        make(part)
        _prune(folder)
        with suppress(OSError):
            put(part, folder / digest)
        # Another process may have made the same entry at the same time.
        yield folder / digest if (folder / digest).is_dir() else part


def _folder(kind: str) -> Path | None:
    """The folder of all entries of a kind, or None where it cannot be used."""
    try:
        return kept_folder("rtl", kind)
    except OSError:
        return None


def _prune(folder: Path) -> None:
    """Remove the entries that were unused for the longest time, until the others are small enough."""
    with suppress(OSError):
        entries = sorted(folder.iterdir(), key=lambda entry: -entry.stat().st_mtime)
        total = 0
        for entry in entries:
            total += sum(file.stat().st_size for file in entry.rglob("*"))
            if total > MOST_BYTES and time.time() - entry.stat().st_mtime > _YOUNG_S:
                shutil.rmtree(entry, ignore_errors=True)
