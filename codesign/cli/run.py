"""``hwsw run``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import (
    SENTENCE,
    TABLES,
    command_line,
    debug_step,
    force_option,
    memory_option,
    need_option,
    output_options,
    ros2_option,
    set_option,
    settings_of,
)
from codesign.cli.specs import specs_of
from codesign.errors import EXIT_NO, printable

if TYPE_CHECKING:
    from codesign.inputs import Constraint
    from codesign.progress import Show
    from codesign.records import Record
    from codesign.results.result import Result
    from codesign.system import MissionProgress

_QUIET_SECONDS = 5.0
"""A shorter run shows no progress."""


@click.command(short_help="Simulate one design point.")
@click.argument("specs", nargs=-1, required=True, metavar="PLATFORM WORKLOAD | STUDY")
@click.option(
    "--point", type=int, metavar="INDEX", help="Run this point of STUDY, a file of hwsw explore, again."
)
@set_option
@need_option
@click.option(
    "--trace", "trace_file", type=click.Path(dir_okay=False, path_type=Path), help="Write an MCAP trace."
)
@ros2_option
@click.option(
    "--trace-level",
    type=click.Choice(["mission", "messages", "blocks", "iterations"]),
    default="blocks",
    show_default=True,
    help="How much the trace holds; each level holds what the one before holds, and more.",
)
@click.option("--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page.")
@click.option(
    "--granularity",
    type=click.Choice(["run_ahead", "visit"]),
    default="run_ahead",
    show_default=True,
    help="How much a component computes in one event. The result is the same.",
)
@memory_option
@click.option(
    "--levers/--no-levers",
    default=True,
    show_default=True,
    help="Repeat a mission with each of its levers moved, to find its bottleneck.",
)
@output_options("Print the sentence alone.", "Print all tables after the sentence and its figures.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
@force_option
def run(
    specs: tuple[str, ...],
    point: int | None,
    settings: tuple[str, ...],
    needs: tuple[str, ...],
    trace_file: Path | None,
    bag: Path | None,
    trace_level: str,
    page: Path | None,
    granularity: str,
    memory: int | None,
    levers: bool,
    detail: str,
    as_json: bool,
) -> None:
    """Simulate WORKLOAD on PLATFORM (names or YAML files), and print the answer: one sentence and five figures.

    With --point, simulate a point of an explored study, from the specs that the study holds.

    -v adds all tables: costs, quality of the plan, resources, and the sources of the figures. For the exit code alone,
    use -q and send the output to /dev/null.

    The exit code is 3 where the design does not fit, or misses a --need. A mission that ends without its goal is a
    result: the exit code is 0, and the result says why.
    """
    import codesign
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import compiling_shown, progress_shown
    from codesign.exploration.constraints import with_constraints
    from codesign.inputs.constraint import needs_of
    from codesign.progress import doing, plans_shown
    from codesign.records import MemoryListener
    from codesign.scenarios import outlook
    from codesign.system import point_of

    debug_step("modules loaded")
    values = settings_of(settings)
    platform, workload_spec, asked = specs_of(specs, point)
    limits = needs_of(needs, figures=asked.figures)
    check_outputs(
        {"--trace": trace_file, "--html": page}, (*specs, workload_spec.map_file), plain=["--trace"]
    )
    if bag is not None:
        from codesign.bags import BagListener, check_new

        check_new(bag, "--ros2")
    moved = point_of(platform, workload_spec, values)
    debug_step("files read and checked")
    records = MemoryListener()
    quiet = as_json or detail == SENTENCE
    long = outlook(moved[1])
    if long is not None and not quiet:
        click.echo(long, err=True)
    with ExitStack() as stack:
        show = stack.enter_context(progress_shown(after_s=_QUIET_SECONDS, quiet=quiet))
        stack.enter_context(compiling_shown(show))
        if moved[1].scenario.type == "plan_once":
            stack.enter_context(plans_shown(show))
        ros2 = None if bag is None else stack.enter_context(BagListener(bag))
        doing(show, "simulating")
        result = codesign.simulate(
            *moved,
            granularity=granularity,
            trace=trace_file,
            trace_level=trace_level,
            listeners=[*([] if page is None else [records]), *([] if ros2 is None else [ros2])],
            progress=mission_progress(show),
            memory=memory,
            keeping=page is not None,
            levers=levers,
            lever_progress=lever_progress(show),
        )
        result = with_constraints(result, limits)
        if ros2 is not None and not result.simulated:
            ros2.abort()
        debug_step("simulated")
        if page is not None:
            doing(show, "drawing the pictures of the page")
            _write_page(result, page, records.records)
            debug_step("page written")
    _print(result, asked.constraints, limits, detail, as_json)
    _print_files(result, {"trace": trace_file, "bag": bag, "page": page}, silent=as_json or quiet)
    _end(result)


def _write_page(result: Result, page: Path, records: Sequence[Record]) -> None:
    """The page of the run, with its pictures and its course."""
    from codesign.report import result_page, run_pictures

    result_page(result, page, pictures=run_pictures(records), records=records, command=command_line())


def _end(result: Result) -> None:
    """Leave with the exit code of an interrupt, or of a design that is not feasible."""
    from codesign import interrupts

    struck = interrupts.struck()
    if struck is not None:
        interrupts.keep("the mission is complete, but not all of its levers were run")
        raise struck
    if not result.feasible:
        raise click.exceptions.Exit(EXIT_NO)


def _print_files(result: Result, files: Mapping[str, Path | None], *, silent: bool) -> None:
    """The files that were written, unless ``silent``; a trace that was not written always, on standard error."""
    for name, path in files.items():
        if path is None:
            continue
        text = f"{name}: {printable(str(path), None)}"
        if name != "page" and not result.simulated:
            click.echo(f"{text} is not written, as the design is not feasible and was not run", err=True)
        elif not silent:
            click.echo(text)


def _print(
    result: Result, asked: Sequence[Constraint], needs: tuple[Constraint, ...], detail: str, as_json: bool
) -> None:
    """The answer, and the reasons of a design that is not feasible; with ``TABLES`` all tables."""
    from codesign.report import answer, render_text, result_reasons_table, result_tables
    from codesign.verdicts import run_document

    if as_json:
        click.echo(run_document(result).model_dump_json(indent=2))
        return
    lead = answer(result, asked, needs)
    if detail == SENTENCE:
        click.echo(lead.sentence_text)
        return
    click.echo(lead.text)
    why_not = (result_reasons_table(result),) if result.reasons else ()
    for table in result_tables(result) if detail == TABLES else why_not:
        click.echo(render_text(table))


def mission_progress(show: Show) -> Callable[[MissionProgress], None]:
    """Show the progress of a mission in thousandths of the longest drive.

    Most drives end long before, so it says no time left.
    """
    from codesign.progress import Advance
    from codesign.units import counted

    def progress(state: MissionProgress) -> None:
        words = f"of the longest drive, {state.time / 1e12:,.0f} s simulated, {counted(state.turns, 'turn')}"
        show(Advance(int(1000 * state.share), 1000, words))

    return progress


def lever_progress(show: Show) -> Callable[[int, int, str], None]:
    """Show how many levers of a mission were run, with the time left at the current rate."""
    from codesign.progress import Advance, Pace

    paces: list[Pace] = []

    def progress(done: int, total: int, path: str) -> None:
        paces.append(paces[0] if paces else Pace(total))
        words = f"levers run, {path}" if path else "levers run"
        show(Advance(done, total, words, paces[0].left_s(done)))

    return progress
