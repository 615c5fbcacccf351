"""The answer of an exploration: one sentence, then the tables in reading order."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from codesign.ground.errors import CodesignError
from codesign.ground.figures import label
from codesign.ground.progress import Show, doing, silent
from codesign.study.groups import Groups
from codesign.system.results.result import Result
from codesign.views.report.axes import aggregated_cell, aim_text, kind_of_row, spread_table
from codesign.views.report.explain_tables import effects_table
from codesign.views.report.render import printable
from codesign.views.report.result_tables import sources_table
from codesign.views.report.sentences import winners_certainty_table
from codesign.views.report.study_tables import (
    best_design,
    best_table,
    front_table,
    infeasible_table,
    nearest_table,
    reasons_table,
    search_table,
    study_table,
    summary,
    why_out,
)
from codesign.views.report.winners_table import winners_table
from codesign.views.report.wording import Table

if TYPE_CHECKING:
    from codesign.study import Study

# The results of a study whose figures have all of its sources.


def sourced_results(study: Study) -> Iterator[Result]:
    """Results that have every source of the figures of a study, in the order of the points.

    Points that were priced differ in clock and power. Their sources follow from the laws of a style and from the part,
    so one point of each kind is simulated; where its files are missing, it is left out.
    """
    outcomes = study.outcomes
    kinds = set()
    for first in Groups.of(outcomes.which).in_turn.firsts.tolist():
        number = int(outcomes.which[first])
        if number < 0:
            continue
        template = outcomes.templates[number]
        yield template
        kind = (
            *(template.platform, template.planner, template.style, template.component, template.part),
            *(template.feasible, *sorted(template.places.items())),
        )
        if number not in outcomes.whole and kind not in kinds:
            kinds.add(kind)
            try:
                result = study.result(first)
            except CodesignError:
                continue
            assert result is not None, "it has a template"
            yield result


def study_sentence(study: Study) -> str:
    """The sentence of a study: what was explored, how many points have each fate, and the best of the first objective.

    If no point is feasible: the point that misses feasibility by least, and by what.
    """
    head = f"{study.workload} on {study.platform}, {summary(study)}"
    if not study.objectives:
        return printable(f"{head}.")
    best, nearest, kind = best_design(study, study.objectives[0]), study.nearest(), kind_of_row(study)
    end = ""
    if best is not None:
        value = aggregated_cell(study, best, study.objectives[0], spread=True).text
        end = f"; {aim_text(study, study.objectives[0])}: {value}, {kind} {best.index}"
    elif lack := _lack(study):
        end = f"; no {kind} has {label(lack)}"
    elif nearest:
        design = study.designs[nearest[0]]
        end = f"; nearest to feasible: {kind} {design.index}, {why_out(study, design)}"
    return printable(f"{head}{end}.")


def _lack(study: Study) -> str:
    """The first objective, and why, where feasible designs have none; "" where none is feasible."""
    first = study.objectives[0].name
    lacks = (reason.name for reason in study.reasons if reason.kind == "no figure")
    return next((name for name in lacks if name.partition(": ")[0] == first), "")


def study_tables(study: Study, *, everything: bool = False, show: Show = silent) -> tuple[Table, ...]:
    """The front, or the points nearest to feasible; how sure the best points are; winners and reasons.

    ``everything``: also the best points, every point, the reasons of each, and the sources of the figures.
    ``show`` is told how far it is.
    """
    doing(show, "finding the front, and how sure it is")
    tables = [front_table(study) if study.feasible else nearest_table(study)]
    if study.feasible and study.conditions:
        tables += [best_table(study), *([spread_table(study)] if study.world.draws is not None else [])]
    tables += filter(None, [search_table(study), winners_certainty_table(study)])
    doing(show, "comparing designs value by value")
    tables += filter(None, [winners_table(study), reasons_table(study)])
    if everything:
        doing(show, "finding what each axis moves")
        effects = effects_table(study.sensitivity(), study.objectives)
        tables += [best_table(study), effects, study_table(study, show), infeasible_table(study, show)]
        tables.append(sources_table(sourced_results(study)))
    return tuple(table for table in tables if table.rows)
