"""The measures of rows.yaml, of Möller and Paschke (1998): the circuit, its wave on own maps, and safe paths."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.inputs.library import load_part
from codesign.maps import generate, nearest_free
from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Series
from codesign.planners.wavefront import published
from codesign.planners.wavefront.plan.grid import CLOCKWISE, DELAYS, UNREACHED, WaveMap, check_map
from codesign.planners.wavefront.plan.tracking import Tracker, octile_length, skeleton
from codesign.planners.wavefront.plan.wave import (
    MAX_OCTILE_RATIO,
    longest_distance,
    obstacle_potentials,
    register_bits,
    run_wave,
    stop_cycle,
)
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.resources import ArrayLayout

Cell = tuple[int, int]


def edges(free: NDArray[np.bool_], cell: Cell, corner_cutting: bool = True) -> Iterator[tuple[Cell, int]]:
    """The free neighbours of a cell of a flat map, each with its delay."""
    rows, columns = free.shape
    for down, right in CLOCKWISE:
        row, column = cell[0] + down, cell[1] + right
        if not (0 <= row < rows and 0 <= column < columns and free[row, column]):
            continue
        diagonal = bool(down and right)
        if diagonal and not corner_cutting and not (free[cell[0], column] and free[row, cell[1]]):
            continue
        yield (row, column), DELAYS[diagonal]


def dijkstra(
    free: NDArray[np.bool_],
    sources: Sequence[Cell],
    *,
    stop: Cell | None = None,
    corner_cutting: bool = True,
    extra_delay: NDArray[np.integer] | None = None,
) -> NDArray[np.int32]:
    """``propagate`` by equation 1 and a heap."""
    potentials = np.full(free.shape, UNREACHED, np.int32)
    waiting = [(0, source) for source in sources]
    last = None
    while waiting:
        potential, cell = heapq.heappop(waiting)
        if last is not None and potential > last:
            break
        if potentials[cell] != UNREACHED:
            continue
        potentials[cell] = potential
        if cell == stop:
            last = potential
        for other, delay in edges(free, cell, corner_cutting):
            extra = 0 if extra_delay is None or other in sources else int(extra_delay[other])
            heapq.heappush(waiting, (potential + delay + extra, other))
    return potentials


def delay_line_circuit(
    free: NDArray[np.bool_], sources: Sequence[Cell], stop: Cell | None = None
) -> tuple[NDArray[np.int64], int]:
    """Figure 2, clocked: the final registers (the counter's value: infinity), and the cycles taken.

    Three flip-flops a node: the first takes the OR of the diagonal neighbours, the second the first or the OR of the
    straight ones, the third the second. Y = third and F, or Z. Without ``stop`` it runs three cycles past the last
    change.
    """
    line = np.zeros((3, *free.shape), np.bool_)
    source = np.zeros(free.shape, np.bool_)
    source[tuple(np.array(sources).T)] = True
    locked = np.zeros(free.shape, np.bool_)
    registers = np.zeros(free.shape, np.int64)
    counter, quiet = 0, 0
    while True:
        output = (line[2] & free) | source
        registers[~locked] = counter
        quiet = quiet + 1 if (output == locked).all() else 0
        if (quiet > len(line)) if stop is None else locked[stop]:
            return registers, counter
        locked |= output
        straight, diagonal = _around(output)
        line = np.stack([diagonal, line[0] | straight, line[1]])
        counter += 1


def _around(output: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    padded = np.pad(output, 1)
    rows, columns = output.shape
    seen = [padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns] for down, right in CLOCKWISE]
    return np.logical_or.reduce(seen[:4]), np.logical_or.reduce(seen[4:])


def adder_circuit(free: NDArray[np.bool_], sources: Sequence[Cell]) -> tuple[NDArray[np.int64], int, NDArray[np.int64]]:
    """Equation 3 in all nodes at once: potentials, cycles to the first without a change, and updates of each node."""
    infinity = 2**40
    potentials = np.full(free.shape, infinity, np.int64)
    potentials[tuple(np.array(sources).T)] = 0
    updates = np.zeros(free.shape, np.int64)
    rows, columns = free.shape
    cycles = 0
    while True:
        padded = np.pad(potentials, 1, constant_values=infinity)
        best = potentials
        for (down, right), delay in zip(CLOCKWISE, [DELAYS[0]] * 4 + [DELAYS[1]] * 4, strict=True):
            best = np.minimum(best, padded[1 + down : 1 + down + rows, 1 + right : 1 + right + columns] + delay)
        best = np.where(free & (best < infinity), best, infinity)
        cycles += 1
        changed = best < potentials
        if not changed.any():
            return np.where(potentials < infinity, potentials, UNREACHED), cycles, updates
        updates += changed
        potentials = best


# Generated maps of 256 × 256 nodes with paths about as long as the paper's, and the planner's results on them.
#
# The paper's only map is a picture. These maps were chosen from rooms and mazes in some hundreds of sizes and seeds,
# with goal and start in opposite corners. They come nearest to the paper's stop potential of 1355 among maps of
# different kinds. No other figure was used for the choice.

SAMPLES: Mapping[str, tuple[str, int, dict[str, Any]]] = {
    "rooms of 24": ("rooms", 8, {"room": (24, 24), "door": 3, "wall": 2, "seed": 1}),
    "rooms of 40": ("rooms", 8, {"room": (40, 40), "door": 3, "wall": 2, "seed": 3}),
    "corridors of 16": ("maze", 3, {"corridor": 16, "wall": 4, "loops": 0.1, "seed": 3}),
    "corridors of 12": ("maze", 3, {"corridor": 12, "wall": 4, "seed": 4}),
    "corridors of 6": ("maze", 3, {"corridor": 6, "wall": 4, "seed": 2}),
}
"""Generator, cells from the corners to goal and start, and parameters."""

TRACKED = 1000
"""Cells of each map from which safe paths are tracked."""


@dataclass(frozen=True, eq=False)
class Sample:
    """A map with its goal and start, and the potentials up to the start. ``order``: reached cells in order of time."""

    name: str
    wave_map: WaveMap
    goal: tuple[int, int]
    start: tuple[int, int]
    potentials: NDArray[np.int32]
    order: NDArray[np.int32]

    @property
    def free(self) -> NDArray[np.bool_]:
        """The cells that are free: bool, rows × columns."""
        return self.wave_map.free

    @property
    def stop_potential(self) -> int:
        """The potential at which the wave ended."""
        return int(self.potentials[self.start])

    @property
    def reached(self) -> int:
        """Nodes that the wave reached."""
        return len(self.order)

    @cached_property
    def obstacle_potentials(self) -> NDArray[np.int32]:
        """The distance map p^d."""
        return obstacle_potentials(self.free)

    @cached_property
    def front(self) -> NDArray[np.int64]:
        """Nodes that the wave locks at each cycle."""
        return np.bincount(self.potentials[self.potentials >= 0])

    def paths(self, safe: bool) -> list[NDArray[np.int64]]:
        """Paths from the start and from ``TRACKED`` more cells, evenly over the order of the wave."""
        tracker = Tracker(self.wave_map, self.potentials, self.obstacle_potentials if safe else None)
        chosen = self.order[np.linspace(0, self.reached - 1, TRACKED).astype(np.int64)]
        cells = [self.start, *map(tuple, self.wave_map.cells(chosen).tolist())]
        return [tracker.follow(cell) for cell in cells]


def make_sample(name: str) -> Sample:
    """The generated map of that name, with the wave run to its stop."""
    kind, inset, parameters = SAMPLES[name]
    side = published.SIDE
    grid = generate(kind, rows=side, columns=side, **parameters)
    goal = nearest_free(grid.free, (inset, inset))
    start = nearest_free(grid.free, (side - 1 - inset, side - 1 - inset))
    assert goal is not None, "every sample has free cells"
    assert start is not None
    wave_map = check_map(grid.free)
    potentials, order = run_wave(wave_map, np.array([goal]), np.array([start]))
    return Sample(name, wave_map, goal, start, potentials, order)


def unit_seconds(samples: tuple[Sample, ...]) -> float:
    """Seconds of the Pentium for a node that the wave reaches: 63 ms over the mean of the samples."""
    return published.SOFTWARE_SECONDS / fmean(sample.reached for sample in samples)


@dataclass(frozen=True)
class SafePaths:
    """Safe paths against shortest paths on one map.

    ``arrived``: share of the tracked cells. ``longer``: mean ratio of octile lengths. ``clearance``,
    ``shortest_clearance``: mean obstacle potential along the paths.
    """

    arrived: float
    longer: float
    clearance: float
    shortest_clearance: float


def compare_safe_paths(sample: Sample) -> SafePaths:
    """Track from the start and ``TRACKED`` cells by equations 4 and 5, and by equation 2."""
    safe, shortest = sample.paths(True), sample.paths(False)
    pairs = [(octile_length(a), octile_length(b)) for a, b in zip(safe, shortest, strict=True) if len(b) > 1]

    def room(paths: list[NDArray[np.int64]]) -> float:
        return fmean(float(sample.obstacle_potentials[tuple(path.T)].mean()) for path in paths)

    return SafePaths(
        arrived=fmean(bool((path[-1] == sample.goal).all()) for path in safe),
        longer=fmean(a / b for a, b in pairs),
        clearance=room(safe),
        shortest_clearance=room(shortest),
    )


@dataclass(frozen=True)
class AdderRun:
    """The adder/comparator circuit clocked on one map: cycles, and the updates of each node that the wave reaches."""

    cycles: int
    mean_updates: float
    most_updates: int


def adder_run(sample: Sample) -> AdderRun:
    """Clock equation 3 on a map until nothing changes."""
    potentials, cycles, updates = adder_circuit(sample.free, [sample.goal])
    reached = updates[potentials > 0]
    return AdderRun(cycles, float(reached.mean()), int(reached.max()))


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
