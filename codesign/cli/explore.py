"""``hwsw explore`` and ``hwsw report``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import command_line, memory_option, settings_of
from codesign.errors import EXIT_FAILED, EXIT_INFEASIBLE, printable

if TYPE_CHECKING:
    from codesign.exploration import Progress, Study

_FILE = click.Path(dir_okay=False, path_type=Path)


def _cores() -> int:
    """The cores of this machine; the help names them by this word, so that it is the same on every machine."""
    return os.cpu_count() or 1


@click.command(short_help="Evaluate every point of an exploration.")
@click.argument("platform")
@click.argument("workload")
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
    "--workers",
    type=click.IntRange(1, 256),
    default=_cores,
    show_default="the number of cores",
    help="The number of worker processes.",
)
@memory_option
@click.option("--csv", "csv_file", type=_FILE, help="Write every point as CSV.")
@click.option("--html", "page", type=_FILE, help="Write a self-contained HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print every point, feasible or not, as JSON.")
def explore(
    platform: str,
    workload: str,
    store: Path | None,
    settings: tuple[str, ...],
    workers: int,
    memory: int | None,
    csv_file: Path | None,
    page: Path | None,
    as_json: bool,
) -> None:
    """Evaluate every point of WORKLOAD's exploration on PLATFORM, and print the front.

    Finished points are kept in one file. The command continues from that file when it runs again.
    """
    import codesign
    from codesign import interrupts
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import Advance, progress_shown
    from codesign.inputs import pin

    values = settings_of(settings)
    platform_spec, workload_spec = codesign.load_platform(platform), codesign.load_workload(workload)
    if values:
        platform_spec, workload_spec = pin(platform_spec, workload_spec, values, "--set ")
    file = store or Path(f"{platform_spec.name}-{workload_spec.name}.sqlite")
    check_outputs(
        {"--csv": csv_file, "--html": page},
        (platform, workload, workload_spec.map_file),
        store=("--store", file),
    )
    interrupts.keep("finished points are kept")
    with progress_shown() as show:

        def progress(state: Progress) -> None:
            show(Advance(state.done, state.total, _words(state), state.left_s))

        study = codesign.explore(
            platform_spec, workload_spec, store=file, workers=workers, progress=progress, memory=memory
        )
    _deliver(study, csv_file, page, as_json)
    if not as_json:
        click.echo(f"points kept in {printable(str(file), None)}")
    if len(study.feasible) == len(study.unreached):
        # A design that fits and never reaches its goals is as useless as a design that does not fit.
        raise click.exceptions.Exit(EXIT_FAILED if study.broken else EXIT_INFEASIBLE)


@click.command(short_help="Write the tables and the page of a stored exploration.")
@click.argument("store", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="AXIS=VALUE",
    help="Show one condition by itself: by its value, or by its number in the list, from 0.",
)
@click.option("--csv", "csv_file", type=_FILE, help="Write every point as CSV.")
@click.option("--html", "page", type=_FILE, help="Write a self-contained HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print every point as JSON.")
def report(
    store: Path, conditions: tuple[str, ...], csv_file: Path | None, page: Path | None, as_json: bool
) -> None:
    """Write the tables, the CSV and the HTML page of the exploration in STORE. Nothing is simulated."""
    from codesign.cli.outputs import check_outputs
    from codesign.exploration import load_study

    check_outputs({"--csv": csv_file, "--html": page}, [store])
    chosen = settings_of(conditions, "--condition")
    _deliver(load_study(store).at(chosen), csv_file, page, as_json)


def _deliver(study: Study, csv_file: Path | None, page: Path | None, as_json: bool) -> None:
    from codesign.report import (
        best_table,
        front_table,
        nearest_table,
        reasons_table,
        render_text,
        spread_table,
        study_page,
        winners_table,
        write_study_csv,
    )

    if csv_file is not None:
        write_study_csv(study, csv_file)
    if page is not None:
        study_page(study, page, command=command_line())
    if as_json:
        click.echo(study.to_json())
        return
    click.echo(render_text(front_table(study) if study.feasible else nearest_table(study)))
    if study.feasible and study.conditions:
        click.echo(render_text(best_table(study)))
        if study.world.draws is not None:
            click.echo(render_text(spread_table(study)))
    winners = winners_table(study)
    if winners is not None:
        click.echo(render_text(winners))
    if study.reasons:
        click.echo(render_text(reasons_table(study)))
    for name, path in (("csv", csv_file), ("page", page)):
        if path is not None:
            click.echo(f"{name}: {printable(str(path), None)}")


def _words(progress: Progress) -> str:
    failed = f", {progress.failed} failed" if progress.failed else ""
    return f"points, {progress.feasible} feasible, {progress.cached} from the store{failed}"
