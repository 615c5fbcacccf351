"""The outcomes of an exploration as they come in, and its progress."""

from __future__ import annotations

import contextlib
import gc
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import StoreError
from codesign.inputs.exploration import Exploration
from codesign.study.budget import Budget
from codesign.study.conditions import Conditions
from codesign.study.definition import OTHER_VERSION, StudyDefinition, read_json
from codesign.study.evaluation import Done
from codesign.study.judged import Judged
from codesign.study.outcomes import Outcomes
from codesign.study.partition import Together, Work
from codesign.study.search import Searched
from codesign.study.shared import Shared
from codesign.study.space import Space
from codesign.study.store import Entry, EntryState
from codesign.study.study import Study
from codesign.system.results.result import Result

# The time left of an exploration, by what its works cost.

_RECENT, _LONG = 64, 512
_CORRECTION = 0.02, 5.0
"""The factor by which the time of recent works may be off the means: a cluster may have more workers than are known."""


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
    """The time that the works that are left will take.

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
        """The outcomes that come in, while they are timed here and in the caller."""
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
        """Count off what came in, and learn from it what such works take."""
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


_SECONDS_BETWEEN = 0.5
_OBJECTS_UNTIL_COLLECTED = 50_000


@dataclass(frozen=True)
class Progress:
    """The progress of an exploration.

    Attributes:
        done: points with an outcome, of ``total``; ``cached`` of them were found in the store.
        feasible, failed: how many of those done.
        simulated: how many simulations were made for those that were computed.
        elapsed_s: seconds since the start. ``left_s``: seconds to go, see ``ExplorationPace``; None as long as they are
            not known.
        doing: what is done with points before the first one is computed, in words; "" afterwards. ``done`` then counts
            that.
    """

    done: int
    total: int
    cached: int
    feasible: int
    failed: int
    simulated: int
    elapsed_s: float
    left_s: float | None
    doing: str = ""


@contextlib.contextmanager
def seldom_collected() -> Iterator[None]:
    """Search for cycles of objects seldom: an exploration makes many objects and few cycles, and keeps most of them."""
    before = gc.get_threshold()
    gc.set_threshold(_OBJECTS_UNTIL_COLLECTED, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


class Tally:
    """The outcomes so far. ``progress`` is called with each change of them."""

    def __init__(
        self, space: Space, section: Exploration, where: str | None, progress: Callable[[Progress], None] | None = None
    ) -> None:
        self.space, self.section, self.where = space, section, where
        self.progress = progress
        self.total = len(space)
        self.outcomes = self._begun()
        self.simulated = 0
        self.chosen: tuple[int, ...] | None = None
        self.search: Searched | None = None
        self._shared = Shared()
        self._started = time.monotonic()
        self._pace: ExplorationPace | None = None
        self._budget: Budget | None = None
        self._reported = self._started
        self.cached = self._computed = self._feasible = self._failed = 0

    @property
    def done(self) -> int:
        """The number of points that came in; ``cached`` of them were found in the store."""
        return self.cached + self._computed

    def sorting(self, works: Iterable[Work]) -> Iterator[Work]:
        """The works of a space, while ``progress`` is told how many points are in them."""
        points = 0
        for work in works:
            points += len(work)
            if time.monotonic() - self._reported > _SECONDS_BETWEEN:
                self.report("points sorted by what they compute", points)
            yield work

    def take_kept(self, done: Done) -> None:
        """Take what a store had."""
        self.cached += len(done.work)
        self._take(done)
        if time.monotonic() - self._reported > _SECONDS_BETWEEN:
            self.report("points read from the store", self.cached)

    def watched(
        self, coming: Iterable[Done], works: Sequence[Work], workers: int, budget: Budget | None
    ) -> Iterator[Done]:
        """The outcomes of works as they come in, timed: ``left_s`` is known from now on."""
        self._pace, self._budget = ExplorationPace(works, len(self.space), workers), budget
        yield from self._pace.watched(coming)

    def take(self, done: Done) -> None:
        """Take what was computed."""
        self._computed += len(done.work)
        self.simulated += done.simulated
        self._take(done)
        self.report()

    def study(self, definition: StudyDefinition) -> Study:
        """The outcomes so far as a study."""
        section = self.section
        return Study(
            definition.platform,
            definition.workload,
            dict(section.axes),
            section.objectives,
            section.constraints,
            self.outcomes,
            dict(section.conditions),
            dict(section.aggregate),
            definition.provenance,
            definition.specs,
            section.when,
            dict(section.figures),
            self.simulated if self._computed else None,
            self.chosen,
            self.search,
        )

    def _begun(self) -> Outcomes:
        """The outcomes to be filled: all points of the space."""
        return Outcomes.empty(self.total)

    def _take(self, done: Done) -> None:
        indices = done.work.numbers
        batch = self._one_by_one(done.entries) if done.priced is None else Outcomes.of_priced(done.priced)
        self._failed += len(batch.failures)
        self._join(indices, batch)
        if self.progress is None:
            return
        # With conditions, it is a design that keeps a constraint, by what all of its points come to.
        limits = () if self.section.conditions else self.section.constraints
        self._feasible += int(Judged(batch, Conditions({}, {}), limits).feasible_points.sum())

    def _one_by_one(self, entries: Sequence[Entry]) -> Outcomes:
        outcomes = Outcomes.empty(len(entries))
        for place, entry in enumerate(entries):
            if entry.state is EntryState.FAILED:
                outcomes.fail(place, entry.text)
                continue
            try:
                result = Result.model_validate(read_json(entry.text))
            except (ValueError, ArithmeticError, RecursionError) as wrong:
                raise StoreError("holds a result that this version cannot read", self.where, OTHER_VERSION) from wrong
            outcomes.put(place, self._shared.result(result))
        return outcomes

    def _join(self, indices: NDArray[np.int64], batch: Outcomes) -> None:
        """Take the outcomes of the points with these places in the enumeration."""
        self.outcomes.join(indices, batch)

    def left_s(self) -> float | None:
        """Seconds to go; None as long as they are not known."""
        return None if self._pace is None else self._pace.left_s(self._budget)

    def report(self, doing: str = "", done: int | None = None) -> None:
        """Tell how far the exploration is; or what goes on before, and with how many points it is done."""
        if self.progress is None:
            return
        now = self._reported = time.monotonic()
        self.progress(
            Progress(
                done=self.done if done is None else done,
                total=self.total,
                cached=self.cached,
                feasible=self._feasible,
                failed=self._failed,
                simulated=self.simulated,
                elapsed_s=now - self._started,
                left_s=self.left_s(),
                doing=doing,
            )
        )
