"""What the runs of Saudi and Sulaiman (2016) come to, in words made from the data."""

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
from codesign.planners.reproduction import Progress, Row, Use

SMALL_OMEGA = 1.5
"""The least ω of Table I, for AM as a means to find ways, not to meet a tolerance."""
MOST_FOLLOWED = 1000
FAR_OFF = 0.05
"""A published time is pointed at where the cost law misses it by more."""


def findings(rows: tuple[Row, ...], outcomes: MethodRuns, progress: Progress | None) -> tuple[str, ...]:
    """How well the fits do, how the methods compare, what the tolerance is worth, what the paper contradicts."""
    return (
        *_fit_findings(rows),
        *_method_findings(outcomes),
        *_precision_findings(outcomes, progress),
        *_paper_findings(outcomes),
    )


def _errors(rows: tuple[Row, ...], table: str, word: str, *, misprint: bool = False) -> list[float]:
    """Errors held out of any fit, in the rows of a table whose quantity has ``word`` in it."""
    return [
        abs(one.error)
        for one in rows
        if one.table == table
        and word in one.quantity
        and one.use is Use.HELD_OUT
        and one.error is not None
        and (misprint or not one.note.startswith("misprinted"))
    ]


def _fit_findings(rows: tuple[Row, ...]) -> tuple[str, ...]:
    """How the map and the cost law fare on rows that they were not fitted to."""
    first, second = _errors(rows, "Table I", ", iterations"), _errors(rows, "Table II", ", iterations")
    times = _errors(rows, "Table I", ", time") + _errors(rows, "Table II", ", time")
    gs = next(one for one in rows if one.quantity == "GS, iterations")
    assert gs.error is not None
    return (
        f"Iterations: the size of one hall was fitted to the Gauss-Seidel row ({gs.error:+.1%}). The other rows are"
        f" held out. Their errors in Table I are {sum(first) / len(first):.1%} on average and {max(first):.0%} at"
        f" worst, in Table II {sum(second) / len(second):.1%} and {max(second):.0%}. The paper does not publish its"
        " map. On other maps the iterations differ, and so do the best ω and r.",
        f"Time: two costs were fitted, one to the Gauss-Seidel row and one to {len(FITTED)} rows of AM"
        f" ({mean_units().value:.2f} Gauss-Seidel iterations each). The errors of the {len(times)} rows held out are"
        f" {sum(times) / len(times):.1%} on average and {max(times):.0%} at worst, without the misprinted row.",
    )


def _method_findings(outcomes: MethodRuns) -> tuple[str, ...]:
    """MAM against methods that the paper leaves out, all on the own floor plan."""
    _, mam = best(outcomes, Method.MAM)
    sor_key, sor = best(outcomes, Method.SOR, followed=True)
    mam_seconds, sor_seconds = seconds(Method.MAM, mam.iterations), seconds(Method.SOR, sor.iterations)
    two = seconds(Method.MAM, mam.iterations, cores=2)
    versus = "is faster" if sor_seconds < mam_seconds else "is not faster"
    still = "slower" if two > sor_seconds else "faster"
    half_key, half = best(outcomes, Method.HALF_SWEEP_AM, followed=True)
    unknowns = outcomes[Key(Method.DIRECT)].updates
    return (
        f"On the own floor plan plain SOR {versus} than MAM. The paper does not compare the two."
        f" At ω = {sor_key.omega:g} SOR takes {sor.iterations:,}"
        f" iterations and {sor_seconds:.1f} s on the paper's machine; MAM at its best takes"
        f" {mam.iterations:,} iterations and {mam_seconds:.1f} s. An iteration of MAM is two sweeps of SOR and a"
        " mean. This ω was chosen on this map. On others SOR at ω = 1.95 leaves cells that lead nowhere"
        " (docs/relaxation.md).",
        f"On two cores, with levels 1 and 2 side by side, MAM takes {two:.1f} s: {still} than SOR on one core.",
        f"Half sweeps are the paper's outlook. AM by half sweeps at ω = {half_key.omega:g} takes {half.iterations:,}"
        f" iterations of half the work, {seconds(Method.HALF_SWEEP_AM, half.iterations):.1f} s. A passage one cell"
        " wide is closed to them.",
        f"A sparse direct solver takes about {direct_seconds(unknowns):.1f} s on that machine, by its measured ratio"
        " to a sweep. It has no parameter to search for.",
    )


def _precision_findings(outcomes: MethodRuns, progress: Progress | None) -> tuple[str, ...]:
    """What the tolerance and the boundary mean for the search."""
    flat = [
        (run.omega, outcome.flat)
        for run, outcome in sorted(outcomes.items())
        if run.method is Method.SOR and run.boundary is Boundary.LOW_GOAL and outcome.flat
    ]
    high = {run: outcome for run, outcome in outcomes.items() if run.boundary is Boundary.HIGH_WALLS}
    stalled = sum(outcome.stagnated for outcome in high.values())
    most = max(outcome.flat for outcome in high.values())
    found = [
        _followed_finding(outcomes, progress),
        f"With obstacles at 1 and the goal at 0, {stalled} of {len(high)} over-relaxed runs stall above 1e-15 and"
        f" never end by the paper's test. Up to {most:,} cells then have no lower neighbour, because doubles next to"
        " 1 lie too far apart. With obstacles at 0 and the goal at -1, values far from the goal are near 0, where"
        " doubles lie close together.",
    ]
    if flat:
        listed = ", ".join(f"{cells} at ω = {omega:g}" for omega, cells in flat)
        others = (
            ""
            if _means_flat(outcomes)
            else " On this map GS, AM and MAM leave none; on others each of them does."
        )
        found.append(
            "A run that meets the tolerance may leave cells that lead nowhere. SOR meets 1e-15 on this map with cells"
            f" that have no lower neighbour ({listed}), in rooms where the potential is smaller than the error."
            f"{others} docs/relaxation.md counts them on 18 maps."
        )
    return tuple(found)


def _followed_finding(outcomes: MethodRuns, progress: Progress | None) -> str:
    """After how many iterations each cell leads to the goal, against how many the tolerance takes."""
    runs = (
        ("Gauss-Seidel", Key(Method.GS)),
        ("SOR", best(outcomes, Method.SOR, followed=True)[0]),
        ("AM", Key(Method.AM, SMALL_OMEGA)),
        ("MAM", best(outcomes, Method.MAM)[0]),
    )
    told: list[tuple[float, str]] = []
    for name, key in runs:
        shown = name if key.omega is None else f"{name} at ω = {key.omega:g}"
        if progress is not None:
            progress(f"relaxation of the floor plan: {shown} until every cell leads to the goal")
        iterations = until_followed(key, MOST_FOLLOWED)
        if iterations is not None:
            spent = seconds(key.method, iterations)
            told.append((spent, f"{iterations:,} of {shown} ({spent:.2f} s)"))
    _, first = min(told)
    whole = outcomes[Key(Method.GS)].iterations
    return (
        "Section V asks for 1e-15 so that no flat areas remain. On this map every cell leads to the goal after far"
        f" fewer iterations (and less time on the paper's machine): {', '.join(text for _, text in told)}. The first"
        f" is {first}. Gauss-Seidel needs {whole:,} iterations to meet the tolerance. Ordered by what the search"
        " needs, the methods stand in another order than by the tolerance."
    )


def _means_flat(outcomes: MethodRuns) -> bool:
    """Whether any run of GS, AM or MAM with the paper's boundary left flat cells."""
    return any(
        outcome.flat
        for key, outcome in outcomes.items()
        if key.method in {Method.GS, Method.AM, Method.MAM} and key.boundary is Boundary.LOW_GOAL
    )


def _paper_findings(outcomes: MethodRuns) -> tuple[str, ...]:
    """What in the paper cannot hold together."""
    am = {run.omega: run.iterations for run in published.AM}
    losing = sum(run.iterations > am[run.r] for run in published.MAM_COARSE)
    best_am, best_mam = min(am.values()), min(run.iterations for run in published.MAM_FINE)
    gs = seconds_an_iteration(published.GS) * mean_units().value
    odd = [
        run
        for run in published.MAM_FINE
        if run is not published.MISPRINT and abs(run.iterations * gs / run.seconds - 1.0) > FAR_OFF
    ]
    shown = "; ".join(
        f"ω = {run.omega:g}, r = {run.r:g}: {run.iterations:,} iterations in {run.seconds:.2f} s, which is time for"
        f" {run.seconds / gs:,.0f}" + _own(outcomes, run)
        for run in odd
    )
    return (
        f'"MAM against AM" of Table III compares MAM at (ω, ω + 0.05) with AM at ω. Compared with AM at ω + 0.05,'
        f" MAM needs more iterations in {losing} of the {len(published.MAM_COARSE)} published pairs: the gain there"
        f" comes from the larger parameter. Between the two optima the gain is {1.0 - best_mam / best_am:.0%}"
        f" ({best_am:,} to {best_mam:,}).",
        f"Some times of Table II do not fit their iterations: {shown}. The time of ω = 1.975, r = 1.99 is misprinted:"
        " it repeats the number of iterations.",
        f"Smaller slips: 64.99 % in Table III is"
        f" {reduction(published.AM[0].iterations, published.GS.iterations):.2f} %; the matrices after equation 15"
        ' have the signs of T and L reversed against equation 13; a double reaches 1.7e308, not 1.7e-308; "1.0^-15"'
        " is 1e-15.",
    )


def _own(outcomes: MethodRuns, run: published.Run) -> str:
    key = key_of(run)
    return f" (own map: {outcomes[key].iterations:,})" if key in outcomes else ""
