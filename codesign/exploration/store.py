"""What is kept of an exploration: entries, blocks and computations by key, and the definitions of studies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

MOST_COMPUTATIONS = 2**26
"""Bytes of computations that are read at once: each worker gets them."""


class EntryState(StrEnum):
    """How the computation of a point ended."""

    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class Entry:
    """A point that was computed.

    Attributes:
        key: of its ``DesignPoint``.
        state: done, or failed where the computation raised.
        text: the result as JSON; the message where it failed.
    """

    key: str
    state: EntryState
    text: str


@dataclass(frozen=True)
class Batch:
    """What is kept together, all of it or nothing.

    - ``entries``: of points that were simulated by themselves.
    - ``blocks``: outcomes of points that compute the same, by key (``blocks.block_of``).
    - ``computations``: what they compute, as JSON by digest.
    """

    entries: Sequence[Entry] = ()
    blocks: Mapping[str, bytes] = field(default_factory=dict)
    computations: Mapping[str, str] = field(default_factory=dict)


class Store(Protocol):
    """What was computed, by key, and the definitions of the studies that it was computed for."""

    def find(self, keys: Sequence[str]) -> dict[str, Entry]:
        """The entries there are under ``keys``."""

    def blocks(self, keys: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """The blocks there are under ``keys``, one by one."""

    def has_entries(self) -> bool:
        """Whether any point that was simulated by itself is kept."""

    def computations(self) -> dict[str, str]:
        """Every computation, up to ``MOST_COMPUTATIONS`` bytes of them, by digest."""

    def put(self, batch: Batch) -> None:
        """Keep all of a batch or nothing; what stands under the same key is replaced."""

    def begin(self, key: str, definition: str, plan: bytes = b"") -> None:
        """Note a study: what ``latest`` gives from now on. The same study again is noted anew, not twice.

        ``plan``: which points compute the same (``blocks.plan_of``).
        """

    def latest(self) -> tuple[str, bytes] | None:
        """The definition and the plan of the study noted last, or None."""

    def plan(self, key: str) -> bytes:
        """The plan of the study noted under a key; empty where there is none."""

    def close(self) -> None:
        """Let go of the file; may be called twice."""


class MemoryStore:
    """A store that lasts as long as the process."""

    def __init__(self) -> None:
        self._entries: dict[str, Entry] = {}
        self._blocks: dict[str, bytes] = {}
        self._computations: dict[str, str] = {}
        self._studies: dict[str, tuple[str, bytes]] = {}

    def find(self, keys: Sequence[str]) -> dict[str, Entry]:
        """The entries there are under ``keys``."""
        return {key: self._entries[key] for key in keys if key in self._entries}

    def blocks(self, keys: Sequence[str]) -> Iterator[tuple[str, bytes]]:
        """The blocks there are under ``keys``."""
        yield from ((key, self._blocks[key]) for key in keys if key in self._blocks)

    def has_entries(self) -> bool:
        """Whether any entry is kept."""
        return bool(self._entries)

    def computations(self) -> dict[str, str]:
        """Every computation."""
        return dict(self._computations)

    def put(self, batch: Batch) -> None:
        """Keep all of a batch."""
        self._entries.update({entry.key: entry for entry in batch.entries})
        self._blocks.update(batch.blocks)
        self._computations.update(batch.computations)

    def begin(self, key: str, definition: str, plan: bytes = b"") -> None:
        """Note a study."""
        self._studies.pop(key, None)
        self._studies[key] = definition, plan

    def latest(self) -> tuple[str, bytes] | None:
        """The definition and the plan of the study noted last, or None."""
        return next(reversed(self._studies.values()), None)

    def plan(self, key: str) -> bytes:
        """The plan of a study."""
        return self._studies.get(key, ("", b""))[1]

    def close(self) -> None:
        """Nothing to let go of."""
