"""Several results side by side, as a table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import zip_longest
from textwrap import wrap

from codesign.ground.errors import CodesignError, SpecError
from codesign.ground.figures import FIGURES, ResultFigure, label
from codesign.inputs.constraint import Constraint, limit_text
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.quality import Quality
from codesign.system.results.result import Reason, Result
from codesign.system.verdicts import constraint_verdict
from codesign.views.report.certainty import Winner, measure_text, need_text, sure_cell, winner_of, winner_text
from codesign.views.report.result_tables import SHORTEST
from codesign.views.report.sentences import arrivals_of, arrived_cell, asked_notes, questions_of, reach_notes
from codesign.views.report.table import Cell, Column, Table, left, right, word, words
from codesign.views.report.wording import ABSENT, quantity_text, yes_cell

_WIDTH_OF_REASON = 28
_PART = "part"


Designs = Sequence[tuple[str, Result | CodesignError]]
"""Named results, or the error that kept a design from running."""


def comparison_table(designs: Designs, needs: Sequence[Constraint] = ()) -> Table:
    """Named results side by side, or why a design has none; and which of the needs each meets.

    Figures are given also as multiples of those of the first design with a plan.
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
    """Whether each design meets each need, and how sure that is."""
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
                words(name, reason.kind, _reason_text(reason), "; ".join(reason.levers) or ABSENT)
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
    if not result.reasons:
        return ABSENT
    return _reason_text(result.reasons[0])


def _reason_text(reason: Reason) -> str:
    if reason.words:
        return reason.words
    demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
    return f"{label(reason.name)}: {demand} against {limit}"


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
