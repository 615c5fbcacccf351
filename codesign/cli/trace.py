"""``hwsw trace``: a run in the terminal (``info``, ``show``, ``stats``, ``diff``, ``timeline``) and in other tools."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from pydantic import ValidationError

from codesign.cli.options import command_line
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, progress_shown
from codesign.cli.requests import TraceDiff, TraceExport, TraceInfo, TraceLayout, TraceShow, TraceStats, TraceTimeline
from codesign.ground.errors import EXIT_NO, InputError, printable
from codesign.ground.files import write_atomically, written_atomically
from codesign.ground.late import load
from codesign.ground.records import ACTIVITY_KINDS
from codesign.ground.units import counted, format_time
from codesign.system.results.result import Result
from codesign.views.exports.difference import channels_table, difference, results_table
from codesign.views.exports.layouts import bag_layout, foxglove_layout, write_blueprint
from codesign.views.exports.perfetto import write_perfetto
from codesign.views.exports.poses import POSE_KINDS, poses_csv
from codesign.views.exports.statistics import gantt, latencies_table, shares_table, statistics
from codesign.views.exports.waveform import waveform_of, write_waveform
from codesign.views.report import moment_picture, records_page, result_page, run_pictures
from codesign.views.report.render import render_text
from codesign.views.report.scrub import SCRUB_KINDS
from codesign.views.trace import HEADER, MOMENT_KINDS, moment, moment_lines, open_trace, trace_thumbnail
from codesign.views.trace import timeline as merged
from codesign.views.trace.moment import row_of

if TYPE_CHECKING:
    from codesign.views.exports.statistics import Statistics
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
    _fault(opened, "")


def _record_lines(
    opened: Trace, topics: tuple[str, ...], begin: int, end: int | None, limit: int, as_json: bool
) -> Iterator[str]:
    rows = merged(opened, topics, limit, begin, end)
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
    drawn = moment_picture(**seen.drawn, format="svg" if picture.suffix.lower() == ".svg" else "png")
    write_atomically(picture, drawn.data)


def stats(asked: TraceStats) -> None:
    """Print of the trace FILE how busy each component and link was, and how long messages, tasks and plans took."""
    opened = _opened(asked.file, asked.as_json)
    found = statistics(opened.records())
    if asked.as_json:
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


def diff(asked: TraceDiff) -> None:
    """Print where the traces FIRST and SECOND differ first in simulated time, then all that differs."""
    one, other = _opened(asked.first, asked.as_json), _opened(asked.second, asked.as_json)
    found = difference(one.records, other.records)
    names = (printable(asked.first.name, 30), printable(asked.second.name, 30))
    names = names if names[0] != names[1] else ("first", "second")
    if asked.as_json:
        channels = [
            {"time_ps" if name == "time" else name: value for name, value in vars(channel).items()}
            for channel in found.channels
        ]
        results = {name: list(values) for name, values in found.results.items()}
        fields = {name: list(values) for name, *values in found.fields()}
        document = {"equal": found.equal, "fields": fields, "channels": channels, "results": results}
        click.echo(json.dumps(document, indent=2))
    elif found.first is None:
        click.echo("all records are equal")
    else:
        at = next(channel for channel in found.channels if channel.time is not None)
        click.echo(f"first difference at {format_time(at.time or 0)}: {at.record} of {printable(at.source, 40)}")
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
    if record is None:
        return "no such record"
    begin, duration, source, what, details = row_of(record).cells()
    return ", ".join(filter(None, (begin, f"for {duration}" if duration else "", source, what, details)))


def timeline(asked: TraceTimeline) -> None:
    """Print the trace FILE as a Gantt chart: when each component and link worked, and the events of a mission."""
    if asked.end is not None and asked.end <= asked.begin:
        raise InputError("--to is not after --from", "hwsw trace timeline", "give a later --to")
    opened = _opened(asked.file)
    width = asked.width or shutil.get_terminal_size().columns
    chart = gantt(opened.records(kinds=ACTIVITY_KINDS), width, asked.begin, asked.end)
    for line in chart.lines():
        click.echo(line)
    _fault(opened)


def _opened(file: Path, quiet: bool = False) -> Trace:
    with progress_shown(after_s=LATER_S, quiet=quiet) as show:
        return open_trace(file, show)


def _fault(opened: Trace, named: str | None = None) -> None:
    """Say what is wrong with a file, after its name unless ``named`` is given."""
    if opened.fault is not None:
        name = f"{printable(str(opened.path), None)}: " if named is None else named
        click.echo(f"{name}the file is not complete: {printable(opened.fault)}", err=True)


def export(asked: TraceExport) -> None:
    """Export the trace FILE for other tools."""
    outputs = {"--perfetto": asked.perfetto, "--vcd": asked.vcd, "--poses": asked.poses, "--html": asked.page}
    if asked.bag is None and not any(outputs.values()):
        hint = f"give {', '.join(f'{option} OUT' for option in outputs)}, --ros2 DIR or several of them"
        raise InputError("nothing to write", "hwsw trace export", hint)
    check_outputs(outputs, (asked.file,))
    if asked.bag is not None:
        load("codesign.views.bags:check_new")(asked.bag, "--ros2")
    writers: list[tuple[Path | None, Callable[[Trace, Path], list[Path]]]] = [
        (asked.perfetto, _perfetto),
        (asked.vcd, lambda opened, path: _waveform(opened, path, asked.begin, asked.end)),
        (asked.poses, _poses),
        (asked.page, _page),
        (asked.bag, lambda opened, path: _bag(opened, path, asked.bag_begin)),
    ]
    with progress_shown(after_s=LATER_S) as display:
        opened = open_trace(asked.file, display)
        written = [each for path, write in writers if path is not None for each in write(opened, path)]
    for each in written:
        click.echo(f"written: {printable(str(each), None)}")
    _fault(opened, "")


def _perfetto(opened: Trace, path: Path) -> list[Path]:
    with written_atomically(path) as passing, passing.open("wb") as file:
        write_perfetto(opened.records(kinds=ACTIVITY_KINDS), file)
    return [path]


def _waveform(opened: Trace, path: Path, begin: int, end: int | None) -> list[Path]:
    if end is not None and end < begin:
        raise InputError("--to is before --from", "hwsw trace export", "give a later --to")
    return write_waveform(waveform_of(opened.records(kinds=ACTIVITY_KINDS), begin, end), path)


def _poses(opened: Trace, path: Path) -> list[Path]:
    write_atomically(path, "".join(poses_csv(opened.records(kinds=POSE_KINDS))).encode("utf-8", "replace"))
    return [path]


def _page(opened: Trace, path: Path) -> list[Path]:
    """The page of the run; without its figures where the trace has no result that this version reads."""
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
    kinds = load("codesign.views.bags:BAG_KINDS")
    load("codesign.views.bags:export_bag")(opened.records(kinds=kinds), path, begin * 10**9)
    return [path]


def layout(asked: TraceLayout) -> None:
    """Write a layout for the trace FILE: the topics that it has, in panels, seen from above, with plots and events."""
    output = asked.output or asked.file.with_suffix(".rbl" if asked.viewer == "rerun" else ".json")
    check_outputs({"--output": output}, [asked.file], kind="blueprint" if asked.viewer == "rerun" else "layout")
    with progress_shown(after_s=LATER_S) as show:
        opened = open_trace(asked.file, show)
        if asked.viewer == "rerun":
            with written_atomically(output) as passing:
                write_blueprint(opened, passing)
        else:
            text = bag_layout(opened) if asked.viewer == "ros2" else foxglove_layout(opened)
            write_atomically(output, text.encode())
    click.echo(f"written: {printable(str(output), None)}")
    _fault(opened, "")
