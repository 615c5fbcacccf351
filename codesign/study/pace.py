"""The time left of an exploration, by what its works cost.

Points differ. A point that was kept costs nothing, one that is priced beside others costs microseconds, and one that is
simulated may cost minutes. So a rate of points says little. Counted here are the seconds that works took in their
workers, simulations and prices apart, and the works that are left of each kind.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from codesign.study.budget import Budget
from codesign.study.evaluation import Done
from codesign.study.partition import Together, Work

_RECENT, _LONG = 64, 512
_CORRECTION = 0.02, 5.0
"""How far the time of recent works may be from what the means say: a cluster may have more workers than are known."""


class _Mean:
    """Seconds for each of many things, judged by the recent ones: with each more, the older ones count less.

    ``recent``: about so many count.
    """

    def __init__(self, recent: int = _RECENT) -> None:
        self.seconds = self.count = 0.0
        self._kept = 1 - 1 / recent

    def add(self, seconds: float, count: float) -> None:
        """So many things took so long."""
        self.seconds = self.seconds * self._kept + seconds
        self.count = self.count * self._kept + count

    def of(self, count: float) -> float | None:
        """The seconds of so many things; None where none was timed."""
        if not count:
            return 0.0
        return self.seconds / self.count * count if self.count else None


class ExplorationPace:
    """How long the works that are left will take.

    The means of recent works are S for a simulation, P for a priced point, and A for a point that is simulated by
    itself. O is what this process does itself with each of them:

        left = (simulations · S + priced points · P + other points · A) / workers + points · O

    times the time of recent works over what this says of them. How many works need a simulation, and how many fall
    apart into points, is judged by those that came in: their order shows the whole space early (``order``).

    Args:
        works: that are left. ``points``: of the space. ``workers``: that compute them.
    """

    def __init__(
        self, works: Sequence[Work], points: int, workers: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._clock, self._workers = clock, workers
        self._owner = np.full(points, -1, np.int32)
        """The work of a point that is priced beside others; -1: it is simulated by itself."""
        self._left = np.zeros(len(works), np.int64)
        self._apart = np.zeros(len(works), np.bool_)
        self._alone = 0
        for number, work in enumerate(works):
            if isinstance(work, Together):
                self._owner[work.numbers] = number
                self._left[number] = len(work)
            else:
                self._alone += len(work)
        self._together = self._left > 0
        self._computations, self._falls_apart = _Mean(_LONG), _Mean(_LONG)
        self._simulation, self._price, self._fallen, self._by_itself = (_Mean() for _ in range(4))
        self._own_of_price, self._own_of_point = _Mean(), _Mean()
        self._taken = self._wall = 0.0
        self._last: float | None = None

    def watched(self, coming: Iterable[Done]) -> Iterator[Done]:
        """What comes in, while it is timed here and in the caller."""
        for done in coming:
            self._take(done)
            begun = self._clock()
            yield done
            own = self._clock() - begun
            (self._own_of_price if done.together else self._own_of_point).add(own, len(done.work))
            self._taken += own

    def left_s(self, budget: Budget | None = None) -> float | None:
        """The seconds left; None as long as works of some kind are left of which none was timed."""
        whole = self._together & ~self._apart & (self._left > 0)
        works, points = int(whole.sum()), int(self._left[whole].sum())
        share = self._falls_apart.of(1.0) or 0.0
        falling = points * share + int(self._left[self._apart].sum())
        need = self._computations.of(works * (1.0 - share))
        if need is None:
            return None
        priced = points * (1.0 - share)
        parts = (
            self._simulation.of(need),
            self._price.of(priced),
            self._fallen.of(falling),
            self._by_itself.of(self._alone),
        )
        own = (self._own_of_price.of(priced), self._own_of_point.of(falling + self._alone))
        if any(part is None for part in parts):
            return None
        seconds = sum(filter(None, parts)) / self._workers + sum(filter(None, own))
        left = seconds * self._correction()
        return left if budget is None else budget.bounded(left)

    def _correction(self) -> float:
        if not self._taken or not self._wall:
            return 1.0
        least, most = _CORRECTION
        return min(max(self._wall / self._taken, least), most)

    def _take(self, done: Done) -> None:
        """What came in is no more left, and says what such works take."""
        alone = self._count_off(done)
        now = self._clock()
        if done.took_s is not None and done.simulating_s is not None:
            if self._last is not None:
                kept = 1 - 1 / _RECENT
                self._taken = self._taken * kept + done.took_s / self._workers
                self._wall = self._wall * kept + now - self._last
            if not done.together:
                (self._by_itself if alone else self._fallen).add(done.took_s, len(done.work))
            else:
                self._price.add(done.took_s - done.simulating_s, len(done.work))
                if done.simulated:
                    self._simulation.add(done.simulating_s, done.simulated)
        self._last = now

    def _count_off(self, done: Done) -> bool:
        """Count the points of what came in off; whether they were to be simulated by themselves from the start."""
        indices = np.array(done.work.indices, np.intp)
        owners = self._owner[indices]
        owned = owners[owners >= 0]
        self._alone -= len(owners) - len(owned)
        numbers, counts = np.unique(owned, return_counts=True)
        if done.together:
            if done.took_s is not None:
                # Otherwise it would be known that simulations are left, and not what they take.
                self._computations.add(done.simulated, len(numbers))
            self._falls_apart.add(0.0, len(owned))
        else:
            fresh = numbers[~self._apart[numbers]]
            self._falls_apart.add(float(self._left[fresh].sum()), float(self._left[fresh].sum()))
            self._apart[numbers] = True
        self._left[numbers] -= counts
        return not len(owned)
