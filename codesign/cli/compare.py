"""``hwsw compare``."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import click
from more_itertools import map_reduce

import codesign
from codesign import simulate
from codesign.cli.options import command_line, debug_step
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.request import ANSWER, SENTENCE, TABLES
from codesign.cli.requests import Compare
from codesign.ground.errors import EXIT_FAILED, EXIT_NO, CodesignError, InputError, SpecError, printable
from codesign.ground.progress import tracked
from codesign.inputs import has_axis
from codesign.inputs.constraint import needs_of
from codesign.inputs.workload import figures_of
from codesign.study.constraints import with_constraints
from codesign.system import applicable, problem_from_map, problem_of, with_problem
from codesign.system.inspect import at_options, with_task
from codesign.system.results.result import Result
from codesign.system.verdicts import run_document
from codesign.views.report import answer, comparison_page, comparison_table, render_text, result_tables

if TYPE_CHECKING:
    from codesign.inputs import Constraint, Platform, Workload
    from codesign.inputs.problem import ProblemSpec

DEFAULT = ("virtex4-pci:labyrinth", "virtex4-pci:wavefront-tiles", "virtex2pro:breadth-first", "pc-3400mhz:floor-plan")


def compare(asked: Compare) -> None:
    """Simulate each PLATFORM:WORKLOAD and print the figures side by side."""
    problem = _problem(asked)
    loaded = [(design, *_specs_of(design)) for design in asked.designs or DEFAULT]
    names = (name for design in asked.designs for name in design.split(":", 1))
    check_outputs({"--html": asked.page}, [asked.like, asked.map_file, *names])
    limits = needs_of(asked.needs, figures=figures_of(*(workload for _, _, workload in loaded)))
    _check_axes(asked.settings, loaded)
    debug_step("files read and checked")
    with progress_shown(after_s=LATER_S, quiet=asked.quiet) as show, compiling_shown(show):
        results: list[tuple[str, Result | CodesignError]] = [
            (design, _result_or_error(platform, workload, problem, asked))
            for design, platform, workload in tracked(loaded, show, "designs simulated", len(loaded))
        ]
    results = [
        (design, with_constraints(result, limits) if isinstance(result, Result) else result)
        for design, result in results
    ]
    debug_step("simulated")
    if asked.page is not None:
        comparison_page(results, asked.page, needs=limits, command=command_line())
    _print(results, limits, asked.detail, asked.as_json)
    if asked.page is not None and not asked.quiet:
        click.echo(f"page: {printable(str(asked.page), None)}")
    _report_failures([(design, result) for design, result in results if isinstance(result, CodesignError)])
    if all(isinstance(result, CodesignError) for _, result in results):
        raise click.exceptions.Exit(EXIT_FAILED)
    if not any(isinstance(result, Result) and result.feasible for _, result in results):
        raise click.exceptions.Exit(EXIT_NO)


def _problem(asked: Compare) -> ProblemSpec | None:
    """The problem that all designs are given: of a workload, or of a map with its goal and start; None: their own."""
    if asked.map_file is None:
        like = asked.like or ("" if asked.designs else "labyrinth")
        return problem_of(codesign.load_workload(like)) if like else None
    if asked.goal is None or asked.start is None:
        raise InputError("a map needs a goal and a start", "--map", "add --goal ROW,COLUMN --start ROW,COLUMN")
    return problem_from_map(asked.map_file, asked.goal, asked.start, asked.reach)


def _specs_of(design: str) -> tuple[Platform, Workload]:
    """Platform and workload of ``PLATFORM:WORKLOAD``."""
    platform, separator, workload = design.partition(":")
    if not separator:
        hint = "write PLATFORM:WORKLOAD, as in virtex4-pci:labyrinth"
        raise InputError(f"{design!r} is no design", "DESIGNS", hint)
    return codesign.load_platform(platform), codesign.load_workload(workload)


def _check_axes(axes: Iterable[str], loaded: Sequence[tuple[str, Platform, Workload]]) -> None:
    """Check that each axis of ``--set`` is one of any design."""
    for axis in axes:
        if not any(has_axis(platform, workload, axis) for _, platform, workload in loaded):
            hint = "write TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD, or workload.variant"
            raise InputError("none of the designs has this", f"--set {axis}", hint)


def _print(
    results: list[tuple[str, Result | CodesignError]], needs: tuple[Constraint, ...], detail: str, as_json: bool
) -> None:
    """The comparison, with ``TABLES`` the tables of each design; with ``SENTENCE`` a sentence for each design."""
    if as_json:
        click.echo(json.dumps({design: _as_json(result) for design, result in results}, indent=2))
        return
    if detail != SENTENCE:
        click.echo(render_text(comparison_table(results, needs)))
    for _, result in results:
        if isinstance(result, CodesignError):
            continue
        if detail != ANSWER:
            click.echo(answer(result, (), needs).sentence_text)
        if detail == TABLES:
            click.echo()
            for table in result_tables(result):
                click.echo(render_text(table))


def _result_or_error(
    platform: Platform, workload: Workload, problem: ProblemSpec | None, asked: Compare
) -> Result | CodesignError:
    """The result of a design on the given map or its own, or why it did not run. A mistake in --set is raised."""
    try:
        if asked.task is not None:
            problem = with_task(problem or problem_of(workload), asked.task)
        own = workload if problem is None else with_problem(workload, problem)
        return simulate(*applicable(platform, own, asked.settings), memory=asked.memory)
    except SpecError as error:
        if any(fault.file.startswith("--set") for fault in error.faults):
            raise
        return error if asked.map_file is None else at_options(error)
    except CodesignError as error:
        return error


def _report_failures(failures: Iterable[tuple[str, CodesignError]]) -> None:
    """Print each fault once with its place and remedy, which do not fit into the table."""
    for text, designs in map_reduce(failures, lambda each: str(each[1]), lambda each: each[0]).items():
        click.echo(f"{', '.join(map(printable, designs))} did not run: {text}", err=True)


def _as_json(result: Result | CodesignError) -> Any:
    if isinstance(result, CodesignError):
        return {"error": str(result)}
    return run_document(result).model_dump(mode="json")
