"""The measures of rows.yaml, of Möller and Paschke (1998): the circuit, its wave on own maps, and safe paths."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from statistics import fmean

import numpy as np

from codesign.inputs.library import load_part
from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Series
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
from codesign.planners.wavefront.plan.reference import delay_line_circuit, dijkstra
from codesign.planners.wavefront.plan.skeleton import skeleton
from codesign.planners.wavefront.plan.wave import MAX_OCTILE_RATIO, longest_distance, register_bits, stop_cycle
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.layout import ArrayLayout

QUICK_SAMPLES = 2
BINS = 100
BITS = register_bits(published.STOP_POTENTIAL)
PARTS = ("XC4VLX160-12", "XC2V6000-4", "XC2VP30-6", "XC3S500E-4")
"""The FPGA of the other papers."""

SHAPE = published.SIDE, published.SIDE
WAVE_SECONDS = stop_cycle(published.STOP_POTENTIAL) / published.CLOCK
LAYOUT = ArrayLayout(SHAPE, BITS)
ADDERS = replace(LAYOUT, adders=True)
COSTS = {"2:3 (the paper)": (1.0, 1.5), "5:7": (1.0, 1.4), "1:√2 (octagon)": (1.0, math.sqrt(2.0))}
"""The costs of a straight and of a diagonal step."""


class WavefrontRuns(Runs[published.WavefrontSettings]):
    """The own maps with their waves and safe paths, and the adder/comparator circuit on the first."""

    @cached_property
    def samples(self) -> tuple[Sample, ...]:
        """The own maps; in a quick run two of them."""
        samples = []
        for name in self.settings.maps or list(SAMPLES)[: QUICK_SAMPLES if self.quick else None]:
            self.progress(f"potentials on {name} cells")
            samples.append(make_sample(name))
        return tuple(samples)

    @cached_property
    def safe(self) -> tuple[SafePaths, ...]:
        """Safe paths against shortest ones on each map."""
        self.progress("safe paths")
        return tuple(compare_safe_paths(sample) for sample in self.samples)

    @cached_property
    def adder(self) -> AdderRun | None:
        """The adder/comparator circuit; a quick run leaves it out."""
        if self.quick:
            return None
        self.progress("the adder/comparator circuit, clocked")
        return adder_run(self.samples[0])

    @cached_property
    def unit(self) -> float:
        """Seconds of the Pentium for a node that the wave reaches."""
        return unit_seconds(self.samples)


PAPER = Paper(Path(__file__).with_name("rows.yaml"), published.NUMBERS, WavefrontRuns, published.WavefrontSettings)
measure = PAPER.measure


@measure
def node(_runs: WavefrontRuns, _case: Case) -> Words:
    """The node of the paper, and the node of Hassoun and Sanghvi over it: without a chain, and with one."""
    family = resources.LAWS.table["similar"]
    bare, chained = (
        resources.lut4(resources.NODES, replace(ADDERS, chain=chain), family)
        / resources.lut4(resources.NODES, replace(LAYOUT, chain=chain), family)
        for chain in (False, True)
    )
    of_line, of_adders = LAYOUT.node_flip_flops, ADDERS.node_flip_flops
    return {
        "family": family,
        "bits": BITS,
        "line": LAYOUT.line,
        "wires": 1,
        "lut": bare,
        "chained": chained,
        "of_line": of_line,
        "of_adders": of_adders,
        "flip_flops": of_adders / of_line,
        "all_flip_flops": LAYOUT.nodes * of_line,
    }


@measure
def chips(_runs: WavefrontRuns, _case: Case) -> list[Words]:
    """The FPGA of the other papers, for "large grids on a single chip"."""
    return [{"part": load_part(name)} for name in PARTS]


@measure
def largest(_runs: WavefrontRuns, case: Case) -> Words:
    """The side of the largest array that fits a part."""
    slices = resources.node_slices(ArrayLayout((1, 1), BITS), case.part)
    side = math.isqrt(int(case.part.resources["slices"].value) // slices)
    return {"value": side, "slices": slices, "bits": BITS, "nodes": side * side, "all": case.side**2}


def potential_ratio(degrees: float, straight: float, diagonal: float) -> float:
    """Potential of open ground in one direction over the straight line, with the given costs of steps."""
    angle = math.radians(degrees)
    along, across = max(math.cos(angle), math.sin(angle)), min(math.cos(angle), math.sin(angle))
    return straight * (along - across) + diagonal * across


def largest_error(costs: tuple[float, float]) -> float:
    """The largest error of the approximation on open ground, relative to the straight line.

    >>> round(largest_error(COSTS["2:3 (the paper)"]), 3), round(largest_error(COSTS["1:√2 (octagon)"]), 3)
    (0.118, 0.082)
    """
    return math.hypot(costs[0], costs[1] - costs[0]) - 1


@measure
def octagon(_runs: WavefrontRuns, _case: Case) -> Words:
    """Footnote 1: 2:3 in place of 1:√2, in closed form."""
    ours, octagon = 1.5 / math.sqrt(2) - 1, 1 / math.cos(math.pi / 8) - 1
    both, finer = largest_error(COSTS["2:3 (the paper)"]), largest_error(COSTS["5:7"])
    return {
        "value": ours / octagon,
        "ours": ours,
        "octagon": octagon,
        "both": both,
        "finer": finer,
        "holds": 0.5 * largest_error(COSTS["1:√2 (octagon)"]) < MAX_OCTILE_RATIO - 1,
    }


@measure
def error_by_direction(_runs: WavefrontRuns, _case: Case) -> Iterator[Series]:
    """The error of the approximations on open ground, over the direction."""
    degrees = tuple(float(angle) for angle in range(91))
    for name, costs in COSTS.items():
        yield Series(name, degrees, tuple(100 * (potential_ratio(angle, *costs) - 1) for angle in degrees))


@measure
def wave(_runs: WavefrontRuns, case: Case) -> Words:
    """The published stop: its cycle, and the seconds of the wave against the published ones of software."""
    return {
        "cycle": stop_cycle(case.stop_potential),
        "seconds": WAVE_SECONDS,
        "speed_up": case.software_seconds / WAVE_SECONDS,
    }


@measure
def maps(runs: WavefrontRuns, _case: Case) -> list[Words]:
    """The own maps."""
    return [{"sample": sample, "name": sample.name} for sample in runs.samples]


@measure
def stop(_runs: WavefrontRuns, case: Case) -> Words:
    """The potential at which the wave ends on an own map."""
    sample: Sample = case.sample
    return {"value": sample.stop_potential, "reached": sample.reached, "free": int(sample.free.sum())}


@measure
def unlike_dijkstra(runs: WavefrontRuns, _case: Case) -> Words:
    """Nodes with another potential than by Dijkstra's algorithm."""
    wrong = sum(
        int((dijkstra(sample.free, [sample.goal], stop=sample.start) != sample.potentials).sum())
        for sample in runs.samples[: 1 if runs.quick else None]
    )
    return {"value": wrong, "verdict": "holds" if wrong == 0 else "does not hold"}


@measure
def clocked(runs: WavefrontRuns, _case: Case) -> Words:
    """The cycle of the stop of Figure 2, clocked on the first own map."""
    sample = runs.samples[0]
    registers, cycles = delay_line_circuit(sample.free, [sample.goal], sample.start)
    differ = int((np.where(registers == cycles, -1, registers) != sample.potentials).sum())
    expected = stop_cycle(sample.stop_potential)
    return {"value": cycles, "name": sample.name, "expected": expected, "differ": differ}


@measure
def front(runs: WavefrontRuns, _case: Case) -> float:
    """Percent of the nodes that update at a cycle."""
    return fmean(100 * float(sample.front.mean()) / sample.free.size for sample in runs.samples)


@measure
def front_by_cycle(runs: WavefrontRuns, _case: Case) -> Iterator[Series]:
    """The number of nodes that the wave locks at each cycle."""
    for sample in runs.samples:
        parts = np.array_split(sample.front, BINS)
        edges = np.cumsum([len(part) for part in parts])
        yield Series(sample.name, tuple(map(float, edges)), tuple(float(part.mean()) for part in parts))


@measure
def pentium(runs: WavefrontRuns, case: Case) -> Words:
    """The one cost that is fitted, and the speed-up by it on own maps."""
    unit, reached = unit_seconds(runs.samples), [sample.reached for sample in runs.samples]
    gains = [unit * each.reached * case.clock / stop_cycle(each.stop_potential) for each in runs.samples]
    return {
        "seconds": unit * fmean(reached),
        "microseconds": 1e6 * unit,
        "cycles": unit * case.software_clock,
        "fewest": min(reached),
        "largest": max(reached),
        "speed_up": fmean(gains),
        "least": min(gains),
        "most": max(gains),
    }


@measure
def loading(_runs: WavefrontRuns, case: Case) -> Words:
    """The speed-up that remains with the loading of the map."""
    load, slow_load = timing.load_cycles(SHAPE) / case.clock, case.side**2 / case.clock
    speed_up = case.software_seconds / (WAVE_SECONDS + slow_load)
    plan_seconds = PAPER.sheet.published("Shortest Paths")["time at 20 MHz"]
    return {
        "printed": case.software_seconds / plan_seconds,
        "load": 1e6 * load,
        "over_wave": load / WAVE_SECONDS,
        "slow_load": 1e3 * slow_load,
        "speed_up": speed_up,
        "holds": speed_up < 100,
    }


@measure
def adder(runs: WavefrontRuns, _case: Case) -> Words | None:
    """The adder/comparator array against the wave."""
    if runs.adder is None:
        return None
    of_wave = stop_cycle(runs.samples[0].stop_potential)
    return {
        "updates": runs.adder.mean_updates,
        "most": runs.adder.most_updates,
        "cycles": runs.adder.cycles,
        "of_wave": of_wave,
        "longer": of_wave / runs.adder.cycles,
        "holds": runs.adder.cycles < of_wave,
    }


@measure
def obstacles(runs: WavefrontRuns, case: Case) -> Words:
    """The wave from all obstacles."""
    farthest = [int(sample.obstacle_potentials.max()) for sample in runs.samples]
    longest, cycles = longest_distance(SHAPE), stop_cycle(longest_distance(SHAPE))
    return {
        "longest": longest,
        "cycles": cycles,
        "seconds": cycles / case.clock,
        "least": min(farthest),
        "most": max(farthest),
        "holds": cycles < 768,
    }


@measure
def register(_runs: WavefrontRuns, case: Case) -> Words:
    """The needs of safe paths beside the register of a node."""
    return {"bits": register_bits(longest_distance(SHAPE)), "words": case.side**2}


@measure
def safe(runs: WavefrontRuns, _case: Case) -> Words:
    """Safe paths by equations 4 and 5 against shortest ones."""
    arrived = 100 * min(each.arrived for each in runs.safe)
    longer = [each.longer for each in runs.safe]
    return {
        "arrived": arrived,
        "length": fmean(longer),
        "least": min(longer),
        "most": max(longer),
        "longer": 100 * (fmean(longer) - 1),
        "clearance": fmean(each.clearance / each.shortest_clearance for each in runs.safe),
        "holds": arrived == 100,
    }


@measure
def crest(runs: WavefrontRuns, _case: Case) -> Words:
    """Percent of the free nodes on the skeleton."""
    each = [float(skeleton(one.obstacle_potentials)[one.free].mean()) for one in runs.samples]
    return {"value": 100 * fmean(each), "least": 100 * min(each), "most": 100 * max(each)}
