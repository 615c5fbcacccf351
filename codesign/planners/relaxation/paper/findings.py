"""The conclusions from the runs of Saudi and Sulaiman (2016), as statements with their figures."""

from __future__ import annotations

from codesign.planners.relaxation import published
from codesign.planners.relaxation.paper.runs import (
    Key,
    MethodRuns,
    best,
    direct_seconds,
    key_of,
    reduction,
    seconds,
    until_followed,
)
from codesign.planners.relaxation.plan import Boundary, Method
from codesign.planners.relaxation.styles.costs import FITTED, mean_units, seconds_an_iteration
from codesign.planners.reproduction import Finding, Progress, Row, Use

SMALL_OMEGA = 1.5
"""The least ω of Table I, for AM as a means to lead to the goal, not to meet a tolerance."""
MOST_FOLLOWED = 1000
FAR_OFF = 0.05
"""A finding names each published time that the cost law misses by more."""


def findings(rows: tuple[Row, ...], outcomes: MethodRuns, progress: Progress | None) -> tuple[Finding, ...]:
    """The errors of the fits, the methods compared, the use of the tolerance, and contradictions of the paper."""
    return (
        *_fit_findings(rows),
        *_method_findings(outcomes),
        _followed_finding(outcomes, progress),
        *_precision_findings(outcomes),
        *_paper_findings(outcomes),
    )


def _errors(rows: tuple[Row, ...], table: str, word: str) -> list[float]:
    """Errors held out of any fit, in the rows of a table with ``word`` in their quantity, without the misprint."""
    return [
        abs(row.error)
        for row in rows
        if row.table == table
        and word in row.quantity
        and row.use is Use.HELD_OUT
        and row.error is not None
        and not row.note.startswith("misprinted")
    ]


def _fit_findings(rows: tuple[Row, ...]) -> tuple[Finding, ...]:
    """The errors of the map and the cost law on rows that they were not fitted to."""
    first, second = _errors(rows, "Table I", ", iterations"), _errors(rows, "Table II", ", iterations")
    times = _errors(rows, "Table I", ", time") + _errors(rows, "Table II", ", time")
    gs = next(row for row in rows if row.quantity == "GS, iterations")
    assert gs.error is not None
    return (
        Finding(
            "A floor plan fitted to the Gauss-Seidel row comes near the iterations of the other rows.",
            {
                "fitted row": f"{gs.error:+.1%}",
                "Table I, mean": f"{sum(first) / len(first):.1%}",
                "Table I, worst": f"{max(first):.0%}",
                "Table II, mean": f"{sum(second) / len(second):.1%}",
                "Table II, worst": f"{max(second):.0%}",
            },
            max(sum(first) / len(first), sum(second) / len(second)) < 0.1,
        ),
        Finding(
            "Two costs, fitted to ten rows, give the times of the others.",
            {
                "rows of AM that were fitted": str(len(FITTED)),
                "iteration of AM over Gauss-Seidel": f"{mean_units().value:.2f}",
                "rows held out": str(len(times)),
                "mean": f"{sum(times) / len(times):.1%}",
                "worst": f"{max(times):.0%}",
            },
            sum(times) / len(times) < 0.05,
        ),
    )


def _method_findings(outcomes: MethodRuns) -> tuple[Finding, ...]:
    """MAM against methods that the paper leaves out, all on the own floor plan."""
    _, mam = best(outcomes, Method.MAM)
    sor_key, sor = best(outcomes, Method.SOR, followed=True)
    mam_seconds, sor_seconds = seconds(Method.MAM, mam.iterations), seconds(Method.SOR, sor.iterations)
    two = seconds(Method.MAM, mam.iterations, cores=2)
    half_key, half = best(outcomes, Method.HALF_SWEEP_AM, followed=True)
    direct = direct_seconds(outcomes[Key(Method.DIRECT)].updates)
    half_seconds = seconds(Method.HALF_SWEEP_AM, half.iterations)
    return (
        Finding(
            "On our floor plan SOR is faster than MAM.",
            {
                "ω of SOR": f"{sor_key.omega:g}",
                "iterations of SOR": f"{sor.iterations:,}",
                "time of SOR": f"{sor_seconds:.1f} s",
                "iterations of MAM": f"{mam.iterations:,}",
                "time of MAM": f"{mam_seconds:.1f} s",
            },
            sor_seconds < mam_seconds,
        ),
        Finding(
            "On two cores MAM is slower than SOR on one.", {"time of MAM": f"{two:.1f} s"}, two > sor_seconds
        ),
        Finding(
            "Half sweeps make AM faster than MAM.",
            {
                "ω": f"{half_key.omega:g}",
                "iterations": f"{half.iterations:,}",
                "time": f"{half_seconds:.1f} s",
            },
            half_seconds < mam_seconds,
        ),
        Finding(
            "A sparse direct solver is faster than all of them.",
            {"time": f"{direct:.1f} s"},
            direct < min(sor_seconds, mam_seconds, half_seconds),
        ),
    )


def _followed_finding(outcomes: MethodRuns, progress: Progress | None) -> Finding:
    """The iterations until each cell leads to the goal, against those until the tolerance is met."""
    runs = (
        ("Gauss-Seidel", Key(Method.GS)),
        ("SOR", best(outcomes, Method.SOR, followed=True)[0]),
        ("AM", Key(Method.AM, SMALL_OMEGA)),
        ("MAM", best(outcomes, Method.MAM)[0]),
    )
    spent: dict[str, float] = {}
    figures: dict[str, str] = {}
    for name, key in runs:
        shown = name if key.omega is None else f"{name} at ω = {key.omega:g}"
        if progress is not None:
            progress(f"relaxation of the floor plan: {shown} until every cell leads to the goal")
        iterations = until_followed(key, MOST_FOLLOWED)
        if iterations is not None:
            spent[name] = seconds(key.method, iterations)
            figures[shown] = f"{iterations:,}"
            figures[f"{shown}, time"] = f"{spent[name]:.2f} s"
    figures["Gauss-Seidel to the tolerance"] = f"{outcomes[Key(Method.GS)].iterations:,}"
    return Finding(
        "Every cell leads to the goal long before the tolerance is met, first with AM.",
        figures,
        min(spent, key=spent.__getitem__) == "AM",
    )


def _precision_findings(outcomes: MethodRuns) -> tuple[Finding, ...]:
    """The effect of the tolerance and the boundary on the search."""
    flat = {
        f"SOR at ω = {run.omega:g}": str(outcome.flat)
        for run, outcome in sorted(outcomes.items())
        if run.method is Method.SOR and run.boundary is Boundary.LOW_GOAL and outcome.flat
    }
    high = [outcome for run, outcome in outcomes.items() if run.boundary is Boundary.HIGH_WALLS]
    stalled = sum(outcome.stagnated for outcome in high)
    return (
        Finding(
            "With obstacles at 1 and the goal at 0, over-relaxed runs stall above 1e-15.",
            {
                "runs that stall": f"{stalled} of {len(high)}",
                "most cells without a lower neighbour": f"{max(outcome.flat for outcome in high):,}",
            },
            stalled == len(high),
        ),
        Finding("SOR may meet the tolerance and leave cells that lead nowhere.", flat, bool(flat)),
        Finding("On this map GS, AM and MAM leave no such cell.", {}, not _means_flat(outcomes)),
    )


def _means_flat(outcomes: MethodRuns) -> bool:
    """Whether any run of GS, AM or MAM with the paper's boundary left flat cells."""
    return any(
        outcome.flat
        for key, outcome in outcomes.items()
        if key.method in {Method.GS, Method.AM, Method.MAM} and key.boundary is Boundary.LOW_GOAL
    )


def _paper_findings(outcomes: MethodRuns) -> tuple[Finding, ...]:
    """Contradictions within the paper."""
    am = {run.omega: run.iterations for run in published.AM}
    losing = sum(run.iterations > am[run.r] for run in published.MAM_COARSE)
    best_am, best_mam = min(am.values()), min(run.iterations for run in published.MAM_FINE)
    return (
        Finding(
            "The gain of MAM in Table III comes from its larger parameter.",
            {
                "pairs in which AM with that parameter needs fewer": f"{losing} of {len(published.MAM_COARSE)}",
                "best AM": f"{best_am:,}",
                "best MAM": f"{best_mam:,}",
                "gain between the two": f"{1.0 - best_mam / best_am:.0%}",
            },
            losing == len(published.MAM_COARSE),
        ),
        _times_finding(outcomes),
        Finding(
            "64.99 % in Table III is a slip.",
            {"reduction": f"{reduction(published.AM[0].iterations, published.GS.iterations):.2f} %"},
            round(reduction(published.AM[0].iterations, published.GS.iterations), 2) != 64.99,
        ),
    )


def _times_finding(outcomes: MethodRuns) -> Finding:
    """Times of Table II that the cost law misses."""
    gs = seconds_an_iteration(published.GS) * mean_units().value
    figures: dict[str, str] = {}
    for run in published.MAM_FINE:
        if run is published.MISPRINT or abs(run.iterations * gs / run.seconds - 1.0) <= FAR_OFF:
            continue
        name = f"ω = {run.omega:g}, r = {run.r:g}"
        figures[f"{name}: iterations"] = f"{run.iterations:,}"
        figures[f"{name}: time"] = f"{run.seconds:.2f} s"
        figures[f"{name}: iterations for which this is time"] = f"{run.seconds / gs:,.0f}"
        if key_of(run) in outcomes:
            figures[f"{name}: iterations on our map"] = f"{outcomes[key_of(run)].iterations:,}"
    return Finding("Some times of Table II do not fit their iterations.", figures, bool(figures))
