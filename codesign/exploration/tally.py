"""The outcomes of an exploration as they come in, and its progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from codesign.errors import StoreError
from codesign.exploration.budget import Budget
from codesign.exploration.definition import OTHER_VERSION, read_json
from codesign.exploration.designs import Conditions
from codesign.exploration.evaluation import Done
from codesign.exploration.judged import Judged
from codesign.exploration.outcomes import Outcomes
from codesign.exploration.pace import ExplorationPace
from codesign.exploration.partition import Work
from codesign.exploration.shared import Shared
from codesign.exploration.space import Space
from codesign.exploration.specs import Specs
from codesign.exploration.store import EntryState
from codesign.exploration.study import Study
from codesign.inputs.exploration import Exploration
from codesign.results.provenance import Provenance
from codesign.results.result import Result

_SECONDS_BETWEEN = 0.5


@dataclass(frozen=True)
class Progress:
    """How far an exploration is.

    Attributes:
        done: points with an outcome, of ``total``; ``cached`` of them were found in the store.
        feasible, failed: how many of those done.
        simulated: how many simulations were made for those that were computed.
        elapsed_s: seconds since the start. ``left_s``: seconds to go, see ``ExplorationPace``; None as long as they are
            not known.
        doing: what goes on before the first point is computed, in words; "" afterwards. ``done`` and ``total`` then
            count that.
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


class Tally:
    """The outcomes so far. ``progress`` is called with each change of them."""

    def __init__(
        self,
        space: Space,
        section: Exploration,
        where: str | None,
        progress: Callable[[Progress], None] | None = None,
        specs: Specs | None = None,
    ) -> None:
        self.space, self.section, self.where, self.specs = space, section, where, specs
        self.progress = progress
        self.outcomes = Outcomes.empty(len(space))
        self.simulated = 0
        self._shared = Shared()
        self._started = time.monotonic()
        self._pace: ExplorationPace | None = None
        self._budget: Budget | None = None
        self._reported = self._started
        self._cached = self._computed = self._feasible = 0

    def take_kept(self, done: Done) -> None:
        """Take what a store had."""
        self._cached += len(done.work.indices)
        self._take(done)
        if time.monotonic() - self._reported > _SECONDS_BETWEEN:
            self.report("points read from the store")

    def watched(
        self, coming: Iterable[Done], works: Sequence[Work], workers: int, budget: Budget | None
    ) -> Iterator[Done]:
        """What comes in of works, timed: ``left_s`` is known from now on."""
        self._pace, self._budget = ExplorationPace(works, len(self.space), workers), budget
        return self._pace.watched(coming)

    def take(self, done: Done) -> None:
        """Take what was computed."""
        self._computed += len(done.work.indices)
        self.simulated += done.simulated
        self._take(done)
        self.report()

    def study(self, platform: str, workload: str, provenance: Provenance) -> Study:
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
            self.specs,
            section.when,
            dict(section.figures),
            self.simulated if self._computed else None,
        )

    def _take(self, done: Done) -> None:
        indices = np.array(done.work.indices, np.intp)
        batch = Outcomes.empty(len(indices))
        if done.priced is not None:
            batch.take(np.arange(len(indices)), done.priced)
        for place, entry in enumerate(done.entries):
            if entry.state is EntryState.FAILED:
                batch.fail(place, entry.text)
                continue
            try:
                result = Result.model_validate(read_json(entry.text))
            except (ValueError, ArithmeticError, RecursionError) as wrong:
                raise StoreError(
                    "holds a result that this version cannot read", self.where, OTHER_VERSION
                ) from wrong
            batch.put(place, self._shared.result(result))
        self.outcomes.join(indices, batch)
        # With conditions, it is a design that keeps a constraint, by what all of its points come to.
        limits = () if self.section.conditions else self.section.constraints
        self._feasible += int(Judged(batch, Conditions({}, {}), limits).feasible_points.sum())

    def report(self, doing: str = "") -> None:
        """Tell how far the exploration is."""
        if self.progress is None:
            return
        now = self._reported = time.monotonic()
        self.progress(
            Progress(
                done=self._cached + self._computed,
                total=len(self.space),
                cached=self._cached,
                feasible=self._feasible,
                failed=len(self.outcomes.failures),
                simulated=self.simulated,
                elapsed_s=now - self._started,
                left_s=None if self._pace is None else self._pace.left_s(self._budget),
                doing=doing,
            )
        )
