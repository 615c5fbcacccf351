"""``hwsw explore`` and ``hwsw report``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

import codesign
from codesign.cli.options import command_line, debug_step
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, compiling, compiling_shown, progress_shown
from codesign.cli.request import SENTENCE, TABLES
from codesign.cli.requests import Explore, Report, StudyOutputs
from codesign.ground import interrupts
from codesign.ground.errors import EXIT_FAILED, EXIT_NO, InputError, printable
from codesign.ground.kernel_cache import is_cold
from codesign.ground.late import load
from codesign.ground.progress import Advance, doing
from codesign.ground.units import counted
from codesign.inputs import held, load_platforms, pin
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.inputs.exploration import ALL, check_search
from codesign.inputs.exploring import exploring
from codesign.study import load_study
from codesign.study.budget import Budget
from codesign.study.check import check_points
from codesign.study.columns import libraries
from codesign.study.outcomes import State
from codesign.views.report import render_text, study_page, study_sentence, study_tables, write_study_csv

if TYPE_CHECKING:
    from codesign.ground.progress import Show
    from codesign.inputs import Platform, Workload
    from codesign.study import ClusterExecutor, Progress, Study


def explore(asked: Explore) -> None:
    """Evaluate every point of WORKLOAD's exploration on PLATFORM, and print the front, after one sentence."""
    debug_step("modules loaded")
    check_search(asked.search or ALL, asked.seed or 0)
    platform, workload_spec = _explored(asked)
    one = "" if platform is None or isinstance(platform, list) else f"{platform.name}-"
    file = asked.store or Path(f"{one}{workload_spec.name}.sqlite")
    _check_files(asked, (*asked.specs, workload_spec.map_file), ("--store", file))
    interrupts.keep("finished points are kept")
    debug_step("files read and checked")
    budget = Budget(asked.points, None if asked.time_ms is None else asked.time_ms / 1000)
    cold = is_cold() and asked.cluster is None
    with (
        _cluster_of(asked.cluster, quiet=asked.quiet) as executor,
        progress_shown(quiet=asked.quiet) as show,
        compiling_shown(show),
    ):
        if executor is not None:
            executor.compiling = lambda: show(compiling())
        study = codesign.explore(
            platform,
            workload_spec,
            store=file,
            workers=asked.workers if executor is None else None,
            executor=executor,
            progress=_progress(show, cold and asked.workers > 1),
            memory=asked.memory,
            budget=budget,
            search=asked.search,
            seed=asked.seed,
        )
    debug_step("explored")
    _deliver(study, asked)
    if not asked.quiet:
        click.echo(f"points kept in {printable(str(file), None)}{_how(study, budget)}")
    if asked.check is not None and not _checked(study, asked.check, quiet=asked.quiet):
        raise click.exceptions.Exit(EXIT_FAILED)
    _end(study)


@contextmanager
def _cluster_of(address: str | None, *, quiet: bool) -> Iterator[ClusterExecutor | None]:
    """The cluster at an address until the end of the block; None if the workers are processes of this machine.

    Raises:
        InputError: ``--workers`` is given too, the address is none, or dask is not installed.
        RunError: nothing answers.
    """
    if address is None:
        yield None
        return
    if click.get_current_context().get_parameter_source("workers") is ParameterSource.COMMANDLINE:
        hint = "keep one of the two: --workers are processes of this machine, and a cluster has its own"
        raise InputError("--workers is given too", "--cluster", hint)
    with load("codesign.study.cluster:ClusterExecutor")(address) as executor:
        if not quiet:
            click.echo(f"cluster {printable(address)}: {executor.words}", err=True)
        yield executor
        if executor.died and not quiet:
            died = counted(executor.died, "worker")
            click.echo(
                f"cluster {printable(address)}: {died} died, and what was under way was computed again", err=True
            )


def _end(study: Study) -> None:
    """Leave with the exit code of a study: whether there is a design of use."""
    if len(study.feasible) == len(study.unreached):
        # A design that fits and never reaches its goals is as useless as a design that does not fit.
        raise click.exceptions.Exit(EXIT_FAILED if study.broken else EXIT_NO)


def _how(study: Study, budget: Budget) -> str:
    """The number of simulations that the points took, and why they are not all."""
    count = study.simulations
    points = counted(int((study.outcomes.state != State.MISSING).sum()), "point")
    took = "" if count is None else f" ({points}, {counted(count, 'simulation')})"
    hint = f"; {budget.ended}: the same command goes on from there" if budget.ended else ""
    return f"{took}{hint}"


def _checked(study: Study, count: int, *, quiet: bool) -> bool:
    """True if random points that are run alone have the figures of the study; says so on standard error."""
    with progress_shown(after_s=LATER_S, quiet=quiet) as show, compiling_shown(show):
        check = check_points(study, count, show=show)
    for line in (check.sentence, *check.differences):
        click.echo(printable(line), err=True)
    return not check.differences


def _explored(asked: Explore) -> tuple[Platform | list[Platform] | None, Workload]:
    """The platform, or the platforms of an axis, or None where the workload has them; and the workload."""
    specs, settings, axes = asked.specs, dict(asked.settings), asked.axes
    if len(specs) > 2:
        raise InputError(f"{counted(len(specs), 'argument')}", "explore", "name one platform and one workload")
    for axis in settings:
        if axis in axes or axis in asked.conditions:
            other = "--axis" if axis in axes else "--condition"
            raise InputError(f"{axis} is set by --set and by {other}", other, "keep one of the two")
    if PLATFORM_AXIS in axes and len(specs) == 2:
        raise InputError("PLATFORM is named too", f"--axis {PLATFORM_AXIS}", "keep one of the two")
    chosen = settings.pop(PLATFORM_AXIS, None)
    names = chosen if isinstance(chosen, list) else [chosen] if chosen is not None else list(specs[:-1])
    if chosen is not None and len(specs) == 2:
        raise InputError("PLATFORM is named too", f"--set {PLATFORM_AXIS}", "keep one of the two")
    workload = exploring(codesign.load_workload(specs[-1]), axes, asked.conditions, asked.needs)
    try:
        platforms = load_platforms(names)
    except InputError as wrong:
        if chosen is None or wrong.where:
            raise
        raise InputError(wrong.what, f"--set {PLATFORM_AXIS}", wrong.hint) from wrong
    if len(platforms) == 1:
        return pin(platforms[0], workload, settings, "--set ") if settings else (platforms[0], workload)
    return platforms or None, held(workload, settings, "--set ")


def report(asked: Report) -> None:
    """Write the tables, the CSV and the HTML page of the exploration in STORE. Nothing is simulated."""
    _check_files(asked, [asked.store])
    with progress_shown(after_s=LATER_S, quiet=asked.quiet) as show:
        study = load_study(asked.store, show).needing(asked.needs).at(asked.conditions)
    _deliver(study, asked)
    _end(study)


def _deliver(study: Study, asked: StudyOutputs) -> None:
    with progress_shown(after_s=LATER_S, quiet=asked.quiet) as show:
        _write_files(study, asked, show)
        texts = [study.to_json()] if asked.as_json else _texts(study, asked.detail, show)
    for text in texts:
        click.echo(text)
    if not asked.quiet:
        written = {"csv": asked.csv, "parquet": asked.parquet, "page": asked.page, "certificate": asked.certificate}
        for name, path in written.items():
            if path is not None:
                click.echo(f"{name}: {printable(str(path), None)}")


def _check_files(
    asked: StudyOutputs, inputs: Iterable[str | Path | None], store: tuple[str, Path] | None = None
) -> None:
    """Check, before any work, that all files of the study can be written; see ``check_outputs``."""
    files = {"--csv": asked.csv, "--parquet": asked.parquet, "--html": asked.page, "--certify": asked.certificate}
    check_outputs(files, inputs, store=store)
    if asked.parquet is not None:
        libraries()


def _write_files(study: Study, asked: StudyOutputs, show: Show) -> None:
    """Write the files of the study that were asked for."""
    if asked.csv is not None:
        write_study_csv(study, asked.csv, show)
    if asked.parquet is not None:
        study.to_parquet(asked.parquet, show)
    if asked.page is not None:
        study_page(study, asked.page, command=command_line(), show=show)
    if asked.certificate is not None:
        doing(show, "writing the certificate")
        study.certify(asked.certificate)


def _texts(study: Study, detail: str, show: Show) -> list[str]:
    """The sentence, and the tables unless it is asked for alone."""
    doing(show, "comparing designs")
    sentence = study_sentence(study)
    if detail == SENTENCE:
        return [sentence]
    tables = study_tables(study, everything=detail == TABLES, show=show)
    return [sentence, "", *(render_text(table, show=show) for table in tables)]


def _progress(show: Show, cold: bool) -> Callable[[Progress], None]:
    """Shows how far an exploration is. ``cold``: a worker compiles kernels first, which this process does not see."""
    announced = not cold

    def progress(state: Progress) -> None:
        nonlocal announced
        if state.doing:
            show(Advance(state.done, state.total, state.doing))
            return
        show(Advance(state.done, state.total, _words(state), state.left_s))
        if not announced and state.done < state.total:
            show(compiling())
        announced = True

    return progress


def _words(progress: Progress) -> str:
    failed = f", {progress.failed} failed" if progress.failed else ""
    return f"points, {progress.feasible} feasible, {progress.cached} from the store{failed}"
