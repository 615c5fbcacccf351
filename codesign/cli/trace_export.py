"""``hwsw trace export``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import Quantity, command_line, force_option, ros2_option
from codesign.errors import InputError, printable

if TYPE_CHECKING:
    from codesign.trace import Trace

_INPUT = click.Path(exists=True, dir_okay=False, path_type=Path)
_OUTPUT = click.Path(dir_okay=False, path_type=Path)
_TIME = Quantity("time", "time")


@click.command(short_help="Export a trace for other tools.")
@click.argument("file", type=_INPUT)
@click.option("--perfetto", type=_OUTPUT, help="Write a trace of Perfetto, for ui.perfetto.dev.")
@click.option("--vcd", type=_OUTPUT, help="Write a waveform, with a save file of GTKWave beside it.")
@click.option("--poses", type=_OUTPUT, help="Write the positions and times of each robot as CSV.")
@click.option("--html", "page", type=_OUTPUT, help="Write the page of the run, which plays it.")
@ros2_option
@click.option(
    "--ros2-begin",
    "bag_begin",
    type=click.IntRange(0, 2 * 10**9),
    default=0,
    metavar="SECONDS",
    help="When the run begins in the bag, in seconds since 1970.",
)
@click.option(
    "--from", "begin", type=_TIME, default=0, help="Of the waveform: only from this simulated time."
)
@click.option("--to", "end", type=_TIME, help="Of the waveform: only up to this simulated time.")
@force_option
def export(
    file: Path,
    perfetto: Path | None,
    vcd: Path | None,
    poses: Path | None,
    page: Path | None,
    bag: Path | None,
    bag_begin: int,
    begin: int,
    end: int | None,
) -> None:
    """Export the trace FILE for other tools."""
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.trace import open_trace

    outputs = {"--perfetto": perfetto, "--vcd": vcd, "--poses": poses, "--html": page}
    if bag is None and not any(outputs.values()):
        hint = f"give {', '.join(f'{option} OUT' for option in outputs)}, --ros2 DIR or several of them"
        raise InputError("nothing to write", "hwsw trace export", hint)
    check_outputs(outputs, (file,))
    if bag is not None:
        from codesign.bags import check_new

        check_new(bag, "--ros2")
    writers: list[tuple[Path | None, Callable[[Trace, Path], list[Path]]]] = [
        (perfetto, _perfetto),
        (vcd, lambda opened, path: _waveform(opened, path, begin, end)),
        (poses, _poses),
        (page, _page),
        (bag, lambda opened, path: _bag(opened, path, bag_begin)),
    ]
    with progress_shown(after_s=LATER_S) as display:
        opened = open_trace(file, display)
        written = [each for path, write in writers if path is not None for each in write(opened, path)]
    for each in written:
        click.echo(f"written: {printable(str(each), None)}")
    if opened.fault is not None:
        click.echo(f"the file is not complete: {printable(opened.fault)}", err=True)


def _perfetto(opened: Trace, path: Path) -> list[Path]:
    from codesign.exports.perfetto import write_perfetto
    from codesign.files import written_atomically
    from codesign.records import ACTIVITY_KINDS

    with written_atomically(path) as passing, passing.open("wb") as file:
        write_perfetto(opened.records(kinds=ACTIVITY_KINDS), file)
    return [path]


def _waveform(opened: Trace, path: Path, begin: int, end: int | None) -> list[Path]:
    from codesign.exports.waveform import waveform_of, write_waveform
    from codesign.records import ACTIVITY_KINDS

    if end is not None and end < begin:
        raise InputError("--to is before --from", "hwsw trace export", "give a later --to")
    return write_waveform(waveform_of(opened.records(kinds=ACTIVITY_KINDS), begin, end), path)


def _poses(opened: Trace, path: Path) -> list[Path]:
    from codesign.exports.poses import POSE_KINDS, poses_csv
    from codesign.files import write_atomically

    write_atomically(path, "".join(poses_csv(opened.records(kinds=POSE_KINDS))).encode("utf-8", "replace"))
    return [path]


def _page(opened: Trace, path: Path) -> list[Path]:
    """The page of the run; without its figures where the trace has no result that this version reads."""
    from pydantic import ValidationError

    from codesign.report import records_page, result_page, run_pictures
    from codesign.report.scrub import SCRUB_KINDS
    from codesign.results.result import Result

    records = list(opened.records(kinds=SCRUB_KINDS))
    pictures = run_pictures(records)
    try:
        result = Result.model_validate(opened.result)
    except ValidationError:
        records_page(records, path, title=opened.path.name, pictures=pictures, command=command_line())
    else:
        result_page(result, path, pictures=pictures, records=records, command=command_line())
    return [path]


def _bag(opened: Trace, path: Path, begin: int) -> list[Path]:
    from codesign.bags import BAG_KINDS, export_bag

    export_bag(opened.records(kinds=BAG_KINDS), path, begin * 10**9)
    return [path]
