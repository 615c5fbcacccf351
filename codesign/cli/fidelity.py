"""``hwsw fidelity``: laws against circuits and papers."""

from __future__ import annotations

import json
import os
import shlex
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import backend_option, debug_option, debug_step, force_option
from codesign.errors import printable

if TYPE_CHECKING:
    from codesign.fidelity import Fidelity
    from codesign.rtl.campaign import Checked


@click.command(short_help="Hold all laws against simulated, synthesised and placed circuits.")
@click.option(
    "-o",
    "--output",
    "page",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the page, in Markdown.",
)
@click.option(
    "--picture",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the picture of law over measured, as SVG.",
)
@click.option("--quick", is_flag=True, help="Simulate fewer design points of each circuit.")
@click.option(
    "--jobs", type=click.IntRange(1, 64), default=1, show_default=True, help="Simulations at a time."
)
@backend_option
@debug_option
@click.option("--json", "as_json", is_flag=True, help="Print everything that is compared as JSON.")
@force_option
def fidelity(
    page: Path | None, picture: Path | None, quick: bool, jobs: int, backend: str, as_json: bool
) -> None:
    """Compare what the laws predict with circuits that were simulated, synthesised and placed, and with papers.

    Circuits of random design points are simulated here. The rows of synthesis and placement are those that the package
    holds: hwsw synth makes such rows of one design point.

    What does not match is listed with its reason, and with the experiment that would settle it.
    """
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import compiling_shown, progress_shown
    from codesign.fidelity import QUICK_SAMPLES, SAMPLES, asked, measure
    from codesign.files import write_atomically
    from codesign.progress import Advance, Pace
    from codesign.report import render_text
    from codesign.report.fidelity_page import fidelity_page
    from codesign.report.fidelity_picture import fidelity_picture
    from codesign.report.fidelity_tables import fidelity_tables

    check_outputs({"-o": page, "--picture": picture})
    seeds = range(QUICK_SAMPLES if quick else SAMPLES)
    done, total = 0, len(asked(seeds))
    pace = Pace(total)
    with progress_shown(quiet=as_json) as show, compiling_shown(show):

        def progress(checked: Checked) -> None:
            nonlocal done
            done += 1
            words = f"points verified, {checked.planner} {checked.style}"
            show(Advance(done, total, words, pace.left_s(done)))

        result = measure(seeds, backend, jobs, progress)
    debug_step("compared")
    if page is not None:
        shown = None if picture is None else os.path.relpath(picture, page.parent)
        write_atomically(page, fidelity_page(result, seeds, _command(page, picture, quick), shown).encode())
    if picture is not None:
        write_atomically(picture, fidelity_picture(result))
    if as_json:
        click.echo(json.dumps(_document(result), indent=2))
        return
    if page is None:
        for table in fidelity_tables(result):
            click.echo(render_text(table))
    for file in (page, picture):
        if file is not None:
            click.echo(f"written: {printable(str(file), None)}")


def _command(page: Path, picture: Path | None, quick: bool) -> str:
    """The command that writes such a page; the simulator and the simulations at a time do not change it."""
    drawn = [] if picture is None else ["--picture", str(picture)]
    return shlex.join(["hwsw", "fidelity", "-o", str(page), *drawn, *(["--quick"] if quick else [])])


def _document(result: Fidelity) -> dict[str, Any]:
    return {
        "cycles": [asdict(each) | {"equal": each.equal} for each in result.cycles],
        "rows": [asdict(point) | {"error": point.error} for point in result.points],
        "papers": [asdict(claim) | {"error": claim.error} for claim in result.claims],
        "mismatches": [asdict(mismatch) for mismatch in result.mismatches],
    }
