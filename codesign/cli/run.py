"""``hwsw run``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from codesign.errors import EXIT_INFEASIBLE, InputError, printable


@click.command(short_help="Simulate one design point.")
@click.argument("platform")
@click.argument("workload")
@click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Override, e.g. workload.variant=NAME"
)
@click.option(
    "--trace", "trace_file", type=click.Path(dir_okay=False, path_type=Path), help="Write an MCAP trace."
)
@click.option("--html", "page", type=click.Path(dir_okay=False, path_type=Path), help="Write an HTML page.")
@click.option(
    "--granularity",
    type=click.Choice(["run_ahead", "visit"]),
    default="run_ahead",
    show_default=True,
    help="How far a component computes at a time; the result is the same.",
)
@click.option(
    "--levers/--no-levers",
    default=True,
    show_default=True,
    help="Run a mission again with each of its levers moved, to find what sets the pace.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def run(
    platform: str,
    workload: str,
    settings: tuple[str, ...],
    trace_file: Path | None,
    page: Path | None,
    granularity: str,
    levers: bool,
    as_json: bool,
) -> None:
    """Simulate WORKLOAD on PLATFORM (names or YAML files) and print what it costs and what the plan is worth.

    Exit code 3 where the design does not fit. A mission that ends without its goal is a result: 0, and it says why.
    """
    import codesign
    from codesign.cli.again import command_line
    from codesign.cli.outputs import check_outputs
    from codesign.report import render_text, result_page, result_tables, run_pictures
    from codesign.system import point_of
    from codesign.trace import MemoryListener

    values = settings_of(settings)
    workload_spec = codesign.load_workload(workload)
    check_outputs(
        {"--trace": trace_file, "--html": page},
        (platform, workload, workload_spec.map_file),
        plain=["--trace"],
    )
    point = point_of(codesign.load_platform(platform), workload_spec, values)
    memory = MemoryListener()
    with _levers_shown() as progress:
        result = codesign.simulate(
            *point,
            granularity=granularity,
            trace=trace_file,
            listeners=() if page is None else (memory,),
            levers=levers,
            progress=progress,
        )
    if page is not None:
        result_page(result, page, pictures=run_pictures(memory.records), command=command_line())
    if as_json:
        click.echo(result.model_dump_json(indent=2))
    else:
        for table in result_tables(result):
            click.echo(render_text(table))
        for name, path, written in (("trace", trace_file, result.feasible), ("page", page, True)):
            if path is not None and written:
                click.echo(f"{name}: {printable(str(path), None)}")
    if not result.feasible:
        raise click.exceptions.Exit(EXIT_INFEASIBLE)


@contextmanager
def _levers_shown() -> Iterator[Callable[[int, int, str], None] | None]:
    """A callback for progress: a bar on a terminal, None elsewhere."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("the design itself", total=None)

        def show(done: int, total: int, path: str) -> None:
            bar.update(task, total=total, completed=done, description=f"lever {path}" if path else "levers")

        yield show


def settings_of(texts: Iterable[str]) -> dict[str, object]:
    """The raw value of each axis that ``--set`` names; none may be named twice.

    Raises:
        InputError: a text is no setting, or an axis comes twice.
    """
    values: dict[str, object] = {}
    for axis, value in map(setting, texts):
        if axis in values:
            raise InputError(f"{axis} is set twice", "--set", "keep one of the two")
        values[axis] = value
    return values


def setting(text: str) -> tuple[str, object]:
    """An axis and its raw value from ``AXIS=VALUE``."""
    from codesign.spec import parse_value

    axis, separator, value = text.partition("=")
    if not separator or not axis:
        raise InputError(
            f"{text!r} is no setting", "--set", "write AXIS=VALUE, as in --set relax.iterations=16"
        )
    return axis, parse_value(value, f"--set {axis}")
