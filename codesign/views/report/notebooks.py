"""The HTML of a study, a result, a comparison, a reproduction or a table in a notebook: small, escaped, bounded."""

from __future__ import annotations

from base64 import b64encode
from functools import singledispatch
from html import escape

from codesign.ground.errors import clip
from codesign.ground.units import format_count
from codesign.planners.reproduction import Reproduction
from codesign.study import Study
from codesign.system.results.result import Result
from codesign.views.report.canvas import Picture, picture_bytes
from codesign.views.report.render import printable
from codesign.views.report.reproduction_page import findings_table
from codesign.views.report.result_tables import result_reasons_table
from codesign.views.report.sentences import answer
from codesign.views.report.study_tables import front_table, reasons_table, study_sentence
from codesign.views.report.wording import Table, pairs

MOST_ROWS, MOST_COLUMNS = 20, 24
"""A notebook shows no more rows and columns of a table than these; a note says how many are left out."""

_MOST_LETTERS = 400


@singledispatch
def notebook_html(shown: object) -> str:
    """The HTML of an object. Every text in it is escaped, and cut where it is long."""
    return f"<pre>{_escaped(repr(shown))}</pre>"


@notebook_html.register
def table_html(table: Table) -> str:
    """The first rows and columns of a table, with its title, and its notes below."""
    columns = table.columns[:MOST_COLUMNS]
    head = "".join(f"<th{_aligned(column.align)}>{_escaped(column.name)}</th>" for column in columns)
    lines = [f"<p><b>{_escaped(table.title)}</b></p>", f"<table><thead><tr>{head}</tr></thead><tbody>"]
    for number, row in enumerate(table.rows[:MOST_ROWS]):
        marks = ("<b>", "</b>") if number in table.strong else ("", "")
        cells = (
            f"<td{_aligned(column.align)}>{_escaped(cell.text).join(marks)}</td>"
            for column, cell in zip(columns, row, strict=False)
        )
        lines.append(f"<tr>{''.join(cells)}</tr>")
    lines.append("</tbody></table>")
    lines += [f"<p><small>{_escaped(note)}</small></p>" for note in (*_left_out(table), *table.notes[:MOST_ROWS])]
    return "\n".join(lines)


def _left_out(table: Table) -> list[str]:
    """The numbers of rows and columns that are not shown, if any."""
    sizes = (("rows", len(table.rows), MOST_ROWS), ("columns", len(table.columns), MOST_COLUMNS))
    return [f"the first {most} of {format_count(count)} {name}" for name, count, most in sizes if count > most]


def _aligned(align: str) -> str:
    return f' style="text-align:{align}"'


def _escaped(text: str) -> str:
    return escape(printable(clip(text, _MOST_LETTERS)))


@notebook_html.register
def _(study: Study) -> str:
    table = front_table(study, MOST_ROWS) if study.front else reasons_table(study)
    more = len(study.front) - MOST_ROWS
    note = f"<p><small>{format_count(more)} more designs are on the front</small></p>" if more > 0 else ""
    return f"<p>{_escaped(study_sentence(study))}</p>\n{table_html(table)}{note}"


@notebook_html.register
def _(result: Result) -> str:
    lead = answer(result, (), ())
    why = table_html(result_reasons_table(result)) if result.reasons else ""
    figures = table_html(pairs("Figures", lead.figures, lead.notes))
    return f"<p>{_escaped(lead.sentence_text)}</p>\n{figures}{why}"


@notebook_html.register
def _(reproduction: Reproduction) -> str:
    head = f"{reproduction.paper}: {format_count(len(reproduction.rows))} rows"
    return f"<p>{_escaped(head)}</p>\n{table_html(findings_table(reproduction))}"


@notebook_html.register
def _(picture: Picture) -> str:
    # A notebook may have no room for PDF, and SVG in it could carry a script.
    assert picture.figure is not None, "drawn here"
    data = b64encode(picture_bytes(picture.figure, "png")).decode()
    return f'<img alt="{_escaped(picture.alt)}" src="data:image/png;base64,{data}">'
