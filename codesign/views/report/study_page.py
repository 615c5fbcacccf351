"""The self-contained page of a study: its points to look into, its tables, its reasons and its sources."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from codesign.ground.progress import Show, doing, silent
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.views.report.aggregated import condition_text, spread_table
from codesign.views.report.axes import fixed_axes
from codesign.views.report.chart import MOST_CONDITIONS, chart_data, chart_figures, offered_figures
from codesign.views.report.effects_matrix import effects_matrix
from codesign.views.report.explain_tables import effects_table
from codesign.views.report.page import rendered, script_json, template_text, write_page
from codesign.views.report.result_tables import sources_table
from codesign.views.report.search_tables import search_picture, search_table
from codesign.views.report.sourced import sourced_results
from codesign.views.report.study_answer import study_sentence
from codesign.views.report.study_tables import best_table, front_table, nearest_table, reasons_table, study_counts
from codesign.views.report.table import Table
from codesign.views.report.winners_table import winners_table

if TYPE_CHECKING:
    from codesign.study import Study
    from codesign.views.report.canvas import Picture

_PAGE_S_A_POINT = 80e-6
"""Measured: 8 s for the page of 104,000 points."""

_SCRIPTS = (
    *("numbers.js", "columns.js"),
    *(f"study/{name}.js" for name in ("data", "state", "points", "scatter", "panel", "filters", "table", "page")),
)
_PLOTTER = "vendor/uPlot.iife.min.js", "vendor/uPlot.min.css"
"""uPlot 1.6.32 (MIT, the licence beside it): axes, ticks and zoom of the plots."""


def study_page(
    study: Study, path: Path, *, pictures: Sequence[Picture] = (), command: str | None = None, show: Show = silent
) -> None:
    """Write the page of a study: points to look into, tables, reasons, sources, and how to make it again.

    ``pictures`` stand below the plot. ``command``: the line that made the study; by default it is made of its names.
    ``show`` is told what is done.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, study_html(study, pictures=pictures, command=command, show=show))


def _platform_word(study: Study) -> str:
    return "" if PLATFORM_AXIS in study.axes else f"{study.platform} "


def study_html(
    study: Study, *, pictures: Sequence[Picture] = (), command: str | None = None, show: Show = silent
) -> str:
    """The page of ``study_page`` as text."""
    doing(show, "making the page", _PAGE_S_A_POINT * len(study.points))
    feasible = bool(study.feasible)
    figures = offered_figures(study)
    effects = study.sensitivity(*figures)
    first = {figure.name for figure in study.objectives}
    return rendered(
        "study.html.j2",
        study.provenance,
        effects=effects_table([each for each in effects if each.figure in first], study.objectives),
        matrix=effects_matrix(study, figures, effects),
        title=f"{study.workload} on {study.platform}",
        counts=study_counts(study),
        fixed=fixed_axes(study),
        feasible=feasible,
        answer=study_sentence(study),
        front=front_table(study),
        spread=spread_table(study) if study.conditions and feasible else None,
        fronts=_fronts_by_condition(study),
        more_conditions=max(0, len(study.world.each) - MOST_CONDITIONS),
        best=best_table(study),
        winners=winners_table(study),
        reasons=reasons_table(study),
        nearest=nearest_table(study),
        sources=sources_table(sourced_results(study)),
        figures=[figure.name for figure in chart_figures(study)],
        data=script_json(chart_data(study, figures)),
        plotter=template_text(_PLOTTER[0]),
        plotter_style=template_text(_PLOTTER[1]),
        page_style=template_text("study/study.css"),
        script="\n".join(template_text(name) for name in _SCRIPTS),
        searched=search_table(study),
        pictures=(*pictures, *([curves] if (curves := search_picture(study)) else [])),
        command=command or f"hwsw explore {_platform_word(study)}{study.workload} --html report.html",
    )


def _fronts_by_condition(study: Study) -> list[tuple[str, Table]]:
    """The front of each condition by itself, of the first conditions."""
    if not study.conditions:
        return []
    return [
        (condition_text(study, number), front_table(study.at(condition)))
        for number, condition in enumerate(study.world.each[:MOST_CONDITIONS])
    ]
