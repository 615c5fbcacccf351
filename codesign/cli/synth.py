"""``hwsw synth``: circuits synthesised, placed and routed by open tools."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import debug_step
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.requests import Synth
from codesign.cli.specs import specs_of
from codesign.ground.errors import InputError
from codesign.ground.progress import Advance, Pace
from codesign.hardware.rtl.compared import compared
from codesign.hardware.rtl.placed import placed
from codesign.system import point_of
from codesign.views.report import render_text
from codesign.views.report.synthesis_tables import synthesis_tables

if TYPE_CHECKING:
    from codesign.hardware.rtl.compared import Compared


def synth(asked: Synth) -> None:
    """Synthesise the circuit of WORKLOAD on PLATFORM by Yosys, and hold the laws against what it takes."""
    if asked.seeds is not None and not asked.placing:
        raise InputError("is for placements only", "--seeds", "add --place, or leave it out")
    platform, workload, _ = specs_of(asked.specs, asked.point)
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as show, compiling_shown(show):
        design = placed(*point_of(platform, workload, asked.settings))
        debug_step("files read and checked")
        paces: list[Pace] = []

        def progress(done: int, total: int, what: str) -> None:
            # A placement takes longer than the synthesis before it: the time of placements counts.
            if done and not paces:
                paces.append(Pace(total - 1))
            show(Advance(done, total, what, paces[0].left_s(done - 1) if paces else None))

        result = compared(design, asked.family, range(1, (asked.seeds or 1) + 1) if asked.placing else (), progress)
    debug_step("synthesised")
    if asked.as_json:
        click.echo(json.dumps(_document(result), indent=2))
        return
    for table in synthesis_tables(result):
        click.echo(render_text(table))


def _document(result: Compared) -> dict[str, Any]:
    synthesis = result.synthesis
    low, high = result.law.interval
    return {
        "part": result.part,
        "family": synthesis.family,
        "top": synthesis.top,
        "total": synthesis.total.by_resource(),
        "lines": [asdict(line) for line in result.lines],
        "modules": [
            {"module": each.module, "instances": each.instances, **each.counts.by_resource()}
            for each in synthesis.modules
        ],
        "law_hz": {"value": result.law.value, "low": low, "high": high, "source": result.law.source},
        "clock_hz": result.clock,
        "placements": [
            {"seed": each.seed, "clock_hz": each.clock, "path": each.path.words, "used": dict(each.used)}
            for each in result.placements
        ],
        "notes": list(result.notes),
    }
