"""Generated maps of 256 × 256 nodes with paths about as long as the paper's, and the planner's results on them.

The paper's only map is a picture. These maps were chosen from rooms and mazes in some hundreds of sizes and seeds, with
goal and start in opposite corners. They come nearest to the paper's stop potential of 1355 among maps of different
kinds. No other figure was used for the choice.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.wavefront import published
from codesign.planners.wavefront.plan.grid import WaveMap, check_map
from codesign.planners.wavefront.plan.reference import adder_circuit
from codesign.planners.wavefront.plan.tracking import Tracker, octile_length
from codesign.planners.wavefront.plan.wave import obstacle_potentials, run_wave

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
    grid = maps.generate(kind, rows=side, columns=side, **parameters)
    goal = maps.nearest_free(grid.free, (inset, inset))
    start = maps.nearest_free(grid.free, (side - 1 - inset, side - 1 - inset))
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
