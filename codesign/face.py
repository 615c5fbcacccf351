"""The functions of Python: ``simulate``, ``explain``, ``explore``, and the loading of what they are given."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from codesign import inputs, study
from codesign.ground.errors import InputError, MapError, choose_hint
from codesign.ground.progress import silent
from codesign.inputs import Platform, Workload
from codesign.system import catalog, point_of, scenarios
from codesign.system.outcome import provenance_of
from codesign.system.problem_map import grid_of
from codesign.views import trace as traces

if TYPE_CHECKING:
    from distributed import Client

    from codesign.ground.progress import Show
    from codesign.ground.records import Listener
    from codesign.inputs.files import Source
    from codesign.study import Executor, Progress, Study
    from codesign.study.budget import Budget
    from codesign.system import MissionProgress, Result
    from codesign.system.explanation import Explanation
    from codesign.system.results.result import Provenance


def load_platform(source: Source) -> Platform:
    """The platform of a shipped name, a YAML file (a path, or a name that ends in ``.yaml``), YAML text, or a dict.

    A text with a line break is YAML. Part files and maps of a text or a dict are looked for from the current folder.

    Raises:
        SpecError: all faults at once. InputError: no shipped platform has that name.
    """
    return inputs.load_platform(source)


def load_workload(source: Source) -> Workload:
    """The workload of a shipped name, a YAML file, YAML text, or a dict; its planner's parameters are checked too.

    Raises:
        SpecError: all faults at once. InputError: no shipped workload has that name.
    """
    return catalog.load_workload(source)


def _platform(source: Platform | Source) -> Platform:
    """The platform, loaded where it is not."""
    return source if isinstance(source, Platform) else load_platform(source)


def _workload(source: Workload | Source) -> Workload:
    """The workload, loaded where it is not."""
    return source if isinstance(source, Workload) else load_workload(source)


def simulate(
    platform: Platform | Source,
    workload: Workload | Source,
    *,
    granularity: str = "run_ahead",
    trace: str | Path | None = None,
    trace_level: str = "blocks",
    listeners: Sequence[Listener] = (),
    progress: Callable[[MissionProgress], None] | None = None,
    memory: int | None = None,
    keeping: bool = False,
    levers: bool = False,
    lever_progress: Callable[[int, int, str], None] | None = None,
) -> Result:
    """Simulate one design point, and write its MCAP trace where a file is named.

    ``platform``, ``workload``: loaded, or what ``load_platform`` and ``load_workload`` take.
    ``granularity``: ``run_ahead`` or ``visit``; the result is the same. ``listeners`` take the records of the run.
    ``progress`` is called now and then while a drive goes on. A design that does not fit gives a result with
    ``feasible`` False and its reasons, and leaves no trace. ``memory``: bytes that the run may take, by an estimate
    made before it begins; by default half of what the machine has free. ``keeping``: a listener keeps all records in
    memory, which the estimate then counts. ``trace_level``: how much the trace holds (``codesign.views.trace.Level``):
    ``mission``, ``messages``, ``blocks`` or ``iterations``.

    ``levers``: run a mission again with each of its levers moved by itself (clocks, costs of hosts, rates of links, the
    robot's kinematics), which takes as many runs more; ``Mission.levers`` and ``Mission.bottleneck`` say what they
    give. ``lever_progress`` takes how many levers are done, of how many, and which comes next.

    Raises:
        SpecError: platform, workload and map do not belong together, or the run would take more than ``memory``.
        InputError: there is no such level of a trace.
        TraceError: the trace cannot be written.
    """
    platform, workload = _platform(platform), _workload(workload)
    try:
        provenance = provenance_of((platform,), workload, grid_of(workload))
    except MapError:
        # The simulation reports it, at its place in the workload.
        provenance = None
    with ExitStack() as stack:
        writer = (
            None
            if trace is None or provenance is None
            else stack.enter_context(_trace_writer(trace, trace_level, platform, workload, provenance))
        )
        result = scenarios.simulate(
            platform,
            workload,
            granularity=granularity,
            listeners=listeners if writer is None else (*listeners, writer),
            progress=progress,
            memory=memory,
            keeping=keeping,
            levers=levers,
            lever_progress=lever_progress,
        )
        if writer is not None and not result.simulated:
            writer.abort()
    return result.model_copy(update={"provenance": provenance})


def _trace_writer(
    trace: str | Path, level: str, platform: Platform, workload: Workload, provenance: Provenance
) -> traces.McapListener:
    names = {
        "platform": platform.name,
        "platform_digest": provenance.platform_digests[platform.name],
        "workload": workload.name,
    }
    if level not in list(traces.Level):
        raise InputError(f"{level!r} is no level of a trace", "trace_level", choose_hint(level, list(traces.Level)))
    return traces.McapListener(trace, names | provenance.stamped().constants, traces.Level(level))


def explain(
    platform: Platform | Source,
    workload: Workload | Source,
    settings: Mapping[str, Any] | None = None,
    show: Show | None = None,
) -> Explanation:
    """Explain why a run takes its time and energy, why it is out, what would be better, and how sure that is.

    The run is simulated, and so is each of its levers and each step to a next value, by itself. ``settings``: raw
    values by axis, put into platform and workload first. A study has ``Study.explain(index)``.
    ``show`` is told what is run (``codesign.ground.progress``).

    Raises:
        SpecError: platform, workload and map do not belong together, or an axis is none.
    """
    asked = _workload(workload)
    point = point_of(_platform(platform), asked, settings or {})
    return study.explain_run(*point, asked, settings, show or silent)


def explore(
    platform: Platform | Source | Sequence[Platform | Source] | None,
    workload: Workload | Source,
    *,
    store: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | Client | None = None,
    progress: Callable[[Progress], None] | None = None,
    memory: int | None = None,
    budget: Budget | None = None,
    search: str | None = None,
    seed: int | None = None,
) -> Study:
    """Evaluate every point of the workload's exploration; finished points are kept in ``store`` and not done again.

    ``platform``: one, which settles the axis ``platform`` of the workload; a list of several, which become the values
    of that axis; or None, where the workload has it. ``platform``, ``workload``: loaded, or what ``load_platform`` and
    ``load_workload`` take.
    ``workers``: processes of this machine; by default one. ``executor``: computes in their place, such as
    ``codesign.study.ClusterExecutor(address)`` or a client of dask.distributed.
    ``memory``: bytes that all workers may take together; by default half of what the machine has free.
    ``budget``: how many points to compute, or for how long (``codesign.study.budget``); by default all.
    ``search``: ``nsga2``, ``tpe``, ``random`` or ``bound`` says which, with ``seed``; ``all``: all in turn. By default
    the workload says it (``explore.search``), or else all in turn.

    Raises:
        SpecError: an axis does not fit the platform. StoreError: the store cannot be used.
    """
    platforms: Platform | list[Platform] | None = None
    if isinstance(platform, list | tuple):
        platforms = [_platform(each) for each in platform]
    elif platform is not None:
        platforms = _platform(cast("Platform | Source", platform))
    return study.explore(
        platforms,
        _workload(workload),
        store=store,
        workers=1 if workers is None and executor is None else workers,
        executor=executor,
        progress=progress,
        memory=memory,
        budget=budget,
        search=search,
        seed=seed,
    )


def open_trace(file: str | Path) -> traces.Trace:
    """Look into the trace of a run.

    Raises:
        TraceError: the file is no trace, or cannot be read.
    """
    return traces.open_trace(Path(file))
