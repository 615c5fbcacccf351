"""The certainty of a result or a winner, in a reader's words and as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from codesign.ground.figures import FIGURES, Figure, ResultFigure, label, named
from codesign.system.results.result import Result
from codesign.system.results.terms import priced
from codesign.system.verdicts import Decider, Fit, Verdict, fit_verdict, sensitivity, winner_verdict
from codesign.views.report.table import Cell, Table, left, right, word
from codesign.views.report.wording import ABSENT, ends_text, figure_cell, quantity_text

if TYPE_CHECKING:
    from codesign.study import Study

HOLDS = "holds within the assumed intervals"
EXACT = "holds: it rests on no assumed figure"
IF_IT_FITS = ", if the design fits"
_READ = {"W/(slice Hz)": ("W", 1e6, " a slice and MHz")}
"""Units that nobody writes: the one that is written, its size, and what stands behind it."""


def sure_cell(result: Result | None, figure: ResultFigure, value: float | None) -> Cell:
    """A figure of a result with its interval, where it has one."""
    return figure_cell(figure, value, None if result is None else result.interval(figure))


def _is_assumed(verdict: Verdict) -> bool:
    return priced(named(verdict.figure)) or verdict.least != verdict.most


def verdict_text(verdict: Verdict) -> str:
    """A verdict in a line."""
    decides = verdict.decides
    if verdict.state == "depends" and decides is not None:
        return _deciding_text(verdict, decides)
    alone = verdict.rival is None and verdict.winner is not None
    proved = verdict.reason if alone else HOLDS if _is_assumed(verdict) else EXACT
    proved += IF_IT_FITS if verdict.fit is not None and verdict.fit.fits != "yes" else ""
    texts = {
        "proved": proved,
        "refuted": "fails within all of the assumed intervals",
        "depends": verdict.reason,
        "not assessed": f"not assessed: {verdict.reason}",
    }
    return texts[verdict.state]


def need_text(verdict: Verdict) -> str:
    """True if a need is met, and how sure that is: ``met (proved)``, ``met, flips at …``."""
    if verdict.holds is None:
        return f"missed: {verdict.reason}"
    fate, decides = "met" if verdict.holds else "missed", verdict.decides
    if verdict.state in {"proved", "refuted"}:
        return f"{fate} ({'proved' if verdict.holds else 'at every value'})"
    if verdict.state == "depends" and decides is not None:
        return f"{fate}, {_deciding_text(verdict, decides)}"
    return f"{fate} ({verdict_text(verdict)})"


def _deciding_text(verdict: Verdict, decides: Decider) -> str:
    """The figure that a verdict depends on, in words."""
    stands = figure_text(decides.figure)
    if decides.flips_at is None:
        return f"rests on {decides.name} ({stands}) and others: {verdict.reason}"
    return f"flips at {decides.name} = {_flip_text(decides)} ({stands})"


def figure_text(figure: Figure) -> str:
    """The status, the value and the interval of a figure: ``assumed 10 ns, 5 to 20``."""
    unit, scale, behind = _READ.get(figure.unit, (figure.unit, 1.0, ""))
    low, high = figure.interval
    value = quantity_text(figure.value * scale, unit)
    ends = ends_text(value, low * scale, high * scale, unit)
    return f"{figure.status} {value}{f', {ends}' if ends else ''}{behind}"


def _flip_text(decides: Decider) -> str:
    """The value at which a verdict changes, to four digits. Of a number of things the first one behind it."""
    value, figure = decides.flips_at, decides.figure
    assert value is not None, "asked of a figure that flips"
    if isinstance(figure.value, int) and figure.unit == "1":
        return quantity_text(math.ceil(value) if value > figure.value else math.floor(value), "1")
    unit, scale, behind = _READ.get(figure.unit, (figure.unit, 1.0, ""))
    return f"{quantity_text(float(f'{value * scale:.4g}'), unit)}{behind}"


def measure_text(verdict: Verdict) -> str:
    """The measurement most worth making, in a sentence; "" where nothing is to be decided."""
    decides = verdict.decides
    if decides is None or verdict.state != "depends":
        return ""
    how = ": hwsw calibrate host does it on the machine itself" if ".costs." in decides.name else ""
    return f"measure {decides.name} first{how}"


def fit_text(fit: Fit) -> str:
    """True if a design fits at every value, in a line."""
    if fit.fits == "yes" or fit.demand is None or fit.limit is None:
        return "yes, at every value of its demand and of its clock limit" if fit.fits == "yes" else fit.fits
    unit = "" if fit.figure is None or fit.figure.unit == "1" else fit.figure.unit
    demand, limit = (_span(*ends, unit) for ends in (fit.demand, fit.limit))
    return f"{fit.fits}: {label(fit.decides)} {demand} against a limit of {limit}"


def _span(low: float, high: float, unit: str) -> str:
    value = quantity_text(low, unit)
    return value if low == high else f"{value} to {quantity_text(high, unit)}"


@dataclass(frozen=True)
class Winner:
    """The best of several designs by a figure: its name, its value with its interval, and how sure that is.

    ``rival``: the name of the design that decides against it.
    """

    figure: ResultFigure
    name: str
    cell: Cell
    verdict: Verdict
    rival: str

    @property
    def sure(self) -> str:
        """The certainty that it wins, and against which design."""
        against = f" against {self.rival}" if self.verdict.state != "proved" else ""
        return f"{verdict_text(self.verdict)}{against}"


def winner_of(names: Sequence[str], results: Sequence[Result | None], figure: ResultFigure) -> Winner | None:
    """The best of several designs by a figure; None if no other has another value."""
    compared = [(name, result) for name, result in zip(names, results, strict=True) if result is not None]
    if sum(result.feasible and result.figure(figure) is not None for _, result in compared) < 2:
        return None
    verdict = winner_verdict([result for _, result in compared], figure)
    assert verdict.winner is not None, "two designs have the figure"
    if verdict.rival is None:
        return None
    name, best = compared[verdict.winner]
    cell = sure_cell(best, figure, best.figure(figure))
    return Winner(figure, name, cell, verdict, compared[verdict.rival][0])


def winner_text(winner: Winner) -> str:
    """The winner in a line, with the measurement most worth making."""
    measure = measure_text(winner.verdict)
    return f"{winner.figure.aim}: {winner.name}, {winner.sure}{f'; {measure}' if measure else ''}"


def winners_certainty_table(study: Study) -> Table:
    """For each objective that rests on intervals the best feasible point, and whether it is the best at every value.

    Empty over conditions: there designs are compared, not points.
    """
    rows = []
    for objective in () if study.conditions else filter(priced, study.objectives):
        verdict = study.rivals.verdict(objective)
        if verdict.winner is None:
            continue
        best = study.points[int(study.rivals.points[verdict.winner])]
        rival = ABSENT if verdict.rival is None else str(study.rivals.points[verdict.rival])
        value = figure_cell(objective, best.figure(objective), best.interval(objective))
        cells = Cell(str(best.index), best.index), value, word(verdict_text(verdict)), word(rival)
        rows.append((word(objective.aim), *cells))
    columns = (*left("best"), *right("point", "value"), *left("how sure", "against point"))
    return Table("How sure the best points are", columns, tuple(rows))


def certainty_table(result: Result) -> Table:
    """Each figure that rests on others with an interval: its least and greatest value, and what moves it most."""
    rows = []
    for figure in filter(priced, FIGURES.values()):
        value, interval = result.figure(figure), result.interval(figure)
        if value is None:
            continue
        if interval is None:
            reason = "" if result.terms is None else result.terms.open.get(figure.name, "")
            rows += [_row(figure, value, None, reason)] if reason else []
            continue
        most = next(iter(sensitivity(result, figure)), None)
        moved = "" if most is None else f"{most.name} ({figure_text(most.figure)})"
        rows.append(_row(figure, value, interval, moved))
    limited = result.part is not None or result.bounds
    notes = (f"fits: {fit_text(fit_verdict(result))}",) if limited else ()
    columns = (*left("figure"), *right("value", "least", "most"), *left("moved most by"))
    return Table("How sure", columns, tuple(rows), notes)


def _row(figure: ResultFigure, value: float, interval: tuple[float, float] | None, moved: str) -> tuple[Cell, ...]:
    ends = [Cell("")] * 2 if interval is None else [figure_cell(figure, end) for end in interval]
    return word(figure.label), figure_cell(figure, value), *ends, word(moved)
