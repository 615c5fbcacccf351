"""``hwsw trace info`` and ``hwsw trace show``, and the group of all commands that read a trace."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import Quantity, force_option
from codesign.cli.trace_export import export
from codesign.cli.trace_layout import layout
from codesign.cli.trace_views import diff, stats, timeline
from codesign.errors import InputError, printable

if TYPE_CHECKING:
    from codesign.trace import Moment, Trace

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.group(short_help="Read the trace of a run.")
def trace() -> None:
    """Read an MCAP trace of hwsw run --trace FILE."""


@trace.command(short_help="Print the contents of a trace.")
@click.argument("file", type=_FILE)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def info(file: Path, as_json: bool) -> None:
    """Print the contents of the trace FILE: its run, time span, topics and numbers of messages."""
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.trace import open_trace
    from codesign.units import counted

    with progress_shown(after_s=LATER_S, quiet=as_json) as show:
        opened = open_trace(file, show)
    if as_json:
        click.echo(json.dumps(opened.summary(), indent=2))
        return
    rows = opened.rows()
    width = max(len(name) for name, _ in rows)
    for name, text in rows:
        click.echo(f"{name:<{width}}  {text}")
    click.echo()
    for topic, schema, messages in opened.channel_rows():
        click.echo(f"{topic:<{width}}  {schema}, {counted(messages, 'message')}")


_TIME = Quantity("time", "time")


@trace.command(short_help="Print the records of a trace.")
@click.argument("file", type=_FILE)
@click.option("--topic", "topics", multiple=True, help="Only this topic. May be repeated.")
@click.option("--from", "begin", type=_TIME, default=0, help="Only from this simulated time, such as 12s.")
@click.option("--to", "end", type=_TIME, help="Only up to this simulated time.")
@click.option("--at", type=_TIME, help="Print the map at this simulated time instead of the records.")
@click.option(
    "--picture", type=click.Path(dir_okay=False, path_type=Path), help="Draw the map of --at as a PNG or SVG."
)
@click.option(
    "--limit", type=click.IntRange(1), default=200, show_default=True, help="The most lines to print."
)
@click.option("--json", "as_json", is_flag=True, help="Print each line as JSON.")
@force_option
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
    """Print the records of the trace FILE in order of time, and the last field of a plan.

    With --at: the true map at that time, the robot's belief, its path and its position.
    """
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.trace import open_trace

    if picture is not None:
        _check_picture(picture, file)
    with progress_shown(after_s=LATER_S, quiet=as_json) as display:
        opened = open_trace(file, display)
        if at is not None or picture is not None:
            lines = _moment_lines(opened, at, picture, as_json)
        else:
            lines = list(_record_lines(opened, topics, begin, end, limit, as_json))
    for line in lines:
        click.echo(line)
    if opened.fault is not None:
        click.echo(f"the file is not complete: {printable(opened.fault)}", err=True)


def _record_lines(
    opened: Trace, topics: tuple[str, ...], begin: int, end: int | None, limit: int, as_json: bool
) -> Iterator[str]:
    from codesign.trace import HEADER, timeline, trace_thumbnail

    rows = timeline(opened, topics, limit, begin, end)
    if as_json:
        yield from (json.dumps(asdict(row)) for row in rows)
        return
    cells = [HEADER, *(row.cells() for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(HEADER) - 1)]
    for row_cells in cells:
        aligned = (f"{text:<{width}}" for text, width in zip(row_cells, widths, strict=False))
        yield "  ".join((*aligned, row_cells[-1]))
    if topics or begin or end is not None:
        return
    left = opened.record_messages - len(rows)
    if left > 0:
        yield f"... and {left} more: --limit {opened.record_messages}"
    yield from trace_thumbnail(opened, shutil.get_terminal_size().columns)


def _moment_lines(opened: Trace, at: int | None, picture: Path | None, as_json: bool) -> list[str]:
    from codesign.trace import MOMENT_KINDS, moment, moment_lines

    seen = moment(opened.records(kinds=MOMENT_KINDS), at, str(opened.path))
    if picture is not None:
        _draw(seen, picture)
    lines = moment_lines(seen, shutil.get_terminal_size().columns)
    return [json.dumps({"time": seen.time, "lines": lines})] if as_json else lines


def _check_picture(picture: Path, source: Path) -> None:
    from codesign.cli.outputs import check_outputs

    if picture.suffix.lower() not in (".png", ".svg"):
        raise InputError(
            f"{picture} is neither PNG nor SVG", "--picture", "name a file that ends in .png or .svg"
        )
    check_outputs({"--picture": picture}, (source,))


def _draw(seen: Moment, picture: Path) -> None:
    from codesign.files import write_atomically
    from codesign.report import moment_picture
    from codesign.trace.floor import UNKNOWN

    drawn = moment_picture(
        seen.time,
        seen.start,
        seen.free,
        goals=seen.goals,
        corner=seen.corner,
        unknown=None if seen.belief is None else seen.belief == UNKNOWN,
        way=seen.path,
        driven=seen.driven,
        robots=seen.robots,
        format="svg" if picture.suffix.lower() == ".svg" else "png",
    )
    write_atomically(picture, drawn.data)


for _command in (export, layout, stats, diff, timeline):
    trace.add_command(_command)
