"""``hwsw trace stats``, ``hwsw trace diff`` and ``hwsw trace timeline``: a run looked at in the terminal."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import Quantity
from codesign.errors import EXIT_NO, InputError, printable

if TYPE_CHECKING:
    from codesign.exports.statistics import Statistics
    from codesign.trace import Trace

_FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
_TIME = Quantity("time", "time")
_JSON = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")


@click.command(short_help="Print how busy all was, and how long things took.")
@click.argument("file", type=_FILE)
@_JSON
def stats(file: Path, as_json: bool) -> None:
    """Print of the trace FILE how busy each component and link was, and how long messages, tasks and plans took."""
    from codesign.exports.statistics import latencies_table, shares_table, statistics
    from codesign.report.render import render_text

    opened = _opened(file, as_json)
    found = statistics(opened.records())
    if as_json:
        click.echo(json.dumps(_statistics_json(found), indent=2))
    else:
        click.echo(render_text(shares_table(found)))
        click.echo(render_text(latencies_table(found)))
    _fault(opened)


def _statistics_json(found: Statistics) -> dict[str, Any]:
    """All times in ps."""
    latencies = []
    for latency in found.latencies:
        counts, ends = latency.histogram()
        latencies.append(
            {
                "what": latency.what,
                "number": len(latency.times),
                "least_ps": int(latency.times[0]),
                "half_ps": latency.percentile(0.5),
                "share_95_ps": latency.percentile(0.95),
                "greatest_ps": int(latency.times[-1]),
                "histogram": {"counts": counts.tolist(), "ends_ps": ends.tolist()},
            }
        )
    shares = [
        {
            "where": share.where,
            "kind": "link" if share.is_link else "component",
            "busy_ps": share.busy,
            "waiting_ps": share.waiting,
            "idle_ps": share.idle,
            "queued_ps": share.queued,
            "most_waiting": share.deepest,
        }
        for share in found.shares
    ]
    return {"end_ps": found.end, "components_and_links": shares, "latencies": latencies}


@click.command(short_help="Compare two traces.")
@click.argument("first", type=_FILE)
@click.argument("second", type=_FILE)
@_JSON
def diff(first: Path, second: Path, as_json: bool) -> None:
    """Print where the traces FIRST and SECOND differ first in simulated time, then all that differs.

    The exit code is 0 where all records are equal, and 3 where they differ.
    """
    from codesign.exports.difference import channels_table, difference, results_table
    from codesign.report.render import render_text
    from codesign.units import format_time

    one, other = _opened(first, as_json), _opened(second, as_json)
    found = difference(one.records, other.records)
    names = (printable(first.name, 30), printable(second.name, 30))
    names = names if names[0] != names[1] else ("first", "second")
    if as_json:
        channels = [
            {
                "record": channel.record,
                "source": channel.source,
                "counts": list(channel.counts),
                "same": channel.same,
                "time_ps": channel.time,
            }
            for channel in found.channels
        ]
        results = {name: list(values) for name, values in found.results.items()}
        fields = {name: list(values) for name, *values in found.fields()}
        click.echo(
            json.dumps(
                {"equal": found.equal, "fields": fields, "channels": channels, "results": results}, indent=2
            )
        )
    elif found.first is None:
        click.echo("all records are equal")
    else:
        at = next(channel for channel in found.channels if channel.time is not None)
        click.echo(
            f"first difference at {format_time(at.time or 0)}: {at.record} of {printable(at.source, 40)}"
        )
        for name, record in zip(names, found.first, strict=True):
            click.echo(f"  {name}: {_row(record)}")
        for field, before, after in found.fields():
            click.echo(f"  {field}: {printable(before)} → {printable(after)}")
        click.echo()
        click.echo(render_text(channels_table(found, names)))
        if found.results:
            click.echo(render_text(results_table(found, names)))
    _fault(one)
    _fault(other)
    if not found.equal:
        raise SystemExit(EXIT_NO)


def _row(record: Any) -> str:
    from codesign.trace.show import row_of

    if record is None:
        return "no such record"
    begin, duration, source, what, details = row_of(record).cells()
    return ", ".join(filter(None, (begin, f"for {duration}" if duration else "", source, what, details)))


@click.command(short_help="Print a Gantt chart.")
@click.argument("file", type=_FILE)
@click.option("--from", "begin", type=_TIME, default=0, help="Only from this simulated time, such as 12s.")
@click.option("--to", "end", type=_TIME, help="Only up to this simulated time.")
@click.option("--width", type=click.IntRange(60, 1000), help="Columns; by default those of the terminal.")
def timeline(file: Path, begin: int, end: int | None, width: int | None) -> None:
    """Print the trace FILE as a Gantt chart: when each component and link worked, and the events of a mission."""
    from codesign.exports.gantt import gantt
    from codesign.records import ACTIVITY_KINDS

    if end is not None and end <= begin:
        raise InputError("--to is not after --from", "hwsw trace timeline", "give a later --to")
    opened = _opened(file)
    chart = gantt(
        opened.records(kinds=ACTIVITY_KINDS), width or shutil.get_terminal_size().columns, begin, end
    )
    for line in chart.lines():
        click.echo(line)
    _fault(opened)


def _opened(file: Path, quiet: bool = False) -> Trace:
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.trace import open_trace

    with progress_shown(after_s=LATER_S, quiet=quiet) as show:
        return open_trace(file, show)


def _fault(opened: Trace) -> None:
    if opened.fault is not None:
        click.echo(
            f"{printable(str(opened.path), None)}: the file is not complete: {printable(opened.fault)}",
            err=True,
        )
