"""The self-contained page of one result: its figures, its pictures, and its course over time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from codesign.ground.records import Record
from codesign.system.results.result import Result
from codesign.views.report.canvas import with_palette
from codesign.views.report.page import rendered, write_page
from codesign.views.report.result_tables import figure_tables, result_reasons_table, sources_table
from codesign.views.report.scrub import scrub_of
from codesign.views.report.scrub_page import scrub_part
from codesign.views.report.sentences import headline, run_pace_text
from codesign.views.report.table import Table
from codesign.views.report.timelines import account_picture
from codesign.views.report.wording import ENDED, PACE

if TYPE_CHECKING:
    from codesign.views.report.canvas import Picture

_NARROW_COLUMNS, _NARROW_LETTERS = 4, 68
"""Tables of at most so many columns, whose headings and numbers need at most so many letters, stand side by side."""


def result_page(
    result: Result,
    path: Path,
    *,
    pictures: Sequence[Picture] = (),
    records: Iterable[Record] = (),
    command: str | None = None,
) -> None:
    """Write the page of one result: its costs, the quality of the plan, the sources of the figures.

    ``records``: of the run, in memory or of a trace. A page with them shows the run over time.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, result_html(result, pictures=pictures, records=records, command=command))


def result_html(
    result: Result, *, pictures: Sequence[Picture] = (), records: Iterable[Record] = (), command: str | None = None
) -> str:
    """The page of ``result_page`` as text."""
    tables = [_without_head(table) for table in figure_tables(result)]
    mission, fleet = result.mission, result.fleet
    scrub = scrub_of(records)
    account = None if mission is None else account_picture(mission.account)
    return rendered(
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
        scrub=None if scrub is None else scrub_part(scrub),
        pictures=(*pictures, *([with_palette(account)] if account else [])),
        command=command or f"hwsw run {result.platform} {result.workload} --html report.html",
    )


def records_page(
    records: Iterable[Record], path: Path, *, title: str, pictures: Sequence[Picture] = (), command: str
) -> None:
    """Write the page of a run of which the records alone are there, such as those of a cut trace.

    Raises:
        RunError: the file cannot be written.
    """
    scrub = scrub_of(records)
    page = rendered(
        "result.html.j2",
        None,
        title=title,
        headline=(),
        ended="",
        bottleneck="",
        reasons=None,
        narrow=(),
        wide=(),
        sources=sources_table([]),
        pictures=pictures,
        scrub=None if scrub is None else scrub_part(scrub),
        command=command,
    )
    write_page(path, page)


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
