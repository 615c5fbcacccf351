"""Explore: every point computed once, kept at once, and put together into a study."""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from codesign.errors import InputError, RunError, StoreError
from codesign.exploration.blocks import plan_of, read_plan
from codesign.exploration.budget import Budget
from codesign.exploration.cluster import ClusterExecutor
from codesign.exploration.definition import (
    MAX_STUDY_POINTS,
    OTHER_VERSION,
    definition_text,
    platform_text,
    read_definition,
)
from codesign.exploration.evaluation import Done, EvaluatePoint, Evaluator, PointByPoint, Pricer
from codesign.exploration.executor import Executor, ProcessExecutor, SerialExecutor
from codesign.exploration.explored import Explored
from codesign.exploration.file_store import FileStore
from codesign.exploration.identity import canonical_digest, contents_of, files_read, identity_of
from codesign.exploration.kept import Kept
from codesign.exploration.partition import Alone, Work, in_order, parted
from codesign.exploration.simulator import check_some_point
from codesign.exploration.space import Space
from codesign.exploration.specs import Specs
from codesign.exploration.store import MemoryStore, Store
from codesign.exploration.study import Study
from codesign.exploration.tally import Progress, Tally
from codesign.inputs import Platform, Workload
from codesign.inputs.exploration import Exploration
from codesign.progress import Show, silent, tracked
from codesign.scenarios import scenario_of
from codesign.system.memory import share_of_memory
from codesign.system.problem_map import grid_of
from codesign.system.provenance import provenance_of

if TYPE_CHECKING:
    from distributed import Client

    from codesign.maps import OccupancyGrid


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

    Raises:
        InputError: the workload has no ``explore`` section, or more than ``MAX_STUDY_POINTS`` points; or ``workers``
            and ``executor`` are both given.
        SpecError: axes that do not fit the platform; or none of the first points can be built: the faults of the first.
        StoreError: the store cannot be used. RunError: a worker process died, a cluster went away, or a part, host or
            map file changed meanwhile. What was finished is kept.
    """
    explored = Explored.of(platform, workload)
    section = _section(explored)
    given = _given(executor, workers)
    workers = _processors() if workers is None else workers
    if workers < 1:
        raise InputError(f"{workers} workers", "workers", "give at least 1")
    share = share_of_memory(workers, memory) if given is None else given.share(memory)
    if evaluate is None:
        explored.check_axes()
    files = files_read(explored)
    grid = grid_of(workload)
    axes = section.every_axis
    specs = Specs.of(explored, identity_of(explored.single, workload, grid), contents_of(explored))
    space = Space(axes, canonical_digest(specs.identity), specs.contents, section.when)
    where = str(store) if isinstance(store, str | Path) else None
    tally = Tally(space, section, where, progress, specs)
    with _open_store(store) as opened:
        kept = Kept(opened, space, where)
        evaluator = _evaluator(explored, space, grid, share, evaluate, opened)
        provenance = provenance_of(explored.platforms.values(), explored.workload)
        definition = definition_text(explored, section, specs, provenance)
        tally.report("sorting points by what they compute")
        every = list(_works(explored, space, alone=evaluate is not None))
        opened.begin(hashlib.sha256(definition.encode()).hexdigest(), definition, plan_of(every))
        decisions = Space(section.axes, "", when=section.when)
        works = in_order(_pending(kept, tally, every), decisions, len(space) // len(decisions))
        several = workers > 1 and len(works) > 1
        computing = given or (ProcessExecutor(workers) if several else SerialExecutor())
        # Closed by name: after Ctrl-C the traceback would keep the generator, and with it the workers, alive.
        begun = works if budget is None else budget.within(works, partial(_cut, space))
        with contextlib.closing(computing.run(begun, evaluator)) as coming:
            for done in tally.watched(coming, works, computing.workers, budget):
                _refuse_changes(files, files_read(explored))
                tally.take(kept.put(done))
    names = [each.name for each in explored.platforms.values()]
    return tally.study(platform_text(names), workload.name, provenance)


def _given(executor: Executor | Client | None, workers: int | None) -> Executor | None:
    """The executor that was handed in; that of a client of dask.distributed computes with its cluster."""
    if executor is not None and workers is not None:
        what = f"{workers} local workers and an executor are asked for at once"
        raise InputError(what, "workers", "leave one of the two out: workers are processes of this machine")
    distributed = sys.modules.get("distributed")
    if distributed is not None and isinstance(executor, distributed.Client):
        return ClusterExecutor(executor)
    return cast("Executor | None", executor)


def _evaluator(
    explored: Explored,
    space: Space,
    grid: OccupancyGrid | None,
    memory: int,
    evaluate: EvaluatePoint | None,
    store: Store,
) -> Evaluator:
    """What computes the points: the caller's own ``evaluate``, or pricing and simulation."""
    if evaluate is not None:
        return PointByPoint(evaluate, space)
    check_some_point(explored, space, grid, memory)
    return Pricer(explored, space, grid, memory, store.computations())


def _works(explored: Explored, space: Space, *, alone: bool) -> Iterator[Work]:
    """The points as work; ``alone``: each of them is computed by itself."""
    if not alone:
        yield from parted(explored, space, np.arange(len(space)))
        return
    yield from (Alone((point,)) for point in space.points())


def _cut(space: Space, work: Work, count: int) -> Work:
    """The first points of work."""
    return Alone(tuple(map(space.point, work.indices[:count])))


def _pending(kept: Kept, tally: Tally, works: Iterable[Work]) -> list[Work]:
    """What is left to compute, after what the store has was taken."""
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
    with FileStore(path, read_only=True) as store:
        latest = store.latest()
        if latest is None:
            raise StoreError("holds no study", str(path), "hwsw explore puts one there")
        try:
            text, plan = latest
            definition = read_definition(text)
            tally = Tally(definition.space, definition.section, str(path), specs=definition.specs)
            kept = Kept(store, definition.space, str(path))
            kept_works = kept.everything(read_plan(plan, len(definition.space)))
            for done in tracked(
                kept_works, show, "points read", len(definition.space), size=lambda done: len(done.work)
            ):
                tally.take_kept(done)
            study = tally.study(definition.platform, definition.workload, definition.provenance)
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as wrong:
            raise StoreError(
                "holds a study that this version cannot read", str(path), OTHER_VERSION
            ) from wrong
    return study


def _refuse_changes(before: Mapping[Path, str], after: Mapping[Path, str]) -> None:
    for file in {**before, **after}:
        if before.get(file) != after.get(file):
            kinds = {"parts": "part", "hosts": "host"}
            kind = kinds.get(file.parent.name, "map") if file.suffix == ".yaml" else "map"
            raise RunError(
                f"a {kind} file changed while its designs were explored",
                str(file),
                "run again: points finished before are kept",
            )


def _section(explored: Explored) -> Exploration:
    """The workload's section ``explore``, with objectives, of a size that a study can hold."""
    section = explored.section
    if section.points > MAX_STUDY_POINTS:
        raise InputError(
            f"{section.points:,} points are too many to explore at once",
            "explore.axes",
            f"at most {MAX_STUDY_POINTS:,}, so that the study fits in memory: take values from the axes and conditions,"
            " or explore in parts",
        )
    named = "objectives" in section.model_fields_set
    return (
        section
        if named
        else section.model_copy(update={"objectives": scenario_of(explored.workload).objectives})
    )


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
