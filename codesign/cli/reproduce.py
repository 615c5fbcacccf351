"""``hwsw reproduce`` and ``hwsw calibrate``: the model against papers, and costs against this machine."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

from codesign.cli.options import command_line
from codesign.errors import InputError, choose_hint, printable


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
@click.option("--json", "as_json", is_flag=True, help="Print rows and findings as JSON.")
def reproduce(
    names: tuple[str, ...],
    quick: bool,
    page: Path | None,
    plots: Path | None,
    csv_file: Path | None,
    as_json: bool,
) -> None:
    """Print published and modelled figures row by row, with the error and the source of each figure.

    Each PLANNER selects the paper of that planner. Without one, all papers are reproduced.
    """
    from codesign import reproduce as papers
    from codesign.cli.outputs import check_folder, check_outputs
    from codesign.report import (
        Picture,
        findings_table,
        render_text,
        reproduction_csv,
        reproduction_page,
        reproduction_table,
        write_csv,
    )
    from codesign.system import catalog

    check_outputs({"--html": page, "--csv": csv_file})
    check_folder("--plots", plots, {"--html": page, "--csv": csv_file})
    available = catalog.papers()
    for name in names:
        if name not in available:
            raise InputError(
                f"no planner named {name!r} has a paper", "PLANNER", choose_hint(name, available)
            )
    reproductions = [
        available[name](quick=quick, progress=lambda line: click.echo(line, err=True))
        for name in names or available
    ]
    written = [
        path for each in reproductions if plots is not None for path in papers.write_plots(each, plots)
    ]
    if page is not None:
        pictures = [
            Picture(
                plot.title,
                f"{plot.title}: {plot.published}",
                "svg",
                papers.plot_svg(plot).encode(),
                plot.published,
            )
            for each in reproductions
            for plot in each.figures
        ]
        reproduction_page(papers.joined(reproductions), page, pictures=pictures, command=command_line())
    if csv_file is not None:
        write_csv(reproduction_csv(reproductions), csv_file)
    if as_json:
        click.echo(papers.joined(reproductions).to_json())
        return
    for each in reproductions:
        click.echo(each.paper)
        click.echo(render_text(reproduction_table(each)))
        if each.note:
            click.echo(each.note)
        click.echo(render_text(findings_table(each)))
    for path in (*written, *(file for file in (page, csv_file) if file is not None)):
        click.echo(f"written: {printable(str(path), None)}")


@click.group(short_help="Measure this machine.")
def calibrate() -> None:
    """Measure this machine, for platform files."""


@calibrate.command(short_help="Measure the cost of each kernel on this machine.")
@click.option(
    "--seconds", type=float, default=2.0, show_default=True, help="The approximate time to measure."
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def host(seconds: float, as_json: bool) -> None:
    """Time the planners' kernels on this machine, and print them as the key costs of a processor in a platform file."""
    from codesign.calibrate.host_costs import measure_host

    measured = measure_host(seconds)
    if as_json:
        click.echo(json.dumps({name: asdict(figure) for name, figure in measured.items()}, indent=2))
        return
    click.echo("costs:")
    for name, figure in measured.items():
        low, high = figure.interval
        value = {"value": f"{_ps(figure.value)} ps", "low": f"{_ps(low)} ps", "high": f"{_ps(high)} ps"}
        text = ", ".join(f"{key}: {quantity}" for key, quantity in value.items())
        click.echo(f"  {name}: {{{text}, status: measured, source: {json.dumps(figure.source)}}}")


def _ps(seconds: float) -> int:
    return max(1, round(seconds * 1e12))
