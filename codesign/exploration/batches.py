"""The batches in which works go to workers, sized by what works took before.

To hand a work over takes a pool of processes about a millisecond, and the scheduler of a cluster some. So works of that
order go out many at a time.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from codesign.exploration.partition import Work
from codesign.exploration.work_queue import WorkQueue

BATCHES_AHEAD = 2
"""The batches of each worker: one in hand, and one ahead."""

_MOST_WORKS = 1000
_GROWTH = 4


class BatchSize:
    """How many works take so many ``seconds``, by those that came in."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._a_work: float | None = None
        self._most = 1

    def take(self, seconds: float, works: int) -> None:
        """So many works took so long. Works that were faster count at once: the first ones waited for kernels."""
        a_work = seconds / max(1, works)
        before = a_work if self._a_work is None else self._a_work
        self._a_work = min(a_work, 0.7 * before + 0.3 * a_work)
        self._most = max(self._most, min(_MOST_WORKS, _GROWTH * works))

    @property
    def works(self) -> int:
        """How many works a batch has."""
        if self._a_work is None:
            return 1
        return max(1, min(self._most, round(self.seconds / max(self._a_work, 1e-6))))


def drawn(queue: WorkQueue, seat: Hashable, busy: Sequence[Work], count: int) -> list[Work]:
    """At most so many works for a seat on which ``busy`` is under way."""
    batch: list[Work] = []
    while len(batch) < count and (work := queue.next([*busy, *batch], seat)) is not None:
        batch.append(work)
    return batch
