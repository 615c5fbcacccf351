"""The outcomes of an exploration as they come in, and its progress."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from codesign.errors import StoreError
from codesign.exploration.definition import OTHER_VERSION, read_json
from codesign.exploration.designs import Conditions
from codesign.exploration.evaluation import Done
from codesign.exploration.judged import Judged
from codesign.exploration.outcomes import Outcomes
from codesign.exploration.shared import Shared
from codesign.exploration.space import Space
from codesign.exploration.specs import Specs
from codesign.exploration.store import EntryState
from codesign.exploration.study import Study
from codesign.inputs.exploration import Exploration
from codesign.results.provenance import Provenance
from codesign.results.result import Result


@dataclass(frozen=True)
class Progress:
    """How far an exploration is.

    Attributes:
        done: points with an outcome, of ``total``; ``cached`` of them were found in the store.
        feasible, failed: how many of those done.
        elapsed_s: seconds since the start. ``left_s``: seconds to go, judged by the points computed so far;
            None until the second batch of them, as the first has the time to start in it.
    """

    done: int
    total: int
    cached: int
    feasible: int
    failed: int
    elapsed_s: float
    left_s: float | None


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
        self._first_batch: tuple[float, int] | None = None
        self._cached = self._computed = self._feasible = 0

    def take_kept(self, done: Done) -> None:
        """Take what a store had."""
        self._cached += len(done.work.indices)
        self._take(done)

    def take(self, done: Done) -> None:
        """Take what was computed."""
        self._computed += len(done.work.indices)
        self.simulated += done.simulated
        self._first_batch = self._first_batch or (time.monotonic(), self._computed)
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

    def report(self) -> None:
        """Tell how far the exploration is."""
        if self.progress is None:
            return
        now = time.monotonic()
        done = self._cached + self._computed
        left_s = None
        if self._first_batch is not None and self._computed > self._first_batch[1]:
            since, before = self._first_batch
            left_s = (now - since) / (self._computed - before) * (len(self.space) - done)
        self.progress(
            Progress(
                done=done,
                total=len(self.space),
                cached=self._cached,
                feasible=self._feasible,
                failed=len(self.outcomes.failures),
                elapsed_s=now - self._started,
                left_s=left_s,
            )
        )
