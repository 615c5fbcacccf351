"""``hwsw reproduce``: the model against papers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import command_line, debug_step
from codesign.cli.outputs import check_folder, check_outputs
from codesign.cli.progress import compiling_shown, progress_shown
from codesign.cli.request import SENTENCE, TABLES
from codesign.cli.requests import Reproduce
from codesign.ground.errors import InputError, choose_hint, printable
from codesign.ground.progress import Advance
from codesign.hardware import reproduce as papers
from codesign.hardware.reproduce import plot_svg
from codesign.planners.reproduction import joined
from codesign.system import catalog, inspect
from codesign.views.report import (
    Picture,
    findings_table,
    render_text,
    reproduction_csv,
    reproduction_page,
    reproduction_sources_table,
    reproduction_table,
    write_csv,
)
from codesign.views.report.reproduction_page import settings_table

if TYPE_CHECKING:
    from codesign.planners.reproduction import Plot, Reproduction

_WHOLE_S = 120.0
"""The seconds that all papers take, measured on two cores; the time left is shown for all of them alone."""


def reproduce(asked: Reproduce) -> None:
    """Print published and modelled figures row by row, with the error and the source of each figure."""
    check_outputs({"--html": asked.page, "--csv": asked.csv})
    check_folder("--plots", asked.plots, {"--html": asked.page, "--csv": asked.csv})
    available = catalog.papers()
    for name in asked.names:
        if name not in available:
            raise InputError(f"no planner named {name!r} has a paper", "PLANNER", choose_hint(name, available))
    if asked.listed:
        click.echo(render_text(settings_table(inspect.paper_settings(asked.names or available))))
        return
    moved = inspect.settings_by_paper(tuple(asked.names or available), asked.settings)
    reproductions: list[Reproduction] = []
    begun, whole = time.monotonic(), not (asked.quick or asked.names or asked.settings)
    with progress_shown(quiet=asked.quiet) as show, compiling_shown(show):

        def progress(line: str) -> None:
            left = _WHOLE_S - (time.monotonic() - begun)
            show(Advance(0, None, line, left if whole and left > 0 else None))

        for name in asked.names or available:
            reproductions.append(available[name](asked.quick, progress, moved[name]))
            debug_step(f"{name} reproduced")
    written = [
        path for each in reproductions if asked.plots is not None for path in papers.write_plots(each, asked.plots)
    ]
    if asked.page is not None:
        _write_page(reproductions, asked.page)
    if asked.csv is not None:
        write_csv(reproduction_csv(reproductions), asked.csv)
    if asked.as_json:
        click.echo(joined(reproductions).to_json())
        return
    for each in reproductions:
        _print(each, asked.detail)
    for path in (*written, *(file for file in (asked.page, asked.csv) if file is not None)):
        click.echo(f"written: {printable(str(path), None)}")


def _write_page(reproductions: Sequence[Reproduction], page: Path) -> None:
    """The page of the papers, with their plots drawn again."""
    pictures = {each.paper: [_picture(plot) for plot in each.figures] for each in reproductions}
    reproduction_page(reproductions, page, pictures=pictures, command=command_line())


def _picture(plot: Plot) -> Picture:
    title, svg = f"{plot.title}: {plot.published}", plot_svg(plot).encode()
    return Picture(plot.title, title, "svg", svg, plot.published)


def _print(reproduction: Reproduction, detail: str) -> None:
    """The rows and findings of a paper; with ``TABLES`` the sources, with ``SENTENCE`` the findings alone."""
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
