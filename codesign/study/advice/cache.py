"""The cache of trials: a second question about a map takes what the first one computed.

A trial stands under the digest of all that it depends on (``Laboratory.key``), so a kept trial is never out of date.
The file is a ``FileStore`` in the user's cache folder. Rejected: the store of a study, which the user would have to
name. Rejected: to keep whole results, which are thirty times as large.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from codesign.ground.errors import StoreError
from codesign.ground.files import cache_folder, kept_folder
from codesign.study.store import FileStore, MemoryStore, Store

MOST_BYTES = 64 * 2**20
"""A larger file is removed before the next question. It holds some 100,000 trials."""


@contextmanager
def kept_trials() -> Iterator[tuple[Store, str]]:
    """The cache until the end of the block, with a remark where it cannot be used: then nothing is kept."""
    store: Store = MemoryStore()
    remark = ""
    path = cache_folder() / "advice.sqlite"
    try:
        kept_folder()
        if path.exists() and path.stat().st_size > MOST_BYTES:
            path.unlink()
        store = FileStore(path)
    except (StoreError, OSError) as fault:
        why = fault.what if isinstance(fault, StoreError) else fault.strerror
        remark = f"no trial is kept for a second question: {path}: {why}"
    try:
        yield store, remark
    finally:
        with suppress(StoreError):
            store.close()
