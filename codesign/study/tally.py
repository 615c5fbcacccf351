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
from codesign.study.definition import OTHER_VERSION, read_json
from codesign.study.evaluation import Done
from codesign.study.judged import Judged
from codesign.study.outcomes import Outcomes
from codesign.study.pace import ExplorationPace
from codesign.study.partition import Work
from codesign.study.search import Searched
from codesign.study.shared import Shared
from codesign.study.space import Space
from codesign.study.specs import Specs
from codesign.study.store import Entry, EntryState
from codesign.study.study import Study
from codesign.system.results.provenance import Provenance
from codesign.system.results.result import Result

_SECONDS_BETWEEN = 0.5
_OBJECTS_UNTIL_COLLECTED = 50_000


@dataclass(frozen=True)
class Progress:
    """How far an exploration is.

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
        """How many points came in; ``cached`` of them were found in the store."""
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
        """What comes in of works, timed: ``left_s`` is known from now on."""
        self._pace, self._budget = ExplorationPace(works, len(self.space), workers), budget
        yield from self._pace.watched(coming)

    def take(self, done: Done) -> None:
        """Take what was computed."""
        self._computed += len(done.work)
        self.simulated += done.simulated
        self._take(done)
        self.report()

    def study(self, platform: str, workload: str, provenance: Provenance, specs: Specs) -> Study:
        """The outcomes so far as a study."""
        section = self.section
        return Study(
            platform,
            workload,
            dict(section.axes),
            section.objectives,
            section.constraints,
            self.outcomes,
            dict(section.conditions),
            dict(section.aggregate),
            provenance,
            specs,
            section.when,
            dict(section.figures),
            self.simulated if self._computed else None,
            self.chosen,
            self.search,
        )

    def _begun(self) -> Outcomes:
        """What the outcomes are taken into: all points of the space."""
        return Outcomes.empty(self.total)

    def _take(self, done: Done) -> None:
        indices = done.work.numbers
        batch = self._one_by_one(done.entries) if done.priced is None else Outcomes.of_priced(done.priced)
        self._failed += len(batch.failures)
        self._join(indices, batch)
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
