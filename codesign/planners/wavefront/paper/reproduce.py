"""Möller and Paschke (1998), held against the model."""

from __future__ import annotations

import math
from statistics import fmean

import numpy as np

from codesign.planners.reproduction import Plot, Progress, Reproduction, Series
from codesign.planners.wavefront import published
from codesign.planners.wavefront.paper.maps import (
    SAMPLES,
    AdderRun,
    SafeWays,
    Sample,
    adder_run,
    safe_ways,
    sample,
    unit_seconds,
)
from codesign.planners.wavefront.paper.rows import paper_rows
from codesign.planners.wavefront.plan.wave import MAX_OCTILE_RATIO, longest_distance, register_bits
from codesign.planners.wavefront.styles import timing

QUICK = ("A quick run: two maps of five, and the adder/comparator circuit not clocked.",)
QUICK_SAMPLES = 2
BINS = 100


def wavefront(quick: bool = False, progress: Progress | None = None) -> Reproduction:
    """Every figure of the paper that the model can be held against, with plots and findings.

    Args:
        quick: fewer maps, and one circuit left out: a second instead of half a minute.
        progress: told in a line what is being computed.
    """
    samples = []
    for name in list(SAMPLES)[: QUICK_SAMPLES if quick else None]:
        _tell(progress, f"potentials on {name} cells")
        samples.append(sample(name))
    chosen = tuple(samples)
    _tell(progress, "safe ways")
    safe = tuple(safe_ways(one) for one in chosen)
    adder = None
    if not quick:
        _tell(progress, "the adder/comparator circuit, clocked")
        adder = adder_run(chosen[0])
    return Reproduction(
        paper="Möller, Paschke 1998, A Simple Hardware Solution for Fast Computation of Shortest Paths",
        rows=paper_rows(chosen, safe, adder, quick),
        figures=(front_plot(chosen), direction_plot()),
        findings=(*QUICK * quick, *findings(chosen, safe, adder)),
    )


def front_plot(samples: tuple[Sample, ...]) -> Plot:
    """How many nodes the wave locks at each cycle."""
    series = []
    for one in samples:
        parts = np.array_split(one.front, BINS)
        edges = np.cumsum([len(part) for part in parts])
        series.append(Series(one.name, tuple(map(float, edges)), tuple(float(part.mean()) for part in parts)))
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
    samples: tuple[Sample, ...], safe: tuple[SafeWays, ...], adder: AdderRun | None
) -> tuple[str, ...]:
    """What the rows come to, made from the data."""
    unit = unit_seconds(samples)
    reached = [one.reached for one in samples]
    wave, cells = published.STOP_CYCLE / published.CLOCK, published.SIDE**2
    load = timing.load_cycles(cells) / published.CLOCK
    slow_load = cells / published.CLOCK
    needed = max(int(one.obstacle_potentials.max()) for one in samples)
    longest = longest_distance((published.SIDE, published.SIDE))
    found = [
        f"Nothing but one cost is fitted: {1e6 * unit:.2f} µs of the Pentium for a node reached, from 63 ms and the"
        f" {min(reached):,} to {max(reached):,} nodes that the wave reaches on maps of about the paper's path. That is"
        f" {unit * published.SOFTWARE_CLOCK:.0f} cycles a node with eight neighbours. Nothing published is left to hold"
        " this fit against.",
        f"63 ms over 68 µs is {published.SOFTWARE_SECONDS / published.PLAN_SECONDS:.0f}, which the paper rounds to"
        f" 1000. It leaves out the map: writing one bit to every node, {timing.LOAD_CELLS} a cycle (assumed), takes"
        f" {1e6 * load:.0f} µs, {load / wave:.1f} times the wave; one bit a cycle would take {1e3 * slow_load:.1f} ms,"
        f" and the speed-up would be {published.SOFTWARE_SECONDS / (wave + slow_load):.0f}.",
        f"768 cycles for the obstacle map are three for each of 256 nodes; the diagonal has 255 steps, so {longest} is"
        f" the longest distance and {longest + 1} cycles are enough. On the generated maps no node is farther than"
        f" {needed} from an obstacle.",
        "Safe paths need p^d and p^t at once, and the circuit has one register a node. The paper does not say where p^d"
        f" stays: a second register takes {register_bits(longest)} flip-flops a node more, reading it out"
        f" {cells:,} words.",
        _footnote_finding(),
        _safe_finding(safe),
    ]
    if adder is not None:
        found.append(_adder_finding(samples[0], adder))
    return tuple(found)


def _footnote_finding() -> str:
    both, octagon, finer = (
        largest_error(COSTS[name]) for name in ("2:3 (the paper)", "1:√2 (octagon)", "5:7")
    )
    return (
        "Footnote 1 calls the error of 2:3 small against that of the octagon. It is"
        f" {MAX_OCTILE_RATIO - 1:.1%} against {octagon:.1%}, and both together {both:.1%} (at 26.6°). Delays of 5"
        f" and 7 would bring the sum to {finer:.1%}, at 2.5 times the cycles and four more flip-flops a node."
    )


def _safe_finding(safe: tuple[SafeWays, ...]) -> str:
    arrived = 100 * min(one.arrived for one in safe)
    longer = 100 * (fmean(one.longer for one in safe) - 1)
    farther = fmean(one.clearance / one.shortest_clearance for one in safe)
    return (
        f"Safe ways arrive from {arrived:.0f} % of the tracked cells (the paper: guaranteed), and are {longer:.0f} %"
        f" longer than the shortest; their mean distance from obstacles is {farther:.1f} times that of shortest ways."
    )


def _adder_finding(one: Sample, adder: AdderRun) -> str:
    cycles = one.stop_potential + 1
    return (
        "Against the adder/comparator array the paper claims less hardware and less time. Less hardware holds in LUT,"
        f" not in flip-flops. In cycles the adder array takes {adder.cycles} for the whole of {one.name} cells, the"
        f" wave {cycles} to the stop alone: it is ahead in time only where its clock is at least"
        f" {cycles / adder.cycles:.1f} times faster. Nodes of the adder array update {adder.mean_updates:.2f} times on"
        f" average and {adder.most_updates} at most (the paper: once or a few times)."
    )


def _tell(progress: Progress | None, what: str) -> None:
    if progress is not None:
        progress(what)
