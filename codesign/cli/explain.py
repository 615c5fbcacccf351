"""``hwsw explain``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

import codesign
from codesign.cli.options import debug_step
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.request import TABLES
from codesign.cli.requests import Explain
from codesign.ground.errors import EXIT_NO, InputError, printable
from codesign.study import load_study
from codesign.views.report import explanation_sentence, explanation_tables, render_text

if TYPE_CHECKING:
    from codesign.ground.progress import Show
    from codesign.system.explanation import Explanation

_NUMBER = re.compile(r"[+-]?[0-9]+")


def explain(asked: Explain) -> None:
    """Say why a design takes its time and its energy, why it is out, what is better, and how sure that is."""
    debug_step("modules loaded")
    with progress_shown(after_s=LATER_S, quiet=asked.quiet) as show, compiling_shown(show):
        explain_it = _of_study if _NUMBER.fullmatch(asked.which) else _of_run
        explanation = explain_it(asked, asked.what, asked.which, show)
    debug_step("explained")
    if asked.as_json:
        click.echo(explanation.model_dump_json(indent=2))
    else:
        click.echo(explanation_sentence(explanation))
    if not asked.quiet:
        click.echo()
        for table in explanation_tables(explanation, everything=asked.detail == TABLES):
            click.echo(render_text(table))
    if not explanation.feasible:
        raise click.exceptions.Exit(EXIT_NO)


def _of_study(asked: Explain, store: str, index: str, show: Show) -> Explanation:
    if asked.settings:
        raise InputError("the axes of a design are those of the study", "--set", "leave it out")
    if not Path(store).is_file():
        raise InputError("no such file", store, "hwsw explore makes one")
    if len(index) > _DIGITS:
        raise InputError(f"there is no design {index[:_DIGITS]}...", hint="hwsw report STUDY -v lists them")
    study = load_study(store, show).at(asked.conditions)
    debug_step("study read")
    explanation = study.explain(int(index), show)
    _note(study.specs.note if study.specs is not None and explanation.out else "")
    return explanation


_DIGITS = 18


def _note(text: str) -> None:
    if text:
        click.echo(f"note: {printable(text)}", err=True)


def _of_run(asked: Explain, platform: str, workload: str, show: Show) -> Explanation:
    if Path(platform).is_file() and not platform.endswith((".yaml", ".yml")):
        what = f"{workload!r} is no index of a design"
        raise InputError(what, platform, "write a number, such as 0; hwsw report STUDY -v lists them")
    if asked.conditions:
        raise InputError("a run has no conditions", "--condition", "set the axis with --set AXIS=VALUE")
    return codesign.explain(platform, workload, asked.settings, show)
