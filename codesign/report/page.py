"""One self-contained HTML page for a study, a result or a reproduction.

Data flows in through templates that escape everything; what is put in as it is comes from this package and
from Bokeh. The page's content security policy forbids every request: what a reader sees is in the file.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.files import write_atomically
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.planners.reproduction import Reproduction
from codesign.progress import Show, doing, silent
from codesign.report.aggregated import condition_text, rules_text, spread_table
from codesign.report.axes import fixed_axes
from codesign.report.chart import MOST_POINTS, bokeh_script, chart_data, chart_figures, chart_plots
from codesign.report.explain_tables import effects_table
from codesign.report.reproduction_tables import findings_table, reproduction_sources_table, reproduction_table
from codesign.report.result_tables import figure_tables, result_reasons_table, sources_table
from codesign.report.search_tables import search_picture, search_table
from codesign.report.sentences import headline, run_pace_text
from codesign.report.sourced import sourced_results
from codesign.report.study_tables import (
    best_table,
    front_table,
    nearest_table,
    reasons_table,
    study_counts,
    summary,
)
from codesign.report.table import Table
from codesign.report.timelines import account_picture
from codesign.report.winners_table import winners_table
from codesign.report.wording import ABSENT, ENDED, PACE
from codesign.results.provenance import Provenance
from codesign.results.result import Result

if TYPE_CHECKING:
    from codesign.exploration import Study
    from codesign.report.canvas import Picture

_INVISIBLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Controls but tab and newline, marks that turn the direction of writing, halves of surrogate pairs."""

MOST_CONDITIONS = 24
"""A page shows no more conditions by themselves than this."""

_NARROW_COLUMNS, _NARROW_LETTERS = 4, 68
"""Tables of at most so many columns, whose headings and numbers need at most so many letters, stand side by side."""


_PAGE_S_A_POINT = 80e-6
"""Measured: 8 s for the page of 104,000 points."""


def study_page(
    study: Study,
    path: Path,
    *,
    pictures: Sequence[Picture] = (),
    command: str | None = None,
    show: Show = silent,
) -> None:
    """Write the page of a study: front to look into, tables, reasons, sources, and how to make it again.

    ``pictures`` stand below the plot. ``command``: the line that made the study; by default it is made of its names.
    ``show`` is told what is done.

    Raises:
        RunError: the file cannot be written.
    """
    _write(path, study_html(study, pictures=pictures, command=command, show=show))


def _platform_word(study: Study) -> str:
    return "" if PLATFORM_AXIS in study.axes else f"{study.platform} "


def study_html(
    study: Study, *, pictures: Sequence[Picture] = (), command: str | None = None, show: Show = silent
) -> str:
    """The page of ``study_page`` as text."""
    doing(show, "making the page", _PAGE_S_A_POINT * len(study.points))
    feasible = bool(study.feasible)
    return _rendered(
        "study.html.j2",
        study.provenance,
        effects=effects_table(study.sensitivity(), study.objectives),
        title=f"{study.workload} on {study.platform}",
        counts=study_counts(study),
        fixed=fixed_axes(study),
        feasible=feasible,
        summary=summary(study) if study.conditions else "",
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
        data=_script_json({"views": _views(study)}),
        plots=_script_json(chart_plots(study)) if feasible else None,
        bokeh=bokeh_script() if feasible else None,
        script=_text("study.js"),
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


def _views(study: Study) -> list[dict[str, Any]]:
    """What plot and table of points may show: all conditions together, and each of the first ones by itself."""
    if not study.conditions:
        return [{"name": "", **chart_data(study)}]
    conditions = study.world.each[:MOST_CONDITIONS]
    most = MOST_POINTS // (len(conditions) + 1)
    together = {"name": f"all, {rules_text(study)}", **chart_data(study, most)}
    return [
        together,
        *(
            {"name": condition_text(study, number), **chart_data(study.at(condition), most)}
            for number, condition in enumerate(conditions)
        ),
    ]


def result_page(
    result: Result, path: Path, *, pictures: Sequence[Picture] = (), command: str | None = None
) -> None:
    """Write the page of one result: its costs, the quality of the plan, the sources of the figures.

    Raises:
        RunError: the file cannot be written.
    """
    _write(path, result_html(result, pictures=pictures, command=command))


def result_html(result: Result, *, pictures: Sequence[Picture] = (), command: str | None = None) -> str:
    """The page of ``result_page`` as text."""
    tables = [_without_head(table) for table in figure_tables(result)]
    mission, fleet = result.mission, result.fleet
    account = None if mission is None else account_picture(mission.account)
    return _rendered(
        "result.html.j2",
        result.provenance,
        title=f"{result.workload} on {result.platform}",
        headline=headline(result),
        ended=next((run.ended for run in (mission, fleet) if run is not None), ""),
        bottleneck=run_pace_text(result),
        reasons=result_reasons_table(result) if result.reasons else None,
        narrow=[table for table in tables if _is_narrow(table)],
        wide=[table for table in tables if not _is_narrow(table)],
        sources=sources_table([result]),
        pictures=(*pictures, *([account] if account else [])),
        command=command or f"hwsw run {result.platform} {result.workload} --html report.html",
    )


def reproduction_page(
    reproduction: Reproduction, path: Path, *, pictures: Sequence[Picture] = (), command: str | None = None
) -> None:
    """Write the page of a reproduction: rows, findings, plots, sources.

    Raises:
        RunError: the file cannot be written.
    """
    _write(path, reproduction_html(reproduction, pictures=pictures, command=command))


def reproduction_html(
    reproduction: Reproduction, *, pictures: Sequence[Picture] = (), command: str | None = None
) -> str:
    """The page of ``reproduction_page`` as text."""
    return _rendered(
        "reproduction.html.j2",
        None,
        title="Published against modelled",
        rows=reproduction_table(reproduction),
        findings=findings_table(reproduction) if reproduction.findings else None,
        note="; ".join(
            filter(
                None,
                (reproduction.settings and f"not as published: {reproduction.settings}", reproduction.note),
            )
        ),
        sources=reproduction_sources_table(reproduction),
        pictures=pictures,
        command=command or "hwsw reproduce harmonic --html report.html",
    )


def _without_head(table: Table) -> Table:
    """The table less the rows that stand in the head of the page."""
    if not any(row and row[0].text in (ENDED, PACE) for row in table.rows):
        return table
    return replace(table, rows=tuple(row for row in table.rows if row[0].text not in (ENDED, PACE)))


def _is_narrow(table: Table) -> bool:
    """Whether half of the page is wide enough. Of two columns the second is words, which may be wrapped."""
    if len(table.columns) > _NARROW_COLUMNS:
        return False
    if len(table.columns) <= 2:
        return True
    texts = zip(*([cell.text for cell in row] for row in table.rows), strict=True)
    widths = (max(map(len, column)) for column in texts)
    columns = zip(table.columns, widths, strict=False)
    return sum(max(len(column.name), width) for column, width in columns) <= _NARROW_LETTERS


def _rendered(template: str, provenance: Provenance | None, **values: Any) -> str:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("codesign.report"),
        autoescape=True,
        finalize=_visible,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(style=_text("style.css"), data_address=_data_address, absent=ABSENT)
    return environment.get_template(template).render(footer=footer_text(provenance), **values)


def footer_text(provenance: Provenance | None) -> str:
    """What made a page, in a line; of a page without specs, version and date."""
    stamped = (provenance or Provenance()).stamped()
    names = {"codesign": "hwsw", "workload_digest": "workload", "map_digest": "map"}
    platforms = [f"platform {name} {digest[:12]}" for name, digest in stamped.platform_digests.items()]
    parts = [
        f"{names.get(key, key)} {text[:12] if key.endswith('digest') else text}"
        for key, text in stamped.constants.items()
    ]
    return "; ".join((parts[0], *platforms, *parts[1:]))


def _visible(value: Any) -> Any:
    """Text with characters that no page may hold, or that would hide or turn what follows, written as escapes.

    What is safe by its type is our own and stays as it is.
    """
    if isinstance(value, str) and not hasattr(value, "__html__"):
        return _INVISIBLE.sub(lambda match: ascii(match[0])[1:-1], value)
    return value


def _text(name: str) -> str:
    return (resources.files("codesign.report") / "templates" / name).read_text(encoding="utf-8")


def _script_json(value: Mapping[str, Any]) -> str:
    """JSON that may stand in a script element: nothing in it can end the element or open a comment."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _data_address(picture: Picture) -> str:
    kind = "svg+xml" if picture.format == "svg" else "png"
    return f"data:image/{kind};base64,{base64.b64encode(picture.data).decode()}"


def _write(path: Path, page: str) -> None:
    write_atomically(path, page.encode("utf-8", "replace"))
