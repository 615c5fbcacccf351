"""The outcomes of an exploration as they come in, and its progress."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from codesign.errors import StoreError
from codesign.exploration.constraints import with_constraints
from codesign.exploration.definition import OTHER_VERSION, read_json
from codesign.exploration.outcomes import Outcomes
from codesign.exploration.shared import Shared
from codesign.exploration.space import DesignPoint, Space
from codesign.exploration.specs import Specs
from codesign.exploration.store import Entry, EntryState, Store
from codesign.exploration.study import Study
from codesign.inputs.exploration import Exploration
from codesign.results.provenance import Provenance
from codesign.results.result import Result

_KEYS_AT_ONCE = 500


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
    """The outcomes so far, by index. ``progress`` is called with each change of them."""

    def __init__(
        self,
        space: Space,
        section: Exploration,
        where: str | None,
        progress: Callable[[Progress], None] | None = None,
        specs: Specs | None = None,
    ) -> None:
        self.space = space
        self.specs = specs
        self.section = section
        # With conditions, it is a design that keeps a constraint, by what all of its points come to.
        self._constraints = () if section.conditions else section.constraints
        self.where = where
        self.progress = progress
        self.points = list(space.points())
        self.outcomes = Outcomes.empty(len(self.points))
        self._shared = Shared()
        self._place = {point.key: point.index for point in self.points}
        self._started = time.monotonic()
        self._first_batch: tuple[float, int] | None = None
        self._cached = self._computed = self._feasible = self._failed = 0

    def take_kept(self, store: Store, *, retry: bool = True) -> list[DesignPoint]:
        """Take what the store has; return the points still to be computed, with ``retry`` those that failed too."""
        pending = []
        for begin in range(0, len(self.points), _KEYS_AT_ONCE):
            some = self.points[begin : begin + _KEYS_AT_ONCE]
            entries = store.find([point.key for point in some])
            for point in some:
                entry = entries.get(point.key)
                if entry is None or (retry and entry.state is EntryState.FAILED):
                    pending.append(point)
                else:
                    self._take(entry)
        self._cached = len(self.points) - len(pending)
        self._report()
        return pending

    def take(self, entries: tuple[Entry, ...]) -> None:
        """Take what was computed."""
        for entry in entries:
            self._take(entry)
        self._computed += len(entries)
        self._first_batch = self._first_batch or (time.monotonic(), self._computed)
        self._report()

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
        )

    def _take(self, entry: Entry) -> None:
        index = self._place[entry.key]
        if entry.state is EntryState.FAILED:
            self.outcomes.fail(index, entry.text)
            self._failed += 1
            return
        try:
            result = self._shared.result(Result.model_validate(read_json(entry.text)))
            feasible = with_constraints(result, self._constraints).feasible
        except (ValueError, ArithmeticError, RecursionError) as wrong:
            raise StoreError(
                "holds a result that this version cannot read", self.where, OTHER_VERSION
            ) from wrong
        self.outcomes.put(index, result)
        self._feasible += feasible

    def _report(self) -> None:
        if self.progress is None:
            return
        now = time.monotonic()
        done = self._cached + self._computed
        left_s = None
        if self._first_batch is not None and self._computed > self._first_batch[1]:
            since, before = self._first_batch
            left_s = (now - since) / (self._computed - before) * (len(self.points) - done)
        self.progress(
            Progress(
                done=done,
                total=len(self.points),
                cached=self._cached,
                feasible=self._feasible,
                failed=self._failed,
                elapsed_s=now - self._started,
                left_s=left_s,
            )
        )
