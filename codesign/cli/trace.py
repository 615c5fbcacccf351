"""``hwsw trace info`` and ``hwsw trace show``."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, progress_shown
from codesign.cli.requests import TraceInfo, TraceShow
from codesign.ground.errors import InputError, printable
from codesign.ground.files import write_atomically
from codesign.ground.units import counted
from codesign.views.report import moment_picture
from codesign.views.trace import HEADER, MOMENT_KINDS, moment, moment_lines, open_trace, timeline, trace_thumbnail
from codesign.views.trace.shapes import UNKNOWN

if TYPE_CHECKING:
    from codesign.views.trace import Moment, Trace


def info(asked: TraceInfo) -> None:
    """Print the contents of the trace FILE: its run, time span, topics and numbers of messages."""
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as show:
        opened = open_trace(asked.file, show)
    if asked.as_json:
        click.echo(json.dumps(opened.summary(), indent=2))
        return
    rows = opened.rows()
    width = max(len(name) for name, _ in rows)
    for name, text in rows:
        click.echo(f"{name:<{width}}  {text}")
    click.echo()
    for topic, schema, messages in opened.channel_rows():
        click.echo(f"{topic:<{width}}  {schema}, {counted(messages, 'message')}")


def show(asked: TraceShow) -> None:
    """Print the records of the trace FILE in order of time, and the last field of a plan."""
    if asked.picture is not None:
        _check_picture(asked.picture, asked.file)
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as display:
        opened = open_trace(asked.file, display)
        if asked.at is not None or asked.picture is not None:
            lines = _moment_lines(opened, asked.at, asked.picture, asked.as_json)
        else:
            lines = list(_record_lines(opened, asked.topics, asked.begin, asked.end, asked.limit, asked.as_json))
    for line in lines:
        click.echo(line)
    if opened.fault is not None:
        click.echo(f"the file is not complete: {printable(opened.fault)}", err=True)


def _record_lines(
    opened: Trace, topics: tuple[str, ...], begin: int, end: int | None, limit: int, as_json: bool
) -> Iterator[str]:
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
    seen = moment(opened.records(kinds=MOMENT_KINDS), at, str(opened.path))
    if picture is not None:
        _draw(seen, picture)
    lines = moment_lines(seen, shutil.get_terminal_size().columns)
    return [json.dumps({"time": seen.time, "lines": lines})] if as_json else lines


def _check_picture(picture: Path, source: Path) -> None:
    if picture.suffix.lower() not in (".png", ".svg"):
        raise InputError(f"{picture} is neither PNG nor SVG", "--picture", "name a file that ends in .png or .svg")
    check_outputs({"--picture": picture}, (source,))


def _draw(seen: Moment, picture: Path) -> None:
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
