"""``hwsw compare``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from codesign.errors import InputError

DEFAULT = (
    "virtex4-pci:labyrinth",
    "virtex4-pci:wavefront-tiles",
    "virtex2pro:breadth-first",
    "pc-3400mhz:floor-plan",
)


@click.command(short_help="Hold designs, of any planner, against each other on one map.")
@click.argument("designs", nargs=-1, metavar="[PLATFORM:WORKLOAD]...")
@click.option(
    "--on", "like", metavar="WORKLOAD", help="Take map, goals and starts from this one.  [default: labyrinth]"
)
@click.option(
    "--map", "map_file", type=click.Path(dir_okay=False, path_type=Path), help="Take this map instead."
)
@click.option("--goal", metavar="ROW,COLUMN", help="Goal on --map.")
@click.option("--start", metavar="ROW,COLUMN", help="Start on --map.")
@click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Override wherever the axis exists."
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def compare(
    designs: tuple[str, ...],
    like: str | None,
    map_file: Path | None,
    goal: str | None,
    start: str | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> None:
    """Simulate each PLATFORM:WORKLOAD and print the figures side by side.

    All run on the same map: that of --on, or of --map with --goal and --start. Without designs, the shipped ones of
    harmonic control, wavefront, breadth-first search and relaxation on a host.
    """
    import codesign
    from codesign.cli.run import settings_of
    from codesign.report import comparison_table, render_text
    from codesign.system import applicable, problem_from_map, problem_of, with_problem

    if map_file is not None:
        if goal is None or start is None:
            raise InputError(
                "a map needs a goal and a start", "--map", "add --goal ROW,COLUMN --start ROW,COLUMN"
            )
        problem = problem_from_map(map_file, _cell("--goal", goal), _cell("--start", start))
    else:
        problem = problem_of(codesign.load_workload(like or "labyrinth"))
    values = settings_of(settings)
    results = []
    for design in designs or DEFAULT:
        platform_name, separator, workload_name = design.partition(":")
        if not separator:
            raise InputError(
                f"{design!r} is no design", "DESIGNS", "write PLATFORM:WORKLOAD, as in virtex4-pci:labyrinth"
            )
        point = (
            codesign.load_platform(platform_name),
            with_problem(codesign.load_workload(workload_name), problem),
        )
        results.append((design, codesign.simulate(*applicable(*point, values))))
    if as_json:
        click.echo(
            json.dumps({design: result.model_dump(mode="json") for design, result in results}, indent=2)
        )
        return
    click.echo(render_text(comparison_table(results)))


def _cell(option: str, text: str) -> tuple[int, int]:
    row, _, column = text.partition(",")
    try:
        return int(row), int(column)
    except ValueError:
        raise InputError(f"{text!r} is no cell", option, "write ROW,COLUMN, as in 3,128") from None
