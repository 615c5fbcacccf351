"""Fits to the tables of Vacariu et al. (2008): the maps and the circuit, then the cost of the program.

The circuit: a family of maps for the rows of 25 %, another for the rows of 50 %, the micro-architecture, and the states
that were timed. They are chosen together for the smallest mean relative error on three rows of Table 2. Two rows of
Table 2 are held out, and so are the same rows of Table 3. There are hundreds of candidates for three numbers. So this
is a calibration: it shows what the rows may have been, not that they were.

The program: one cost for a popped cell, from the two largest maps of Table 1. The tick of 10 ms matters least there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from operator import itemgetter
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.parameters import MicroArchitecture
from codesign.planners.breadth_first.published import HardwareRun
from codesign.planners.breadth_first.styles import timing
from codesign.planners.reproduction import Progress, Use, silent

# Families of maps that may stand for those of Vacariu et al. (2008), which are not published.

FILLS = {"thrown with replacement": 1, "exact share": 1, "squares of 2 × 2": 2, "squares of 3 × 3": 3}
"""The falls of obstacles, with their side in cells. Thrown with replacement, a share of d covers 1 - exp(-d)."""
PLACES = ("corners", "opposite sides", "anywhere")
FEWEST_WITH_A_PATH = 0.01
PATIENCE = 300
"""The number of maps after which a family is given up, if a smaller share than ``FEWEST_WITH_A_PATH`` had a path."""


Ends = tuple[tuple[int, int], tuple[int, int]]


@dataclass(frozen=True)
class Family:
    """The rule for maps of one share of obstacles. ``bordered``: the outermost of the N × N cells are obstacles."""

    fill: str
    bordered: bool
    place: str

    def __str__(self) -> str:
        border = "border inside" if self.bordered else "border outside"
        return f"{self.fill}, {border}, start and goal {_at(self.place)}"


def _at(place: str) -> str:
    return {"corners": "in corners", "opposite sides": "on opposite sides", "anywhere": "anywhere"}[place]


@dataclass(frozen=True, eq=False)
class Sample:
    """Searches on the maps of a family with a path: ``popped``, ``steps`` and ``spreading``, one entry a map.

    ``tried``: the number of maps drawn. ``filled``: the mean share of obstacles on the maps with a path.
    """

    popped: NDArray[np.int64]
    steps: NDArray[np.int64]
    spreading: NDArray[np.int64]
    tried: int
    filled: float


@cache
def sample(family: Family, side: int, share: float, count: int) -> Sample | None:
    """``count`` searches on maps of ``side`` × ``side`` cells; None where hardly any map has a path."""
    popped: list[int] = []
    steps: list[int] = []
    spreading: list[int] = []
    filled = 0.0
    tried = 0
    while len(popped) < count:
        if tried >= PATIENCE and len(popped) < FEWEST_WITH_A_PATH * tried:
            return None
        free, ends = _map(family, side, share, tried)
        tried += 1
        plan = search(free, *ends) if ends else None
        if plan is not None and plan.path_steps is not None:
            popped.append(plan.popped_cells)
            steps.append(plan.path_steps)
            spreading.append(plan.spreading)
            filled += 1.0 - float(free.sum()) / side**2
    return Sample(np.array(popped), np.array(steps), np.array(spreading), tried, filled / count)


def _map(family: Family, side: int, share: float, seed: int) -> tuple[NDArray[np.bool_], Ends | None]:
    """One map without its border, and its start and goal; None where one of them would lie on an obstacle."""
    inner = side - 2 * family.bordered
    density = 1.0 - math.exp(-share) if family.fill.startswith("thrown") else share
    grid = maps.random_obstacles(inner, inner, density=density, size=FILLS[family.fill], seed=seed)
    free = grid.free.copy()
    first, second = (int(word) for word in np.random.PCG64([seed, side]).random_raw(2))
    if family.place == "corners":
        # The paper draws S and G into the map: their cells are free.
        free[0, 0] = free[-1, -1] = True
        return free, ((0, 0), (inner - 1, inner - 1))
    if family.place == "opposite sides":
        start, goal = (first % inner, 0), (second % inner, inner - 1)
        return free, (start, goal) if free[start] and free[goal] else None
    cells = np.argwhere(free)
    (row, column), (goal_row, goal_column) = cells[[first % len(cells), second % len(cells)]].tolist()
    return free, ((row, column), (goal_row, goal_column))


SOFTWARE_FIT_SIDE = 100
MAPS, QUICK_MAPS = 100, 12
QUICK_FILLS = ("thrown with replacement", "squares of 3 × 3")


@dataclass(frozen=True)
class Candidate:
    """One explanation of Tables 2 and 3. ``sparse``: the family of the rows of 25 %; ``dense``: of 50 %."""

    sparse: Family
    dense: Family
    micro_architecture: MicroArchitecture
    init_timed: bool
    path_timed: bool

    def family(self, obstacles: float) -> Family:
        """The family of a row."""
        return self.sparse if obstacles < 0.5 else self.dense

    def cycles(self, searches: Sample, side: int) -> NDArray[np.int64]:
        """Timed cycles on each map of a sample, int64; without the constant, which nobody has published."""
        cycles = timing.EXPANSION_CYCLES[self.micro_architecture] * (searches.popped - 1)
        if self.path_timed:
            cycles = cycles + timing.PATH_CYCLES * (searches.steps + 1)
        return cycles + timing.INIT_CYCLES * side**2 * self.init_timed


@dataclass(frozen=True)
class Fit:
    """The best candidate, its mean error, the number of candidates, and the number of maps for a row."""

    candidate: Candidate
    error: float
    candidates: int
    maps: int

    def sample(self, side: int, obstacles: float) -> Sample:
        """The searches that represent a row."""
        searches = sample(self.candidate.family(obstacles), side, obstacles, self.maps)
        assert searches is not None, "a family without paths is no candidate"
        return searches

    def cycles(self, side: int, obstacles: float) -> tuple[float, float, float]:
        """Timed cycles of a row: mean over its maps, and the 10th and 90th percentile."""
        cycles = self.candidate.cycles(self.sample(side, obstacles), side)
        low, high = np.percentile(cycles, (10, 90))
        return float(cycles.mean()), float(low), float(high)


def errors(candidate: Candidate, rows: Sequence[HardwareRun], count: int) -> list[float] | None:
    """Relative error on each row of Table 2, of the mean over maps; None where a family has no maps with a path."""
    row_errors = []
    for run in rows:
        searches = sample(candidate.family(run.obstacles), run.side, run.obstacles, count)
        if searches is None:
            return None
        row_errors.append(float(candidate.cycles(searches, run.side).mean()) / run.cycles_at_120 - 1)
    return row_errors


def candidates(fills: Sequence[str]) -> Iterator[Candidate]:
    """All candidates. Both families of a candidate have the same obstacles and border, and places of their own."""
    for fill, bordered, sparse, dense in product(fills, (False, True), PLACES, PLACES):
        for micro_architecture, init_timed, path_timed in product(MicroArchitecture, (False, True), (False, True)):
            yield Candidate(
                Family(fill, bordered, sparse),
                Family(fill, bordered, dense),
                micro_architecture,
                init_timed,
                path_timed,
            )


def fit(quick: bool = False, progress: Progress = silent, maps: int | None = None) -> Fit:
    """The candidate with the least mean relative error on the rows that are fitted."""
    count = maps or (QUICK_MAPS if quick else MAPS)
    rows = [run for run in published.HARDWARE if run.use == Use.FITTED]
    scored: list[tuple[float, Candidate]] = []
    fill = ""
    for candidate in candidates(QUICK_FILLS if quick else tuple(FILLS)):
        if candidate.sparse.fill != fill:
            progress(f"maps that may explain Tables 2 and 3: {candidate.sparse.fill}")
        fill = candidate.sparse.fill
        row_errors = errors(candidate, rows, count)
        if row_errors is not None:
            scored.append((fmean(map(abs, row_errors)), candidate))
    error, best = min(scored, key=itemgetter(0))
    return Fit(best, error, len(scored), count)


def java_cell_seconds(chosen: Fit) -> float:
    """Seconds of the Java program for a popped cell: the times of its 100 × 100 rows over their popped cells."""
    rows = [(key, time) for key, time in published.SOFTWARE.items() if key[0] == SOFTWARE_FIT_SIDE]
    cells = sum(float(chosen.sample(*key).popped.mean()) for key, _ in rows)
    return sum(time for _, time in rows) / 1e3 / cells


def least_popped(run: HardwareRun, micro_architecture: MicroArchitecture, init_timed: bool) -> float:
    """The fewest popped cells that explain the cycles of a row on any map, with a timed path through all of them."""
    cycles = run.cycles_at_120 - init_timed * timing.INIT_CYCLES * run.side**2
    return cycles / (timing.EXPANSION_CYCLES[micro_architecture] + timing.PATH_CYCLES)
