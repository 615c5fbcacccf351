"""``hwsw advise``."""

from __future__ import annotations

import time
from pathlib import Path

import click

from codesign.cli.options import REACH, MapFile, force_option
from codesign.errors import EXIT_NO, printable


@click.command(short_help="Which board suffices for a map, at a rate?")
@click.argument("map_file", metavar="MAP", type=MapFile(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--goal", "goals", multiple=True, required=True, metavar="PLACE", help="A goal, such as 12.5,3.0."
)
@click.option("--rate", required=True, metavar="RATE", help="Plans a second, such as 10Hz.")
@click.option("--boards", metavar="NAME,...", help="Boards to ask about: names or files.  [default: all]")
@click.option("--power", metavar="POWER", help="Most mean power at that rate, such as 5W.")
@click.option("--price", metavar="PRICE", help="Most that a board may cost, such as 200USD.")
@click.option("--clearance", metavar="LENGTH", help="Distance to keep from obstacles, such as 0.3m.")
@click.option("--start", "starts", multiple=True, metavar="PLACE", help="A start.  [default: 64 are drawn]")
@click.option(
    "--task",
    type=click.Choice(["path", "field", "replan"]),
    default="path",
    show_default=True,
    help="What is asked of a plan.",
)
@click.option(
    "--change",
    type=click.IntRange(min=1),
    default=20,
    show_default=True,
    metavar="COUNT",
    help="Cells that change before a plan of task replan, drawn.",
)
@click.option("--reach", type=click.FloatRange(0, 1), metavar="SHARE", help=REACH)
@click.option("--unknown", type=click.Choice(["blocked", "free"]), help="What unknown cells count as.")
@click.option("--resolution", metavar="LENGTH", help="Size of a cell, for a map that does not say it.")
@click.option(
    "--budget",
    type=click.FloatRange(min=0),
    metavar="SECONDS",
    help="Computing time after which no further design is begun.  [default: 45]",
)
@click.option(
    "--write",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="FOLDER",
    help="Write the workload of the winner into this folder.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
@force_option
def advise(
    map_file: Path,
    goals: tuple[str, ...],
    rate: str,
    boards: str | None,
    power: str | None,
    price: str | None,
    clearance: str | None,
    starts: tuple[str, ...],
    task: str,
    change: int,
    reach: float | None,
    unknown: str | None,
    resolution: str | None,
    budget: float | None,
    write: Path | None,
    as_json: bool,
) -> None:
    """Answer which board suffices to plan on MAP at a rate, whether a cheaper one does, and why the next one does not.

    MAP is a file, or a shipped map such as house.

    Every planner, style and placement is searched on every board. A PLACE is ROW,COLUMN in whole numbers, or X,Y in
    metres of the map's frame, as 12.5,3.0 or 12m,3m. The exit code is 3 where no board suffices.
    """
    from codesign import advice
    from codesign.cli.progress import compiling_shown, progress_shown
    from codesign.cli.replacing import check_replaceable
    from codesign.progress import Advance, Pace
    from codesign.report import render_text
    from codesign.report.advice_tables import advice_table

    needs = advice.parse_needs(rate, power, price, clearance)
    named = None if boards is None else [name.strip() for name in boards.split(",") if name.strip()]
    asked = advice.boards_of(named)
    section = advice.problem_section(
        map_file,
        goals,
        starts,
        needs,
        task=task,
        unknown=unknown,
        resolution=resolution,
        changed_cells=change,
        reach=reach,
    )
    question = advice.ask(needs, section, map_file)
    if write is not None:
        for board in asked:
            check_replaceable("--write", advice.design_file(write, board))
    budget_s = advice.BUDGET_S if budget is None else budget
    pace, begun = Pace(1), time.process_time()

    def progress(done: int, total: int) -> None:
        pace.total = total
        left = pace.left_s(done)
        rest = max(0.0, budget_s - (time.process_time() - begun))
        show(Advance(done, total, "chains of designs searched", None if left is None else min(left, rest)))

    with progress_shown(after_s=_QUIET_SECONDS, quiet=as_json) as show, compiling_shown(show):
        answer = advice.advise(
            question,
            asked,
            write=write,
            budget_s=budget_s,
            progress=progress,
        )
    if as_json:
        click.echo(answer.model_dump_json(indent=2))
    else:
        click.echo(f"{printable(answer.verdict, None)}.")
        click.echo(render_text(advice_table(answer)))
        if answer.command is not None:
            click.echo(f"the winner's run: {printable(answer.command, None)}")
    if answer.recommended is None:
        raise click.exceptions.Exit(EXIT_NO)


_QUIET_SECONDS = 3.0
"""A shorter search shows no progress."""
