"""``hwsw reproduce``."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(short_help="Hold the model against the published tables.")
@click.argument("paper", type=click.Choice(["harmonic"]), default="harmonic")
@click.option("--quick", is_flag=True, help="Fewer and smaller maps for the figures that are simulated.")
@click.option(
    "--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page with plots."
)
@click.option(
    "--plots", type=click.Path(file_okay=False, path_type=Path), help="Write the plots into this folder."
)
@click.option("--json", "as_json", is_flag=True, help="Print rows and findings as JSON.")
def reproduce(paper: str, quick: bool, page: Path | None, plots: Path | None, as_json: bool) -> None:
    """Print published against modelled, row by row, with the error and the source of each figure."""
    from codesign import reproduce as papers
    from codesign.report import Picture, render_text, reproduction_page, reproduction_table

    reproduction = papers.PAPERS[paper](quick=quick, progress=lambda line: click.echo(line, err=True))
    written = papers.write_plots(reproduction, plots) if plots is not None else ()
    if page is not None:
        pictures = [
            Picture(
                plot.title,
                f"{plot.title}: {plot.published}",
                "svg",
                papers.plot_svg(plot).encode(),
                plot.published,
            )
            for plot in reproduction.figures
        ]
        reproduction_page(reproduction, page, pictures=pictures)
    if as_json:
        click.echo(reproduction.to_json())
        return
    click.echo(render_text(reproduction_table(reproduction)))
    click.echo("Findings")
    for finding in reproduction.findings:
        click.echo(f"- {finding}")
    for path in (*written, *([page] if page else [])):
        click.echo(f"written: {path}")
