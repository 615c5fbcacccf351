"""``hwsw explore`` and ``hwsw report``."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.cluster import cluster_of, cluster_option
from codesign.cli.options import (
    SENTENCE,
    TABLES,
    axes_of,
    budget_options,
    debug_step,
    memory_option,
    need_option,
    output_options,
    settings_of,
)
from codesign.cli.search import check_search_options, search_options
from codesign.cli.study_files import StudyFiles, study_file_options
from codesign.errors import EXIT_FAILED, EXIT_NO, InputError, printable
from codesign.units import counted

if TYPE_CHECKING:
    from codesign.exploration import Progress, Study
    from codesign.exploration.budget import Budget
    from codesign.inputs import Platform, Workload
    from codesign.progress import Show

_FILE = click.Path(dir_okay=False, path_type=Path)


def _cores() -> int:
    """The cores of this machine; the help names them by this word, so that it is the same on every machine."""
    return os.cpu_count() or 1


@click.command(short_help="Evaluate every point of an exploration.")
@click.argument("specs", nargs=-1, required=True, metavar="[PLATFORM] WORKLOAD")
@click.option(
    "--store", type=_FILE, help="The SQLite file of finished points.  [default: PLATFORM-WORKLOAD.sqlite]"
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="AXIS=VALUE",
    help="Set an axis for all points.",
)
@click.option(
    "--axis",
    "axes",
    multiple=True,
    metavar="AXIS=VALUES",
    help="Explore these values: a,b,c, or a range 1..8, 10MHz..100MHz:10MHz (step), 1..1024*2 (factor) or"
    " '10MHz..1GHz in 12 log' (count); 'a,b when OTHER=VALUE': where another axis has this value alone.",
)
@click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="AXIS=VALUES",
    help="Run every design in these conditions; written as --axis.",
)
@need_option
@click.option(
    "--workers",
    type=click.IntRange(1, 256),
    default=_cores,
    show_default="the number of cores",
    help="The number of worker processes.",
)
@cluster_option
@memory_option
@budget_options
@search_options
@click.option(
    "--check",
    type=click.IntRange(min=1),
    metavar="N",
    help="Run N random points alone too, and compare every figure with the study, to the last bit.",
)
@study_file_options
@output_options(
    "Print the sentence alone.", "Print the best points, every point and the sources of the figures too."
)
@click.option("--json", "as_json", is_flag=True, help="Print every point, feasible or not, as JSON.")
def explore(
    specs: tuple[str, ...],
    store: Path | None,
    settings: tuple[str, ...],
    axes: tuple[str, ...],
    conditions: tuple[str, ...],
    needs: tuple[str, ...],
    workers: int,
    cluster: str | None,
    memory: int | None,
    points: int | None,
    time_ms: int | None,
    search: str | None,
    seed: int | None,
    check: int | None,
    files: StudyFiles,
    detail: str,
    as_json: bool,
) -> None:
    """Evaluate every point of WORKLOAD's exploration on PLATFORM, and print the front, after one sentence.

    Finished points are kept in one file. The command continues from that file when it runs again.

    Leave PLATFORM out where the workload has an axis platform, or with --axis platform=NAME,FILE.yaml.

    --axis and --condition replace the axis of that name in the file, or add one. --need adds a constraint.

    The exit code is 3 where no design is feasible.
    """
    import codesign
    from codesign import interrupts
    from codesign.cli.progress import compiling, compiling_shown, progress_shown
    from codesign.exploration.budget import Budget
    from codesign.kernel_cache import is_cold

    debug_step("modules loaded")
    check_search_options(search, seed)
    changed = axes_of(axes, "--axis"), axes_of(conditions, "--condition"), needs
    platform, workload_spec = _explored(specs, settings_of(settings), *changed)
    one = "" if platform is None or isinstance(platform, list) else f"{platform.name}-"
    file = store or Path(f"{one}{workload_spec.name}.sqlite")
    files.check((*specs, workload_spec.map_file), ("--store", file))
    interrupts.keep("finished points are kept")
    debug_step("files read and checked")
    budget = Budget(points, None if time_ms is None else time_ms / 1000)
    cold = is_cold() and cluster is None
    with (
        cluster_of(cluster, quiet=as_json or detail == SENTENCE) as executor,
        progress_shown(quiet=as_json or detail == SENTENCE) as show,
        compiling_shown(show),
    ):
        if executor is not None:
            executor.compiling = lambda: show(compiling())
        study = codesign.explore(
            platform,
            workload_spec,
            store=file,
            workers=workers if executor is None else None,
            executor=executor,
            progress=_progress(show, cold and workers > 1),
            memory=memory,
            budget=budget,
            search=search,
            seed=seed,
        )
    debug_step("explored")
    _deliver(study, files, detail, as_json)
    if not as_json and detail != SENTENCE:
        click.echo(f"points kept in {printable(str(file), None)}{_how(study, budget)}")
    if check is not None and not _checked(study, check, quiet=as_json or detail == SENTENCE):
        raise click.exceptions.Exit(EXIT_FAILED)
    _end(study)


def _end(study: Study) -> None:
    """Leave with the exit code of a study: whether there is a design of use."""
    if len(study.feasible) == len(study.unreached):
        # A design that fits and never reaches its goals is as useless as a design that does not fit.
        raise click.exceptions.Exit(EXIT_FAILED if study.broken else EXIT_NO)


def _how(study: Study, budget: Budget) -> str:
    """How many simulations the points took, and why they are not all."""
    from codesign.exploration.outcomes import State

    count = study.simulations
    points = counted(int((study.outcomes.state != State.MISSING).sum()), "point")
    took = "" if count is None else f" ({points}, {counted(count, 'simulation')})"
    hint = f"; {budget.ended}: the same command goes on from there" if budget.ended else ""
    return f"{took}{hint}"


def _checked(study: Study, count: int, *, quiet: bool) -> bool:
    """Whether random points that are run alone have the figures of the study; says so on standard error."""
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
    from codesign.exploration.check import check_points

    with progress_shown(after_s=LATER_S, quiet=quiet) as show, compiling_shown(show):
        check = check_points(study, count, show=show)
    for line in (check.sentence, *check.differences):
        click.echo(printable(line), err=True)
    return not check.differences


def _explored(
    specs: Sequence[str],
    settings: dict[str, Any],
    axes: dict[str, dict[str, Any]],
    conditions: dict[str, dict[str, Any]],
    needs: Sequence[str],
) -> tuple[Platform | list[Platform] | None, Workload]:
    """The platform, or the platforms of an axis, or None where the workload has them; and the workload."""
    import codesign
    from codesign.inputs import held, load_platforms, pin
    from codesign.inputs.edit import PLATFORM_AXIS
    from codesign.inputs.exploring import exploring

    if len(specs) > 2:
        raise InputError(
            f"{counted(len(specs), 'argument')}", "explore", "name one platform and one workload"
        )
    for axis in settings:
        if axis in axes or axis in conditions:
            other = "--axis" if axis in axes else "--condition"
            raise InputError(f"{axis} is set by --set and by {other}", other, "keep one of the two")
    if PLATFORM_AXIS in axes and len(specs) == 2:
        raise InputError("PLATFORM is named too", f"--axis {PLATFORM_AXIS}", "keep one of the two")
    chosen = settings.pop(PLATFORM_AXIS, None)
    names = chosen if isinstance(chosen, list) else [chosen] if chosen is not None else list(specs[:-1])
    if chosen is not None and len(specs) == 2:
        raise InputError("PLATFORM is named too", f"--set {PLATFORM_AXIS}", "keep one of the two")
    if not all(isinstance(name, str) for name in names):
        raise InputError(
            "names no platform", f"--set {PLATFORM_AXIS}", "write the name of one, or [NAME, ...]"
        )
    workload = exploring(codesign.load_workload(specs[-1]), axes, conditions, needs)
    platforms = load_platforms(names)
    if len(platforms) == 1:
        return pin(platforms[0], workload, settings, "--set ") if settings else (platforms[0], workload)
    return platforms or None, held(workload, settings, "--set ")


@click.command(short_help="Write the tables and the page of a stored exploration.")
@click.argument("store", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="AXIS=VALUE",
    help="Show one condition by itself: by its value, or by its number in the list, from 0.",
)
@need_option
@study_file_options
@output_options(
    "Print the sentence alone.", "Print the best points, every point and the sources of the figures too."
)
@click.option("--json", "as_json", is_flag=True, help="Print every point as JSON.")
def report(
    store: Path,
    conditions: tuple[str, ...],
    needs: tuple[str, ...],
    files: StudyFiles,
    detail: str,
    as_json: bool,
) -> None:
    """Write the tables, the CSV and the HTML page of the exploration in STORE. Nothing is simulated.

    --need judges the designs anew, with a further constraint. The exit code is 3 where none is feasible.
    """
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.exploration import load_study

    files.check([store])
    chosen = settings_of(conditions, "--condition")
    with progress_shown(after_s=LATER_S, quiet=as_json or detail == SENTENCE) as show:
        study = load_study(store, show).needing(needs).at(chosen)
    _deliver(study, files, detail, as_json)
    _end(study)


def _deliver(study: Study, files: StudyFiles, detail: str, as_json: bool) -> None:
    from codesign.cli.progress import LATER_S, progress_shown

    with progress_shown(after_s=LATER_S, quiet=as_json or detail == SENTENCE) as show:
        files.write(study, show)
        texts = [study.to_json()] if as_json else _texts(study, detail, show)
    for text in texts:
        click.echo(text)
    if not as_json and detail != SENTENCE:
        files.name()


def _texts(study: Study, detail: str, show: Show) -> list[str]:
    """The sentence, and the tables unless it is asked for alone."""
    from codesign.progress import doing
    from codesign.report import render_text, study_sentence, study_tables

    doing(show, "comparing designs")
    sentence = study_sentence(study)
    if detail == SENTENCE:
        return [sentence]
    tables = study_tables(study, everything=detail == TABLES, show=show)
    return [sentence, "", *(render_text(table, show=show) for table in tables)]


def _progress(show: Show, cold: bool) -> Callable[[Progress], None]:
    """Shows how far an exploration is. ``cold``: a worker compiles kernels first, which this process does not see."""
    from codesign.cli.progress import compiling
    from codesign.progress import Advance

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
