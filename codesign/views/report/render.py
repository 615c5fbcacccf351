"""A table as text, Markdown or CSV.

What a user wrote (names of maps, platforms, components) may stand in any cell, so each form defuses it: no
markup and no control characters reach a terminal, no markup a Markdown viewer, no formula a spreadsheet.
"""

from __future__ import annotations

import csv
import io
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codesign.ground.files import is_stream, write_atomically, written_atomically
from codesign.ground.late import late
from codesign.ground.progress import Show, silent, tracked
from codesign.views.report.wording import Column, Table

if TYPE_CHECKING:
    from rich import console as rich_console
    from rich import text as rich_text
    from rich.segment import Segment
else:
    rich_console = late("rich.console")
    rich_text = late("rich.text")

box = late("rich.box")
rich_measure = late("rich.measure")
rich_table = late("rich.table")
rich_cells = late("rich.cells")

_WIDTH_OF_FILES = 160
_MOST = 10_000
_BETWEEN = 3
"""Spaces between two columns."""
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_MARKDOWN = re.compile(r"([\\`*\[\]|#~])")


def render_text(table: Table, width: int | None = None, *, styled: bool | None = None, show: Show = silent) -> str:
    """The table as lines of text.

    ``width``: columns of the terminal; None takes the width of the terminal on standard output, 160 if there is
    none. No number and no word is ever cut: a table that needs more room takes it. ``styled``: bold headings
    and rows by escape codes; None: only on a terminal. ``show`` is told how far it is.
    """

    class First(rich_text.Text):
        """The first cell of a row: it counts the row when it is laid out."""

        def __rich_console__(
            self, console: rich_console.Console, options: rich_console.ConsoleOptions
        ) -> Iterable[Segment]:
            next(laid_out, None)
            return super().__rich_console__(console, options)

    terminal = rich_console.Console(file=sys.stdout)
    on_terminal = terminal.is_terminal and not terminal.is_dumb_terminal
    if styled is None:
        styled = on_terminal
    if width is None:
        width = terminal.width if on_terminal else _WIDTH_OF_FILES
    shown = rich_table.Table(box=box.SIMPLE_HEAD, pad_edge=False, header_style="bold", show_edge=False)
    texts = [[printable(cell.text) for cell in row] for row in table.rows]
    for column, chars in zip(table.columns, _widths(table, texts, width), strict=True):
        shown.add_column(rich_text.Text(printable(column.name)), justify=column.align, overflow="fold", width=chars)
    laid_out = tracked(table.rows, show, f"rows of the table {table.title}", len(table.rows))
    for number, (first, *others) in enumerate(texts):
        style = "bold" if number in table.strong else ""
        shown.add_row(First(first), *map(rich_text.Text, others), style=style)
    out = io.StringIO()
    console = rich_console.Console(
        file=out,
        width=max(width, rich_measure.Measurement.get(terminal, terminal.options.update(width=_MOST), shown).minimum),
        force_terminal=styled,
        color_system="standard" if styled else None,
        legacy_windows=False,
    )
    console.print(rich_text.Text(printable(table.title), style="bold underline"))
    console.print(shown)
    for note in table.notes:
        console.print(rich_text.Text(printable(note), style="italic"))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"


def _widths(table: Table, texts: Sequence[Sequence[str]], width: int) -> list[int]:
    """The width of each column: what its longest word takes, and of what is left, what its text takes.

    A number stands in one line. Long texts share what is left, so that none is wider than another that is folded.
    """
    least, most = [], []
    for number, column in enumerate(table.columns):
        heading, cells = printable(column.name), [row[number] for row in texts]
        whole = cells if column.align == "right" else [word for cell in cells for word in cell.split()]
        least.append(max(map(rich_cells.cell_len, (*heading.split(), *whole)), default=0))
        most.append(max(map(rich_cells.cell_len, (heading, *cells))))
    room = width - _BETWEEN * (len(least) - 1)
    taken = least
    while True:
        narrow = [place for place, high in enumerate(most) if taken[place] < high]
        narrow = [place for place in narrow if taken[place] == min(taken[each] for each in narrow)]
        # The last ones may not all get one more.
        narrow = narrow[: max(0, room - sum(taken))]
        if not narrow:
            return taken
        taken = [chars + (place in narrow) for place, chars in enumerate(taken)]


def render_markdown(table: Table) -> str:
    """The table in GitHub's Markdown, title and notes with it."""
    rule = ("---:" if column.align == "right" else "---" for column in table.columns)
    lines = [
        f"**{_markdown(table.title)}**",
        "",
        _line(_markdown(column.name) for column in table.columns),
        _line(rule),
        *(_line(_markdown(cell.text) for cell in row) for row in table.rows),
    ]
    for note in table.notes:
        lines += ["", _markdown(note)]
    return "\n".join(lines) + "\n"


def render_csv(table: Table, *, headed: bool = True) -> str:
    """The values (not the texts) of the table as CSV, units in the heading; an absent value is empty.

    A text that a spreadsheet would take for a formula gets an apostrophe in front.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    if headed:
        writer.writerow([_harmless(_heading(column)) for column in table.columns])
    for row in table.rows:
        writer.writerow([_value(cell.value) for cell in row])
    return out.getvalue()


def write_csv(table: Table | Iterable[Table], path: Path) -> None:
    """Write the table, or the rows of several tables with the same columns, as CSV in UTF-8, whole or not at all.

    Raises:
        RunError: the file cannot be written.
    """
    tables = [table] if isinstance(table, Table) else table
    parts = (render_csv(each, headed=number == 0).encode() for number, each in enumerate(tables))
    write_atomically(path, b"".join(parts))


def write_columns_csv(blocks: Iterable[Mapping[str, Sequence[Any]]], path: Path) -> None:
    """Write blocks of columns as CSV like ``render_csv``, one block after another: no more than one is held.

    Raises:
        RunError: the file cannot be written.
    """

    def parts() -> Iterator[bytes]:
        for number, columns in enumerate(blocks):
            out = io.StringIO()
            writer = csv.writer(out, lineterminator="\n")
            if number == 0:
                writer.writerow(map(_harmless, columns))
            writer.writerows(zip(*(map(_value, column) for column in columns.values()), strict=True))
            yield out.getvalue().encode()

    if is_stream(path):
        write_atomically(path, b"".join(parts()))
        return
    with written_atomically(path) as target, target.open("wb") as file:
        file.writelines(parts())


def printable(text: str) -> str:
    r"""The text with control characters (escape codes, line breaks, writing direction) shown, not obeyed.

    >>> printable("a\x1b[31mb")
    'a\\x1b[31mb'
    """
    return _CONTROL.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _markdown(text: str) -> str:
    marked = _MARKDOWN.sub(r"\\\1", printable(text))
    return marked.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _heading(column: Column) -> str:
    return f"{column.name} [{column.unit}]" if column.unit not in {"", "1"} else column.name


def _value(value: str | int | float | None) -> str | int | float:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return _harmless(value) if isinstance(value, str) else value


def _harmless(text: str) -> str:
    shown = printable(text)
    return f"'{shown}" if text.startswith(_FORMULA) else shown
