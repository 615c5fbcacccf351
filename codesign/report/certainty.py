"""How sure a result or a winner is, in a reader's words and as a table."""

from __future__ import annotations

from collections.abc import Sequence

from codesign.figures import FIGURES, Figure, ResultFigure, label
from codesign.report.table import Cell, Table, left, right, word
from codesign.report.wording import ends_text, figure_cell, quantity_text
from codesign.results.result import Result
from codesign.verdicts import Fit, Verdict, fit_verdict, sensitivity, winner_verdict

HOLDS = "holds within the assumed intervals"
EXACT = "holds: it rests on no assumed figure"
_SHOWN = ("first_plan_s", "energy_j", "power")


def sure_cell(result: Result | None, figure: ResultFigure, value: float | None) -> Cell:
    """A figure of a result with its interval, where it has one."""
    return figure_cell(figure, value, None if result is None else result.interval(figure))


def verdict_text(verdict: Verdict) -> str:
    """A verdict in a line."""
    decides = verdict.decides
    if verdict.state == "not assessed":
        return f"not assessed: {verdict.reason}"
    if verdict.state == "proved":
        if verdict.rival is None and verdict.winner is not None:
            return verdict.reason
        return EXACT if verdict.least == verdict.most else HOLDS
    if verdict.state == "refuted":
        return "fails within all of the assumed intervals"
    if decides is None:
        return verdict.reason
    stands = figure_text(decides.figure)
    if decides.flips_at is None:
        return f"rests on {decides.name} ({stands}) and others: {verdict.reason}"
    return f"flips at {decides.name} = {_rounded(decides.flips_at, decides.figure.unit)} ({stands})"


def figure_text(figure: Figure) -> str:
    """The status, the value and the interval of a figure: ``assumed 10 ns, 5 to 20``."""
    value = quantity_text(figure.value, figure.unit)
    ends = ends_text(value, *figure.interval, figure.unit)
    return f"{figure.status} {value}, {ends}" if ends else f"{figure.status} {value}"


def _rounded(value: float, unit: str) -> str:
    """To four digits: nobody measures more."""
    return quantity_text(float(f"{value:.4g}"), unit)


def measure_text(verdict: Verdict) -> str:
    """The measurement most worth making, in a sentence; "" where nothing is to be decided."""
    decides = verdict.decides
    if decides is None or verdict.state != "depends":
        return ""
    how = ": hwsw calibrate host does it on the machine itself" if ".costs." in decides.name else ""
    return f"measure {decides.name} first{how}"


def fit_text(fit: Fit) -> str:
    """Whether a design fits at every value, in a line."""
    if fit.fits == "yes" or fit.demand is None or fit.limit is None:
        return "yes, at every value of its demand and of its clock limit" if fit.fits == "yes" else fit.fits
    unit = "" if fit.figure is None or fit.figure.unit == "1" else fit.figure.unit
    demand, limit = (_span(*ends, unit) for ends in (fit.demand, fit.limit))
    return f"{fit.fits}: {label(fit.decides)} {demand} against a limit of {limit}"


def _span(low: float, high: float, unit: str) -> str:
    value = quantity_text(low, unit)
    return value if low == high else f"{value} to {quantity_text(high, unit)}"


def winner_text(names: Sequence[str], results: Sequence[Result | None], figure: ResultFigure) -> str:
    """Which of several designs is best by a figure, and whether that holds; "" where no other has another value."""
    compared = [(name, result) for name, result in zip(names, results, strict=True) if result is not None]
    if sum(result.feasible and result.figure(figure) is not None for _, result in compared) < 2:
        return ""
    verdict = winner_verdict([result for _, result in compared], figure)
    assert verdict.winner is not None, "two designs have the figure"
    if verdict.rival is None:
        return ""
    text = f"{figure.aim}: {compared[verdict.winner][0]}, {verdict_text(verdict)}"
    against = "" if verdict.rival is None else f" against {compared[verdict.rival][0]}"
    measure = measure_text(verdict)
    return f"{text}{against if verdict.state != 'proved' else ''}{f'; {measure}' if measure else ''}"


def certainty_table(result: Result) -> Table:
    """Each figure that rests on others with an interval: its least and greatest value, and what moves it most."""
    rows = []
    for name in _SHOWN:
        figure = FIGURES[name]
        value, interval = result.figure(figure), result.interval(figure)
        if value is None:
            continue
        if interval is None:
            reason = "" if result.terms is None else result.terms.open.get(name, "")
            rows += [_row(figure, value, None, reason)] if reason else []
            continue
        most = next(iter(sensitivity(result, figure)), None)
        moved = "" if most is None else f"{most.name} ({figure_text(most.figure)})"
        rows.append(_row(figure, value, interval, moved))
    notes = (f"fits its part: {fit_text(fit_verdict(result))}",) if result.part is not None else ()
    columns = (*left("figure"), *right("value", "least", "most"), *left("moved most by"))
    return Table("How sure", columns, tuple(rows), notes)


def _row(
    figure: ResultFigure, value: float, interval: tuple[float, float] | None, moved: str
) -> tuple[Cell, ...]:
    ends = [Cell("")] * 2 if interval is None else [figure_cell(figure, end) for end in interval]
    return word(figure.label), figure_cell(figure, value), *ends, word(moved)
