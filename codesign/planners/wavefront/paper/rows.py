"""The figures of Möller and Paschke (1998) as rows, in the order of the paper."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from statistics import fmean

import numpy as np

from codesign.figures import Status
from codesign.planners.reproduction import Row, Use, row
from codesign.planners.wavefront import published
from codesign.planners.wavefront.paper.maps import AdderRun, SafePaths, Sample, unit_seconds
from codesign.planners.wavefront.plan.skeleton import skeleton
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits, stop_cycle
from codesign.planners.wavefront.styles import resources
from codesign.planners.wavefront.styles.layout import ArrayLayout

BITS = register_bits(published.STOP_POTENTIAL)
PARTS = ("XC4VLX160-12", "XC2V6000-4", "XC2VP30-6", "XC3S500E-4")
HARDWARE, SHORTEST, SAFE = "Hardware", "Shortest Paths", "Safe Paths"

published_law = partial(row, status=Status.PUBLISHED, use=Use.HELD_OUT)
measured = partial(row, status=Status.MEASURED, use=Use.HELD_OUT)
unpublished = partial(row, status=Status.MEASURED, use=Use.NOTHING)
"""Rows held out: by a law of the paper, by a measurement; and a measurement without a published figure."""


def paper_rows(
    samples: tuple[Sample, ...], safe: tuple[SafePaths, ...], adder: AdderRun | None, quick: bool
) -> tuple[Row, ...]:
    """Every row."""
    return (
        *_node_rows(),
        *_footnote_rows(),
        *_wave_rows(samples, quick),
        *_time_rows(samples),
        *_front_rows(samples, adder),
        *_safe_rows(samples, safe),
        *_part_rows(),
    )


def _node_rows() -> Iterator[Row]:
    """The node against that of Hassoun and Sanghvi."""
    layout = ArrayLayout((published.SIDE, published.SIDE), BITS)
    adders = replace(layout, adders=True)
    family = resources.LAWS.table["similar"]
    bare, chained = (
        resources.lut4(resources.NODES, replace(adders, chain=chain), family)
        / resources.lut4(resources.NODES, replace(layout, chain=chain), family)
        for chain in (False, True)
    )
    flip_flops = [each.node_flip_flops for each in (layout, adders)]
    own = f"RTL of this package, synthesised for {family}, R = {BITS}"
    yield published_law(
        HARDWARE,
        "delay elements a node",
        published.DELAY_ELEMENTS,
        layout.line,
        source="as many as the longest delay",
    )
    yield published_law(
        HARDWARE,
        "wires from a node to its neighbours",
        1,
        1,
        source="Y, Figure 2",
        note=f"{BITS} for adders and comparators",
    )
    yield measured(
        HARDWARE,
        "LUT, adder/comparator node over delay-line node",
        "radically reduced",
        bare,
        source=own,
        note=f"{chained:.1f} with a chain that reads the registers out",
    )
    yield measured(
        HARDWARE,
        "flip-flops, adder/comparator node over delay-line node",
        "radically reduced",
        flip_flops[1] / flip_flops[0],
        source=own,
        note=f"{flip_flops[1]} against {flip_flops[0]}: not saved",
    )
    yield unpublished(
        HARDWARE,
        "flip-flops of all nodes",
        None,
        layout.nodes * flip_flops[0],
        source=own,
        note=f"{BITS} bits hold {published.STOP_POTENTIAL} and infinity; with Z, which Figure 2 does not name",
    )


def _footnote_rows() -> Iterator[Row]:
    """Footnote 1: 2:3 in place of 1:√2."""
    ours, octagon = 1.5 / math.sqrt(2) - 1, 1 / math.cos(math.pi / 8) - 1
    yield published_law(
        "Footnote 1",
        "error of 2:3 over that of the octagon",
        "small",
        ours / octagon,
        source="closed form",
        note=f"{ours:.1%} against {octagon:.1%}; together {math.sqrt(1.25) - 1:.1%}",
    )


def _wave_rows(samples: tuple[Sample, ...], quick: bool) -> Iterator[Row]:
    """The wave, its stop, and Dijkstra's answer."""
    from codesign.planners.wavefront.plan.reference import delay_line_circuit, dijkstra

    yield published_law(
        SHORTEST,
        "cycle of the stop",
        published.STOP_CYCLE,
        stop_cycle(published.STOP_POTENTIAL),
        source=f"D + 1, D = {published.STOP_POTENTIAL}",
    )
    for sample in samples:
        yield row(
            SHORTEST,
            f"potential of the stop node, {sample.name} cells",
            published.STOP_POTENTIAL,
            sample.stop_potential,
            status=Status.MEASURED,
            source="own map, chosen for this figure",
            use=Use.FITTED,
            note=f"{sample.reached:,} of {int(sample.free.sum()):,} free nodes reached",
        )
    wrong = sum(
        int((dijkstra(sample.free, [sample.goal], stop=sample.start) != sample.potentials).sum())
        for sample in samples[: 1 if quick else None]
    )
    yield measured(
        SHORTEST,
        "nodes that differ from Dijkstra's potentials",
        "identical",
        wrong,
        source="own maps, heap",
        note="holds" if wrong == 0 else "does not hold",
    )
    sample = samples[0]
    registers, cycles = delay_line_circuit(sample.free, [sample.goal], sample.start)
    differ = int((np.where(registers == cycles, -1, registers) != sample.potentials).sum())
    yield measured(
        SHORTEST,
        f"cycle of the stop, circuit clocked on {sample.name} cells",
        f"D + 1 = {stop_cycle(sample.stop_potential)}",
        cycles,
        source="Figure 2, clocked; infinity is the counter at the stop",
        note=f"{differ} registers differ from the potentials",
    )


def _time_rows(samples: tuple[Sample, ...]) -> Iterator[Row]:
    """68 µs, 63 ms and the speed-up."""
    wave = published.STOP_CYCLE / published.CLOCK
    unit = unit_seconds(samples)
    yield published_law(
        SHORTEST, "time at 20 MHz", published.PLAN_SECONDS, wave, unit="s", source="D + 1 cycles"
    )
    yield row(
        SHORTEST,
        "time on the 133 MHz Pentium",
        published.SOFTWARE_SECONDS,
        unit * fmean(sample.reached for sample in samples),
        unit="s",
        status=Status.CALIBRATED,
        source=f"{1e6 * unit:.2f} µs a node reached",
        use=Use.FITTED,
        note="the one cost is fitted to this row; the number of nodes is that of own maps",
    )
    yield published_law(
        SHORTEST,
        "speed-up, published times",
        published.SPEED_UP,
        published.SOFTWARE_SECONDS / wave,
        source="63 ms over D + 1 cycles",
    )
    gains = [
        unit * sample.reached * published.CLOCK / stop_cycle(sample.stop_potential) for sample in samples
    ]
    yield row(
        SHORTEST,
        "speed-up, own maps",
        published.SPEED_UP,
        fmean(gains),
        status=Status.CALIBRATED,
        use=Use.FITTED,
        source="the fitted cost of the Pentium",
        note=f"mean; {min(gains):.0f} to {max(gains):.0f}",
    )


def _front_rows(samples: tuple[Sample, ...], adder: AdderRun | None) -> Iterator[Row]:
    """The share of the array that works at a time, and the updates of the other array."""
    share = fmean(100 * float(sample.front.mean()) / sample.free.size for sample in samples)
    yield measured(
        HARDWARE,
        "nodes that update at a cycle",
        "only the wave front",
        share,
        unit="%",
        source="own maps",
        note="mean, of all nodes",
    )
    if adder is None:
        return
    own = "equation 3 in all nodes, clocked on the first own map"
    yield measured(
        HARDWARE,
        "updates of a node by equation 3",
        "once or a few times",
        adder.mean_updates,
        source=own,
        note=f"mean of the nodes reached; at most {adder.most_updates}",
    )
    yield measured(
        HARDWARE,
        "cycles, delay lines over adders",
        "> 1 is slower",
        stop_cycle(samples[0].stop_potential) / adder.cycles,
        source=own,
        note=f"{adder.cycles} cycles for the whole map, which cannot stop early",
    )


def _safe_rows(samples: tuple[Sample, ...], safe: tuple[SafePaths, ...]) -> Iterator[Row]:
    """The obstacle map, paths by equations 4 and 5, the skeleton."""
    longest = longest_distance((published.SIDE, published.SIDE))
    yield published_law(
        SAFE,
        "cycles of the obstacle map",
        published.OBSTACLE_CYCLES,
        stop_cycle(longest),
        source="longest distance + 1",
        note=f"768 = 3 × 256; 255 diagonal steps are {longest}",
    )
    yield published_law(
        SAFE,
        "time of the obstacle map at 20 MHz",
        published.OBSTACLE_SECONDS,
        stop_cycle(longest) / published.CLOCK,
        unit="s",
        source="longest distance + 1",
    )
    farthest = [int(sample.obstacle_potentials.max()) for sample in samples]
    yield unpublished(
        SAFE,
        "largest distance from an obstacle",
        None,
        max(farthest),
        source="own maps",
        note=f"{min(farthest)} to {max(farthest)}: how long the wave does anything",
    )
    yield measured(
        SAFE,
        "safe ways that arrive",
        "guaranteed",
        100 * min(comparison.arrived for comparison in safe),
        unit="%",
        source="own maps, equations 4 and 5",
        note="least over the maps",
    )
    yield unpublished(
        SAFE,
        "length of safe ways over shortest",
        None,
        fmean(comparison.longer for comparison in safe),
        source="own maps, octile",
        note=f"{min(comparison.longer for comparison in safe):.2f} to"
        f" {max(comparison.longer for comparison in safe):.2f}",
    )
    crest = [float(skeleton(sample.obstacle_potentials)[sample.free].mean()) for sample in samples]
    yield unpublished(
        SAFE,
        "free nodes on the skeleton",
        None,
        100 * fmean(crest),
        unit="%",
        source="own rule in 5 × 5 nodes; the paper gives none",
        note=f"{100 * min(crest):.0f} to {100 * max(crest):.0f} %",
    )


def _part_rows() -> Iterator[Row]:
    """The largest arrays that fit the four FPGA of the other papers, for "large grids on a single chip"."""
    from codesign.inputs.part_file import load_part

    for name in PARTS:
        part = load_part(name)
        slices = resources.node_slices(ArrayLayout((1, 1), BITS), part)
        side = math.isqrt(int(part.resources["slices"].value) // slices)
        yield unpublished(
            "Conclusion",
            f"side of the largest array, {part.name}",
            None,
            side,
            source=f"{slices} slices a node, R = {BITS}",
            note=f"{side * side:,} of {published.SIDE**2:,} nodes; counter and selection left out",
        )
