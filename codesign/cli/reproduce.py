"""``hwsw reproduce``."""

from __future__ import annotations

from pathlib import Path

import click

from codesign.errors import InputError, choose_hint, printable


@click.command(short_help="Hold the model against the published tables.")
@click.argument("names", nargs=-1, metavar="[PLANNER]...")
@click.option("--quick", is_flag=True, help="Fewer and smaller maps for the figures that are simulated.")
@click.option(
    "--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page with plots."
)
@click.option(
    "--plots", type=click.Path(file_okay=False, path_type=Path), help="Write the plots into this folder."
)
@click.option("--json", "as_json", is_flag=True, help="Print rows and findings as JSON.")
def reproduce(
    names: tuple[str, ...], quick: bool, page: Path | None, plots: Path | None, as_json: bool
) -> None:
    """Print published against modelled, row by row, with the error and the source of each figure.

    Each name stands for the paper of that planner; without a name, all of them.
    """
    from codesign import reproduce as papers
    from codesign.cli.again import command_line
    from codesign.cli.outputs import check_folder, check_outputs
    from codesign.report import Picture, findings_table, render_text, reproduction_page, reproduction_table
    from codesign.system import catalog

    check_outputs({"--html": page})
    check_folder("--plots", plots, {"--html": page})
    at_hand = catalog.papers()
    for name in names:
        if name not in at_hand:
            raise InputError(f"no planner named {name!r} has a paper", "PLANNER", choose_hint(name, at_hand))
    found = [
        at_hand[name](quick=quick, progress=lambda line: click.echo(line, err=True))
        for name in names or at_hand
    ]
    written = [path for each in found if plots is not None for path in papers.write_plots(each, plots)]
    if page is not None:
        pictures = [
            Picture(
                plot.title,
                f"{plot.title}: {plot.published}",
                "svg",
                papers.plot_svg(plot).encode(),
                plot.published,
            )
            for each in found
            for plot in each.figures
        ]
        reproduction_page(papers.joined(found), page, pictures=pictures, command=command_line())
    if as_json:
        click.echo(papers.joined(found).to_json())
        return
    for each in found:
        click.echo(each.paper)
        click.echo(render_text(reproduction_table(each)))
        if each.note:
            click.echo(each.note)
        click.echo(render_text(findings_table(each)))
    for path in (*written, *([page] if page else [])):
        click.echo(f"written: {printable(str(path), None)}")
