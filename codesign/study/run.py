"""Explore: every point computed once, kept at once, and put together into a study."""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from codesign.ground.errors import InputError, StoreError
from codesign.ground.progress import Show, silent, tracked
from codesign.inputs import Platform, Workload
from codesign.inputs.exploration import Exploration, Searching, asked
from codesign.study.blocks import Plan, plan_of, read_plan
from codesign.study.bounds import Bounds
from codesign.study.budget import Budget
from codesign.study.cluster import ClusterExecutor
from codesign.study.definition import MAX_STUDY_POINTS, OTHER_VERSION, Specs, StudyDefinition, read_definition
from codesign.study.evaluation import Done, EvaluatePoint, Evaluator, PointByPoint, Pricer
from codesign.study.executor import Executor, ProcessExecutor, SerialExecutor
from codesign.study.explored import Explored
from codesign.study.identity import canonical_digest
from codesign.study.kept import Kept, boxes_of, forget_search, keep_boxes, keep_search, search_of_study
from codesign.study.partition import Alone, Indices, Together, Turns, Work, parted
from codesign.study.search import Searched, Trace
from codesign.study.search_run import CUT_OFF, Rounds, SearchRun, enumerated, searched_before
from codesign.study.simulator import check_some_point
from codesign.study.space import Space
from codesign.study.store import FileStore, MemoryStore, Store
from codesign.study.study import Study
from codesign.study.tally import Progress, Tally, seldom_collected
from codesign.study.work_queue import Dealer
from codesign.system.memory import share_of_memory
from codesign.system.scenarios import scenario_of

if TYPE_CHECKING:
    from distributed import Client


def explore(
    platform: Platform | Sequence[Platform] | None,
    workload: Workload,
    *,
    store: Path | str | Store | None = None,
    workers: int | None = None,
    executor: Executor | Client | None = None,
    progress: Callable[[Progress], None] | None = None,
    evaluate: EvaluatePoint | None = None,
    memory: int | None = None,
    budget: Budget | None = None,
    search: str | None = None,
    seed: int | None = None,
) -> Study:
    """Compute every point of the workload's exploration on the platform or platforms.

    Args:
        platform, workload: what is explored: see ``Explored.of``. The axes, objectives and constraints stand in the
            workload.
        store: a file that finished points are kept in, and found in the next time; or a store; None keeps
            nothing.
        workers: processes; by default one for each processor of this machine. The study is the same
            whatever it is.
        executor: computes in the place of processes of this machine, such as ``ClusterExecutor(address)``; or a client
            of dask.distributed.
        progress: called at the start and whenever points come in.
        evaluate: computes one point; by default it is simulated. Must pickle where there are several
            workers. A store tells results apart by platform, workload and axes, not by this: use one
            store for each.
        memory: bytes that all workers may take together; by default half of what the machine has free. A point that
            would take more than a worker's share, by an estimate, is not begun: it counts as failed.
        budget: how many points to compute, or for how long; by default all. The rest is missing. ``budget.ended`` then
            says why.
        search, seed: the search that says which points to compute; by default the workload's own (``explore.search``),
            or else all points. ``all``: all of them. What ``budget`` leaves open, the workload's search settles.

    Raises:
        InputError: the workload has no ``explore`` section, or more than ``MAX_STUDY_POINTS`` points; or ``workers``
            and ``executor`` are both given.
        SpecError: axes that do not fit the platform; or none of the first points can be built: the faults of the first.
        StoreError: the store cannot be used. RunError: a worker process died, a cluster went away, or a part, host or
            map file changed meanwhile. What was finished is kept.
    """
    searching = asked(workload.explore.search if workload.explore else None, search, seed)
    if searching is not None:
        budget = (budget or Budget()).filled(searching.points, searching.seconds)
    explored = Explored.of(platform, workload)
    section = _section(explored, searching)
    given = _given(executor, workers)
    workers = _processors() if workers is None else workers
    if workers < 1:
        raise InputError(f"{workers} workers", "workers", "give at least 1")
    share = share_of_memory(workers, memory) if given is None else given.share(memory)
    if evaluate is None:
        explored.check_axes()
    specs = Specs.of(explored)
    space = Space(section.every_axis, canonical_digest(specs.identity), specs.contents, section.when)
    definition = StudyDefinition.of(section, space, specs)
    where = str(store) if isinstance(store, str | Path) else None
    with seldom_collected(), _open_store(store) as opened:
        evaluator = _evaluator(specs, space, share, evaluate, opened)
        why = ""
        if searching is not None and isinstance(evaluator, Pricer):
            why = enumerated(searching, explored, space, budget)
        kind = Tally if searching is None or why else Rounds
        tally = kind(space, section, where, progress)
        kept = Kept(opened, space, where, lasting=store is not None or searching is not None)
        run = _Run(definition, kept, tally, evaluator, given or workers)
        if searching is None:
            run.every_point(budget)
        elif isinstance(tally, Rounds):
            tally.search = run.search(tally, searching, budget)
        else:
            tally.search = run.in_place_of(searching, why, budget or Budget())
        excluded = boxes_of(run.kept, run.key, run.decisions)
    return replace(tally.study(definition), excluded=excluded)


@dataclass(frozen=True)
class _Run:
    """An exploration with an open store. ``computing``: an executor, or how many processes of this machine."""

    definition: StudyDefinition
    kept: Kept
    tally: Tally
    evaluator: Evaluator
    computing: Executor | int

    @property
    def section(self) -> Exploration:
        """The exploration: axes, conditions, objectives and constraints."""
        return self.definition.section

    @property
    def space(self) -> Space:
        """The points."""
        return self.kept.space

    @cached_property
    def decisions(self) -> Space:
        """The designs."""
        return Space(self.section.axes, "", when=self.section.when)

    @cached_property
    def key(self) -> str:
        """The key of the study in its store."""
        return hashlib.sha256(self.definition.text.encode()).hexdigest()

    @cached_property
    def earlier(self) -> Plan:
        """The plan of this study that was made before."""
        plan = self.kept.store.plan(self.key)
        return read_plan(plan, len(self.space)) if plan else ()

    def every_point(self, budget: Budget | None) -> None:
        """Compute all points, or as many as the budget allows."""
        found, left = self._evaluated()
        every = list(self.tally.sorting(self.works(left)))
        self._note(every, found)
        forget_search(self.kept, self.key)
        pending = _pending(self.kept, self.tally, every)
        turns = Turns(self.decisions, len(self.space) // len(self.decisions))
        works, beyond = turns.sorted(pending), list[Work]()
        if budget is not None and budget.left is not None and budget.left < sum(map(len, works)):
            points = turns.first(np.concatenate([work.numbers for work in works]), budget.left)
            # Nothing is begun of what lies beyond: it ends the budget.
            works, beyond = turns.sorted(self.works(points)), works[:1]
            self._note([*every, *works], found)
        begun = works if budget is None else Dealer(budget.within([*works, *beyond]), budget.late)
        # Closed by name: after Ctrl-C the traceback would keep the generator, and with it the workers, alive.
        executor = self._executor(several=len(works) > 1)
        with contextlib.closing(executor.run(begun, self.evaluator)) as coming:
            for done in self.tally.watched(coming, works, executor.workers, budget):
                self._came(done)

    def _evaluated(self) -> tuple[Plan, Indices]:
        """The blocks of this study that the store has, whatever was asked for together then; and all other points."""
        left = np.ones(len(self.space), np.bool_)
        found = []
        for done in self.kept.blocks(self.earlier):
            assert isinstance(done.work, Together), "a block"
            numbers = done.work.numbers
            if left[numbers].all():
                left[numbers] = False
                found.append((done.work.key, numbers))
                self.tally.take_kept(done)
        return found, np.flatnonzero(left)

    def search(self, rounds: Rounds, searching: Searching, budget: Budget | None) -> Searched:
        """Compute what a search asks for, and as many random points beside it."""
        run = SearchRun(
            self.section, self.kept, rounds, self.works, self._computed, self._note_asked, self._came, self.earlier
        )
        bounds = None
        if isinstance(self.evaluator, Pricer):
            bounds = Bounds(self.space, self.decisions, self.section, self.evaluator)
        beside = () if searching.sampler == "random" else (searching.as_random(),)
        with contextlib.closing(run):
            try:
                found = run.run((searching, *beside), run.problem(self.decisions, bounds), budget)
            finally:
                keep_search(self.kept, self.key, run.searched)
        rounds.gather(run.in_order, run.conditions)
        keep_boxes(self.kept, self.key, found.excluded, self.decisions)
        return found

    def in_place_of(self, searching: Searching, why: str, budget: Budget) -> Searched:
        """Compute all points in the place of a search; ``why``: see ``enumerated``. Time alone limits it."""
        budget.points = None
        trace = Trace(searching.sampler, searching.seed, ended=CUT_OFF, enumerated=why)
        try:
            self.every_point(budget)
            trace.ended, trace.proved = budget.ended, self.tally.done == len(self.space)
        finally:
            searched = Searched((trace,), self.tally.simulated, self.tally.cached)
            keep_search(self.kept, self.key, searched)
        return searched

    def works(self, points: Indices) -> Iterator[Work]:
        """Points as work: those that compute the same together, where they can be priced."""
        if isinstance(self.evaluator, Pricer):
            if len(points):
                yield from parted(self.definition.specs.explored, self.space, points)
            return
        yield from (Alone((self.space.point(point),)) for point in points.tolist())

    def _executor(self, *, several: bool = True) -> Executor:
        if not isinstance(self.computing, int):
            return self.computing
        return ProcessExecutor(self.computing) if several and self.computing > 1 else SerialExecutor()

    def _computed(self, works: Iterable[Work]) -> Generator[Done, None, None]:
        return self._executor().run(works, self.evaluator)

    def _note(self, works: Sequence[Work], earlier: Plan) -> None:
        self.kept.store.begin(self.key, self.definition.text, plan_of(works, earlier=earlier))

    def _note_asked(self, works: Sequence[Work]) -> None:
        plan = plan_of(works, alone=True, earlier=self.earlier)
        self.kept.store.begin(self.key, self.definition.text, plan)

    def _came(self, done: Done) -> None:
        self.definition.specs.refuse_changes()
        self.tally.take(self.kept.put(done))
        if isinstance(self.evaluator, Pricer):
            # Where a worker computed it, this process has not.
            self.evaluator.computations.update(done.computations)


def _given(executor: Executor | Client | None, workers: int | None) -> Executor | None:
    """The executor that was handed in; the executor of a client of dask.distributed computes with its cluster."""
    if executor is not None and workers is not None:
        what = f"{workers} local workers and an executor are asked for at once"
        raise InputError(what, "workers", "leave one of the two out: workers are processes of this machine")
    distributed = sys.modules.get("distributed")
    if distributed is not None and isinstance(executor, distributed.Client):
        return ClusterExecutor(executor)
    return cast("Executor | None", executor)


def _evaluator(specs: Specs, space: Space, memory: int, evaluate: EvaluatePoint | None, store: Store) -> Evaluator:
    """The evaluator of the points: the caller's own ``evaluate``, or pricing and simulation."""
    if evaluate is not None:
        return PointByPoint(evaluate, space)
    check_some_point(specs.explored, space, specs.grid, memory)
    return Pricer(specs.explored, space, specs.grid, memory, store.computations())


def _pending(kept: Kept, tally: Tally, works: Iterable[Work]) -> list[Work]:
    """The work that is left to compute, after what the store has was taken."""
    pending: list[Work] = []
    for each in kept.parted(works):
        if isinstance(each, Done):
            tally.take_kept(each)
        else:
            pending.append(each)
    tally.report()
    return pending


def load_study(path: Path | str, show: Show = silent) -> Study:
    """The study that a store's file was last used for, without computing anything.

    Points that the interrupted exploration did not reach are in the state ``missing``.

    Raises:
        StoreError: the file is no store, is damaged, or holds no study.
    """
    with seldom_collected(), FileStore(path, read_only=True) as store:
        latest = store.latest()
        if latest is None:
            raise StoreError("holds no study", str(path), "hwsw explore puts one there")
        try:
            text, plan = latest
            definition = read_definition(text)
            space, section = definition.space, definition.section
            kept = Kept(store, space, str(path))
            planned = read_plan(plan, len(space))
            if len(space) > MAX_STUDY_POINTS:
                tally: Tally = searched_before(kept, section, planned)
            else:
                tally = Tally(space, section, str(path))
                for done in tracked(
                    kept.everything(planned), show, "points read", len(space), size=lambda done: len(done.work)
                ):
                    tally.take_kept(done)
            study = tally.study(definition)
            key = hashlib.sha256(text.encode()).hexdigest()
            whole = Space(section.axes, "", when=section.when)
            searched = search_of_study(kept, key, whole, study.chosen)
            study = replace(study, excluded=boxes_of(kept, key, study.decisions), search=searched)
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as wrong:
            raise StoreError("holds a study that this version cannot read", str(path), OTHER_VERSION) from wrong
    return study


def _section(explored: Explored, search: Searching | None) -> Exploration:
    """The workload's section ``explore``, with objectives; without a search, of a size that a study can hold."""
    section = explored.section
    if search is None and section.points > MAX_STUDY_POINTS:
        raise InputError(
            f"{section.points:,} points are too many to explore at once",
            "explore.axes",
            f"at most {MAX_STUDY_POINTS:,}, so that the study fits in memory: take values from the axes and conditions,"
            " or search (--search)",
        )
    named = "objectives" in section.model_fields_set
    return section if named else section.model_copy(update={"objectives": scenario_of(explored.workload).objectives})


def _open_store(store: Path | str | Store | None) -> contextlib.AbstractContextManager[Store]:
    """A store that is closed afterwards if it is opened here."""
    if store is None:
        return contextlib.closing(MemoryStore())
    if isinstance(store, str | Path):
        return contextlib.closing(FileStore(store))
    return contextlib.nullcontext(store)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
