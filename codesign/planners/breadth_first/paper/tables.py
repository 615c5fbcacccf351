"""Rows of Vacariu et al. (2008): Tables 1 to 3, and the numbers of its text."""

from __future__ import annotations

from functools import partial
from statistics import fmean

import numpy as np

from codesign import maps
from codesign.figures import Status
from codesign.inputs.part_file import load_part
from codesign.part import Part
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.paper.fit import FIT_SIDES, SOFTWARE_FIT_SIDE, Fit, java_cell_seconds
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.parameters import SearchParameters, VgaController
from codesign.planners.breadth_first.styles import resources, timing
from codesign.planners.breadth_first.styles.software import JAVA_BYTES_A_CELL, JAVA_HEAP
from codesign.planners.reproduction import Row, Use, row

PART = "XC2VP30-6"
SVGA_PIXELS = 1056 * 628
XGA_PIXELS = 1344 * 806
"""Pixel periods of a frame, blanking included: VESA timings of 800×600 and of 1024×768 at 60 Hz."""
CLOCKS = {"Table 2": 120_000_000, "Table 3": 150_000_000}
OPTIMAL_MAPS = 40


def hardware_microseconds(chosen: Fit, run: published.HardwareRun, clock: int) -> tuple[float, float, float]:
    """Modelled µs of a row at ``clock`` Hz: mean over the maps, 10th and 90th percentile."""
    mean, low, high = (cycles / clock * 1e6 for cycles in chosen.cycles(run.side, run.obstacles))
    return mean, low, high


def software_milliseconds(chosen: Fit, side: int, obstacles: float) -> float:
    """Modelled ms of a row of Table 1."""
    return java_cell_seconds(chosen) * float(chosen.sample(side, obstacles).popped.mean()) * 1e3


def spreading(chosen: Fit, side: int, obstacles: float) -> str:
    """Spreading of a row in words."""
    searches = chosen.sample(side, obstacles)
    cells = float(searches.spreading.mean())
    return f"spreading {cells:.0f} cells, {cells / (cells + float(searches.steps.mean()) + 1):.0%} of those pushed"


def table_1(chosen: Fit) -> list[Row]:
    """The Java program."""
    rows = []
    for run in published.SOFTWARE:
        modelled = software_milliseconds(chosen, run.side, run.obstacles)
        inside = abs(modelled - run.milliseconds) <= published.SOFTWARE_TICK_MS
        rows.append(
            row(
                "Table 1",
                f"time of the Java program, {run.side}×{run.side}, {run.obstacles:.0%}",
                run.milliseconds / 1e3 if run.milliseconds else "almost 0",
                modelled / 1e3,
                unit="s",
                status=Status.CALIBRATED,
                source="one cost for a popped cell, on the maps fitted to Table 2",
                use=Use.FITTED if run.side == SOFTWARE_FIT_SIDE else Use.HELD_OUT,
                note=f"{'within' if inside else 'outside of'} the tick of ±{published.SOFTWARE_TICK_MS} ms; published"
                f" spreading {run.spreading}; {spreading(chosen, run.side, run.obstacles)}",
            )
        )
    wall = int((JAVA_HEAP / JAVA_BYTES_A_CELL) ** 0.5)
    rows.append(
        row(
            "Section 2.2",
            "largest side that the Java program holds",
            "100 to 199",
            wall,
            status=Status.ASSUMED,
            source=f"{JAVA_BYTES_A_CELL:,.0f} bytes a cell in a heap of {JAVA_HEAP >> 20} MB",
            use=Use.FITTED,
            note="the geometric mean of what the two sizes bound; nothing else is known",
        )
    )
    return rows


def tables_2_and_3(chosen: Fit) -> list[Row]:
    """The circuit at 120 and at 150 MHz, and at the 185 MHz of its synthesis."""
    rows = []
    for table, clock in CLOCKS.items():
        for run in published.HARDWARE:
            mean, low, high = hardware_microseconds(chosen, run, clock)
            microseconds = run.microseconds_at_120 if table == "Table 2" else run.microseconds_at_150
            rows.append(
                row(
                    table,
                    f"time at {clock // 10**6} MHz, {run.side}×{run.side}, {run.obstacles:.0%}",
                    microseconds / 1e6,
                    mean / 1e6,
                    unit="s",
                    status=Status.CALIBRATED,
                    source=f"b(V - 1), mean over {chosen.maps} maps: {chosen.candidate.family(run.obstacles)}",
                    use=Use.FITTED if run.side in FIT_SIDES else Use.HELD_OUT,
                    note=f"10th to 90th percentile {low:.2f} to {high:.2f} µs;"
                    f" {spreading(chosen, run.side, run.obstacles)}",
                )
            )
    largest = published.HARDWARE[-1]
    mean, _, _ = hardware_microseconds(chosen, largest, published.CLOCK_LIMIT)
    rows.append(
        row(
            "Section 3.2",
            f"time at the maximum of 185 MHz, {largest.side}×{largest.side}, {largest.obstacles:.0%}",
            None,
            mean / 1e6,
            unit="s",
            status=Status.CALIBRATED,
            source="the same cycles; the paper gives the clock and no time",
            use=Use.NOTHING,
        )
    )
    return rows


def proportion_rows() -> list[Row]:
    """Time at 120 MHz over time at 150 MHz, from the paper's own numbers."""
    return [
        row(
            "Tables 2, 3",
            f"time at 120 MHz over time at 150 MHz, {run.side}×{run.side}",
            run.microseconds_at_120 / run.microseconds_at_150,
            150 / 120,
            status=Status.PUBLISHED,
            source="the same cycles at both clocks",
            use=Use.HELD_OUT,
            note=f"{run.cycles_at_120:,.0f} cycles at 120 MHz, {run.cycles_at_150:,.0f} at 150 MHz",
        )
        for run in published.HARDWARE
    ]


def speed_up_rows(chosen: Fit) -> list[Row]:
    """Software over hardware at 120 MHz, for the maps in both tables."""
    rows = []
    software = {(run.side, run.obstacles): run for run in published.SOFTWARE}
    for run in published.HARDWARE:
        same = software.get((run.side, run.obstacles))
        if same is None:
            continue
        mean, _, _ = hardware_microseconds(chosen, run, CLOCKS["Table 2"])
        ratio = same.milliseconds * 1e3 / run.microseconds_at_120
        rows.append(
            row(
                "Section 4",
                f"software over hardware at 120 MHz, {run.side}×{run.side}, {run.obstacles:.0%}",
                ratio,
                software_milliseconds(chosen, run.side, run.obstacles) * 1e3 / mean,
                status=Status.CALIBRATED,
                source="Table 1 over Table 2, and the same of the models",
                use=Use.FITTED if run.side in FIT_SIDES else Use.HELD_OUT,
                note='"at least two orders of magnitude"'
                + (": the paper's own numbers give less" if ratio < 100 else ""),
            )
        )
    return rows


def memory_rows(part: Part) -> list[Row]:
    """Rows on the resources of the chip."""
    alone = SearchParameters(display=VgaController.NONE)
    budget = int(part.resources["block_rams"].value)
    need = resources.block_ram_total(100, 100, alone, part)
    counts = [
        resources.counted(piece, (100, 100), SearchParameters(), part)
        for piece in ("state machine", "display")
    ]
    share = 100 * sum(lut4.amount for lut4, _ in counts) / part.resources["lut4"].value
    law = "cells and directions of 2 bits, a queue of addresses, row and column side by side"
    section = partial(row, "Section 3.2", use=Use.HELD_OUT)
    return [
        section(
            "block RAMs for 100×100 cells",
            "fits",
            need,
            status=Status.MEASURED,
            source=f"{law}; RTL of this package",
            note=f"of {budget} (assumed)",
        ),
        section(
            "side of the largest map in block RAM",
            '100; "a lot larger maps cannot"',
            resources.largest_side(alone, part),
            status=Status.MEASURED,
            source=law,
            note=f"{resources.block_ram_total(256, 256, alone, part)} block RAMs for 256×256",
        ),
        section(
            f"LUT of {part.name} at 100×100 cells",
            "a small fraction",
            share,
            unit="%",
            status=Status.CALIBRATED,
            source="synthesis of the RTL of this package, with its display; the part's budget is assumed",
            note=f"its block RAMs: {100 * need / budget:.0f} %",
        ),
    ]


def display_rows() -> list[Row]:
    """The display's clock against its refresh."""
    return [
        row(
            "Section 3.1.1",
            f"refresh of 800×600 at 65 MHz, {name}",
            published.DISPLAY_REFRESH,
            published.DISPLAY_CLOCK / pixels,
            unit="Hz",
            status=Status.PUBLISHED,
            source=f"65 MHz over {pixels:,} pixel periods a frame (VESA)",
            use=Use.HELD_OUT,
            note=note,
        )
        for name, pixels, note in (
            ("timing of 800×600", SVGA_PIXELS, "60 Hz would take 40 MHz"),
            ("timing of 1024×768", XGA_PIXELS, "65 MHz is the pixel clock of 1024×768 at 60 Hz"),
        )
    ]


def optimal_row() -> Row:
    """The share of paths that are shortest."""
    optimal = []
    for seed in range(OPTIMAL_MAPS):
        free = maps.random_obstacles(30, 30, density=0.25, seed=seed).free
        cells = np.argwhere(maps.reachable(free, [maps.nearest_free(free, (0, 0)) or (0, 0)]))
        start, goal = (tuple(int(index) for index in cell) for cell in (cells[0], cells[-1]))
        steps = search(free, (start[0], start[1]), (goal[0], goal[1])).path_steps
        optimal.append(steps == int(maps.distance_steps(free, [(goal[0], goal[1])])[start]))
    return row(
        "Section 2.2",
        "share of paths that are shortest, small maps",
        80,
        100 * fmean(optimal),
        unit="%",
        status=Status.MEASURED,
        source=f"{OPTIMAL_MAPS} maps of 30×30, 25 %, against an independent distance",
        use=Use.HELD_OUT,
        note="breadth-first search finds a shortest path always",
    )


def all_rows(chosen: Fit) -> tuple[Row, ...]:
    """Every row, in the paper's order."""
    part = load_part(PART)
    return (
        *table_1(chosen),
        optimal_row(),
        *display_rows(),
        *tables_2_and_3(chosen),
        *proportion_rows(),
        *memory_rows(part),
        *speed_up_rows(chosen),
    )


def expansion_cycles(chosen: Fit) -> int:
    """b of the chosen micro-architecture."""
    return timing.EXPANSION_CYCLES[chosen.candidate.micro_architecture]
