"""Explore: every point computed once, kept at once, and put together into a study."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, InputError, RunError, SpecError, StoreError
from codesign.exploration.executor import Evaluate, Executor, Group, ProcessExecutor, SerialExecutor
from codesign.exploration.identity import fingerprint, parts_digest, variant_digests
from codesign.exploration.shared import Shared
from codesign.exploration.space import DesignPoint, Space, group, group_limit
from codesign.exploration.store import Entry, EntryState, FileStore, MemoryStore, Store
from codesign.exploration.study import Study, StudyPoint, judged
from codesign.figures import ResultFigure
from codesign.inputs import Platform, Workload, cross_check, design_point
from codesign.inputs.exploration import Constraint, Exploration, declared
from codesign.memo import Memo
from codesign.results.result import Result
from codesign.scenarios import bind, scenario_of
from codesign.system.bind import grid_of
from codesign.system.memory import share_of_memory
from codesign.system.ready import ready

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

MAX_POINTS = 200_000
"""Most points of one exploration: a study holds them all in memory."""

_TRIED_AT_FIRST = 1000
_KEYS_AT_ONCE = 500
_MOST_DIGITS = 40
_OTHER_VERSION = "read it with the version that wrote it, or explore again into another file"


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


class Simulator:
    """Computes a point by simulating it; what points share is computed once in each process.

    ``grid``: the map that the keys of the points were made for: every process plans on it, whatever becomes of its
    file. ``memory``: bytes that a point may take; one that would take more is refused, and so fails.
    """

    def __init__(
        self,
        platform: Platform,
        workload: Workload,
        grid: OccupancyGrid | None = None,
        memory: int | None = None,
    ) -> None:
        self.platform, self.workload, self.grid, self.memory = platform, workload, grid, memory
        self._memo: Memo | None = None

    def __call__(self, point: DesignPoint) -> Result:
        """The result of one point."""
        from codesign.scenarios import simulate

        if self._memo is None:
            self._memo = Memo()
        moved = design_point(self.platform, self.workload, point.axes)
        own = _grid_for(moved[1], self.workload, self.grid)
        return simulate(*moved, memo=self._memo, grid=own, memory=self.memory)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_memo": None}


def explore(
    platform: Platform,
    workload: Workload,
    *,
    store: Path | str | Store | None = None,
    workers: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    evaluate: Evaluate | None = None,
    memory: int | None = None,
) -> Study:
    """Compute every point of the workload's exploration on the platform.

    Args:
        platform, workload: what is explored; the axes, objectives and constraints stand in the workload.
        store: a file that finished points are kept in, and found in the next time; or a store; None keeps
            nothing.
        workers: processes; by default one for each processor of this machine. The study is the same
            whatever it is.
        progress: called at the start and whenever points come in.
        evaluate: computes one point; by default it is simulated. Must pickle where there are several
            workers. Results in a store are told apart by platform, workload and axes, not by this: use one
            store for each.
        memory: bytes that all workers may take together; by default half of what the machine has free. A point that
            would take more than a worker's share, by an estimate, is not begun: it counts as failed.

    Raises:
        InputError: the workload has no ``explore`` section, or more than ``MAX_POINTS`` points.
        SpecError: axes that do not fit the platform; or none of the first points can be built: the faults of the first.
        StoreError: the store cannot be used. RunError: a worker process died, or a part file changed meanwhile. What
            was finished is kept.
    """
    section = _section(workload)
    workers = _processors() if workers is None else workers
    if workers < 1:
        raise InputError(f"{workers} workers", "workers", "give at least 1")
    if evaluate is None:
        _check_axes(platform, workload, section)
    parts = parts_digest(platform)
    grid = grid_of(workload)
    space = Space(section.axes, fingerprint(platform, workload, grid), variant_digests(workload))
    if evaluate is None:
        share = share_of_memory(workers, memory)
        _check_some_point(platform, workload, space, grid, share)
        evaluate = Simulator(platform, workload, grid, share)
    where = str(store) if isinstance(store, str | Path) else None
    tally = _Tally(space, section.constraints, where, progress)
    with _opened(store) as kept:
        definition = _definition(platform, workload, section, space)
        kept.begin(hashlib.sha256(definition.encode()).hexdigest(), definition)
        groups = _groups(tally.take_kept(kept), platform, space, workers)
        several = workers > 1 and len(groups) > 1
        executor: Executor = ProcessExecutor(workers) if several else SerialExecutor()
        # Closed by name: after Ctrl-C the traceback would keep the generator, and with it the workers, alive.
        with contextlib.closing(executor.run(groups, evaluate)) as batches:
            for batch in batches:
                if parts_digest(platform) != parts:
                    raise RunError(
                        "a part file changed while its designs were explored",
                        str(platform.document.folder / "parts"),
                        "run again: points finished before are kept",
                    )
                kept.put(batch)
                tally.take(batch)
    return tally.study(platform.name, workload.name, section.objectives)


def _section(workload: Workload) -> Exploration:
    """What is to be explored, of a size that a study can hold."""
    section = workload.explore
    if section is None:
        raise InputError(
            f"workload {workload.name} has nothing to explore", hint="give it a section explore: with axes:"
        )
    if section.points > MAX_POINTS:
        raise InputError(
            f"{section.points:,} points are too many to explore at once",
            "explore.axes",
            f"at most {MAX_POINTS:,}, so that the study fits in memory: take values from the axes, or explore in parts",
        )
    named = "objectives" in section.model_fields_set
    return section if named else section.model_copy(update={"objectives": scenario_of(workload).objectives})


def _opened(store: Path | str | Store | None) -> contextlib.AbstractContextManager[Store]:
    """A store that is closed afterwards if it is opened here."""
    if store is None:
        return contextlib.closing(MemoryStore())
    if isinstance(store, str | Path):
        return contextlib.closing(FileStore(store))
    return contextlib.nullcontext(store)


def load_study(path: Path | str) -> Study:
    """The study that a store's file was last used for, without computing anything.

    Points that are not there, because the exploration was interrupted, are in the state ``missing``.

    Raises:
        StoreError: the file is none of ours, is damaged, or holds no study.
    """
    with FileStore(path, read_only=True) as store:
        text = store.latest()
        if text is None:
            raise StoreError("holds no study", str(path), "hwsw explore puts one there")
        try:
            known = _read_json(text)
            constraints = tuple(Constraint.model_validate(limit) for limit in known["constraints"])
            objectives = tuple(declared(name) for name in known["objectives"])
            axes = Exploration.model_validate({"axes": known["axes"]}).axes
            variants = {str(name): str(digest) for name, digest in known.get("variants", {}).items()}
            space = Space(axes, str(known["fingerprint"]), variants)
            if len(space) > MAX_POINTS:
                raise ValueError(f"{len(space)} points")
            tally = _Tally(space, constraints, str(path))
            tally.take_kept(store, retry=False)
            study = tally.study(str(known["platform"]["name"]), str(known["workload"]["name"]), objectives)
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as wrong:
            raise StoreError(
                "holds a study that this version cannot read", str(path), _OTHER_VERSION
            ) from wrong
    return study


class _Tally:
    """The outcomes so far, by index, and what is told of them."""

    def __init__(
        self,
        space: Space,
        constraints: tuple[Constraint, ...],
        where: str | None,
        progress: Callable[[Progress], None] | None = None,
    ) -> None:
        self.space = space
        self.constraints = constraints
        self.where = where
        self.progress = progress
        self.points = list(space.points())
        self.outcomes = [StudyPoint(point.index, point.axes) for point in self.points]
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
            found = store.find([point.key for point in some])
            for point in some:
                entry = found.get(point.key)
                if entry is None or (retry and entry.state is EntryState.FAILED):
                    pending.append(point)
                else:
                    self._take(entry)
        self._cached = len(self.points) - len(pending)
        self._tell()
        return pending

    def take(self, entries: tuple[Entry, ...]) -> None:
        """Take what was computed."""
        for entry in entries:
            self._take(entry)
        self._computed += len(entries)
        self._first_batch = self._first_batch or (time.monotonic(), self._computed)
        self._tell()

    def study(self, platform: str, workload: str, objectives: tuple[ResultFigure, ...]) -> Study:
        """What was taken, as a study."""
        axes, outcomes = dict(self.space.axes), tuple(self.outcomes)
        return Study(platform, workload, axes, objectives, self.constraints, outcomes)

    def _take(self, entry: Entry) -> None:
        index = self._place[entry.key]
        axes = self.points[index].axes
        if entry.state is EntryState.FAILED:
            self.outcomes[index] = StudyPoint(index, axes, failure=entry.text)
            self._failed += 1
            return
        try:
            read = self._shared.result(Result.model_validate(_read_json(entry.text)))
            result = judged(read, self.constraints)
        except (ValueError, ArithmeticError, RecursionError) as wrong:
            raise StoreError(
                "holds a result that this version cannot read", self.where, _OTHER_VERSION
            ) from wrong
        self.outcomes[index] = StudyPoint(index, axes, result)
        self._feasible += result.feasible

    def _tell(self) -> None:
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


def _read_json(text: str) -> Any:
    """JSON whose numbers all are finite, as those of results are.

    Raises:
        ValueError: the text is none. RecursionError: it is nested too deep.
    """
    return json.loads(text, parse_float=_finite, parse_int=_bounded, parse_constant=_finite)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not finite")
    return value


def _bounded(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text)


def _definition(platform: Platform, workload: Workload, section: Exploration, space: Space) -> str:
    """What ``load_study`` needs, and the specs for whoever opens the file later."""
    # Not canonical text: the order of the axes is that of the points, and JSON keeps it only unsorted.
    known = {
        "platform": platform.model_dump(mode="json"),
        "workload": workload.model_dump(mode="json"),
        "fingerprint": space.fingerprint,
        "variants": dict(space.variants),
        "axes": {name: list(values) for name, values in space.axes.items()},
        "objectives": [figure.name for figure in section.objectives],
        "constraints": [limit.model_dump(mode="json", exclude_none=True) for limit in section.constraints],
    }
    return json.dumps(known, ensure_ascii=False, allow_nan=False)


def _check_axes(platform: Platform, workload: Workload, section: Exploration) -> None:
    """Tell what is wrong with the axes at their places in the file.

    Raises:
        SpecError: every fault.
    """
    document = workload.document
    axes = {name: list(values) for name, values in section.axes.items()}
    if (document.tree.get("explore") or {}).get("axes", {}) != axes:
        # A section put in from Python: it stands in no file, and its faults are told of the file as a whole.
        workload = workload.model_copy()
        workload._document = dataclasses.replace(document, tree={**document.tree, "explore": {"axes": axes}})
    cross_check(platform, workload, explored=True)


def _grid_for(moved: Workload, workload: Workload, grid: OccupancyGrid | None) -> OccupancyGrid | None:
    """The map that was read before, unless an axis moved the problem."""
    return grid if moved.problem is workload.problem else None


def _check_some_point(
    platform: Platform, workload: Workload, space: Space, grid: OccupancyGrid | None, memory: int
) -> None:
    """Where no point at all can be bound, or none in so much memory, say so now, instead of a failure for each.

    Raises:
        SpecError, InputError: those of the first point.
    """
    first: CodesignError | None = None
    for point in islice(space.points(), _TRIED_AT_FIRST):
        try:
            moved = design_point(platform, workload, point.axes)
            ready(bind(*moved, grid=_grid_for(moved[1], workload, grid)), memory=memory)
        except (SpecError, InputError) as fault:
            first = first or fault
        else:
            return
    if first is not None and len(space) <= _TRIED_AT_FIRST:
        raise first


def _groups(pending: list[DesignPoint], platform: Platform, space: Space, workers: int) -> Sequence[Group]:
    """Points that share work together: axes of the platform leave it as it is, those of schedules share stages."""
    known = {*platform.components, *platform.links}
    cheap = [name for name in space.axes if name.partition(".")[0] in known]
    related = [name for name in space.axes if name.split(".")[1:2] == ["schedule"]]
    limit = group_limit(len(pending), workers)
    return group(pending, cheap=cheap, related=related, limit=limit)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
