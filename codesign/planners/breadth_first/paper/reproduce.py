"""Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008), held against the model."""

from __future__ import annotations

from statistics import fmean

from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.paper.fit import Fit, fit, java_cell_seconds, least_popped
from codesign.planners.breadth_first.paper.tables import (
    CLOCKS,
    all_rows,
    expansion_cycles,
    hardware_microseconds,
)
from codesign.planners.breadth_first.plan.parameters import MicroArchitecture
from codesign.planners.reproduction import Plot, Progress, Reproduction, Row, Series, Use

QUICK = ("A quick run: fewer maps and families than in the full one, whose choice may differ.",)


def breadth_first(quick: bool = False, progress: Progress | None = None) -> Reproduction:
    """Every row of the paper that the model can be held against, a plot and findings.

    Args:
        quick: fewer maps and families: seconds instead of half a minute.
        progress: told in a line what is being computed.
    """
    chosen = fit(quick, progress)
    rows = all_rows(chosen)
    return Reproduction(
        paper="Vacariu, Roman, Timar, Stanciu, Banabic, Cret 2008, Mobile robot path-planning in software and hardware",
        rows=rows,
        figures=(times_plot(chosen),),
        findings=(*QUICK * quick, *_fit_findings(chosen, rows), *_clash_findings(chosen, rows)),
    )


def times_plot(chosen: Fit) -> Plot:
    """Tables 2 and 3 against the model, over the side of the map."""
    sides = tuple(float(one.side) for one in published.HARDWARE)
    series = []
    for name, clock in CLOCKS.items():
        given = tuple(
            one.microseconds_at_120 if name == "Table 2" else one.microseconds_at_150
            for one in published.HARDWARE
        )
        modelled = tuple(hardware_microseconds(chosen, one, clock)[0] for one in published.HARDWARE)
        series += [Series(f"{name}, published", sides, given), Series(f"{name}, modelled", sides, modelled)]
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


def _percent(values: list[float]) -> str:
    return ", ".join(f"{value:+.1%}" for value in values)


def _fit_findings(chosen: Fit, rows: tuple[Row, ...]) -> tuple[str, ...]:
    best = chosen.candidate
    timed = [name for name, on in (("Init", best.init_timed), ("Path", best.path_timed)) if on]
    second = [one for one in rows if one.table == "Table 2" and one.error is not None]
    fitted = [one.error or 0.0 for one in second if one.use is Use.FITTED]
    held_out = [one.error or 0.0 for one in second if one.use is Use.HELD_OUT]
    sparse = chosen.sample(30, 0.25)
    spread = float(sparse.popped.std() / sparse.popped.mean())
    first = [one for one in rows if one.table == "Table 1"]
    apart = [one for one in first if one.use is Use.HELD_OUT]
    outside = [one.quantity.split(", ", 1)[1] for one in apart if one.note.startswith("outside")]
    reading = f"{len(apart) - len(outside)} of the {len(apart)} times held out"
    return (
        f"Tables 2 and 3 are best explained, of {chosen.candidates} candidates, by maps of {best.sparse} for 25 % and"
        f" {best.dense} for 50 %, b = {expansion_cycles(chosen)} ({str(best.micro_architecture).replace('_', ' ')} a"
        f" neighbour), and {' and '.join(timed) or 'neither Init nor Path'} in the timed part. Errors on Table 2:"
        f" {_percent(fitted)} on the rows that chose it, {_percent(held_out)} on those held out.",
        f"That is a calibration on three numbers with {chosen.candidates} candidates, and one map a row: on such maps"
        f" the cycles at 30×30 scatter by {spread:.0%} (one standard deviation). State ±10 % on means of many"
        " maps, and nothing on one map.",
        f"Java: {java_cell_seconds(chosen) * 1e6:.1f} µs a popped cell, from the two 100×100 rows, which it misses by"
        f" {_percent([one.error or 0.0 for one in first if one.use is Use.FITTED])}; {reading} are met within the tick"
        f" of {published.SOFTWARE_TICK_MS} ms" + (f"; {' and '.join(outside)} is not." if outside else "."),
    )


def _clash_findings(chosen: Fit, rows: tuple[Row, ...]) -> tuple[str, ...]:
    """What in the paper cannot hold together."""
    apart = {one.side: one.cycles_at_120 / one.cycles_at_150 - 1 for one in published.HARDWARE}
    dense = [one for one in published.HARDWARE if one.obstacles >= 0.5]
    too_fast = [
        f"{str(micro).replace('_', ' ')}{' with Init timed' if init else ''}"
        for micro in MicroArchitecture
        for init in (False, True)
        if any(least_popped(one, micro, init) > (1 - one.obstacles) * one.side**2 for one in dense)
    ]
    slow = [one for one in rows if one.table == "Section 4" and "less" in one.note]
    filled = chosen.sample(100, 0.5).filled
    refresh = [one.modelled for one in rows if one.table == "Section 3.1.1"]
    java = {(one.side, one.obstacles): one.milliseconds for one in published.SOFTWARE}
    ratio = java[100, 0.25] / java[100, 0.5]
    popped = chosen.sample(100, 0.25).popped.mean() / chosen.sample(100, 0.5).popped.mean()
    largest = next(one.modelled for one in rows if one.quantity.startswith("side of the largest"))
    shortest = next(one.modelled for one in rows if one.quantity.startswith("share of paths"))
    return (
        "The two clocks disagree on the cycles of one map, by "
        + ", ".join(f"{abs(share):.1%} at {side}×{side}" for side, share in apart.items())
        + ': "the execution time diminishes proportionally" does not hold to better than that, and no deterministic'
        " model can.",
        "No map whatever with half of its cells free has cells enough to pop for these times with"
        f" {', '.join(too_fast)}: the circuit was not that fast, or the share of obstacles was lower than stated."
        if too_fast
        else "Every micro-architecture has maps that it could have taken these times on.",
        f'"50 %" of obstacles thrown singly and uniformly leaves no way between corners: a 4-connected grid falls apart'
        f" above about 41 %. The maps chosen here have {filled:.0%} of the 100×100 covered, border included.",
        f'"At least two orders of magnitude": {", ".join(one.quantity.split(", ", 1)[1] for one in slow)} gives'
        f" {fmean(float(one.published or 0) for one in slow):.0f} by the paper's own Tables 1 and 2."
        if slow
        else "Two orders of magnitude hold in every row that both tables have.",
        f"65 MHz and 60 Hz are not 800×600: its timing would refresh at {refresh[0]:.0f} Hz; 1024×768 gives"
        f" {refresh[1]:.1f} Hz. Either the screen or the clock is another one.",
        f'"80 % of the times optimal" cannot be said of breadth-first search on cells of equal cost: {shortest:.0f} %'
        " of the paths are shortest here, as they must be.",
        f"Java at 100×100 takes {ratio:.0f} times as long with 25 % as with 50 % of obstacles, where the maps that"
        f" explain the circuit give {popped:.1f} times the popped cells: not the same maps at one cost a cell.",
        f'"A lot larger maps cannot be stored into the BlockRAMs": {largest}×{largest} can, a size that the Java'
        " program ran out of memory on.",
    )
