"""``hwsw reproduce``: the model against papers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import (
    SENTENCE,
    TABLES,
    command_line,
    debug_step,
    force_option,
    output_options,
    settings_of,
)
from codesign.errors import InputError, choose_hint, printable

if TYPE_CHECKING:
    from codesign.planners.reproduction import Plot, Reproduction
    from codesign.report import Picture

_WHOLE_S = 120.0
"""What all papers take, measured on two cores; the time left is shown for all of them alone."""


@click.command(short_help="Compare the model with the published tables.")
@click.argument("names", nargs=-1, metavar="[PLANNER]...")
@click.option("--quick", is_flag=True, help="Simulate fewer and smaller maps.")
@click.option(
    "--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page with plots."
)
@click.option(
    "--plots", type=click.Path(file_okay=False, path_type=Path), help="Write the plots into this folder."
)
@click.option(
    "--csv", "csv_file", type=click.Path(dir_okay=False, path_type=Path), help="Write the rows as CSV."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Move a setting of the papers' runs; see --settings.",
)
@click.option(
    "--settings", "listed", is_flag=True, help="List the settings that --set moves, and run nothing."
)
@output_options("Print the findings alone.", "Print the sources of the modelled figures too.")
@click.option("--json", "as_json", is_flag=True, help="Print rows and findings as JSON.")
@force_option
def reproduce(
    names: tuple[str, ...],
    quick: bool,
    page: Path | None,
    plots: Path | None,
    csv_file: Path | None,
    settings: tuple[str, ...],
    listed: bool,
    detail: str,
    as_json: bool,
) -> None:
    """Print published and modelled figures row by row, with the error and the source of each figure.

    Each PLANNER selects the paper of that planner. Without one, all papers are reproduced.

    With --set, head and rows say which settings are not the published ones.
    """
    from codesign import reproduce as papers
    from codesign.cli.outputs import check_folder, check_outputs
    from codesign.cli.progress import compiling_shown, progress_shown
    from codesign.progress import Advance
    from codesign.report import render_text, reproduction_csv, write_csv
    from codesign.report.planner_tables import settings_table
    from codesign.system import catalog, inspect

    check_outputs({"--html": page, "--csv": csv_file})
    check_folder("--plots", plots, {"--html": page, "--csv": csv_file})
    available = catalog.papers()
    for name in names:
        if name not in available:
            raise InputError(
                f"no planner named {name!r} has a paper", "PLANNER", choose_hint(name, available)
            )
    if listed:
        click.echo(render_text(settings_table(inspect.paper_settings(names or available))))
        return
    moved = inspect.settings_by_paper(tuple(names or available), settings_of(settings))
    reproductions: list[Reproduction] = []
    begun, whole = time.monotonic(), not (quick or names or settings)
    with progress_shown(quiet=as_json or detail == SENTENCE) as show, compiling_shown(show):

        def progress(line: str) -> None:
            left = _WHOLE_S - (time.monotonic() - begun)
            show(Advance(0, None, line, left if whole and left > 0 else None))

        for name in names or available:
            reproductions.append(available[name](quick, progress, moved[name]))
            debug_step(f"{name} reproduced")
    written = [
        path for each in reproductions if plots is not None for path in papers.write_plots(each, plots)
    ]
    if page is not None:
        _write_page(reproductions, page)
    if csv_file is not None:
        write_csv(reproduction_csv(reproductions), csv_file)
    if as_json:
        click.echo(papers.joined(reproductions).to_json())
        return
    for each in reproductions:
        _print(each, detail)
    for path in (*written, *(file for file in (page, csv_file) if file is not None)):
        click.echo(f"written: {printable(str(path), None)}")


def _write_page(reproductions: Sequence[Reproduction], page: Path) -> None:
    """The page of the papers, with their plots drawn again."""
    from codesign.report import reproduction_page

    pictures = {each.paper: [_picture(plot) for plot in each.figures] for each in reproductions}
    reproduction_page(reproductions, page, pictures=pictures, command=command_line())


def _picture(plot: Plot) -> Picture:
    from codesign.report import Picture
    from codesign.reproduce import plot_svg

    title, svg = f"{plot.title}: {plot.published}", plot_svg(plot).encode()
    return Picture(plot.title, title, "svg", svg, plot.published)


def _print(reproduction: Reproduction, detail: str) -> None:
    """The rows and findings of a paper; with ``TABLES`` the sources, with ``SENTENCE`` the findings alone."""
    from codesign.report import findings_table, render_text, reproduction_sources_table, reproduction_table

    click.echo(reproduction.paper)
    if reproduction.settings:
        click.echo(f"not as published: {reproduction.settings}")
    if detail != SENTENCE:
        click.echo(render_text(reproduction_table(reproduction)))
        if reproduction.note:
            click.echo(reproduction.note)
    click.echo(render_text(findings_table(reproduction)))
    if detail == TABLES:
        click.echo(render_text(reproduction_sources_table(reproduction)))
