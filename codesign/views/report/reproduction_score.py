"""The score of the model on the papers: rows within 1, 5 and 10 %, missed ones, and rows that cannot be held."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from codesign.planners.reproduction import Reproduction, Row, Use, short_name
from codesign.views.report.reproduction_tables import error_text, figure_of_row
from codesign.views.report.table import Cell, Table, left, right, word, words
from codesign.views.report.wording import ABSENT, count_cell, share_text

WITHIN = (0.01, 0.05, 0.10)
"""The errors that rows are counted by. A row beyond the last is missed."""

_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Score:
    """The rows of a paper, or of all, by how well the model meets them.

    ``within``: the number of rows within each error of ``WITHIN``; each counts those before it, too. ``missed``: rows
    with a larger error. ``unheld``: rows without an error. ``held_out``: rows with an error that no law was made from,
    and ``held_out_met``: the ones among them within the last error.
    """

    name: str
    rows: int
    within: tuple[int, ...]
    missed: int
    unheld: int
    held_out: int
    held_out_met: int

    @property
    def compared(self) -> int:
        """The rows that have an error."""
        return self.rows - self.unheld

    @property
    def parts(self) -> tuple[int, ...]:
        """The rows between one error and the next, those missed, and those that cannot be held: all rows once."""
        steps = zip(self.within, (0, *self.within), strict=False)
        return (*(count - before for count, before in steps), self.missed, self.unheld)


def score_of(name: str, rows: Iterable[Row]) -> Score:
    """The score of some rows."""
    all_rows = list(rows)
    errors = [(abs(row.error), row.use) for row in all_rows if row.error is not None]
    within = tuple(sum(_meets(error, most) for error, _ in errors) for most in WITHIN)
    held_out = [error for error, use in errors if use == Use.HELD_OUT]
    met = sum(_meets(error, WITHIN[-1]) for error in held_out)
    missed, unheld = len(errors) - within[-1], len(all_rows) - len(errors)
    return Score(name, len(all_rows), within, missed, unheld, len(held_out), met)


def _meets(error: float, most: float) -> bool:
    return error <= most * (1 + _TOLERANCE)


def scores(reproductions: Sequence[Reproduction]) -> list[Score]:
    """The score of each paper; of several papers, the score of all comes last."""
    each = [score_of(short_name(one.paper), one.rows) for one in reproductions]
    if len(each) < 2:
        return each
    return [*each, score_of("all papers", (row for one in reproductions for row in one.rows))]


def score_table(each: Sequence[Score]) -> Table:
    """A row for each score; the last of several, for all papers, stands out."""
    last = (f"within {share_text(most)}" for most in WITHIN)
    columns = (
        *left("paper"),
        *right("rows", "compared", *last, "missed", "cannot be held"),
        *right("held out, within 10 %"),
    )
    rows = tuple(
        (
            word(score.name),
            *map(count_cell, (score.rows, score.compared, *score.within, score.missed, score.unheld)),
            Cell(f"{score.held_out_met:,} of {score.held_out:,}", score.held_out_met),
        )
        for score in each
    )
    notes = (
        "Each column of errors counts those before it, too. Missed: by more than 10 %."
        " Held out: no law was made from the row, and nothing was chosen in view of it.",
    )
    strong = frozenset({len(rows) - 1} if len(rows) > 1 else ())
    return Table("Score", columns, rows, notes, strong)


def missed_table(reproductions: Sequence[Reproduction]) -> Table:
    """The rows that are missed, the worst first."""
    missed = [
        (abs(row.error), paper, row)
        for paper, row in _named(reproductions)
        if row.error is not None and not _meets(abs(row.error), WITHIN[-1])
    ]
    rows = tuple(
        (
            *words(paper, row.table, row.quantity),
            figure_of_row(row.published, row.unit),
            figure_of_row(row.modelled, row.unit),
            Cell(error_text(row.error or 0.0), row.error),
            *words(str(row.use), row.note),
        )
        for _, paper, row in sorted(missed, key=lambda each: -each[0])
    )
    columns = (*left("paper", "table", "quantity"), *right("published", "modelled", "error"), *left("use", "note"))
    return Table("Missed rows, worst first", columns, rows)


def unheld_table(reproductions: Sequence[Reproduction]) -> Table:
    """The rows that cannot be held against the model by a relative error, and why not."""
    rows = tuple(
        (
            *words(paper, row.table, row.quantity),
            figure_of_row(row.published, row.unit),
            figure_of_row(row.modelled, row.unit),
            *words(why_unheld(row), row.note),
        )
        for paper, row in _named(reproductions)
        if row.error is None
    )
    columns = (*left("paper", "table", "quantity"), *right("published", "modelled"), *left("why", "note"))
    return Table("Rows that cannot be held", columns, rows)


def why_unheld(row: Row) -> str:
    """The reason why a row has no error."""
    if row.published is None:
        return "the paper gives no figure"
    if isinstance(row.published, str):
        return "the paper gives words or a bound"
    if row.modelled is None:
        return "the model gives no figure"
    if isinstance(row.modelled, str):
        return "the model gives words or a bound"
    return "the paper gives 0, which no error is relative to" if not row.published else ABSENT


def _named(reproductions: Sequence[Reproduction]) -> Iterable[tuple[str, Row]]:
    return ((short_name(each.paper), row) for each in reproductions for row in each.rows)
