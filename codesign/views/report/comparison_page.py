"""The self-contained page of a comparison: who is best and how sure, bars with intervals, and each design by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from codesign.ground.errors import CodesignError
from codesign.ground.figures import FIGURES
from codesign.ground.units import counted
from codesign.inputs.constraint import Constraint
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.system.results.provenance import Provenance
from codesign.system.results.result import Result
from codesign.views.report.answer import answer
from codesign.views.report.bars import bar_chart
from codesign.views.report.certainty import Winner
from codesign.views.report.comparison_tables import (
    Designs,
    best_designs_table,
    figures_left_out,
    infeasible_designs_table,
    needs_table,
    results_of,
    side_by_side,
    winners,
)
from codesign.views.report.page import rendered, write_page
from codesign.views.report.result_tables import figure_tables, result_reasons_table, sources_table
from codesign.views.report.sentences import asked_notes, headline, reach_notes
from codesign.views.report.table import Table

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
    """What the page has of one design: the sentence that answers for it, and its tables."""

    name: str
    sentence: str
    tables: tuple[Table, ...]


def _part(name: str, result: Result | CodesignError, needs: Sequence[Constraint]) -> _Part:
    if isinstance(result, CodesignError):
        return _Part(name, f"did not run: {result}", ())
    reasons = (result_reasons_table(result),) if result.reasons else ()
    return _Part(name, answer(result, (), needs).sentence, (*reasons, *figure_tables(result)))


def _provenance(results: Sequence[Result]) -> Provenance:
    """What made all of the results: what they differ in is left out, but for platforms."""
    if not results:
        return Provenance()
    first, *others = (result.provenance or Provenance() for result in results)
    platforms = {name: digest for each in (first, *others) for name, digest in each.platform_digests.items()}
    same = {name: value for name, value in first if all(value == dict(other)[name] for other in others)}
    return Provenance(**{**same, "platform_digests": platforms})
