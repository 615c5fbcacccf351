"""``hwsw advise``."""

from __future__ import annotations

import time

import click

from codesign.cli.options import command_line
from codesign.cli.outputs import check_outputs, check_replaceable
from codesign.cli.progress import compiling_shown, progress_shown
from codesign.cli.requests import Advise
from codesign.ground.errors import EXIT_NO, EXIT_OPEN, printable
from codesign.ground.progress import Advance, Pace
from codesign.inputs.files import shipped_maps
from codesign.study import advice
from codesign.views.report import advice_page, render_text
from codesign.views.report.advice_page import PathKeeper, advice_table


def advise(asked: Advise) -> None:
    """Answer which board suffices for a map at a rate, and why no cheaper one does."""
    motion = advice.parse_motion(asked.speed, asked.sight, asked.brake, asked.sensor, asked.delay)
    needs = advice.parse_needs(asked.rate, asked.power, asked.price, asked.clearance, motion)
    needs = advice.limited(
        needs,
        detour=asked.detour,
        needs_of_figures=asked.needs,
        share=asked.share,
        on=asked.on,
        planner=asked.planner,
        style=asked.style,
    )
    named = None if asked.boards is None else [name.strip() for name in asked.boards.split(",") if name.strip()]
    boards = advice.boards_of(named, asked.prices)
    section = advice.problem_section(
        asked.map_file,
        asked.goals,
        asked.starts,
        needs,
        task=asked.task,
        unknown=asked.unknown,
        resolution=asked.resolution,
        changed_cells=asked.change,
        reach=asked.reach,
    )
    question = advice.ask(needs, section, asked.map_file)
    if asked.write is not None:
        for path, kind in advice.files_of(asked.write, boards).items():
            check_replaceable("--write", path, kind)
    budget_s = advice.BUDGET_S if asked.budget is None else asked.budget
    outputs = {"--html": asked.page, "--certify": asked.certificate}
    check_outputs(outputs, (asked.map_file, asked.prices), kind="advise")
    keeper = PathKeeper()
    pace, begun = Pace(1), time.process_time()

    def progress(done: int, total: int) -> None:
        pace.total = total
        left = pace.left_s(done)
        rest = max(0.0, budget_s - (time.process_time() - begun))
        show(Advance(done, total, "boards searched", None if left is None else min(left, rest)))

    with progress_shown(after_s=_QUIET_SECONDS, quiet=asked.as_json) as show, compiling_shown(show):
        answer = advice.advise(
            question,
            boards,
            write=asked.write,
            certificate=asked.certificate,
            budget_s=budget_s,
            progress=progress,
            listeners=[] if asked.page is None else [keeper],
        )
    if asked.page is not None:
        advice_page(answer, question, asked.page, paths=keeper.paths, command=_command(asked))
    if asked.as_json:
        click.echo(answer.model_dump_json(indent=2))
    else:
        for sentence in (answer.question, answer.verdict, answer.driving):
            if sentence:
                click.echo(f"{printable(sentence, None)}.")
        click.echo(render_text(advice_table(answer)))
        if asked.write is not None:
            click.echo(f"files and commands: {printable(str(asked.write / advice.COMMANDS), None)}")
        if answer.command is not None:
            click.echo(f"the winner's run: {printable(answer.command, None)}")
        if asked.page is not None:
            click.echo(f"page: {printable(str(asked.page), None)}")
    if answer.proof.state == "not proved":
        raise click.exceptions.Exit(EXIT_OPEN)
    if answer.recommended is None:
        raise click.exceptions.Exit(EXIT_NO)


def _command(asked: Advise) -> str:
    """The command line, with a shipped map by its name, wherever this package lies."""
    names = {str(path): name for name, path in shipped_maps().items()}
    file = str(asked.map_file)
    return command_line().replace(file, names[file], 1) if file in names else command_line()


_QUIET_SECONDS = 3.0
"""A shorter search shows no progress."""
