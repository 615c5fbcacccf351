"""Möller and Paschke (1998), held against the model."""

from __future__ import annotations

import math
from statistics import fmean

import numpy as np

from codesign.planners.reproduction import Finding, Plot, Progress, Reproduction, Series
from codesign.planners.wavefront import published
from codesign.planners.wavefront.paper.maps import (
    SAMPLES,
    AdderRun,
    SafePaths,
    Sample,
    adder_run,
    compare_safe_paths,
    make_sample,
    unit_seconds,
)
from codesign.planners.wavefront.paper.rows import paper_rows
from codesign.planners.wavefront.paper.settings import WavefrontSettings
from codesign.planners.wavefront.plan.wave import MAX_OCTILE_RATIO, longest_distance, register_bits
from codesign.planners.wavefront.styles import timing

QUICK = "A quick run: two maps of five, and the adder/comparator circuit not clocked."
QUICK_SAMPLES = 2
BINS = 100


def wavefront(
    quick: bool = False, progress: Progress | None = None, settings: WavefrontSettings | None = None
) -> Reproduction:
    """Every figure of the paper that the model can be held against, with plots and findings.

    Args:
        quick: fewer maps, without one circuit: a second instead of half a minute.
        progress: gets a line on each step of the computation.
        settings: of the runs; by default as published.
    """
    settings = settings or WavefrontSettings()
    samples = []
    for name in settings.maps or list(SAMPLES)[: QUICK_SAMPLES if quick else None]:
        _report(progress, f"potentials on {name} cells")
        samples.append(make_sample(name))
    chosen = tuple(samples)
    _report(progress, "safe paths")
    safe = tuple(compare_safe_paths(sample) for sample in chosen)
    adder = None
    if not quick:
        _report(progress, "the adder/comparator circuit, clocked")
        adder = adder_run(chosen[0])
    return Reproduction(
        paper="Möller, Paschke 1998, A Simple Hardware Solution for Fast Computation of Shortest Paths",
        rows=paper_rows(chosen, safe, adder, quick),
        figures=(front_plot(chosen), direction_plot()),
        findings=findings(chosen, safe, adder),
        note=QUICK if quick else "",
    ).with_settings(settings)


def front_plot(samples: tuple[Sample, ...]) -> Plot:
    """The number of nodes that the wave locks at each cycle."""
    series = []
    for sample in samples:
        parts = np.array_split(sample.front, BINS)
        edges = np.cumsum([len(part) for part in parts])
        series.append(
            Series(sample.name, tuple(map(float, edges)), tuple(float(part.mean()) for part in parts))
        )
    return Plot(
        name="wave-front",
        title="Nodes that update their potential at a cycle, of 65,536",
        published='"only the nodes at a wave front spreading from the reference node update their potential"',
        x_label="cycle",
        y_label="nodes",
        series=tuple(series),
    )


def potential_ratio(degrees: float, straight: float, diagonal: float) -> float:
    """Potential of open ground in one direction over the straight line, with the given costs of steps."""
    angle = math.radians(degrees)
    along, across = max(math.cos(angle), math.sin(angle)), min(math.cos(angle), math.sin(angle))
    return straight * (along - across) + diagonal * across


COSTS = {"2:3 (the paper)": (1.0, 1.5), "5:7": (1.0, 1.4), "1:√2 (octagon)": (1.0, math.sqrt(2.0))}


def direction_plot() -> Plot:
    """The error of the approximations on open ground, over the direction."""
    degrees = tuple(float(angle) for angle in range(91))
    series = tuple(
        Series(name, degrees, tuple(100 * (potential_ratio(angle, *costs) - 1) for angle in degrees))
        for name, costs in COSTS.items()
    )
    return Plot(
        name="delays",
        title="Potential on open ground over the straight line",
        published='"the discretization error is small compared to the error resulting from ... an octagon"',
        x_label="direction, degrees",
        y_label="longer than the straight line, %",
        series=series,
    )


def largest_error(costs: tuple[float, float]) -> float:
    """The largest error of the approximation on open ground, relative to the straight line.

    >>> round(largest_error(COSTS["2:3 (the paper)"]), 3), round(largest_error(COSTS["1:√2 (octagon)"]), 3)
    (0.118, 0.082)
    """
    return math.hypot(costs[0], costs[1] - costs[0]) - 1


def findings(
    samples: tuple[Sample, ...], safe: tuple[SafePaths, ...], adder: AdderRun | None
) -> tuple[Finding, ...]:
    """The conclusions from the rows."""
    return (
        *_time_findings(samples),
        *_circuit_findings(samples),
        _footnote_finding(),
        _safe_finding(safe),
        *(() if adder is None else (_adder_finding(samples[0], adder),)),
    )


def _time_findings(samples: tuple[Sample, ...]) -> tuple[Finding, ...]:
    """The one cost that is fitted, and the speed-up."""
    unit = unit_seconds(samples)
    reached = [sample.reached for sample in samples]
    wave, cells = published.STOP_CYCLE / published.CLOCK, published.SIDE**2
    load, slow_load = (
        timing.load_cycles((published.SIDE, published.SIDE)) / published.CLOCK,
        cells / published.CLOCK,
    )
    slow_speed_up = published.SOFTWARE_SECONDS / (wave + slow_load)
    return (
        Finding(
            "One cost is fitted, that of a node on the Pentium, and nothing published is left to test it.",
            {
                "cost of a node": f"{1e6 * unit:.2f} µs",
                "cycles of a node": f"{unit * published.SOFTWARE_CLOCK:.0f}",
                "nodes reached, least": f"{min(reached):,}",
                "nodes reached, most": f"{max(reached):,}",
            },
        ),
        Finding(
            "The published speed-up of 1000 leaves out the loading of the map.",
            {
                "63 ms over 68 µs": f"{published.SOFTWARE_SECONDS / published.PLAN_SECONDS:.0f}",
                "loading": f"{1e6 * load:.0f} µs",
                "loading over the wave": f"{load / wave:.1f}",
                "loading bit by bit": f"{1e3 * slow_load:.1f} ms",
                "speed-up with it": f"{slow_speed_up:.0f}",
            },
            slow_speed_up < 100,
        ),
    )


def _circuit_findings(samples: tuple[Sample, ...]) -> tuple[Finding, ...]:
    """The obstacle map, and the register that safe paths need."""
    needed = max(int(sample.obstacle_potentials.max()) for sample in samples)
    longest = longest_distance((published.SIDE, published.SIDE))
    return (
        Finding(
            "The obstacle map needs fewer than the published 768 cycles.",
            {
                "longest distance": str(longest),
                "cycles": str(longest + 1),
                "farthest on our maps": str(needed),
            },
            longest + 1 < 768,
        ),
        Finding(
            "Safe paths need two potentials at once, and the circuit has one register for each node.",
            {"flip-flops more": str(register_bits(longest)), "words to read out": f"{published.SIDE**2:,}"},
        ),
    )


def _footnote_finding() -> Finding:
    both, octagon, finer = (
        largest_error(COSTS[name]) for name in ("2:3 (the paper)", "1:√2 (octagon)", "5:7")
    )
    figures = {"2:3": f"{MAX_OCTILE_RATIO - 1:.1%}", "octagon": f"{octagon:.1%}", "both": f"{both:.1%}"}
    return Finding(
        "The error of 2:3 is not small against that of the octagon.",
        {**figures, "5:7": f"{finer:.1%}"},
        0.5 * octagon < MAX_OCTILE_RATIO - 1,
    )


def _safe_finding(safe: tuple[SafePaths, ...]) -> Finding:
    arrived = 100 * min(comparison.arrived for comparison in safe)
    longer = 100 * (fmean(comparison.longer for comparison in safe) - 1)
    farther = fmean(comparison.clearance / comparison.shortest_clearance for comparison in safe)
    return Finding(
        "Safe paths arrive from every tracked cell, as the paper guarantees.",
        {
            "arrived": f"{arrived:.0f} %",
            "longer than the shortest": f"{longer:.0f} %",
            "clearance over that of the shortest": f"{farther:.1f}",
        },
        arrived == 100,
    )


def _adder_finding(sample: Sample, adder: AdderRun) -> Finding:
    cycles = sample.stop_potential + 1
    return Finding(
        "The adder/comparator array takes fewer cycles than the wave.",
        {
            "cycles of the array": str(adder.cycles),
            "cycles of the wave": str(cycles),
            "clock that the wave needs, over the array's": f"{cycles / adder.cycles:.1f}",
            "updates of a node, mean": f"{adder.mean_updates:.2f}",
            "updates of a node, most": str(adder.most_updates),
        },
        adder.cycles < cycles,
    )


def _report(progress: Progress | None, step: str) -> None:
    if progress is not None:
        progress(step)
