"""Explore: every point computed once, kept at once, and put together into a study."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from codesign.errors import InputError, RunError, StoreError
from codesign.exploration.definition import (
    MAX_STUDY_POINTS,
    OTHER_VERSION,
    definition_text,
    platform_text,
    read_definition,
)
from codesign.exploration.executor import Evaluate, Executor, Group, ProcessExecutor, SerialExecutor
from codesign.exploration.explored import Explored
from codesign.exploration.identity import canonical_digest, contents_of, files_read, identity_of
from codesign.exploration.simulator import Simulator, check_some_point
from codesign.exploration.space import DesignPoint, Space, group, group_limit
from codesign.exploration.specs import Specs
from codesign.exploration.store import FileStore, MemoryStore, Store
from codesign.exploration.study import Study
from codesign.exploration.tally import Progress, Tally
from codesign.inputs import Platform, Workload
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.inputs.exploration import Exploration
from codesign.inputs.roles import ROLES
from codesign.scenarios import scenario_of
from codesign.system.memory import share_of_memory
from codesign.system.problem_map import grid_of
from codesign.system.provenance import provenance_of


def explore(
    platform: Platform | Sequence[Platform] | None,
    workload: Workload,
    *,
    store: Path | str | Store | None = None,
    workers: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    evaluate: Evaluate | None = None,
    memory: int | None = None,
) -> Study:
    """Compute every point of the workload's exploration on the platform or platforms.

    Args:
        platform, workload: what is explored: see ``Explored.of``. The axes, objectives and constraints stand in the
            workload.
        store: a file that finished points are kept in, and found in the next time; or a store; None keeps
            nothing.
        workers: processes; by default one for each processor of this machine. The study is the same
            whatever it is.
        progress: called at the start and whenever points come in.
        evaluate: computes one point; by default it is simulated. Must pickle where there are several
            workers. A store tells results apart by platform, workload and axes, not by this: use one
            store for each.
        memory: bytes that all workers may take together; by default half of what the machine has free. A point that
            would take more than a worker's share, by an estimate, is not begun: it counts as failed.

    Raises:
        InputError: the workload has no ``explore`` section, or more than ``MAX_STUDY_POINTS`` points.
        SpecError: axes that do not fit the platform; or none of the first points can be built: the faults of the first.
        StoreError: the store cannot be used. RunError: a worker process died, or a part, host or map file changed
            meanwhile. What was finished is kept.
    """
    explored = Explored.of(platform, workload)
    section = _section(explored)
    workers = _processors() if workers is None else workers
    if workers < 1:
        raise InputError(f"{workers} workers", "workers", "give at least 1")
    if evaluate is None:
        explored.check_axes()
    files = files_read(explored)
    grid = grid_of(workload)
    axes = section.every_axis
    specs = Specs.of(explored, identity_of(explored.single, workload, grid), contents_of(explored))
    space = Space(axes, canonical_digest(specs.identity), specs.contents)
    if evaluate is None:
        share = share_of_memory(workers, memory)
        check_some_point(explored, space, grid, share)
        evaluate = Simulator(explored, grid, share)
    where = str(store) if isinstance(store, str | Path) else None
    tally = Tally(space, section, where, progress, specs)
    with _open_store(store) as kept:
        provenance = provenance_of(explored.platforms.values(), explored.workload)
        definition = definition_text(explored, section, specs, provenance)
        kept.begin(hashlib.sha256(definition.encode()).hexdigest(), definition)
        groups = _groups(tally.take_kept(kept), explored, space, workers)
        several = workers > 1 and len(groups) > 1
        executor: Executor = ProcessExecutor(workers) if several else SerialExecutor()
        # Closed by name: after Ctrl-C the traceback would keep the generator, and with it the workers, alive.
        with contextlib.closing(executor.run(groups, evaluate)) as batches:
            for batch in batches:
                _refuse_changes(files, files_read(explored))
                kept.put(batch)
                tally.take(batch)
    names = [each.name for each in explored.platforms.values()]
    return tally.study(platform_text(names), workload.name, provenance)


def load_study(path: Path | str) -> Study:
    """The study that a store's file was last used for, without computing anything.

    Points that the interrupted exploration did not reach are in the state ``missing``.

    Raises:
        StoreError: the file is no store, is damaged, or holds no study.
    """
    with FileStore(path, read_only=True) as store:
        text = store.latest()
        if text is None:
            raise StoreError("holds no study", str(path), "hwsw explore puts one there")
        try:
            definition = read_definition(text)
            tally = Tally(definition.space, definition.section, str(path), specs=definition.specs)
            tally.take_kept(store, retry=False)
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


def _groups(pending: list[DesignPoint], explored: Explored, space: Space, workers: int) -> Sequence[Group]:
    """Points that share work together: platforms and their axes leave it as it is, those of schedules share stages."""
    owners = {PLATFORM_AXIS, *ROLES}
    for platform in explored.platforms.values():
        owners |= {*platform.components, *platform.links}
    cheap = [name for name in space.axes if name.partition(".")[0] in owners]
    related = [name for name in space.axes if name.split(".")[1:2] == ["schedule"]]
    limit = group_limit(len(pending), workers)
    return group(pending, cheap=cheap, related=related, limit=limit)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
