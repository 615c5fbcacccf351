"""Saudi and Sulaiman (2016), held against the model: Tables I to III, the text, and methods beyond them."""

from __future__ import annotations

from codesign.figures import Status
from codesign.planners.relaxation import published
from codesign.planners.relaxation.paper.findings import findings
from codesign.planners.relaxation.paper.runs import (
    Key,
    MethodRuns,
    best,
    beyond,
    direct_seconds,
    key_of,
    reduction,
    run_all,
    seconds,
    tabulated,
)
from codesign.planners.relaxation.paper.settings import RelaxationSettings
from codesign.planners.relaxation.plan import Boundary, Method
from codesign.planners.relaxation.styles.costs import FITTED
from codesign.planners.reproduction import Plot, Progress, Reproduction, Row, Series, Use, row

OWN_MAP = "own floor plan of 330 × 270 cells, its hall fitted to the GS row"
COST_LAW = "iterations × cells × 16.8 ns, and 2.60 times that for AM and MAM"

QUICK = "A quick run: a few of the rows with few iterations; the findings are of these alone."


def relaxation(
    quick: bool = False, progress: Progress | None = None, settings: RelaxationSettings | None = None
) -> Reproduction:
    """Tables I to III against the planner on an own floor plan and the cost law of the host styles.

    Args:
        quick: rows of few iterations only: seconds instead of a minute or two.
        progress: gets a line on each step of the computation.
        settings: of the runs; by default as published.
    """
    settings = settings or RelaxationSettings()
    runs = tabulated(quick)
    outcomes = run_all((*map(key_of, runs), *beyond(quick, settings.sor_omegas)), progress)
    rows = (
        *_table_rows(runs, outcomes),
        *_reduction_rows(outcomes),
        *_text_rows(outcomes),
        *_beyond_rows(outcomes),
    )
    return Reproduction(
        paper="Saudi, Sulaiman 2016, Autonomous vehicle navigation using harmonic functions via modified"
        " arithmetic mean iterative method",
        rows=rows,
        figures=(_omega_plot(runs, outcomes), _r_plot(runs, outcomes)),
        findings=findings(rows, outcomes, progress),
        note=QUICK if quick else "",
    ).with_settings(settings)


def _name(run: published.Run) -> str:
    if run.omega is None:
        return "GS"
    return f"AM ω={run.omega:g}" if run.r is None else f"MAM ω={run.omega:g} r={run.r:g}"


def _table_rows(runs: tuple[published.Run, ...], outcomes: MethodRuns) -> list[Row]:
    """Tables I and II: iterations on the own map, and the law's time of the published iterations."""
    rows = []
    for run in runs:
        key = key_of(run)
        table = "Table II" if run in published.MAM_FINE else "Table I"
        fitted = run is published.GS
        rows.append(
            row(
                table,
                f"{_name(run)}, iterations",
                run.iterations,
                outcomes[key].iterations,
                status=Status.CALIBRATED,
                source=OWN_MAP,
                use=Use.FITTED if fitted else Use.HELD_OUT,
                note="the size of the hall is fitted to this row" if fitted else "",
            )
        )
        rows.append(
            row(
                table,
                f"{_name(run)}, time of {run.iterations:,} iterations",
                run.seconds,
                seconds(key.method, run.iterations),
                unit="s",
                status=Status.CALIBRATED,
                source=COST_LAW,
                use=Use.FITTED if fitted or run in FITTED else Use.HELD_OUT,
                note="misprinted: the number of iterations once more" if run is published.MISPRINT else "",
            )
        )
    return rows


def _reductions(outcomes: MethodRuns) -> dict[str, tuple[list[float], list[float]]]:
    """Table III from own runs: reductions in %, of iterations and of time, of every pair of runs."""
    reductions: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in published.REDUCTIONS}
    gs = outcomes[Key(Method.GS)].iterations
    for run in (*published.AM, *published.MAM_COARSE):
        key = key_of(run)
        if key not in outcomes:
            continue
        own, name = outcomes[key].iterations, "AM against GS"
        other, other_seconds = gs, seconds(Method.GS, gs)
        if run.r is not None:
            name, other = "MAM against AM", outcomes[Key(Method.AM, run.omega)].iterations
            other_seconds = seconds(Method.AM, other)
        elif run.omega is not None and run.omega > published.AM[17].omega:  # type: ignore[operator]
            # The paper's range ends at its best ω, 1.97.
            continue
        reductions[name][0].append(reduction(own, other))
        reductions[name][1].append(reduction(seconds(key.method, own), other_seconds))
    return reductions


def _reduction_rows(outcomes: MethodRuns) -> list[Row]:
    """Table III, as far as its runs are among the outcomes."""
    rows = []
    whole = key_of(published.AM[0]) in outcomes
    for name, (iterations, times) in published.REDUCTIONS.items():
        own = _reductions(outcomes)[name]
        for what, ends, values in (("iterations", iterations, own[0]), ("time", times, own[1])):
            for which, end, value in (("least", ends[0], min(values)), ("greatest", ends[1], max(values))):
                if which == "least" and not whole:
                    continue
                rows.append(
                    row(
                        "Table III",
                        f"{name}, {what}, {which} reduction",
                        end,
                        value,
                        unit="%",
                        status=Status.CALIBRATED,
                        source=OWN_MAP if what == "iterations" else f"{OWN_MAP}; {COST_LAW}",
                        use=Use.HELD_OUT,
                    )
                )
    return rows


def _text_rows(outcomes: MethodRuns) -> list[Row]:
    """The best parameters, against section VI."""
    am, mam = best(outcomes, Method.AM), best(outcomes, Method.MAM)
    return [
        row(
            "Section VI",
            quantity,
            printed,
            value,
            unit=unit,
            status=Status.CALIBRATED,
            source=OWN_MAP,
            use=Use.HELD_OUT,
        )
        for quantity, printed, value, unit in (
            ("best ω of AM", "1.95 to 1.975", am[0].omega, "1"),
            ("best ω of MAM", "1.97 to 1.975", mam[0].omega, "1"),
            ("best r of MAM", "1.92 to 1.94", mam[0].r, "1"),
            ("iterations of the best MAM", "< 1500", mam[1].iterations, "1"),
            ("time of the best MAM", "< 6 s", seconds(Method.MAM, mam[1].iterations), "s"),
        )
    ]


def _beyond_rows(outcomes: MethodRuns) -> list[Row]:
    """Methods that the paper leaves out, on the same map and at the same cost of an update."""
    rows = []
    for method in (Method.SOR, Method.RED_BLACK, Method.HALF_SWEEP_AM):
        key, outcome = best(outcomes, method, followed=True)
        for what, value, unit in (
            ("iterations", outcome.iterations, "1"),
            ("time", seconds(method, outcome.iterations), "s"),
        ):
            rows.append(_unpublished(f"{method} ω={key.omega:g}, {what}", value, unit))
    for method in (Method.AM, Method.MAM):
        key, outcome = best(outcomes, method)
        shown = f"{method} ω={key.omega:g}" + ("" if key.r is None else f" r={key.r:g}")
        rows.append(
            _unpublished(f"{shown} on two cores, time", seconds(method, outcome.iterations, cores=2), "s")
        )
    unknowns = outcomes[Key(Method.DIRECT)].updates
    rows.append(_unpublished("sparse direct solution, time", direct_seconds(unknowns), "s"))
    return rows


def _unpublished(quantity: str, value: float, unit: str) -> Row:
    note = "fewest iterations without flat cells" if unit == "1" else ""
    return row(
        "Beyond",
        quantity,
        None,
        value,
        unit=unit,
        status=Status.ASSUMED,
        source=COST_LAW,
        use=Use.NOTHING,
        note=note,
    )


def _omega_plot(runs: tuple[published.Run, ...], outcomes: MethodRuns) -> Plot:
    """Iterations against ω, published and own."""
    series = []
    for name, method in (("AM", Method.AM), ("MAM, r = ω + 0.05", Method.MAM)):
        chosen = [
            run for run in runs if run in (published.AM if method is Method.AM else published.MAM_COARSE)
        ]
        omegas = tuple(float(run.omega or 0.0) for run in chosen)
        series.append(Series(f"{name}, published", omegas, tuple(float(run.iterations) for run in chosen)))
        own = tuple(float(outcomes[key_of(run)].iterations) for run in chosen)
        series.append(Series(f"{name}, own map", omegas, own))
    sor = sorted(
        (key.omega or 0.0, float(outcome.iterations))
        for key, outcome in outcomes.items()
        if key.method is Method.SOR and key.boundary is Boundary.LOW_GOAL
    )
    series.append(Series("SOR, own map", tuple(point[0] for point in sor), tuple(point[1] for point in sor)))
    return Plot(
        name="saudi2016-omega",
        title="Iterations to 1e-15 on 330 × 270 cells",
        published="Table I: iterations fall to a sharp optimum at ω = 1.97",
        x_label="ω",
        y_label="iterations",
        series=tuple(series),
        y_scale="log",
    )


def _r_plot(runs: tuple[published.Run, ...], outcomes: MethodRuns) -> Plot:
    """Iterations of MAM against r for the widest ω of Table II, published and own."""
    series = []
    for omega in (1.95, 1.97):
        chosen = [run for run in runs if run in published.MAM_FINE and run.omega == omega]
        r = tuple(float(run.r or 0.0) for run in chosen)
        series.append(Series(f"ω = {omega:g}, published", r, tuple(float(run.iterations) for run in chosen)))
        own = tuple(float(outcomes[key_of(run)].iterations) for run in chosen)
        series.append(Series(f"ω = {omega:g}, own map", r, own))
    return Plot(
        name="saudi2016-r",
        title="MAM: iterations against r",
        published="Table II: for ω = 1.95 the best r lies above ω, for ω = 1.97 below",
        x_label="r",
        y_label="iterations",
        series=tuple(series),
    )
