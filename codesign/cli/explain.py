"""``hwsw explain``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import SENTENCE, TABLES, debug_step, output_options, settings_of
from codesign.errors import EXIT_NO, InputError, printable

if TYPE_CHECKING:
    from codesign.explanation import Explanation
    from codesign.progress import Show

_NUMBER = re.compile(r"[+-]?[0-9]+")


@click.command(short_help="Say why a design of a study, or a run, is as it is.")
@click.argument("what", metavar="STUDY|PLATFORM")
@click.argument("which", metavar="INDEX|WORKLOAD")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="AXIS=VALUE",
    help="Of a run: set an axis, e.g. fabric.clock=50MHz.",
)
@click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="AXIS=VALUE",
    help="Of a study: in one condition, by its value, or by its number in the list, from 0.",
)
@output_options("Print the sentence alone.", "Print all parts, levers and neighbours.")
@click.option("--json", "as_json", is_flag=True, help="Print the explanation as JSON.")
def explain(
    what: str,
    which: str,
    settings: tuple[str, ...],
    conditions: tuple[str, ...],
    detail: str,
    as_json: bool,
) -> None:
    """Say why a design takes its time and its energy, why it is out, what is better, and how sure that is.

    With a file of hwsw explore and the INDEX of a design: the design among its neighbours. With PLATFORM and WORKLOAD:
    the run, and what it is with each lever and each next value. Each lever is run by itself, for the whole design.

    The exit code is 3 where the design is not feasible.
    """
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
    from codesign.report import explanation_sentence, explanation_tables, render_text

    debug_step("modules loaded")
    quiet = as_json or detail == SENTENCE
    with progress_shown(after_s=LATER_S, quiet=quiet) as show, compiling_shown(show):
        explanation = (
            _of_study(what, which, settings, conditions, show)
            if _NUMBER.fullmatch(which)
            else _of_run(what, which, settings, conditions, show)
        )
    debug_step("explained")
    if as_json:
        click.echo(explanation.model_dump_json(indent=2))
    else:
        click.echo(explanation_sentence(explanation))
    if not as_json and detail != SENTENCE:
        click.echo()
        for table in explanation_tables(explanation, everything=detail == TABLES):
            click.echo(render_text(table))
    if not explanation.feasible:
        raise click.exceptions.Exit(EXIT_NO)


def _of_study(
    store: str, index: str, settings: tuple[str, ...], conditions: tuple[str, ...], show: Show
) -> Explanation:
    from codesign.exploration import load_study

    if settings:
        raise InputError("the axes of a design are those of the study", "--set", "leave it out")
    if not Path(store).is_file():
        raise InputError("no such file", store, "hwsw explore makes one")
    chosen = settings_of(conditions, "--condition")
    if len(index) > _DIGITS:
        raise InputError(f"there is no design {index[:_DIGITS]}...", hint="hwsw report STUDY -v lists them")
    study = load_study(store, show).at(chosen)
    debug_step("study read")
    explanation = study.explain(int(index), show)
    _note(study.specs.note if study.specs is not None and explanation.out else "")
    return explanation


_DIGITS = 18


def _note(text: str) -> None:
    if text:
        click.echo(f"note: {printable(text)}", err=True)


def _of_run(
    platform: str, workload: str, settings: tuple[str, ...], conditions: tuple[str, ...], show: Show
) -> Explanation:
    import codesign

    if Path(platform).is_file() and not platform.endswith((".yaml", ".yml")):
        what = f"{workload!r} is no index of a design"
        raise InputError(what, platform, "write a number, such as 0; hwsw report STUDY -v lists them")
    if conditions:
        raise InputError("a run has no conditions", "--condition", "set the axis with --set AXIS=VALUE")
    return codesign.explain(platform, workload, settings_of(settings), show)
