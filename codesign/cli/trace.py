"""``hwsw trace info``, ``hwsw trace show`` and ``hwsw trace export``."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.errors import CodesignError, InputError, printable

if TYPE_CHECKING:
    from codesign.trace import Moment, Trace

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.group(short_help="Look into the trace of a run.")
def trace() -> None:
    """Look into the MCAP trace that ``hwsw run --trace FILE`` wrote."""


@trace.command(short_help="What the trace holds.")
@click.argument("file", type=_FILE)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def info(file: Path, as_json: bool) -> None:
    """Print what the trace FILE holds: topics, counts, time span, what run it is of."""
    from codesign.trace import open_trace, trace_info

    found = trace_info(open_trace(file))
    if as_json:
        click.echo(json.dumps(asdict(found), indent=2))
        return
    rows = found.rows()
    width = max(len(name) for name, _ in rows)
    for name, text in rows:
        click.echo(f"{name:<{width}}  {text}")
    click.echo()
    for topic, schema, count in found.channel_rows():
        click.echo(f"{topic:<{width}}  {schema}, {count}")


class _Time(click.ParamType[int]):
    """A simulated time with its unit, as picoseconds."""

    name = "time"

    def convert(self, value: str | int, param: click.Parameter | None, _context: click.Context | None) -> int:
        """Picoseconds of ``12 s``; a bare number is refused, as in a spec."""
        from codesign.units import Dimension, parse_quantity

        if isinstance(value, int):
            return value
        try:
            return int(parse_quantity(value, Dimension.TIME))
        except CodesignError as fault:
            raise InputError(fault.what, param.opts[0] if param else None, fault.hint) from fault


_TIME = _Time()


@trace.command(short_help="The story of the run.")
@click.argument("file", type=_FILE)
@click.option("--topic", "topics", multiple=True, help="Only this topic; may be given again.")
@click.option("--from", "begin", type=_TIME, default=0, help="Only from this simulated time on, such as 12s.")
@click.option("--to", "end", type=_TIME, help="Only up to this simulated time.")
@click.option("--at", type=_TIME, help="The map at this simulated time in place of the records.")
@click.option(
    "--picture", type=click.Path(dir_okay=False, path_type=Path), help="Draw the map of --at as a PNG or SVG."
)
@click.option(
    "--limit", type=click.IntRange(1), default=200, show_default=True, help="At most so many lines."
)
@click.option("--json", "as_json", is_flag=True, help="Print the lines as JSON, one a line.")
def show(
    file: Path,
    topics: tuple[str, ...],
    begin: int,
    end: int | None,
    at: int | None,
    picture: Path | None,
    limit: int,
    as_json: bool,
) -> None:
    """Print the records of the trace FILE in the order of time, and the last field that was planned with.

    With --at: the true map by then, what the robot knew of it, its way and the robot.
    """
    from codesign.trace import open_trace

    opened = open_trace(file)
    if at is not None or picture is not None:
        _show_moment(opened, at, picture, as_json)
    else:
        _show_records(opened, topics, begin, end, limit, as_json)
    if opened.fault is not None:
        click.echo(f"the file is not whole: {printable(opened.fault)}", err=True)


def _show_records(
    opened: Trace, topics: tuple[str, ...], begin: int, end: int | None, limit: int, as_json: bool
) -> None:
    from codesign.trace import HEADER, timeline, trace_thumbnail

    rows = timeline(opened, topics, limit, begin, end)
    if as_json:
        for row in rows:
            click.echo(json.dumps(asdict(row)))
        return
    cells = [HEADER, *(row.cells() for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(HEADER) - 1)]
    for row_cells in cells:
        aligned = (f"{text:<{width}}" for text, width in zip(row_cells, widths, strict=False))
        click.echo("  ".join((*aligned, row_cells[-1])))
    if topics or begin or end is not None:
        return
    left = opened.record_messages - len(rows)
    if left > 0:
        click.echo(f"... and {left} more: --limit {opened.record_messages}")
    for line in trace_thumbnail(opened, shutil.get_terminal_size().columns):
        click.echo(line)


def _show_moment(opened: Trace, at: int | None, picture: Path | None, as_json: bool) -> None:
    from codesign.trace import MOMENT_KINDS, moment, moment_lines

    seen = moment(opened.records(kinds=MOMENT_KINDS), at, str(opened.path))
    if picture is not None:
        _draw(seen, picture, opened.path)
    lines = moment_lines(seen, shutil.get_terminal_size().columns)
    click.echo(json.dumps({"time": seen.time, "lines": lines}) if as_json else "\n".join(lines))


def _draw(seen: Moment, picture: Path, source: Path) -> None:
    from codesign.cli.outputs import check_outputs
    from codesign.files import write_atomically
    from codesign.report import moment_picture
    from codesign.trace.grid import UNKNOWN

    kind = picture.suffix.lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise InputError(
            f"{picture} is neither PNG nor SVG", "--picture", "name a file that ends in .png or .svg"
        )
    check_outputs({"--picture": picture}, (source,))
    drawn = moment_picture(
        seen.time,
        seen.start,
        seen.free,
        goals=seen.goals,
        unknown=None if seen.belief is None else seen.belief == UNKNOWN,
        way=seen.way,
        driven=seen.driven,
        robots=seen.robots,
        format="svg" if kind == "svg" else "png",
    )
    write_atomically(picture, drawn.data)


@trace.command(short_help="The trace for other tools.")
@click.argument("file", type=_FILE)
@click.option(
    "--perfetto",
    "events",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write trace events: open them at ui.perfetto.dev.",
)
@click.option(
    "--poses",
    "poses",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write a CSV of where each robot was, when.",
)
def export(file: Path, events: Path | None, poses: Path | None) -> None:
    """Write the trace FILE for other tools."""
    from codesign.cli.outputs import check_outputs
    from codesign.files import write_atomically
    from codesign.trace import PERFETTO_KINDS, POSE_KINDS, open_trace, perfetto, poses_csv

    if events is None and poses is None:
        raise InputError("nothing to write", "hwsw trace export", "give --perfetto OUT, --poses OUT or both")
    check_outputs({"--perfetto": events, "--poses": poses}, (file,))
    opened = open_trace(file)
    for path, write, kinds in ((events, perfetto, PERFETTO_KINDS), (poses, poses_csv, POSE_KINDS)):
        if path is not None:
            write_atomically(path, "".join(write(opened.records(kinds=kinds))).encode("utf-8", "replace"))
            click.echo(f"written: {printable(str(path), None)}")
    if opened.fault is not None:
        click.echo(f"the file is not whole: {printable(opened.fault)}", err=True)
