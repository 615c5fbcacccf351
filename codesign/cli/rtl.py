"""``hwsw rtl``, ``verify`` and ``synth``: circuits as Verilog, against the model, and synthesised by open tools."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import debug_step
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.requests import Rtl, Synth, Verify
from codesign.cli.specs import specs_of
from codesign.ground.errors import EXIT_FAILED, EXIT_NO, InputError, choose_hint, printable, printable_lines
from codesign.ground.files import write_folder
from codesign.ground.progress import Advance, Pace
from codesign.ground.units import counted
from codesign.hardware.rtl.export import MANIFEST, Origin, export_files
from codesign.hardware.rtl.place import compared
from codesign.hardware.rtl.placed import placed, refuse_what_does_not_fit
from codesign.hardware.rtl.verify import Asked, samples, verify_all
from codesign.system import catalog, point_of
from codesign.views.report import render_text
from codesign.views.report.hardware_tables import difference_text, synthesis_tables, verification_table

if TYPE_CHECKING:
    from codesign.hardware.rtl.place import Compared
    from codesign.hardware.rtl.verify import Checked, StyleChecked


def verify(asked: Verify) -> None:
    """Simulate the circuit of WORKLOAD on PLATFORM, and compare all that it reports with the model."""
    check_outputs({"--waves": asked.waves}, asked.specs, plain=["--waves"])
    if asked.cycles is not None and (asked.waves is None or asked.cycles[1] < asked.cycles[0]):
        raise InputError("names cycles of no waveform", "--cycles", "give --waves FILE --cycles FIRST LAST")
    if not asked.every:
        _refuse_options({"--planner": asked.planners or None, "--points": asked.points, "--seed": asked.seed})
    with progress_shown(quiet=asked.as_json) as show, compiling_shown(show):
        points = _samples(asked) if asked.every else [_design_point(asked)]
        debug_step("files read and checked")
        done, pace = 0, Pace(len(points))

        def progress(checked: Checked) -> None:
            nonlocal done
            done += 1
            words = f"points verified, {checked.planner} {checked.style}"
            show(Advance(done, len(points), words, pace.left_s(done)))

        def within(words: str, cycles: int, expected: int) -> None:
            nonlocal pace
            if not cycles:
                pace = Pace(expected)
            pace.total = expected
            show(Advance(cycles, expected or None, words, pace.left_s(cycles)))

        styles = verify_all(
            points, asked.backend, asked.jobs, progress if asked.every else None, asked.waves, within, asked.cycles
        )
    debug_step("verified")
    _print(styles, asked.waves, asked.cycles is not None, asked.as_json)
    if any(point.verified is None for each in styles for point in each.points):
        raise click.exceptions.Exit(EXIT_FAILED)
    if not all(each.equal for each in styles):
        raise click.exceptions.Exit(EXIT_NO)


def _samples(asked: Verify) -> list[Asked]:
    """Random points of all circuits, or of the circuits of some planners."""
    if asked.specs or asked.settings or asked.point is not None:
        hint = "leave PLATFORM, WORKLOAD, --set and --point out, or leave --all out"
        raise InputError("--all draws its design points itself", "verify --all", hint)
    circuits = catalog.circuits()
    for name in asked.planners:
        if name not in {owner for owner, *_ in circuits}:
            hint = choose_hint(name, {owner for owner, *_ in circuits})
            raise InputError(f"no planner named {name!r} has circuits", "--planner", hint)
    styles = [style for (owner, *_), style in circuits.items() if not asked.planners or owner in asked.planners]
    if not styles:
        raise InputError("no planner has circuits", "verify --all", "install a planner with circuits")
    first = asked.seed or 0
    return samples(styles, range(first, first + (asked.points or 3)))


def _refuse_options(given: dict[str, object]) -> None:
    for option, value in given.items():
        if value is not None:
            raise InputError("is for --all only", option, "add --all, or leave it out")


def _design_point(asked: Verify) -> Asked:
    """The design point of platform and workload, or of a study."""
    platform, workload, _ = specs_of(asked.specs, asked.point)
    design = placed(*point_of(platform, workload, asked.settings))
    return Asked(design.style, f"{platform.name} {workload.name}", lambda: design.job)


def _print(styles: Sequence[StyleChecked], waves: Path | None, drawn: bool, as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps([asdict(each) | {"equal": each.equal} for each in styles], indent=2))
        return
    click.echo(render_text(verification_table(styles)))
    wrong = [point for each in styles for point in each.points if not point.equal]
    for point in wrong:
        click.echo(printable_lines(difference_text(point)))
    for each in styles:
        if not each.equal and all(point.equal for point in each.points):
            click.echo(f"{each.planner} {each.style}: the cycles deviate by more than contention excuses")
    if waves is not None:
        seen = waves.exists() and (drawn or any(point.verified is not None for point in wrong))
        click.echo(f"waveform: {printable(str(waves), None)}" if seen else "no difference: no waveform is written")
    count = sum(len(each.points) for each in styles)
    if not wrong:
        click.echo(f"{counted(count, 'design point')}: every event equals the model in kind, value and cycle")


def rtl(asked: Rtl) -> None:
    """Write the circuit of WORKLOAD on PLATFORM into the folder DIR, as Verilog that any tool takes."""
    stale = _stale(asked.folder, asked.force, MANIFEST)
    platform, workload, _ = specs_of(asked.specs, asked.point)
    if asked.point is None:
        origin = Origin(asked.specs[0], asked.specs[1], asked.settings)
    else:
        origin = Origin(platform.name, workload.name, asked.settings, asked.specs[0], asked.point)
    with progress_shown(after_s=LATER_S) as show, compiling_shown(show):
        design = placed(*point_of(platform, workload, asked.settings))
        refuse_what_does_not_fit(design)
        debug_step("files read and checked")
        files = export_files(design, origin)
    debug_step("circuit and expected events made")
    write_folder(asked.folder, {name: text.encode() for name, text in files.items()}, stale)
    top = json.loads(files[MANIFEST])["top"]
    click.echo(f"written: {printable(str(asked.folder), None)} ({counted(len(files), 'file')}, top module {top})")
    click.echo("next: README.md there says how to simulate and to build it")


def _stale(folder: Path, force: bool, manifest: str) -> list[str]:
    """The files that an earlier run wrote into the folder.

    Raises:
        InputError: it is no folder, or not empty without ``force``.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is no folder", "-o", "name a folder")
    if not folder.is_dir() or not any(folder.iterdir()):
        return []
    if not force:
        raise InputError(f"{folder} is not empty", "-o", "name another folder, or add --force")
    try:
        names = json.loads((folder / manifest).read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [str(name) for name in names] if isinstance(names, dict) else []


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
