"""``hwsw verify`` and ``hwsw rtl``: circuits against the model, and their Verilog in a folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import (
    backend_option,
    debug_option,
    debug_step,
    force_option,
    set_option,
    settings_of,
)
from codesign.cli.specs import specs_of
from codesign.errors import EXIT_FAILED, EXIT_NO, InputError, choose_hint, printable, printable_lines
from codesign.units import counted

if TYPE_CHECKING:
    from codesign.rtl.campaign import Asked, Checked, StyleChecked


@click.command(short_help="Compare circuits in Verilog with the model, cycle for cycle.")
@click.argument("specs", nargs=-1, metavar="[PLATFORM WORKLOAD | STUDY]")
@click.option(
    "--point", type=int, metavar="INDEX", help="Verify this point of STUDY, a file of hwsw explore."
)
@set_option
@click.option(
    "--all", "every", is_flag=True, help="Verify random design points of every style that has a circuit."
)
@click.option("--planner", "planners", multiple=True, help="With --all: only the circuits of this planner.")
@click.option(
    "--points",
    type=click.IntRange(1, 10_000),
    metavar="N",
    help="With --all: points of each style.  [default: 3]",
)
@click.option("--seed", type=click.IntRange(0), metavar="S", help="With --all: the first seed.  [default: 0]")
@backend_option
@click.option(
    "--jobs", type=click.IntRange(1, 256), default=1, show_default=True, help="Points verified at a time."
)
@click.option(
    "--waves",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the waveform around the first difference (VCD, for GTKWave), circuit and model above each other.",
)
@click.option(
    "--cycles",
    type=click.IntRange(0),
    nargs=2,
    metavar="FIRST LAST",
    help="With --waves: write these cycles, whether or not they differ.",
)
@debug_option
@click.option("--json", "as_json", is_flag=True, help="Print every point as JSON.")
@force_option
def verify(
    specs: tuple[str, ...],
    point: int | None,
    settings: tuple[str, ...],
    every: bool,
    planners: tuple[str, ...],
    points: int | None,
    seed: int | None,
    backend: str,
    jobs: int,
    waves: Path | None,
    cycles: tuple[int, int] | None,
    as_json: bool,
) -> None:
    """Simulate the circuit of WORKLOAD on PLATFORM, and compare all that it reports with the model.

    Every event is compared in its kind, its value and its cycle, every phase in its cycles, and a display in every
    cycle. A difference is printed with its first cycle.

    With --all, random design points on random maps are verified. Sample S is the same for the same seed S.

    The exit code is 3 where a circuit differs from the model, and 1 where a run fails.
    """
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import compiling_shown, progress_shown
    from codesign.progress import Advance, Pace
    from codesign.rtl.campaign import verify_all

    check_outputs({"--waves": waves}, specs, plain=["--waves"])
    if cycles is not None and (waves is None or cycles[1] < cycles[0]):
        raise InputError("names cycles of no waveform", "--cycles", "give --waves FILE --cycles FIRST LAST")
    if not every:
        _refuse_options({"--planner": planners or None, "--points": points, "--seed": seed})
    with progress_shown(quiet=as_json) as show, compiling_shown(show):
        if every:
            asked = _samples(specs, point, settings, planners, points, seed)
        else:
            asked = [_design_point(specs, point, settings)]
        debug_step("files read and checked")
        done, pace = 0, Pace(len(asked))

        def progress(checked: Checked) -> None:
            nonlocal done
            done += 1
            words = f"points verified, {checked.planner} {checked.style}"
            show(Advance(done, len(asked), words, pace.left_s(done)))

        def within(words: str, cycles: int, expected: int) -> None:
            nonlocal pace
            if not cycles:
                pace = Pace(expected)
            pace.total = expected
            show(Advance(cycles, expected or None, words, pace.left_s(cycles)))

        styles = verify_all(asked, backend, jobs, progress if every else None, waves, within, cycles)
    debug_step("verified")
    _print(styles, waves, cycles is not None, as_json)
    if any(point.verified is None for each in styles for point in each.points):
        raise click.exceptions.Exit(EXIT_FAILED)
    if not all(each.equal for each in styles):
        raise click.exceptions.Exit(EXIT_NO)


def _samples(
    specs: tuple[str, ...],
    point: int | None,
    settings: tuple[str, ...],
    planners: tuple[str, ...],
    points: int | None,
    seed: int | None,
) -> list[Asked]:
    """Random points of all circuits, or of those of some planners."""
    from codesign.rtl.campaign import samples
    from codesign.system import catalog

    if specs or settings or point is not None:
        hint = "leave PLATFORM, WORKLOAD, --set and --point out, or leave --all out"
        raise InputError("--all draws its design points itself", "verify --all", hint)
    circuits = catalog.circuits()
    for name in planners:
        if name not in {owner for owner, *_ in circuits}:
            hint = choose_hint(name, {owner for owner, *_ in circuits})
            raise InputError(f"no planner named {name!r} has circuits", "--planner", hint)
    styles = [style for (owner, *_), style in circuits.items() if not planners or owner in planners]
    if not styles:
        raise InputError("no planner has circuits", "verify --all", "install a planner with circuits")
    first = seed or 0
    return samples(styles, range(first, first + (points or 3)))


def _refuse_options(given: dict[str, object]) -> None:
    for option, value in given.items():
        if value is not None:
            raise InputError("is for --all only", option, "add --all, or leave it out")


def _design_point(specs: tuple[str, ...], point: int | None, settings: tuple[str, ...]) -> Asked:
    """The design point of platform and workload, or of a study."""
    from codesign.rtl.campaign import Asked
    from codesign.rtl.placed import placed
    from codesign.system import point_of

    platform, workload, _ = specs_of(specs, point)
    design = placed(*point_of(platform, workload, settings_of(settings)))
    return Asked(design.style, f"{platform.name} {workload.name}", lambda: design.job)


def _print(styles: Sequence[StyleChecked], waves: Path | None, drawn: bool, as_json: bool) -> None:
    from codesign.report import render_text
    from codesign.report.verification_tables import difference_text, verification_table

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
        click.echo(
            f"waveform: {printable(str(waves), None)}" if seen else "no difference: no waveform is written"
        )
    count = sum(len(each.points) for each in styles)
    if not wrong:
        click.echo(f"{counted(count, 'design point')}: every event equals the model in kind, value and cycle")


@click.command(short_help="Write the Verilog of a design point.")
@click.argument("specs", nargs=-1, required=True, metavar="PLATFORM WORKLOAD | STUDY")
@click.option("--point", type=int, metavar="INDEX", help="Take this point of STUDY, a file of hwsw explore.")
@set_option
@click.option(
    "-o",
    "--output",
    "folder",
    required=True,
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write into this folder, which is made.",
)
@click.option(
    "--force",
    is_flag=True,
    help="Write into a folder that is not empty: replace the files of this command there.",
)
@debug_option
def rtl(
    specs: tuple[str, ...], point: int | None, settings: tuple[str, ...], folder: Path, force: bool
) -> None:
    """Write the circuit of WORKLOAD on PLATFORM into the folder DIR, as Verilog that any tool takes.

    The folder has the Verilog of the design point, a self-checking test bench for Icarus and Verilator, the images of
    its memories, the stream with the map, the clock constraint for the tools of the part, golden vectors with a test
    for cocotb, a core file for FuseSoC, and a README. The same design point gives the same bytes.

    The folder is written whole or not at all.
    """
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
    from codesign.files import write_folder
    from codesign.rtl.export import MANIFEST, Origin, export_files
    from codesign.rtl.placed import placed, refuse_what_does_not_fit
    from codesign.system import point_of

    stale = _stale(folder, force, MANIFEST)
    values = settings_of(settings)
    platform, workload, _ = specs_of(specs, point)
    if point is None:
        origin = Origin(specs[0], specs[1], values)
    else:
        origin = Origin(platform.name, workload.name, values, specs[0], point)
    with progress_shown(after_s=LATER_S) as show, compiling_shown(show):
        design = placed(*point_of(platform, workload, values))
        refuse_what_does_not_fit(design)
        debug_step("files read and checked")
        files = export_files(design, origin)
    debug_step("circuit and expected events made")
    write_folder(folder, {name: text.encode() for name, text in files.items()}, stale)
    top = json.loads(files[MANIFEST])["top"]
    click.echo(f"written: {printable(str(folder), None)} ({counted(len(files), 'file')}, top module {top})")
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
