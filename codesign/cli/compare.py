"""``hwsw compare``."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import (
    ANSWER,
    REACH,
    SENTENCE,
    TABLES,
    cell_of,
    command_line,
    debug_step,
    force_option,
    memory_option,
    need_option,
    output_options,
    settings_of,
)
from codesign.errors import EXIT_FAILED, EXIT_NO, CodesignError, InputError, SpecError, printable

if TYPE_CHECKING:
    from codesign.inputs import Constraint, Platform, Workload
    from codesign.inputs.problem import ProblemSpec
    from codesign.results.result import Result

DEFAULT = (
    "virtex4-pci:labyrinth",
    "virtex4-pci:wavefront-tiles",
    "virtex2pro:breadth-first",
    "pc-3400mhz:floor-plan",
)


@click.command(short_help="Compare designs of any planner on one map.")
@click.argument("designs", nargs=-1, metavar="[PLATFORM:WORKLOAD]...")
@click.option(
    "--on",
    "like",
    metavar="WORKLOAD",
    help="Use the map, goals and starts of this workload in every design.  [default: of each design its own;"
    " labyrinth without designs]",
)
@click.option(
    "--map",
    "map_file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Use this map in every design.",
)
@click.option("--goal", metavar="ROW,COLUMN", help="The goal on --map.")
@click.option("--start", metavar="ROW,COLUMN", help="The start on --map.")
@click.option("--reach", type=click.FloatRange(0, 1), metavar="SHARE", help=REACH)
@click.option(
    "--task",
    type=click.Choice(["path", "field", "replan"]),
    help="What is asked of every design.  [default: that of the workload; path on --map]",
)
@click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Set an axis, in every design that has it."
)
@need_option
@memory_option
@output_options(
    "Print a sentence for each design alone.", "Print all tables of each design after the comparison."
)
@click.option("--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page.")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
@force_option
def compare(
    designs: tuple[str, ...],
    like: str | None,
    map_file: Path | None,
    goal: str | None,
    start: str | None,
    reach: float | None,
    task: str | None,
    settings: tuple[str, ...],
    needs: tuple[str, ...],
    memory: int | None,
    detail: str,
    page: Path | None,
    as_json: bool,
) -> None:
    """Simulate each PLATFORM:WORKLOAD and print the figures side by side.

    Each design plans on the map of its own workload. With --on, or --map with --goal and --start, all designs are asked
    the same on one map. By default the shipped designs of harmonic control, wavefront, breadth-first search and
    relaxation on a host are compared on the labyrinth. Where a design cannot use the map, its column says why, and the
    others still run.

    The exit code is 3 where no design is feasible, or none meets every --need, and 1 where none could run.
    """
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
    from codesign.exploration.constraints import with_constraints
    from codesign.inputs.constraint import needs_of
    from codesign.inputs.workload import figures_of
    from codesign.progress import tracked
    from codesign.report import comparison_page
    from codesign.results.result import Result

    problem = _problem(like if designs else like or "labyrinth", map_file, goal, start, reach)
    values = settings_of(settings)
    loaded = [(design, *_specs_of(design)) for design in designs or DEFAULT]
    _check_page(page, [like, map_file, *(name for design in designs for name in design.split(":", 1))])
    limits = needs_of(needs, figures=figures_of(*(workload for _, _, workload in loaded)))
    _check_axes(values, loaded)
    debug_step("files read and checked")
    with progress_shown(after_s=LATER_S, quiet=as_json or detail == SENTENCE) as show, compiling_shown(show):
        results: list[tuple[str, Result | CodesignError]] = [
            (
                design,
                _result_or_error(platform, workload, problem, task, values, map_file is not None, memory),
            )
            for design, platform, workload in tracked(loaded, show, "designs simulated", len(loaded))
        ]
    results = [
        (design, with_constraints(result, limits) if isinstance(result, Result) else result)
        for design, result in results
    ]
    debug_step("simulated")
    if page is not None:
        comparison_page(results, page, needs=limits, command=command_line())
    _print(results, limits, detail, as_json)
    if page is not None and not as_json and detail != SENTENCE:
        click.echo(f"page: {printable(str(page), None)}")
    _report_failures([(design, result) for design, result in results if isinstance(result, CodesignError)])
    if all(isinstance(result, CodesignError) for _, result in results):
        raise click.exceptions.Exit(EXIT_FAILED)
    if not any(isinstance(result, Result) and result.feasible for _, result in results):
        raise click.exceptions.Exit(EXIT_NO)


def _problem(
    like: str | None, map_file: Path | None, goal: str | None, start: str | None, reach: float | None
) -> ProblemSpec | None:
    """The problem that all designs are given: of a workload, or of a map with its goal and start; None: their own."""
    import codesign
    from codesign.system import problem_from_map, problem_of

    if map_file is None:
        return None if like is None else problem_of(codesign.load_workload(like))
    if goal is None or start is None:
        raise InputError(
            "a map needs a goal and a start", "--map", "add --goal ROW,COLUMN --start ROW,COLUMN"
        )
    return problem_from_map(map_file, cell_of("--goal", goal), cell_of("--start", start), reach)


def _specs_of(design: str) -> tuple[Platform, Workload]:
    """Platform and workload of ``PLATFORM:WORKLOAD``."""
    import codesign

    platform, separator, workload = design.partition(":")
    if not separator:
        hint = "write PLATFORM:WORKLOAD, as in virtex4-pci:labyrinth"
        raise InputError(f"{design!r} is no design", "DESIGNS", hint)
    return codesign.load_platform(platform), codesign.load_workload(workload)


def _check_axes(axes: Iterable[str], loaded: Sequence[tuple[str, Platform, Workload]]) -> None:
    """Check that each axis of ``--set`` is one of any design."""
    from codesign.inputs import has_axis

    for axis in axes:
        if not any(has_axis(platform, workload, axis) for _, platform, workload in loaded):
            raise InputError(
                "none of the designs has this",
                f"--set {axis}",
                "write TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD, or workload.variant",
            )


def _check_page(page: Path | None, inputs: Iterable[str | Path | None]) -> None:
    """Check before any work that the page can be written, and overwrites no input."""
    from codesign.cli.outputs import check_outputs

    check_outputs({"--html": page}, inputs)


def _print(
    results: list[tuple[str, Result | CodesignError]],
    needs: tuple[Constraint, ...],
    detail: str,
    as_json: bool,
) -> None:
    """The comparison, with ``TABLES`` those of each design; with ``SENTENCE`` a sentence for each design."""
    from codesign.report import answer, comparison_table, render_text, result_tables

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
    platform: Platform,
    workload: Workload,
    problem: ProblemSpec | None,
    task: str | None,
    values: dict[str, object],
    from_options: bool,
    memory: int | None,
) -> Result | CodesignError:
    """The result of a design on the given map or its own, or why it did not run. A mistake in --set is raised."""
    from codesign import simulate
    from codesign.system import applicable, problem_of, with_problem
    from codesign.system.inspect import at_options, with_task

    try:
        if task is not None:
            problem = with_task(problem or problem_of(workload), task)
        own = workload if problem is None else with_problem(workload, problem)
        return simulate(*applicable(platform, own, values), memory=memory)
    except SpecError as error:
        if any(fault.file.startswith("--set") for fault in error.faults):
            raise
        return at_options(error) if from_options else error
    except CodesignError as error:
        return error


def _report_failures(failures: Iterable[tuple[str, CodesignError]]) -> None:
    """Print each fault once with its place and remedy, which do not fit into the table."""
    designs: dict[str, list[str]] = {}
    for design, failure in failures:
        designs.setdefault(str(failure), []).append(printable(design))
    for text, names in designs.items():
        click.echo(f"{', '.join(names)} did not run: {text}", err=True)


def _as_json(result: Result | CodesignError) -> Any:
    from codesign.verdicts import run_document

    if isinstance(result, CodesignError):
        return {"error": str(result)}
    return run_document(result).model_dump(mode="json")
