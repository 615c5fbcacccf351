"""``hwsw trace info`` and ``hwsw trace show``."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path

import click

from codesign.errors import printable

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


@trace.command(short_help="The story of the run.")
@click.argument("file", type=_FILE)
@click.option("--topic", "topics", multiple=True, help="Only this topic; may be given again.")
@click.option(
    "--limit", type=click.IntRange(1), default=200, show_default=True, help="At most so many lines."
)
@click.option("--json", "as_json", is_flag=True, help="Print the lines as JSON, one a line.")
def show(file: Path, topics: tuple[str, ...], limit: int, as_json: bool) -> None:
    """Print the records of the trace FILE in the order of time, and the potential of the last stage."""
    from codesign.trace import HEADER, open_trace, timeline, trace_thumbnail

    opened = open_trace(file)
    rows = timeline(opened, topics, limit)
    if as_json:
        for row in rows:
            click.echo(json.dumps(asdict(row)))
        return
    cells = [HEADER, *(row.cells() for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(HEADER) - 1)]
    for row_cells in cells:
        aligned = (f"{text:<{width}}" for text, width in zip(row_cells, widths, strict=False))
        click.echo("  ".join((*aligned, row_cells[-1])))
    left = opened.messages - len(rows)
    if left > 0 and not topics:
        click.echo(f"... and {left} more: --limit {opened.messages}")
    for line in trace_thumbnail(opened, shutil.get_terminal_size().columns):
        click.echo(line)
    if opened.fault is not None:
        click.echo(f"the file is not whole: {printable(opened.fault)}", err=True)
