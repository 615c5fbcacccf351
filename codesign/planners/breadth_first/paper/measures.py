"""The measures of rows.yaml, of Vacariu et al. (2008): times on the maps that explain them best, and memory.

The maps and the circuit are fitted to Table 2: a family of maps for the rows of 25 %, another for those of 50 %, the
micro-architecture, and the states that were timed, together, for the smallest mean relative error on three rows. Two
rows are held out, and so are the same rows of Table 3. There are hundreds of candidates for three numbers. So this is
a calibration: it shows what the rows may have been, not that they were.

The program is fitted as one cost for a popped cell, from the two largest maps of Table 1, where the tick of 10 ms
matters least.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product
from operator import itemgetter
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.inputs.library import load_part
from codesign.planners.breadth_first import published
from codesign.planners.breadth_first.plan import search
from codesign.planners.breadth_first.plan.parameters import MicroArchitecture, SearchParameters, VgaController
from codesign.planners.breadth_first.published import BreadthFirstSettings, HardwareRun
from codesign.planners.breadth_first.styles import resources, timing
from codesign.planners.breadth_first.styles.software import JAVA_BYTES_A_CELL, JAVA_HEAP
from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Progress, Row, Series, Use, silent

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


PART = "XC2VP30-6"
CLOCKS = {"Table 2": 120_000_000, "Table 3": 150_000_000}
OPTIMAL_MAPS = 40


@dataclass
class MapRuns(Runs[BreadthFirstSettings]):
    """The maps and the micro-architecture that explain Tables 2 and 3 best."""

    @cached_property
    def chosen(self) -> Fit:
        """The best candidate."""
        return fit(self.quick, self.progress, self.settings.maps)

    def of(self, place: str, use: Use | None = None) -> list[Row]:
        """The rows of a table, or the rows of it with this use."""
        return [row for row in self.rows if row.table == place and use in {None, row.use}]


PAPER = Paper(Path(__file__).with_name("rows.yaml"), published.NUMBERS, MapRuns, BreadthFirstSettings)
measure = PAPER.measure


def hardware_microseconds(chosen: Fit, side: int, obstacles: float, clock: int) -> tuple[float, float, float]:
    """Modelled µs of a row at ``clock`` Hz: mean over the maps, 10th and 90th percentile."""
    mean, low, high = (cycles / clock * 1e6 for cycles in chosen.cycles(side, obstacles))
    return mean, low, high


def software_milliseconds(chosen: Fit, side: int, obstacles: float) -> float:
    """Modelled ms of a row of Table 1."""
    return java_cell_seconds(chosen) * float(chosen.sample(side, obstacles).popped.mean()) * 1e3


def spreading(chosen: Fit, side: int, obstacles: float) -> str:
    """Spreading of a row in words."""
    searches = chosen.sample(side, obstacles)
    cells = float(searches.spreading.mean())
    return f"spreading {cells:.0f} cells, {cells / (cells + float(searches.steps.mean()) + 1):.0%} of those pushed"


@measure
def java(runs: MapRuns, case: Case) -> Words:
    """The Java program on a map of Table 1."""
    modelled = software_milliseconds(runs.chosen, case.side, case.obstacles)
    inside = abs(modelled - case.milliseconds) <= case.software_tick_ms
    return {
        "seconds": modelled / 1e3,
        "inside": "within" if inside else "outside of",
        "spreading": spreading(runs.chosen, case.side, case.obstacles),
    }


@measure
def java_wall(_runs: MapRuns, _case: Case) -> Words:
    """The largest side that the heap of the Java program holds."""
    side = int((JAVA_HEAP / JAVA_BYTES_A_CELL) ** 0.5)
    return {"value": side, "cell": JAVA_BYTES_A_CELL, "heap": JAVA_HEAP >> 20}


@measure
def circuit(runs: MapRuns, case: Case) -> Words:
    """The circuit on a map of Tables 2 and 3."""
    mean, low, high = hardware_microseconds(runs.chosen, case.side, case.obstacles, case.clock)
    return {
        "value": mean / 1e6,
        "low": low,
        "high": high,
        "maps": runs.chosen.maps,
        "family": runs.chosen.candidate.family(case.obstacles),
        "spreading": spreading(runs.chosen, case.side, case.obstacles),
    }


@measure
def clocks(_runs: MapRuns, case: Case) -> Words:
    """Time at 120 MHz over time at 150 MHz, from the paper's own numbers."""
    times = case.microseconds_at_120, case.microseconds_at_150
    return {"value": 150 / 120, "printed": times[0] / times[1], "at_120": times[0] * 120, "at_150": times[1] * 150}


@measure
def speed_up(runs: MapRuns, case: Case) -> Words | None:
    """Software over hardware at 120 MHz, for the maps in both tables."""
    milliseconds = published.SOFTWARE.get((case.side, case.obstacles))
    if milliseconds is None:
        return None
    mean, _, _ = hardware_microseconds(runs.chosen, case.side, case.obstacles, case.clock)
    printed = milliseconds * 1e3 / case.microseconds_at_120
    return {
        "value": software_milliseconds(runs.chosen, case.side, case.obstacles) * 1e3 / mean,
        "printed": printed,
        "less": ": the paper's own numbers give less" if printed < 100 else "",
    }


@measure
def memory(_runs: MapRuns, _case: Case) -> Words:
    """Block RAMs and LUT of the part for maps of several sizes."""
    part, alone = load_part(PART), SearchParameters(display=VgaController.NONE)
    budget = int(part.resources["block_rams"].value)
    need, largest = resources.block_ram_total(100, 100, alone, part), resources.largest_side(alone, part)
    counts = [resources.counted(piece, (100, 100), SearchParameters(), part) for piece in ("state machine", "display")]
    return {
        "part": part.name,
        "budget": budget,
        "need": need,
        "rams": 100 * need / budget,
        "largest": largest,
        "need_of_256": resources.block_ram_total(256, 256, alone, part),
        "share": 100 * sum(lut4.amount for lut4, _ in counts) / part.resources["lut4"].value,
        "holds": largest > 100,
    }


@measure
def refresh(_runs: MapRuns, case: Case) -> Words:
    """The refresh of the display's clock by the pixel periods of a frame, blanking included (VESA at 60 Hz)."""
    pixels = case.across * case.down
    return {"value": case.display_clock / pixels, "pixels": pixels}


@measure
def shortest(_runs: MapRuns, _case: Case) -> Words:
    """The share of paths that are shortest."""
    optimal = []
    for seed in range(OPTIMAL_MAPS):
        free = maps.random_obstacles(30, 30, density=0.25, seed=seed).free
        cells = np.argwhere(maps.reachable(free, [maps.nearest_free(free, (0, 0)) or (0, 0)]))
        start, goal = (tuple(int(index) for index in cell) for cell in (cells[0], cells[-1]))
        steps = search(free, (start[0], start[1]), (goal[0], goal[1])).path_steps
        optimal.append(steps == int(maps.distance_steps(free, [(goal[0], goal[1])])[start]))
    percent = 100 * fmean(optimal)
    return {"value": percent, "maps": OPTIMAL_MAPS, "holds": percent == 100}


@measure
def times_by_side(runs: MapRuns, _case: Case) -> Iterator[Series]:
    """Tables 2 and 3 against the model, over the side of the map."""
    sides = tuple(float(run.side) for run in published.HARDWARE)
    for name, clock in CLOCKS.items():
        microseconds = tuple(
            run.microseconds_at_120 if name == "Table 2" else run.microseconds_at_150 for run in published.HARDWARE
        )
        yield Series(f"{name}, published", sides, microseconds)
        modelled = tuple(
            hardware_microseconds(runs.chosen, run.side, run.obstacles, clock)[0] for run in published.HARDWARE
        )
        yield Series(f"{name}, modelled", sides, modelled)


@measure
def explanation(runs: MapRuns, _case: Case) -> Words:
    """The chosen maps and micro-architecture, with the errors of Table 2."""
    best = runs.chosen.candidate
    errors = {
        f"error, {use}, {row.quantity.split(', ')[1]}": f"{row.error or 0.0:+.1%}"
        for use in (Use.FITTED, Use.HELD_OUT)
        for row in runs.of("Table 2", use)
        if row.error is not None
    }
    figures = {
        "candidates": str(runs.chosen.candidates),
        "maps for 25 %": str(best.sparse),
        "maps for 50 %": str(best.dense),
        "b": str(timing.EXPANSION_CYCLES[best.micro_architecture]),
        **errors,
    }
    three = best.micro_architecture is MicroArchitecture.THREE_CYCLES
    return {"figures": figures, "holds": three and not best.init_timed and not best.path_timed}


@measure
def scatter(runs: MapRuns, _case: Case) -> Words:
    """The deviation of the popped cells of one map from their mean."""
    popped = runs.chosen.sample(30, 0.25).popped
    deviation, mean = float(popped.std()), float(popped.mean())
    return {"deviation": float(popped.std() / popped.mean()), "holds": deviation > 0.3 * mean}


@measure
def java_cost(runs: MapRuns, _case: Case) -> Words:
    """The cost of the Java program, and how its rows meet it."""
    fitted, held_out = (runs.of("Table 1", use) for use in (Use.FITTED, Use.HELD_OUT))
    figures = {
        "cost of a popped cell": f"{java_cell_seconds(runs.chosen) * 1e6:.1f} µs",
        **{row.quantity: f"{row.error or 0.0:+.1%}" for row in fitted},
        "times held out": str(len(held_out)),
        "of these within the tick": str(sum(not row.note.startswith("outside") for row in held_out)),
    }
    return {"figures": figures, "holds": max(abs(row.error or 0.0) for row in fitted) > 0.3}


@measure
def disagreement(_runs: MapRuns, _case: Case) -> Words:
    """The cycles of one map by the two clocks."""
    shares = {run.side: abs(run.cycles_at_120 / run.cycles_at_150 - 1) for run in published.HARDWARE}
    figures = {f"{side}×{side}": f"{share:.1%}" for side, share in shares.items()}
    return {"figures": figures, "holds": max(shares.values()) > 0.01}


@measure
def too_fast(_runs: MapRuns, _case: Case) -> Words:
    """The circuits that would have to pop more cells than are free."""
    dense = [run for run in published.HARDWARE if run.obstacles >= 0.5]
    circuits = [
        f"{str(micro).replace('_', ' ')}{' with Init timed' if init else ''}"
        for micro in MicroArchitecture
        for init in (False, True)
        if any(least_popped(run, micro, init) > (1 - run.obstacles) * run.side**2 for run in dense)
    ]
    return {"circuits": ", ".join(circuits), "holds": circuits}


@measure
def filled_share(runs: MapRuns, _case: Case) -> Words:
    """The share of obstacles on the maps of the last row."""
    share = runs.chosen.sample(100, 0.5).filled
    return {"filled": share, "holds": share < 0.5}


@measure
def slow_rows(runs: MapRuns, _case: Case) -> Words:
    """The published speed-ups below 100."""
    slow = [row for row in runs.of("Section 4") if "less" in row.note]
    figures = {row.quantity.split(", ", 1)[1]: f"{float(row.published or 0):.0f}" for row in slow}
    return {"figures": figures, "holds": slow}


@measure
def refreshes(runs: MapRuns, _case: Case) -> Words:
    """The refresh by the timing of 800×600 and of 1024×768."""
    narrow, wide = (float(row.modelled or 0) for row in runs.of("Section 3.1.1"))
    return {"narrow": narrow, "wide": wide, "holds": narrow > 65}


@measure
def java_against_circuit(runs: MapRuns, _case: Case) -> Words:
    """The rows of 25 % over the rows of 50 % at 100×100: Java times, and popped cells."""
    ratio = published.SOFTWARE[100, 0.25] / published.SOFTWARE[100, 0.5]
    sparse, dense = (runs.chosen.sample(100, share).popped.mean() for share in (0.25, 0.5))
    return {"ratio": ratio, "popped": sparse / dense, "holds": sparse / dense < 0.5 * ratio}
