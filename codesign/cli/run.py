"""``hwsw run``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

import codesign
from codesign.cli.options import command_line, debug_step
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import compiling_shown, progress_shown
from codesign.cli.request import SENTENCE, TABLES
from codesign.cli.requests import Run
from codesign.cli.specs import specs_of
from codesign.ground import interrupts
from codesign.ground.errors import EXIT_NO, printable
from codesign.ground.late import load
from codesign.ground.progress import Advance, Pace, doing, plans_shown
from codesign.ground.records import MemoryListener
from codesign.ground.units import counted
from codesign.inputs.constraint import needs_of
from codesign.study.constraints import with_constraints
from codesign.system import point_of
from codesign.system.scenarios import outlook
from codesign.system.verdicts import run_document
from codesign.views import report

if TYPE_CHECKING:
    from codesign.ground.progress import Show
    from codesign.ground.records import Record
    from codesign.inputs import Constraint
    from codesign.system import MissionProgress
    from codesign.system.results.result import Result

_QUIET_SECONDS = 5.0
"""A shorter run shows no progress."""


def run(asked: Run) -> None:
    """Simulate WORKLOAD on PLATFORM (names or YAML files), and print the answer: one sentence and five figures."""
    debug_step("modules loaded")
    platform, workload_spec, study = specs_of(asked.specs, asked.point)
    limits = needs_of(asked.needs, figures=study.figures)
    check_outputs(
        {"--trace": asked.trace, "--html": asked.page}, (*asked.specs, workload_spec.map_file), plain=["--trace"]
    )
    if asked.bag is not None:
        load("codesign.views.bags:check_new")(asked.bag, "--ros2")
    moved = point_of(platform, workload_spec, asked.settings)
    debug_step("files read and checked")
    records = MemoryListener()
    quiet = asked.as_json or asked.detail == SENTENCE
    long = outlook(moved[1])
    if long is not None and not quiet:
        click.echo(long, err=True)
    with ExitStack() as stack:
        show = stack.enter_context(progress_shown(after_s=_QUIET_SECONDS, quiet=quiet))
        stack.enter_context(compiling_shown(show))
        if moved[1].scenario.type == "plan_once":
            stack.enter_context(plans_shown(show))
        ros2 = None if asked.bag is None else stack.enter_context(load("codesign.views.bags:BagListener")(asked.bag))
        doing(show, "simulating")
        result = codesign.simulate(
            *moved,
            granularity=asked.granularity,
            trace=asked.trace,
            trace_level=asked.trace_level,
            listeners=[*([] if asked.page is None else [records]), *([] if ros2 is None else [ros2])],
            progress=mission_progress(show),
            memory=asked.memory,
            keeping=asked.page is not None,
            levers=asked.levers,
            lever_progress=lever_progress(show),
        )
        result = with_constraints(result, limits)
        if ros2 is not None and not result.simulated:
            ros2.abort()
        debug_step("simulated")
        if asked.page is not None:
            doing(show, "drawing the pictures of the page")
            _write_page(result, asked.page, records.records)
            debug_step("page written")
    _print(result, study.constraints, limits, asked.detail, asked.as_json)
    _print_files(result, {"trace": asked.trace, "bag": asked.bag, "page": asked.page}, silent=asked.as_json or quiet)
    _end(result)


def _write_page(result: Result, page: Path, records: Sequence[Record]) -> None:
    """The page of the run, with its pictures and its course."""
    report.result_page(result, page, pictures=report.run_pictures(records), records=records, command=command_line())


def _end(result: Result) -> None:
    """Leave with the exit code of an interrupt, or of a design that is not feasible."""
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
    if as_json:
        click.echo(run_document(result).model_dump_json(indent=2))
        return
    lead = report.answer(result, asked, needs)
    if detail == SENTENCE:
        click.echo(lead.sentence_text)
        return
    click.echo(lead.text)
    why_not = (report.result_reasons_table(result),) if result.reasons else ()
    for table in report.result_tables(result) if detail == TABLES else why_not:
        click.echo(report.render_text(table))


def mission_progress(show: Show) -> Callable[[MissionProgress], None]:
    """Show the progress of a mission in thousandths of the longest drive.

    Most drives end long before, so it says no time left.
    """

    def progress(state: MissionProgress) -> None:
        words = f"of the longest drive, {state.time / 1e12:,.0f} s simulated, {counted(state.turns, 'turn')}"
        show(Advance(int(1000 * state.share), 1000, words))

    return progress


def lever_progress(show: Show) -> Callable[[int, int, str], None]:
    """Show how many levers of a mission were run, with the time left at the current rate."""
    paces: list[Pace] = []

    def progress(done: int, total: int, path: str) -> None:
        paces.append(paces[0] if paces else Pace(total))
        words = f"levers run, {path}" if path else "levers run"
        show(Advance(done, total, words, paces[0].left_s(done)))

    return progress
