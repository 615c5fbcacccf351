"""``hwsw trace info`` and ``hwsw trace show``."""

from __future__ import annotations

from pathlib import Path

import click

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.group(short_help="Look into the trace of a run.")
def trace() -> None:
    """Look into the MCAP trace that ``hwsw run --trace FILE`` wrote."""


@trace.command(short_help="What the trace holds.")
@click.argument("file", type=_FILE)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def info(file: Path, as_json: bool) -> None:
    """Print what the trace FILE holds: topics, counts, time span, what run it is of."""
    from codesign.trace import info_json, info_lines, open_trace, trace_info

    found = trace_info(open_trace(file))
    click.echo(info_json(found) if as_json else "\n".join(info_lines(found)))


@trace.command(short_help="The story of the run.")
@click.argument("file", type=_FILE)
@click.option("--topic", help="Only this topic.")
@click.option(
    "--limit", type=click.IntRange(1), default=200, show_default=True, help="At most so many lines."
)
@click.option("--json", "as_json", is_flag=True, help="Print records as JSON, one a line.")
def show(file: Path, topic: str | None, limit: int, as_json: bool) -> None:
    """Print the records of the trace FILE in the order of time, and the potential of the last stage."""
    from codesign.trace import open_trace, show_json_lines, show_lines

    lines = (show_json_lines if as_json else show_lines)(open_trace(file), topic=topic, limit=limit)
    for line in lines:
        click.echo(line)
