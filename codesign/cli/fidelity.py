"""``hwsw fidelity``: laws against circuits and papers."""

from __future__ import annotations

import json
import os
import shlex
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli import requests
from codesign.cli.options import debug_step
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import compiling_shown, progress_shown
from codesign.ground.errors import printable
from codesign.ground.files import write_atomically
from codesign.ground.progress import Advance, Pace
from codesign.hardware.fidelity import QUICK_SAMPLES, SAMPLES, measure
from codesign.hardware.fidelity import asked as points_of
from codesign.views.report import render_text
from codesign.views.report.fidelity_page import fidelity_page, fidelity_picture, fidelity_tables

if TYPE_CHECKING:
    from codesign.hardware.fidelity import Fidelity
    from codesign.hardware.rtl.verify import Checked


def fidelity(asked: requests.Fidelity) -> None:
    """Compare what the laws predict with circuits that were simulated, synthesised and placed, and with papers."""
    check_outputs({"-o": asked.page, "--picture": asked.picture})
    seeds = range(QUICK_SAMPLES if asked.quick else SAMPLES)
    done, total = 0, len(points_of(seeds))
    pace = Pace(total)
    with progress_shown(quiet=asked.as_json) as show, compiling_shown(show):

        def progress(checked: Checked) -> None:
            nonlocal done
            done += 1
            words = f"points verified, {checked.planner} {checked.style}"
            show(Advance(done, total, words, pace.left_s(done)))

        result = measure(seeds, asked.backend, asked.jobs, progress)
    debug_step("compared")
    if asked.page is not None:
        shown = None if asked.picture is None else os.path.relpath(asked.picture, asked.page.parent)
        write_atomically(
            asked.page, fidelity_page(result, seeds, _command(asked.page, asked.picture, asked.quick), shown).encode()
        )
    if asked.picture is not None:
        write_atomically(asked.picture, fidelity_picture(result))
    if asked.as_json:
        click.echo(json.dumps(_document(result), indent=2))
        return
    if asked.page is None:
        for table in fidelity_tables(result):
            click.echo(render_text(table))
    for file in (asked.page, asked.picture):
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
