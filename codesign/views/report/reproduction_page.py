"""The self-contained page of a reproduction: led by its score, then plots, what is missed, and each paper."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from more_itertools import map_reduce

from codesign.ground.units import counted
from codesign.planners.reproduction import Reproduction, Row, Use, joined, short_name
from codesign.system import PlannerFacts
from codesign.system.inspect import Parameter
from codesign.system.results.result import Provenance
from codesign.views.report.page import rendered, write_page
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Table,
    count_cell,
    left,
    quantity_cell,
    right,
    share_text,
    word,
    words,
    yes_cell,
)

if TYPE_CHECKING:
    from codesign.views.report.canvas import Picture

# Published against modelled, row by row.


def reproduction_table(reproduction: Reproduction) -> Table:
    """All rows in the order given, under the names that JSON has, with the relative error; notes come last.

    ``use``: whether a law was fitted to the row, or it was held out, or known when something was chosen.
    """
    rows = []
    previous = None
    for row in reproduction.rows:
        place = Cell("" if row.table == previous else row.table, row.table)
        previous = row.table
        rows.append((place, *_held(row), _error_cell(row), *words(str(row.status), str(row.use), row.note)))
    figures = (*right("published", "modelled"), *right("error", unit="1"))
    columns = (*left("table", "quantity"), *figures, *left("status", "use", "note"))
    return Table("Published against modelled", columns, tuple(rows))


def reproduction_csv(reproductions: Sequence[Reproduction]) -> Table:
    """The rows of all papers as raw values: ``paper``, then the fields of ``Row``; the unit is a column of its own.

    The last columns are the version and the date.
    """
    made = Provenance().stamped().constants
    rows = ((each.paper, *astuple(row), *made.values()) for each in reproductions for row in each.rows)
    names = ("paper", *(field.name for field in fields(Row)), *made)
    return Table(
        "Published against modelled", left(*names), tuple(tuple(Cell("", value) for value in row) for row in rows)
    )


def findings_table(reproduction: Reproduction) -> Table:
    """Each statement, whether it holds in the run, and the figures that it rests on, a row for each."""
    rows = []
    for finding in reproduction.findings:
        first = (word(finding.statement), yes_cell(finding.holds))
        later = tuple(Cell("", cell.value) for cell in first)
        for index, texts in enumerate(finding.figures.items() or [("", "")]):
            rows.append((*(later if index else first), *words(*texts)))
    return Table("Findings", left("statement", "holds", "figure", "measured"), tuple(rows))


def joined_findings_table(reproduction: Reproduction) -> Table:
    """The findings in a row each, with the figures that they rest on in one cell."""
    rows = (
        (
            word(finding.statement),
            yes_cell(finding.holds),
            word("; ".join(f"{name}: {value}" for name, value in finding.figures.items())),
        )
        for finding in reproduction.findings
    )
    return Table("Findings", left("statement", "holds", "figures"), tuple(rows))


def reproduction_sources_table(reproduction: Reproduction) -> Table:
    """Each source once, with the tables, figures and sections of the paper that rest on it."""
    tables = map_reduce(
        reproduction.rows, lambda row: (str(row.status), row.source), lambda row: row.table, dict.fromkeys
    )
    return Table(
        "Where the modelled figures come from",
        left("status", "tables", "source"),
        tuple(words(status, ", ".join(named), source) for (status, source), named in tables.items()),
    )


def _held(row: Row) -> tuple[Cell, Cell, Cell]:
    """The quantity of a row, published and modelled."""
    return word(row.quantity), figure_of_row(row.published, row.unit), figure_of_row(row.modelled, row.unit)


def _error_cell(row: Row) -> Cell:
    return Cell(ABSENT if row.error is None else error_text(row.error), row.error)


def error_text(error: float) -> str:
    """A relative error as signed percent.

    >>> error_text(0.0), error_text(-0.0123), error_text(1.5)
    ('0 %', '-1.2 %', '+150 %')
    """
    if error == 0:
        return "0 %"
    percent = 100 * error
    if abs(percent) < 0.001:
        return "<0.001 %"
    return f"{percent:+.0f} %" if abs(percent) >= 10 else f"{percent:+.2g} %"


def figure_of_row(value: float | str | None, unit: str) -> Cell:
    """A figure of a row: a number with its unit, or words."""
    return word(value) if isinstance(value, str) else quantity_cell(value, unit)


# What a planner can be given, as tables.


def settings_table(settings: Sequence[Parameter]) -> Table:
    """The settings of the papers' runs that ``hwsw reproduce --set`` moves."""
    rows = tuple(words(each.task, each.name, each.accepted, each.meaning) for each in settings)
    return Table("Settings of the papers' runs", left("planner", "setting", "accepted", "meaning"), rows)


def planner_tables(facts: PlannerFacts) -> tuple[Table, ...]:
    """The parameters of a planner's tasks, its styles, and its policies for planning again."""
    parameters = [(each.task, each.name, each.accepted, each.default, each.meaning) for each in facts.parameters]
    policies = [(policy, "" if number else "default") for number, policy in enumerate(facts.policies)]
    tables = (
        Table(
            "Parameters: in a workload mapping.TASK.PARAMETER, with --set TASK.PARAMETER",
            left("task", "parameter", "accepted", "default", "meaning"),
            tuple(words(*row) for row in parameters),
        ),
        Table("Styles", left("style", "what it is"), tuple(words(*row) for row in facts.styles.items())),
        Table("Policies for planning again", left("policy", ""), tuple(words(*row) for row in policies)),
    )
    return tuple(table for table in tables if table.rows)


# How well the model meets the papers: rows within 1, 5 and 10 %, missed ones, and those that cannot be held.

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
    counts = right("rows", "compared", *last, "missed", "cannot be held", "held out, within 10 %")
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
    return Table("Score", (*left("paper"), *counts), rows, notes, strong)


def missed_table(reproductions: Sequence[Reproduction]) -> Table:
    """The rows that are missed, the worst first."""
    missed = [
        (abs(row.error), paper, row)
        for paper, row in _named(reproductions)
        if row.error is not None and not _meets(abs(row.error), WITHIN[-1])
    ]
    rows = tuple(
        (*words(paper, row.table), *_held(row), _error_cell(row), *words(str(row.use), row.note))
        for _, paper, row in sorted(missed, key=lambda each: -each[0])
    )
    columns = (*left("paper", "table", "quantity"), *right("published", "modelled", "error"), *left("use", "note"))
    return Table("Missed rows, worst first", columns, rows)


def unheld_table(reproductions: Sequence[Reproduction]) -> Table:
    """The rows that cannot be held against the model by a relative error, and why not."""
    rows = tuple(
        (*words(paper, row.table), *_held(row), *words(why_unheld(row), row.note))
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


# The plots of a reproduction page as places: published against computed, and the errors of each paper.

KINDS = 6
"""Papers that have a colour and a shape of their own; further ones begin again with the first."""

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SIDE, _LEFT, _BOTTOM, _MARGIN = 400.0, 46.0, 34.0, 8.0
_ERRORS = (-1.0, -0.1, -0.01, 0.0, 0.01, 0.1, 1.0)
_MOST_ERROR = 4.0
_SMALLEST = 0.001
"""Errors below it stand at 0; from there on the axis is logarithmic to either side."""


@dataclass(frozen=True)
class Mark:
    """A row as a mark: its place, the number of its colour and shape, and what it says."""

    x: float
    y: float
    kind: int
    text: str


@dataclass(frozen=True)
class Against:
    """Published against computed on logarithmic axes, in a square of ``side``.

    ``ticks``: (place, text), of both axes alike; ``band``: the corners of what is within 10 %, as points of SVG.
    ``frame``: left, top, right and bottom of the axes.
    """

    side: float
    frame: tuple[float, float, float, float]
    ticks: tuple[tuple[float, float, str], ...]
    band: str
    marks: tuple[Mark, ...]
    papers: tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Strip:
    """The errors of a paper: marks with ``x`` in percent of the width, ``y`` in pixels from the top."""

    name: str
    summary: str
    height: float
    marks: tuple[Mark, ...]


def against(reproductions: Sequence[Reproduction]) -> Against | None:
    """All rows with two numbers above 0; None without any. Each number is in the unit of its row."""
    rows = [
        (number, row, float(row.published), float(row.modelled))
        for number, each in enumerate(reproductions)
        for row in each.rows
        if isinstance(row.published, int | float)
        and isinstance(row.modelled, int | float)
        and 0 < row.published < math.inf
        and 0 < row.modelled < math.inf
    ]
    if not rows:
        return None
    values = [value for _, _, *pair in rows for value in pair]
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)
    frame = (_LEFT, _MARGIN, _SIDE - _MARGIN, _SIDE - _BOTTOM)

    def across(value: float) -> float:
        return round(frame[0] + (frame[2] - frame[0]) * (math.log10(value) - low) / (high - low), 2)

    def up(value: float) -> float:
        return round(frame[3] - (frame[3] - frame[1]) * (math.log10(value) - low) / (high - low), 2)

    step = math.ceil((high - low) / 6)
    ticks = tuple((across(10.0**power), up(10.0**power), _power(power)) for power in range(low, high + 1, step))
    ends = 10.0**low, 10.0**high
    corners = [(ends[0], 0.9), (ends[0], 1.1), (ends[1], 1.1), (ends[1], 0.9)]
    band = " ".join(f"{across(value)},{up(value * share)}" for value, share in corners)
    marks = tuple(
        Mark(across(published), up(modelled), number % KINDS, _said(reproductions[number], row))
        for number, row, published, modelled in rows
    )
    papers = tuple((number % KINDS, short_name(each.paper)) for number, each in enumerate(reproductions))
    return Against(_SIDE, frame, ticks, band, marks, papers)


def _power(power: int) -> str:
    return f"{10.0**power:,g}" if -2 <= power <= 3 else f"10{str(power).translate(_RAISED)}"


def _said(reproduction: Reproduction, row: Row) -> str:
    published, modelled = (figure_of_row(value, row.unit).text for value in (row.published, row.modelled))
    error = "" if row.error is None else f", {error_text(row.error)}"
    place = f"{short_name(reproduction.paper)}, {row.table}"
    return f"{place}: {row.quantity}: published {published}, modelled {modelled}{error}"


def strips(reproductions: Sequence[Reproduction]) -> tuple[Strip, ...]:
    """The errors of each paper that has any, side by side on one axis."""
    each = (_strip(number, one) for number, one in enumerate(reproductions))
    return tuple(strip for strip in each if strip.marks)


def error_ticks() -> tuple[tuple[float, str], ...]:
    """The ticks of the axis of errors: place in percent, and text."""
    return tuple((_place(error), error_text(error).replace(".0", "")) for error in _ERRORS)


def _strip(number: int, reproduction: Reproduction) -> Strip:
    rows = [row for row in reproduction.rows if row.error is not None and math.isfinite(row.error)]
    stacked = list(_stacked(rows))
    deepest = max((level for _, _, level in stacked), default=0)
    score = score_of("", reproduction.rows)
    summary = f"{score.within[-1]} of {score.compared} within 10 %, {score.within[0]} within 1 %"
    kind = number % KINDS
    marks = tuple(Mark(place, 8.0 + 9.0 * level, kind, _said(reproduction, row)) for place, row, level in stacked)
    return Strip(short_name(reproduction.paper), summary, 16.0 + 9.0 * deepest, marks)


def _stacked(rows: Iterable[Row]) -> Iterable[tuple[float, Row, int]]:
    """Each row with its place, and the level at which it hides no row before it."""
    taken: list[float] = []
    for row in sorted(rows, key=lambda row: row.error or 0.0):
        place = _place(row.error or 0.0)
        level = next((level for level, end in enumerate(taken) if place - end >= 1.6), len(taken))
        taken[level : level + 1] = [place]
        yield place, row, level


def _place(error: float) -> float:
    """Percent of the width: logarithmic from ``_SMALLEST`` on, to either side of 0."""
    least, most = (_bent(end) for end in (_ERRORS[0], _MOST_ERROR))
    share = (_bent(error) - least) / (most - least)
    return round(2 + 96 * min(max(share, 0.0), 1.0), 2)


def _bent(error: float) -> float:
    return math.copysign(math.log10(1 + abs(error) / _SMALLEST), error)


_FATES = (
    *((f"met-{number}", f"within {share_text(most)}") for number, most in enumerate(WITHIN, 1)),
    *(("missed", "missed"), ("unheld", "cannot be held")),
)
"""The parts of a bar of the score: class and words."""

Pictures = Mapping[str, Sequence["Picture"]]
"""The figures of each paper, drawn again, by the name of the paper."""


def reproduction_page(
    reproductions: Sequence[Reproduction],
    path: Path,
    *,
    pictures: Pictures | None = None,
    command: str = "hwsw reproduce",
) -> None:
    """Write the page of papers held against the model: score, plots, missed rows, findings, rows, sources.

    Raises:
        RunError: the file cannot be written. ValueError: there is no reproduction.
    """
    write_page(path, reproduction_html(reproductions, pictures=pictures, command=command))


def reproduction_html(
    reproductions: Sequence[Reproduction], *, pictures: Pictures | None = None, command: str = "hwsw reproduce"
) -> str:
    """The page of ``reproduction_page`` as text."""
    whole, each = joined(reproductions), scores(reproductions)
    total = each[-1]
    counts = list(zip(total.within, (words for _, words in _FATES), strict=False))
    return rendered(
        "reproduction.html.j2",
        None,
        title="Published against modelled",
        compared=f"{counted(total.rows, 'row')} of {counted(len(reproductions), 'paper')};"
        f" {total.compared:,} have figures on both sides. Their relative errors:",
        counts=[*counts, (total.missed, "missed"), (total.unheld, "cannot be held")],
        score=score_table(each),
        bars=[(score.name, _bar(score)) for score in each if score.rows],
        fates=_FATES,
        against=against(reproductions),
        strips=strips(reproductions),
        error_ticks=error_ticks(),
        missed=missed_table(reproductions),
        unheld=unheld_table(reproductions),
        papers=[_paper(one, (pictures or {}).get(one.paper, ())) for one in reproductions],
        sources=reproduction_sources_table(whole),
        command=command,
    )


def _bar(score: Score) -> list[tuple[str, str, int, float]]:
    """The parts of a bar: class, words, number of rows, percent of the width."""
    parts = zip(_FATES, score.parts, strict=True)
    return [(kind, words, count, 100 * count / score.rows) for (kind, words), count in parts]


@dataclass(frozen=True)
class _Paper:
    """The part of the page for one paper."""

    name: str
    note: str
    findings: Table | None
    rows: Table
    pictures: Sequence[Picture]


def _paper(reproduction: Reproduction, pictures: Sequence[Picture]) -> _Paper:
    moved = reproduction.settings and f"not as published: {reproduction.settings}"
    note = "; ".join(filter(None, (moved, reproduction.note)))
    findings = joined_findings_table(reproduction) if reproduction.findings else None
    return _Paper(reproduction.paper, note, findings, reproduction_table(reproduction), pictures)
