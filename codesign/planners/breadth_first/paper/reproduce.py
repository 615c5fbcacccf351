"""The reproduction of Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008)."""

from __future__ import annotations

from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.paper.fit import Fit, fit, java_cell_seconds, least_popped
from codesign.planners.breadth_first.paper.settings import BreadthFirstSettings
from codesign.planners.breadth_first.paper.tables import (
    CLOCKS,
    all_rows,
    expansion_cycles,
    hardware_microseconds,
)
from codesign.planners.breadth_first.plan.parameters import MicroArchitecture
from codesign.planners.reproduction import Finding, Plot, Progress, Reproduction, Row, Series, Use, silent

QUICK = "A quick run: fewer maps and families than in the full one, whose choice may differ."


def breadth_first(
    quick: bool = False, progress: Progress = silent, settings: BreadthFirstSettings | None = None
) -> Reproduction:
    """Every row of the paper that the model can be compared with, a plot and findings.

    Args:
        quick: fewer maps and families: seconds instead of half a minute.
        progress: called with a line for each part of the work.
        settings: of the runs; by default as published.
    """
    settings = settings or BreadthFirstSettings()
    chosen = fit(quick, progress, settings.maps)
    rows = all_rows(chosen)
    return Reproduction(
        paper="Vacariu, Roman, Timar, Stanciu, Banabic, Cret 2008, Mobile robot path-planning in software and hardware",
        rows=rows,
        figures=(times_plot(chosen),),
        findings=(*_fit_findings(chosen, rows), *_clash_findings(chosen, rows)),
        note=QUICK if quick else "",
    ).with_settings(settings)


def times_plot(chosen: Fit) -> Plot:
    """Tables 2 and 3 against the model, over the side of the map."""
    sides = tuple(float(run.side) for run in published.HARDWARE)
    series = []
    for name, clock in CLOCKS.items():
        microseconds = tuple(
            run.microseconds_at_120 if name == "Table 2" else run.microseconds_at_150
            for run in published.HARDWARE
        )
        modelled = tuple(hardware_microseconds(chosen, run, clock)[0] for run in published.HARDWARE)
        series += [
            Series(f"{name}, published", sides, microseconds),
            Series(f"{name}, modelled", sides, modelled),
        ]
    return Plot(
        name="vacariu-tables-2-3",
        title="Tables 2 and 3: time of the circuit",
        published="execution times of one map a size, at 120 and 150 MHz",
        x_label="side of the map, cells",
        y_label="time, µs",
        series=tuple(series),
        x_scale="log",
        y_scale="log",
    )


def _errors(rows: tuple[Row, ...], name: str) -> dict[str, str]:
    return {f"{name}, {row.quantity.split(', ')[1]}": f"{row.error or 0.0:+.1%}" for row in rows}


def _fit_findings(chosen: Fit, rows: tuple[Row, ...]) -> tuple[Finding, ...]:
    """The errors of the chosen maps and micro-architecture, and the cost of the Java program."""
    best = chosen.candidate
    second = [row for row in rows if row.table == "Table 2" and row.error is not None]
    fitted = tuple(row for row in second if row.use is Use.FITTED)
    held_out = tuple(row for row in second if row.use is Use.HELD_OUT)
    sparse = chosen.sample(30, 0.25)
    first = [row for row in rows if row.table == "Table 1"]
    first_held_out = [row for row in first if row.use is Use.HELD_OUT]
    outside = [row for row in first_held_out if row.note.startswith("outside")]
    return (
        Finding(
            "Three cycles a neighbour, without Init and Path in the timed part, explain Tables 2 and 3 best.",
            {
                "candidates": str(chosen.candidates),
                "maps for 25 %": str(best.sparse),
                "maps for 50 %": str(best.dense),
                "b": str(expansion_cycles(chosen)),
                **_errors(fitted, "error, fitted"),
                **_errors(held_out, "error, held out"),
            },
            best.micro_architecture is MicroArchitecture.THREE_CYCLES
            and not best.init_timed
            and not best.path_timed,
        ),
        Finding(
            "One map says nothing: the cycles scatter from map to map.",
            {"standard deviation at 30×30": f"{float(sparse.popped.std() / sparse.popped.mean()):.0%}"},
            float(sparse.popped.std()) > 0.3 * float(sparse.popped.mean()),
        ),
        Finding(
            "One cost for each popped cell does not fit both Java rows of 100×100.",
            {
                "cost of a popped cell": f"{java_cell_seconds(chosen) * 1e6:.1f} µs",
                **{row.quantity: f"{row.error or 0.0:+.1%}" for row in first if row.use is Use.FITTED},
                "times held out": str(len(first_held_out)),
                "of these within the tick": str(len(first_held_out) - len(outside)),
            },
            max(abs(row.error or 0.0) for row in first if row.use is Use.FITTED) > 0.3,
        ),
    )


def _clash_findings(chosen: Fit, rows: tuple[Row, ...]) -> tuple[Finding, ...]:
    """Statements of the paper that contradict each other."""
    differences = {run.side: abs(run.cycles_at_120 / run.cycles_at_150 - 1) for run in published.HARDWARE}
    dense = [run for run in published.HARDWARE if run.obstacles >= 0.5]
    too_fast = [
        f"{str(micro).replace('_', ' ')}{' with Init timed' if init else ''}"
        for micro in MicroArchitecture
        for init in (False, True)
        if any(least_popped(run, micro, init) > (1 - run.obstacles) * run.side**2 for run in dense)
    ]
    slow = [row for row in rows if row.table == "Section 4" and "less" in row.note]
    filled = chosen.sample(100, 0.5).filled
    refresh = [float(row.modelled or 0) for row in rows if row.table == "Section 3.1.1"]
    java = {(run.side, run.obstacles): run.milliseconds for run in published.SOFTWARE}
    ratio = java[100, 0.25] / java[100, 0.5]
    popped = chosen.sample(100, 0.25).popped.mean() / chosen.sample(100, 0.5).popped.mean()
    largest = next(row.modelled for row in rows if row.quantity.startswith("side of the largest"))
    shortest = next(row.modelled for row in rows if row.quantity.startswith("share of paths"))
    return (
        Finding(
            "The two clocks disagree on the cycles of one map.",
            {f"{side}×{side}": f"{share:.1%}" for side, share in differences.items()},
            max(differences.values()) > 0.01,
        ),
        Finding(
            "With half of the cells free, no map has enough cells to pop for these times on a faster circuit.",
            {"circuits": ", ".join(too_fast)},
            bool(too_fast),
        ),
        Finding(
            'Obstacles of "50 %" cannot be thrown singly and uniformly: no path would join the corners.',
            {"covered on the chosen maps of 100×100": f"{filled:.0%}"},
            filled < 0.5,
        ),
        Finding(
            '"At least two orders of magnitude" does not hold in every row.',
            {row.quantity.split(", ", 1)[1]: f"{float(row.published or 0):.0f}" for row in slow},
            bool(slow),
        ),
        Finding(
            "65 MHz and 60 Hz are not 800×600.",
            {"refresh of 800×600": f"{refresh[0]:.0f} Hz", "refresh of 1024×768": f"{refresh[1]:.1f} Hz"},
            refresh[0] > 65,
        ),
        Finding(
            '"80 % of the times optimal" cannot be said of breadth-first search on cells of equal cost.',
            {"shortest paths": f"{shortest:.0f} %"},
            shortest == 100,
        ),
        Finding(
            "The Java times and the circuit's times cannot be of the same maps at one cost for each cell.",
            {"time of 25 % over 50 %": f"{ratio:.0f}", "popped cells of 25 % over 50 %": f"{popped:.1f}"},
            bool(popped < 0.5 * ratio),
        ),
        Finding(
            "Maps larger than 100×100 do fit into the block RAMs.",
            {"largest map": f"{largest}×{largest}"},
            float(largest or 0) > 100,
        ),
    )
