"""One self-contained HTML page for a result, and what every page shares.

Data flows in through templates that escape everything; what is put in as it is comes from this package, or from a
library that is kept in it with its licence. The page's content security policy forbids every request: what a reader
sees is in the file.
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
from codesign.report.result_tables import figure_tables, result_reasons_table, sources_table
from codesign.report.sentences import headline, run_pace_text
from codesign.report.table import Table
from codesign.report.timelines import account_picture
from codesign.report.wording import ABSENT, ENDED, PACE
from codesign.results.provenance import Provenance
from codesign.results.result import Result

if TYPE_CHECKING:
    from codesign.report.canvas import Picture

_INVISIBLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Controls but tab and newline, marks that turn the direction of writing, halves of surrogate pairs."""

_NARROW_COLUMNS, _NARROW_LETTERS = 4, 68
"""Tables of at most so many columns, whose headings and numbers need at most so many letters, stand side by side."""


def result_page(
    result: Result, path: Path, *, pictures: Sequence[Picture] = (), command: str | None = None
) -> None:
    """Write the page of one result: its costs, the quality of the plan, the sources of the figures.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, result_html(result, pictures=pictures, command=command))


def result_html(result: Result, *, pictures: Sequence[Picture] = (), command: str | None = None) -> str:
    """The page of ``result_page`` as text."""
    tables = [_without_head(table) for table in figure_tables(result)]
    mission, fleet = result.mission, result.fleet
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
        pictures=(*pictures, *([account] if account else [])),
        command=command or f"hwsw run {result.platform} {result.workload} --html report.html",
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


def rendered(template: str, provenance: Provenance | None, **values: Any) -> str:
    """The page that a template makes of values. What is no page of its own is escaped."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("codesign.report"),
        autoescape=True,
        finalize=_visible,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(
        style=template_text("style.css"),
        shared=template_text("shared.js"),
        data_address=_data_address,
        absent=ABSENT,
    )
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


def template_text(name: str) -> str:
    """A file beside the templates: a style, a script."""
    return (resources.files("codesign.report") / "templates" / name).read_text(encoding="utf-8")


def script_json(value: Mapping[str, Any]) -> str:
    """JSON that may stand in a script element: nothing in it can end the element or open a comment."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _data_address(picture: Picture) -> str:
    kind = "svg+xml" if picture.format == "svg" else "png"
    return f"data:image/{kind};base64,{base64.b64encode(picture.data).decode()}"


def write_page(path: Path, page: str) -> None:
    """Write a page whole, or not at all.

    Raises:
        RunError: the file cannot be written.
    """
    write_atomically(path, page.encode("utf-8", "replace"))
