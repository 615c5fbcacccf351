"""Explore: every point computed once, kept at once, and put together into a study."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from codesign.errors import InputError, RunError, StoreError
from codesign.exploration.definition import MAX_STUDY_POINTS, OTHER_VERSION, definition_text, read_definition
from codesign.exploration.executor import Evaluate, Executor, Group, ProcessExecutor, SerialExecutor
from codesign.exploration.identity import (
    files_digest,
    fingerprint,
    parts_digest,
    problem_files,
    variant_digests,
)
from codesign.exploration.simulator import Simulator, check_some_point
from codesign.exploration.space import DesignPoint, Space, group, group_limit
from codesign.exploration.store import FileStore, MemoryStore, Store
from codesign.exploration.study import Study
from codesign.exploration.tally import Progress, Tally
from codesign.inputs import Platform, Workload, cross_check
from codesign.inputs.exploration import Exploration
from codesign.scenarios import scenario_of
from codesign.system.memory import share_of_memory
from codesign.system.problem_map import grid_of


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
            workers. A store tells results apart by platform, workload and axes, not by this: use one
            store for each.
        memory: bytes that all workers may take together; by default half of what the machine has free. A point that
            would take more than a worker's share, by an estimate, is not begun: it counts as failed.

    Raises:
        InputError: the workload has no ``explore`` section, or more than ``MAX_STUDY_POINTS`` points.
        SpecError: axes that do not fit the platform; or none of the first points can be built: the faults of the first.
        StoreError: the store cannot be used. RunError: a worker process died, or a part or map file changed
            meanwhile. What was finished is kept.
    """
    section = _section(workload)
    workers = _processors() if workers is None else workers
    if workers < 1:
        raise InputError(f"{workers} workers", "workers", "give at least 1")
    if evaluate is None:
        _check_axes(platform, workload, section)
    parts = parts_digest(platform)
    files = problem_files(platform, workload)
    content = files_digest(files)
    grid = grid_of(workload)
    space = Space(section.axes, fingerprint(platform, workload, grid), variant_digests(workload))
    if evaluate is None:
        share = share_of_memory(workers, memory)
        check_some_point(platform, workload, space, grid, share)
        evaluate = Simulator(platform, workload, grid, share)
    where = str(store) if isinstance(store, str | Path) else None
    tally = Tally(space, section.constraints, where, progress)
    with _open_store(store) as kept:
        definition = definition_text(platform, workload, section, space)
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
                if files_digest(files) != content:
                    raise RunError(
                        "a map or .scen file changed while its designs were explored",
                        str(workload.document.folder),
                        "run again: points finished before are kept",
                    )
                kept.put(batch)
                tally.take(batch)
    return tally.study(platform.name, workload.name, section.objectives)


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
            tally = Tally(definition.space, definition.constraints, str(path))
            tally.take_kept(store, retry=False)
            study = tally.study(definition.platform, definition.workload, definition.objectives)
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as wrong:
            raise StoreError(
                "holds a study that this version cannot read", str(path), OTHER_VERSION
            ) from wrong
    return study


def _section(workload: Workload) -> Exploration:
    """The workload's section ``explore``, with objectives, of a size that a study can hold."""
    section = workload.explore
    if section is None:
        raise InputError(
            f"workload {workload.name} has nothing to explore", hint="give it a section explore: with axes:"
        )
    if section.points > MAX_STUDY_POINTS:
        raise InputError(
            f"{section.points:,} points are too many to explore at once",
            "explore.axes",
            f"at most {MAX_STUDY_POINTS:,}, so that the study fits in memory: take values from the axes,"
            " or explore in parts",
        )
    named = "objectives" in section.model_fields_set
    return section if named else section.model_copy(update={"objectives": scenario_of(workload).objectives})


def _open_store(store: Path | str | Store | None) -> contextlib.AbstractContextManager[Store]:
    """A store that is closed afterwards if it is opened here."""
    if store is None:
        return contextlib.closing(MemoryStore())
    if isinstance(store, str | Path):
        return contextlib.closing(FileStore(store))
    return contextlib.nullcontext(store)


def _check_axes(platform: Platform, workload: Workload, section: Exploration) -> None:
    """Check the axes; each fault is reported at its place in the file.

    Raises:
        SpecError: every fault.
    """
    document = workload.document
    axes = {name: list(values) for name, values in section.axes.items()}
    if (document.tree.get("explore") or {}).get("axes", {}) != axes:
        # A section put in from Python: it stands in no file, and its faults are those of the file as a whole.
        workload = workload.model_copy()
        workload._document = dataclasses.replace(document, tree={**document.tree, "explore": {"axes": axes}})
    cross_check(platform, workload, explored=True)


def _groups(pending: list[DesignPoint], platform: Platform, space: Space, workers: int) -> Sequence[Group]:
    """Points that share work together: axes of the platform leave it as it is, those of schedules share stages."""
    owners = {*platform.components, *platform.links}
    cheap = [name for name in space.axes if name.partition(".")[0] in owners]
    related = [name for name in space.axes if name.split(".")[1:2] == ["schedule"]]
    limit = group_limit(len(pending), workers)
    return group(pending, cheap=cheap, related=related, limit=limit)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
