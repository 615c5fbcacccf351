"""The self-contained page of a comparison: who is best and how sure, bars with intervals, and each design by itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from textwrap import wrap

from codesign.ground.errors import CodesignError, SpecError
from codesign.ground.figures import FIGURES, ResultFigure, label
from codesign.ground.units import counted
from codesign.inputs.constraint import Constraint, limit_text
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.interface import Quality
from codesign.system.results.result import Provenance, Result
from codesign.system.verdicts import constraint_verdict
from codesign.views.report.page import rendered, write_page
from codesign.views.report.result_tables import SHORTEST, figure_tables, result_reasons_table, sources_table
from codesign.views.report.sentences import (
    Winner,
    answer,
    arrivals_of,
    arrived_cell,
    asked_notes,
    headline,
    measure_text,
    need_text,
    questions_of,
    reach_notes,
    reason_text,
    sure_cell,
    winner_of,
    winner_text,
)
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Column,
    Table,
    figure_cell,
    left,
    right,
    wants_logarithm,
    word,
    words,
    yes_cell,
)

# Several results side by side, as a table.

_WIDTH_OF_REASON = 28
_PART = "part"


Designs = Sequence[tuple[str, Result | CodesignError]]
"""Named results, or the error that kept a design from running."""


def comparison_table(designs: Designs, needs: Sequence[Constraint] = ()) -> Table:
    """Named results side by side, or the fault of a design that has none; and which of the needs each meets.

    Figures are given also as multiples of the figures of the first design with a plan.
    """
    results = results_of(designs)
    sides = side_by_side(designs)
    at = next(number for number, row in enumerate(sides.rows) if row[0].text == _PART)
    texts: list[tuple[Cell, ...]] = []
    if not all(result and result.feasible for result in results):
        texts += _wrapped_rows("why infeasible", [_why_not(result) for _, result in designs])
    for need in needs:
        verdicts = (need_text(constraint_verdict(result, need)) if result else ABSENT for result in results)
        texts += _wrapped_rows(f"need {limit_text(need)}", list(verdicts))
    notes = [winner_text(winner) for winner in winners(designs)]
    return replace(sides, rows=(*sides.rows[:at], *texts, *sides.rows[at:]), notes=(*sides.notes, *notes))


def side_by_side(designs: Designs) -> Table:
    """The figures of named results side by side, without reasons, needs and winners."""
    results = results_of(designs)
    base = next((number for number, result in enumerate(results) if result and _has_plan(result)), None)
    rows: list[tuple[Cell, ...]] = [
        (word("feasible"), *(yes_cell(result.feasible) if result else Cell("not run") for result in results)),
        *((word(name), *cells) for name, cells in _arrivals_rows(results)),
        (word(_PART), *(word((result and result.part) or ABSENT) for result in results)),
    ]
    asked = asked_notes(results)
    notes = [] if base is None else [f"in brackets: as a multiple of {designs[base][0]}"]
    left_out = figures_left_out(results)
    for figure in FIGURES.values():
        # The row of arrivals counts the starts already.
        if figure.name in (*left_out, "arrive"):
            continue
        values = [result.figure(figure) if result else None for result in results]
        if any(value is not None for value in values):
            rows.append((word(figure.label), *_against(base, figure, results)))
            notes += [SHORTEST] if figure.name == "path_length_ratio_mean" else []
    notes += reach_notes(results)
    if left_out:
        figures = ", ".join(label(name) for name in left_out)
        notes.append(f"left out: {figures}, as not every plan covers every cell; --task field compares them")
    notes += [f"{name}: {warning}" for name, result in designs for warning in _warnings(result)]
    columns = (*left("figure"), *(Column(name, align="right") for name, _ in designs))
    return Table(", ".join(("Comparison", *asked)), columns, tuple(rows), tuple(notes))


def results_of(designs: Designs) -> list[Result | None]:
    """The result of each design; None where it did not run."""
    return [result if isinstance(result, Result) else None for _, result in designs]


def winners(designs: Designs) -> list[Winner]:
    """The best design by each of the first figures, where designs differ in it; none where they were asked different
    questions.
    """
    names, results = [name for name, _ in designs], results_of(designs)
    if len(questions_of(results)) > 1:
        return []
    each = (winner_of(names, results, figure) for figure in DEFAULT_OBJECTIVES)
    return [winner for winner in each if winner is not None]


def best_designs_table(best: Sequence[Winner]) -> Table:
    """The best design by each figure, with its value, how sure that is, and what to measure first."""
    rows = (
        (word(each.figure.aim), word(each.name), each.cell, *words(each.sure, measure_text(each.verdict)))
        for each in best
    )
    columns = (*left("best", "design"), *right("value"), *left("how sure", "measure first"))
    return Table("Which design is best, and how sure that is", columns, tuple(rows))


def needs_table(designs: Designs, needs: Sequence[Constraint]) -> Table:
    """True if each design meets each need, and how sure that is."""
    rows = []
    for need in needs:
        for name, result in designs:
            text = need_text(constraint_verdict(result, need)) if isinstance(result, Result) else "not run"
            rows.append(words(limit_text(need), name, text))
    return Table("Needs", left("need", "design", "verdict"), tuple(rows))


def infeasible_designs_table(designs: Designs) -> Table:
    """Every reason against each design that is not feasible, and the faults of each that did not run."""
    rows = []
    for name, result in designs:
        if isinstance(result, SpecError):
            rows += [words(name, "did not run", fault.what, fault.hint or ABSENT) for fault in result.faults]
        elif isinstance(result, CodesignError):
            rows.append(words(name, "did not run", result.what, result.hint or ABSENT))
        else:
            rows += [
                words(name, reason.kind, reason_text(reason, ": "), "; ".join(reason.levers) or ABSENT)
                for reason in result.reasons
            ]
    return Table("Why designs are not feasible", left("design", "kind", "why", "what would mend it"), tuple(rows))


_OF_CELLS = ("share_reaching_goal", "local_maxima", "wrong_cells")
"""Figures that count over the cells of a plan. A plan that ends at a start covers fewer than a field."""


def figures_left_out(results: Sequence[Result | None]) -> tuple[str, ...]:
    """The figures of cells, unless the plan of every design covers all cells that lead to a goal."""
    qualities = [result.quality for result in results if result is not None]
    covered = all(
        quality.planned_cells == quality.reachable_cells for quality in qualities if isinstance(quality, Quality)
    )
    return () if covered else _OF_CELLS


def _warnings(result: Result | CodesignError) -> tuple[str, ...]:
    quality = result.quality if isinstance(result, Result) else None
    return quality.warnings if isinstance(quality, Quality) else ()


def _has_plan(result: Result) -> bool:
    arrivals = arrivals_of(result)
    return result.feasible and (arrivals is None or arrived_cell(arrivals[1]).value != 0)


def _arrivals_rows(results: Sequence[Result | None]) -> Iterable[tuple[str, list[Cell]]]:
    arrivals = [arrivals_of(result) if result else None for result in results]
    for name in dict.fromkeys(each[0] for each in arrivals if each):
        yield name, [arrived_cell(each[1]) if each and each[0] == name else Cell(ABSENT) for each in arrivals]


def _why_not(result: Result | CodesignError) -> str:
    """The fault of a design that did not run, or the first reason against one that did, in a line."""
    if isinstance(result, SpecError):
        return result.faults[0].what
    if isinstance(result, CodesignError):
        return result.what
    return reason_text(result.reasons[0], ": ") if result.reasons else ABSENT


def _wrapped_rows(name: str, texts: Sequence[str]) -> Iterable[tuple[Cell, ...]]:
    """Texts in as many rows as they take: columns of figures are not wrapped, and these should stay narrow."""
    lines = [wrap(text, _WIDTH_OF_REASON, break_long_words=False) for text in texts]
    for number, row in enumerate(zip_longest(*lines, fillvalue="")):
        yield word("" if number else name), *map(word, row)


def _against(base: int | None, figure: ResultFigure, results: Sequence[Result | None]) -> tuple[Cell, ...]:
    values = [result.figure(figure) if result else None for result in results]
    unit = None if base is None else values[base]
    cells = []
    for number, (value, result) in enumerate(zip(values, results, strict=True)):
        cell = sure_cell(result, figure, value)
        if number != base and value is not None and unit:
            cell = Cell(f"{cell.text} (×{value / unit:.3g})", cell.value)
        cells.append(cell)
    return tuple(cells)


# Bars of one figure with intervals, as places in percent of a width: a template draws them as inline SVG.

_TICKS = 4


@dataclass(frozen=True)
class Bar:
    """The bar of one design: all places in percent of the width; None where there is no value or no interval.

    ``begin``, ``end``: of the bar. ``low``, ``high``: the interval. ``kind``: best, plain or infeasible.
    """

    name: str
    text: str
    kind: str
    begin: float = 0.0
    end: float | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class BarChart:
    """The bars of one figure, and the ticks of their axis: (place in percent, text)."""

    title: str
    logarithmic: bool
    bars: tuple[Bar, ...]
    ticks: tuple[tuple[float, str], ...]

    @property
    def whiskers(self) -> bool:
        """True if any bar has an interval."""
        return any(bar.low is not None for bar in self.bars)


def bar_chart(
    names: Sequence[str], results: Sequence[Result | None], figure: ResultFigure, best: str | None
) -> BarChart | None:
    """The bars of a figure of named results; None where fewer than two have it, or all of them the same.

    ``best``: the name of the best design, which is marked.
    """
    values = [None if result is None else result.figure(figure) for result in results]
    ends = [_ends(result, figure, value) for result, value in zip(results, values, strict=True)]
    real = [end for pair in ends if pair for end in pair]
    if sum(pair is not None for pair in ends) < 2 or min(real) == max(real):
        return None
    axis = _Axis.over(real, share=figure.counted == "share")
    bars = []
    for name, result, value, pair in zip(names, results, values, ends, strict=True):
        if result is None or value is None or pair is None:
            bars.append(Bar(name, "did not run" if result is None else ABSENT, "infeasible"))
            continue
        kind = "infeasible" if not result.feasible else "best" if name == best else "plain"
        low, high = (axis.place(end) for end in pair) if pair[0] < pair[1] else (None, None)
        text = sure_cell(result, figure, value).text
        bars.append(Bar(name, text, kind, 0.0, axis.place(value), low, high))
    ticks = tuple((axis.place(tick), figure_cell(figure, tick).text) for tick in axis.ticks())
    return BarChart(figure.label, axis.logarithmic, tuple(bars), ticks)


def _ends(result: Result | None, figure: ResultFigure, value: float | None) -> tuple[float, float] | None:
    """The interval of a figure, or its value twice; None without a finite value."""
    if result is None or value is None or not math.isfinite(value):
        return None
    low, high = result.interval(figure) or (value, value)
    return (low, high) if math.isfinite(low) and math.isfinite(high) else (value, value)


@dataclass(frozen=True)
class _Axis:
    least: float
    most: float
    logarithmic: bool

    @classmethod
    def over(cls, values: Sequence[float], *, share: bool) -> _Axis:
        """The axis of these values: from 0, or by logarithm between the decades around them."""
        least, most = min(values), max(values)
        if wants_logarithm(least, most) and not share:
            return cls(10.0 ** math.floor(math.log10(least)), 10.0 ** math.ceil(math.log10(most)), True)
        # The longest bar leaves room for the end of its whisker.
        return cls(min(least, 0.0), max(most * 1.02, 1.0 if share else 0.0, 0.0), False)

    def place(self, value: float) -> float:
        """Percent of the width."""
        if self.logarithmic:
            share = math.log(value / self.least) / math.log(self.most / self.least)
        else:
            share = (value - self.least) / (self.most - self.least)
        return round(100 * min(max(share, 0.0), 1.0), 3)

    def ticks(self) -> list[float]:
        """Round values, at most five."""
        if self.logarithmic:
            first, last = round(math.log10(self.least)), round(math.log10(self.most))
            step = math.ceil((last - first) / _TICKS)
            return [10.0**power for power in range(first, last + 1, step)]
        span = self.most - self.least
        size = 10.0 ** math.floor(math.log10(span / _TICKS))
        size_of_step = next(size * factor for factor in (1, 2, 5, 10) if span / (size * factor) <= _TICKS)
        numbers = range(math.ceil(self.least / size_of_step), math.floor(self.most / size_of_step) + 1)
        return [size_of_step * number for number in numbers]


_DRAWN = (*DEFAULT_OBJECTIVES, FIGURES["power"], FIGURES["path_length_ratio_mean"], FIGURES["clearance_mean"])
"""The figures that bars are drawn of, where two designs have them."""


def comparison_page(
    designs: Designs, path: Path, *, needs: Sequence[Constraint] = (), command: str = "hwsw compare"
) -> None:
    """Write the page of named results: winners and verdicts, bars, all figures side by side, each design, sources.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, comparison_html(designs, needs=needs, command=command))


def comparison_html(designs: Designs, *, needs: Sequence[Constraint] = (), command: str = "hwsw compare") -> str:
    """The page of ``comparison_page`` as text."""
    names, results = [name for name, _ in designs], results_of(designs)
    ran = [result for result in results if result is not None]
    best = winners(designs)
    by_figure = {winner.figure.name: winner.name for winner in best}
    drawn = (figure for figure in _DRAWN if figure.name not in figures_left_out(results))
    charts = (bar_chart(names, results, figure, by_figure.get(figure.name)) for figure in drawn)
    feasible = sum(result.feasible for result in ran)
    return rendered(
        "comparison.html.j2",
        _provenance(ran),
        title=f"{counted(len(designs), 'design')} side by side",
        asked=[f"{note[0].upper()}{note[1:]}" for note in (*asked_notes(results), *reach_notes(results))],
        feasible=f"{feasible} of {len(designs)}",
        headline=_headline(designs, best),
        best=best_designs_table(best),
        charts=[chart for chart in charts if chart is not None],
        sides=side_by_side(designs),
        needs=needs_table(designs, needs),
        reasons=infeasible_designs_table(designs),
        parts=[_part(name, result, needs) for name, result in designs],
        sources=sources_table(ran),
        command=command,
    )


def _headline(designs: Designs, best: Sequence[Winner]) -> list[tuple[str, str, str]]:
    """The best values as (value, words, design); where one design alone is feasible its own figures."""
    if best:
        return [(winner.cell.text, winner.figure.aim, winner.name) for winner in best]
    feasible = [(name, result) for name, result in designs if isinstance(result, Result) and result.feasible]
    if len(feasible) != 1:
        return []
    name, result = feasible[0]
    return [(value, words, name) for value, words in headline(result)[1:]]


@dataclass(frozen=True)
class _Part:
    """The part of the page for one design: the sentence that answers for it, and its tables."""

    name: str
    sentence: str
    tables: tuple[Table, ...]


def _part(name: str, result: Result | CodesignError, needs: Sequence[Constraint]) -> _Part:
    if isinstance(result, CodesignError):
        return _Part(name, f"did not run: {result}", ())
    reasons = (result_reasons_table(result),) if result.reasons else ()
    return _Part(name, answer(result, (), needs).sentence, (*reasons, *figure_tables(result)))


def _provenance(results: Sequence[Result]) -> Provenance:
    """The provenance that all of the results share, with all of their platforms."""
    if not results:
        return Provenance()
    first, *others = (result.provenance or Provenance() for result in results)
    platforms = {name: digest for each in (first, *others) for name, digest in each.platform_digests.items()}
    same = {name: value for name, value in first if all(value == dict(other)[name] for other in others)}
    return Provenance(**{**same, "platform_digests": platforms})
