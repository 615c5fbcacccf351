"""The measures of rows.yaml, of Girau et al. (2008): laws of the circuit, speed, estimates, Figures 3 to 6."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.ground.figures import Status
from codesign.planners.circuits import phase_cycles
from codesign.planners.harmonic import published
from codesign.planners.harmonic.paper import theory
from codesign.planners.harmonic.paper.theory import (
    ADDED,
    ERROR,
    LAST,
    MARGIN,
    Counts,
    StillBlocks,
    bits_a_doubling,
    count_maps,
    equation_6,
    node_power,
    plateau,
)
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.fixed_point import limbs_needed
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.plan.precision import required_precision
from codesign.planners.harmonic.published import HarmonicSettings
from codesign.planners.harmonic.styles import BitSerial, resources, timing
from codesign.planners.harmonic.styles.steps import RELAX
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Progress, Row, Series, Use

# Speed of Girau et al. (2008), section 5.4: a maze of 9,500 nodes in 4 blocks, p = 255, I = 6, on own mazes.
#
# The paper publishes neither its maze, nor the cost of its software at 255 bits, nor its steps of precision. So this
# module runs mazes of several corridor widths, with two goals, three steps and both terminations, and reports the mean
# and the range.
#
# - Software: one synchronous relaxation at full precision, stopped when no bit changes. An iteration of 2,376 nodes
#   takes 100 µs, at any precision (flat) or for each 64-bit limb.
# - Circuit: the visits of the run at 150 MHz, changes of block included.

ROWS, COLUMNS = 72, 132
BLOCK = published.WHOLE_DESIGN_ROWS, published.WHOLE_DESIGN_COLUMNS
BLOCKS = 4
SPEED_PRECISION = published.WHOLE_DESIGN_PRECISION
ITERATIONS = 6
WHOLE_MAP_ITERATIONS = 1 << 20

CORRIDORS = (2, 3, 4, 6, 8)
SEEDS = (1, 2)
LOOPS = (0.0, 0.3)
"""The share of opened walls of a perfect maze: a "not too complex" maze may have several paths."""
STEPS = (8, 16, 32)
TERMINATIONS = ("sound", "published")


@dataclass(frozen=True)
class Measurement:
    """One maze under one schedule and termination.

    ``speed_up``: flat software time over circuit time. ``gain``: the circuit with synchronous iterations
    at full precision over the circuit as published. ``iteration_ratio``: block iterations over the iterations of
    the synchronous run, both per block.
    """

    corridor: int
    step: int
    termination: str
    speed_up: float
    gain: float
    iteration_ratio: float


def software_seconds(iterations: int, nodes: int) -> float:
    """Seconds of ``iterations`` over ``nodes`` at the paper's 100 µs for 2,376 nodes."""
    return iterations * nodes / (BLOCK[0] * BLOCK[1]) * published.SOFTWARE_ITERATION_PS / 1e12


def circuit_run(
    free: NDArray[np.bool_], goal: tuple[int, int], schedule: Sequence[int], termination: str
) -> tuple[float, HarmonicPlan]:
    """Seconds of a relaxation at the paper's 150 MHz, and its plan."""
    parameters = RelaxParameters(
        block=BLOCK,
        iterations=ITERATIONS,
        schedule=tuple(schedule),
        termination=Termination(termination),
        stop=Stop.SCHEDULE_END,
    )
    job = Job(Problem(free, (goal,), ()), parameters, detail=False)
    cycles, plan = phase_cycles(BitSerial().work(job))
    return cycles[RELAX] / published.ESTIMATED_CLOCK, plan


def measurements(quick: bool, progress: Progress, seeds: Sequence[int] | None = None) -> tuple[Measurement, ...]:
    """The measurements of all mazes; ``quick``: of one maze. ``seeds``: others than the published ones."""
    runs: list[Measurement] = []
    for corridor in CORRIDORS[2:3] if quick else CORRIDORS:
        progress(f"speed-up of section 5.4: mazes with corridors of {corridor} cells")
        for seed in seeds or (SEEDS[:1] if quick else SEEDS):
            for loops in LOOPS[:1] if quick else LOOPS:
                grid = maps.maze(ROWS, COLUMNS, corridor=corridor, wall=2, seed=seed, loops=loops)
                for goal in ((0, 0),) if quick else ((0, 0), (ROWS // 2, COLUMNS // 2)):
                    runs += _measure(grid, goal, corridor, STEPS[1:2] if quick else STEPS)
    return tuple(runs)


def _measure(
    grid: maps.OccupancyGrid, wanted: tuple[int, int], corridor: int, steps: tuple[int, ...]
) -> Iterator[Measurement]:
    goal = maps.nearest_free(grid.free, wanted)
    assert goal is not None, "a maze has free cells"
    synchronous = relax(
        grid.free,
        [goal],
        block=(ROWS, COLUMNS),
        iterations=WHOLE_MAP_ITERATIONS,
        schedule=[SPEED_PRECISION],
        record_visits=False,
    ).total_iterations
    software = software_seconds(synchronous, ROWS * COLUMNS)
    full = synchronous * BLOCKS * timing.iteration_cycles(SPEED_PRECISION) / published.ESTIMATED_CLOCK
    for step in steps:
        schedule = [*range(step - 1, SPEED_PRECISION, step), SPEED_PRECISION]
        for termination in TERMINATIONS:
            circuit, result = circuit_run(grid.free, goal, schedule, termination)
            yield Measurement(
                corridor,
                step,
                termination,
                speed_up=software / circuit,
                gain=full / circuit,
                iteration_ratio=result.total_iterations / BLOCKS / synchronous,
            )


SOON = 0.2
"""The share of a run within which Figure 6 has to reach its level to agree with "rapidly"."""
MET = 0.2
"""The largest error with which the model meets a row."""
LAWS = {"Table 1", "Table 2", "Table 3", "Section 1", "Section 4.5.2", "Section 5.4"}
"""The places of the rows that laws answer, not counts of runs."""
DEPTH = 1024
"""Words of a block RAM of 18 bits."""


class HarmonicRuns(Runs[HarmonicSettings]):
    """Runs on own mazes, on the maps of section 4, and for Figures 3 to 6; quick: fewer and smaller maps."""

    @cached_property
    def speed(self) -> tuple[Measurement, ...]:
        """The mazes of section 5.4."""
        return measurements(self.quick, self.progress, self.settings.maze_seeds)

    @cached_property
    def counts(self) -> tuple[Counts, ...]:
        """The maps of section 4."""
        return count_maps(self.quick, self.progress)

    @property
    def magnifications(self) -> tuple[int, ...]:
        """The factors by which the environments are magnified."""
        return (1, 2, 4) if self.quick else (1, 2, 3, 4, 6, 8)

    @property
    def sides(self) -> tuple[int, ...]:
        """Blocks a side."""
        return (1, 2, 4) if self.quick else theory.BLOCKS_A_SIDE

    @cached_property
    def bits(self) -> list[Series]:
        """Figure 3."""
        return theory.required_bits(self.magnifications, self.progress)

    @cached_property
    def iterations(self) -> list[Series]:
        """Figure 4."""
        return theory.iterations_to_stability(self.magnifications, self.progress)

    @cached_property
    def still(self) -> StillBlocks:
        """Figure 5."""
        seeds = theory.LABYRINTH_SEEDS[: 1 if self.quick else None]
        consecutive = (1, 4, 16, 256) if self.quick else theory.CONSECUTIVE
        return theory.still_blocks(self.sides, consecutive, self.settings.labyrinth_seeds or seeds, self.progress)

    @cached_property
    def shares(self) -> list[Series]:
        """Figure 6."""
        return theory.shares_by_sweep(self.sides[1:], self.progress)


PAPER = Paper(Path(__file__).with_name("rows.yaml"), published.NUMBERS, HarmonicRuns, HarmonicSettings)
measure = PAPER.measure


@measure
def resources_of(_runs: HarmonicRuns, case: Case) -> Words:
    """A resource of Tables 1 to 3 by the law of nodes, and of the array around a block."""
    a_node, constant = {
        "flip_flops": (resources.NODE_FLIP_FLOPS, resources.ARRAY_FLIP_FLOPS),
        "lut4": (resources.NODE_LUT4, resources.ARRAY_LUT4),
        "slices": (resources.NODE_SLICES, resources.ARRAY_SLICES),
    }[case.kind]
    nodes, array = case.rows * case.columns, case.table == published.BLOCK.table
    remark = f"the constant {constant} is fitted to this row; no OR tree can be in it" if array else ""
    if case.table == published.CLUSTER.table and case.kind == "lut4":
        remark = "18 nodes and 2 LUT: the counters said to be in it cannot be"
    return {
        "value": a_node * nodes + (constant if array else 0),
        "law": f"{a_node}N" + (f" + {constant}" if array else ""),
        "nodes": nodes,
        "basis": Status.CALIBRATED if array else Status.PUBLISHED,
        "remark": remark,
    }


@measure
def clock_of(_runs: HarmonicRuns, case: Case) -> Words:
    """The clock of a grid by the law of the period."""
    fit = timing.clock_fit()
    clock = fit.clock(case.rows * case.columns)
    return {"value": clock, "offset": fit.offset, "slope": fit.slope, "form": fit.form}


@measure
def clock_miss(_runs: HarmonicRuns, _case: Case) -> Words:
    """The residual of the law of the period, and its error on the estimated clock."""
    miss = timing.clock_miss()
    return {"residual": timing.clock_fit().residual, "miss": miss, "holds": miss > 0.1}


@measure
def whole_design(_runs: HarmonicRuns, case: Case) -> Words:
    """Logic cells, block RAMs and slices of the 36 × 66 block on the XC2V6000."""
    shape = case.design_rows, case.design_columns
    cells, budget = 2 * resources.NODE_SLICES, case.slices_of_xc2v6000
    share = 100 * cells * (shape[0] * shape[1]) / (2 * budget)
    machine = resources.Machine(*shape, case.design_precision)
    demand = resources.totals(machine, "Virtex-II")["slices"]
    return {
        "cells": cells,
        "of_cluster": cells * published.CLUSTER.nodes,
        "share": share,
        "verdict": "holds" if share < 92 else "does not hold",
        "rams": resources.cluster_count(*shape),
        "border_rams": resources.border_rams(*shape),
        "printed": 100 * case.design_share,
        "slices": 100 * demand / budget,
        "border": resources.SLICES_A_BORDER_NODE,
        "listed": 100 * (demand - resources.border_slices(*shape)) / budget,
    }


@measure
def depth(_runs: HarmonicRuns, case: Case) -> Words:
    """Blocks against bits a word."""
    blocks = DEPTH // 64
    return {
        "precision": resources.largest_precision(case.design_blocks, DEPTH),
        "word": resources.largest_precision(1, DEPTH) + 1,
        "blocks": blocks,
        "words": resources.words(16, 64),
        "nodes": blocks * 96 * 48,
    }


@measure
def block_rams(_runs: HarmonicRuns, case: Case) -> Words:
    """Block RAMs of a large block, against the block RAMs of a part."""
    need = resources.totals(resources.Machine(case.rows, case.columns, 63), "Virtex-4")["block_rams"]
    fits = need <= case.budget
    return {"value": need, "missing": need - case.budget, "verdict": "fits" if fits else "does not fit"}


@measure
def at_128_bits(_runs: HarmonicRuns, case: Case) -> Words:
    """The speed-up of an iteration at 128 bits."""
    software, clock = case.software_iteration_ps / 1e12, case.estimated_clock
    hardware, limbs = timing.iteration_cycles(128) / clock, limbs_needed(128)
    return {
        "flat": software / hardware,
        "limbs": limbs,
        "by_limbs": limbs * software / hardware,
        "break_even": round(software / 100 * clock) - 2,
    }


@measure
def laws_met(runs: HarmonicRuns, _case: Case) -> Words:
    """The errors of the laws on rows that they were not fitted to. Some of these rest on an assumption."""
    rows = [row for row in runs.rows if row.table in LAWS]
    held_out = [row for row in rows if row.use is Use.HELD_OUT and row.error is not None]
    assumed = [row for row in held_out if row.status is Status.ASSUMED]
    others = [row for row in held_out if row.status is not Status.ASSUMED]
    worst = _worst(others)
    texts = {
        "fitted rows": str(sum(row.use is Use.FITTED for row in rows)),
        "other rows": str(len(held_out)),
        "rows that rest on an assumption": str(len(assumed)),
        **{row.quantity: f"{row.error:+.0%}" for row in assumed},
        "rows that need none": str(len(others)),
        "of these exact": str(sum(row.error == 0 for row in others)),
        "worst of Table 2": f"{_worst(row for row in others if row.table == 'Table 2'):.1%}",
        "worst of these": f"{worst:.0%}",
    }
    return {"figures": texts, "holds": worst < MET}


def _worst(rows: Iterable[Row]) -> float:
    return max(abs(row.error or 0.0) for row in rows)


# Speed of section 5.4, and the gain of section 4.5.2.


@measure
def maze_speed(runs: HarmonicRuns, _case: Case) -> Words:
    """The speed-ups on own mazes, and the gain of blocks and rising precision."""
    flat, gains = [run.speed_up for run in runs.speed], [run.gain for run in runs.speed]
    limbs = limbs_needed(SPEED_PRECISION)
    return {
        "runs": len(runs.speed),
        "corridors": ", ".join(str(width) for width in sorted({run.corridor for run in runs.speed})),
        "limbs": limbs,
        "mean": fmean(flat),
        "least": min(flat),
        "most": max(flat),
        "mean_by_limbs": limbs * fmean(flat),
        "least_by_limbs": limbs * min(flat),
        "most_by_limbs": limbs * max(flat),
        "gain": fmean(gains),
        "least_gain": min(gains),
        "most_gain": max(gains),
    }


@measure
def flat_speed(runs: HarmonicRuns, case: Case) -> Words:
    """The speed-up over software of flat cost, by the step of precision too."""
    speed = maze_speed(runs, case)
    by_step = {
        f"mean with steps of {step} bits": f"{fmean(run.speed_up for run in runs.speed if run.step == step):.0f}"
        for step in sorted({run.step for run in runs.speed})
    }
    texts = {"least": f"{speed['least']:.0f}", "most": f"{speed['most']:.0f}", **by_step}
    return {"figures": texts, "holds": speed["most"] < 270}


@measure
def speed_by_limbs(runs: HarmonicRuns, case: Case) -> Words:
    """The speed-up over software that pays for each limb."""
    speed = maze_speed(runs, case)
    return speed | {"holds": speed["least_by_limbs"] <= 270 <= speed["most_by_limbs"]}


@measure
def gain_below_2(runs: HarmonicRuns, case: Case) -> Words:
    """The gain from blocks and rising precision."""
    speed = maze_speed(runs, case)
    return speed | {"holds": speed["most_gain"] < 2}


@measure
def shorter_iterations(runs: HarmonicRuns, _case: Case) -> Words:
    """Iterations in blocks over the iterations of the synchronous run."""
    ratios = [run.iteration_ratio for run in runs.speed]
    holds = fmean(1 / ratio for ratio in ratios) < fmean(run.gain for run in runs.speed)
    return {"least": min(ratios), "most": max(ratios), "holds": holds}


# Estimates of sections 3.2.2 and 4, against what is counted.


@measure
def corridor(_runs: HarmonicRuns, case: Case) -> Words:
    """Bits for a corridor: the paper's formula, and the least precision."""
    length = case.length
    return {
        "value": required_precision(np.ones((1, length), np.bool_), [(0, length - 1)]).least,
        "estimate": theory.corridor_bits(length),
        "exponent": -math.log2(theory.corridor_estimate(1, length)),
    }


@measure
def counted_maps(runs: HarmonicRuns, _case: Case) -> list[Words]:
    """The maps of section 4."""
    return [{"counts": counts, "name": counts.name} for counts in runs.counts]


@measure
def counted(_runs: HarmonicRuns, case: Case) -> Words:
    """Estimates for the rectangle around a map and by the map's own K, and the counts."""
    counts: Counts = case.counts
    gain = counts.estimated_gain
    return {
        "margin": MARGIN,
        "estimated_gain": gain,
        "gain": counts.gain,
        "gamma": theory.gamma(counts.rows + 1, counts.columns + 1),
        "own": 1.0 - 1.0 / counts.gain,
        "first_precision": theory.first_precision(gain, MARGIN),
        "first_of_best": counts.best[0],
        "best": " ".join(map(str, counts.best)),
        "stages_of_best": len(counts.best),
        "best_ratio": counts.best_ratio,
        "last_precision": theory.last_precision(ERROR, gain, MARGIN),
        "error_bits": counts.error_bits,
        "first_estimate": round(theory.first_iterations(LAST, gain, MARGIN)),
        "first": counts.first,
        "own_first": theory.first_iterations(LAST, counts.gain, MARGIN),
        "later_estimate": round(theory.next_iterations(ADDED, gain, MARGIN)),
        "later": counts.later,
        "own_later": theory.next_iterations(ADDED, counts.gain, MARGIN),
    }


@measure
def equal_stages(_runs: HarmonicRuns, case: Case) -> Words:
    """Time with equal stages over time with one."""
    counts: Counts = case.counts
    return {
        "value": counts.ratios[case.stages],
        "estimate": theory.increasing_precision_ratio(case.stages),
        "equation_6": equation_6(case.stages, counts.estimated_gain),
    }


@measure
def contraction(runs: HarmonicRuns, _case: Case) -> Words:
    """Estimates of the iterations over their counts, by the sides of a map and by its own K."""
    by_sides = [theory.first_iterations(LAST, one.estimated_gain, MARGIN) / one.first for one in runs.counts]
    by_map = [theory.first_iterations(LAST, one.gain, MARGIN) / one.first for one in runs.counts]
    texts = {
        **_each(runs.counts, by_sides, "estimate by the sides over the count"),
        **_each(runs.counts, by_map, "estimate by the largest eigenvalue over the count"),
    }
    return {"figures": texts, "holds": max(by_map) < 1.2 < max(by_sides)}


@measure
def no_bound(runs: HarmonicRuns, _case: Case) -> Words:
    """The estimate of the iterations of a later stage, and its count."""
    later = {one: theory.next_iterations(ADDED, one.estimated_gain, MARGIN) for one in runs.counts}
    texts = {f"counted, {one.name}": f"{one.later:,}" for one in later}
    texts |= {f"estimated, {one.name}": f"{estimate:,.0f}" for one, estimate in later.items()}
    return {"figures": texts, "holds": any(one.later > estimate for one, estimate in later.items())}


@measure
def half_of_time(runs: HarmonicRuns, _case: Case) -> Words:
    """Time with equal stages and with the best schedule, over time with one stage."""
    equal, best = [min(one.ratios.values()) for one in runs.counts], [one.best_ratio for one in runs.counts]
    texts = {
        **_each(runs.counts, equal, "best of equal stages"),
        **_each(runs.counts, best, "fastest of all schedules"),
    }
    return {"figures": texts, "holds": min(*equal, *best) > 0.5}


def _each(counts: Sequence[Counts], values: Sequence[float], name: str) -> dict[str, str]:
    return {f"{name}, {place.name}": f"{value:.2f}" for place, value in zip(counts, values, strict=True)}


# Figures 3 to 6: one number for each curve, beside the words of the paper.


@measure
def bits_by_distance(runs: HarmonicRuns, _case: Case) -> list[Series]:
    """Figure 3."""
    return runs.bits


@measure
def bits_of_curve(_runs: HarmonicRuns, case: Case) -> Words:
    """The bits that a doubling of L adds."""
    (first, last), y = bits_a_doubling(case.item), case.item.y
    return {"value": last / first, "first": first, "last": last, "from_bits": y[0], "to_bits": y[-1]}


@measure
def growing_bits(runs: HarmonicRuns, _case: Case) -> Words:
    """The environments in which a doubling of L adds more and more bits."""
    halves = {curve.name: bits_a_doubling(curve) for curve in runs.bits}
    texts = {name: f"{first:.1f} to {last:.1f}" for name, (first, last) in halves.items()}
    growing = [name for name, (first, last) in halves.items() if last > first]
    return {"figures": texts, "holds": growing == ["empty"]}


@measure
def iterations_by_nodes(runs: HarmonicRuns, _case: Case) -> list[Series]:
    """Figure 4."""
    return runs.iterations


@measure
def power_of_curve(_runs: HarmonicRuns, case: Case) -> Words:
    """The exponent of iterations against nodes."""
    x, y = case.item.x, case.item.y
    ends = {"from_x": x[0], "to_x": x[-1], "from_y": y[0], "to_y": y[-1]}
    return {"value": node_power(case.item), **ends}


@measure
def growing_iterations(runs: HarmonicRuns, _case: Case) -> Words:
    """The growth of iterations with nodes."""
    powers = {series.name: node_power(series) for series in runs.iterations}
    texts = {f"iterations for twice the nodes, {name}": f"{2**power:.2f}" for name, power in powers.items()}
    texts |= {f"exponent, {name}": f"{power:.2f}" for name, power in powers.items()}
    texts["iterations for ten times the nodes, least"] = f"{10 ** min(powers.values()):.1f}"
    return {"figures": texts, "holds": max(powers.values()) < 1}


@measure
def all_ratios(runs: HarmonicRuns, _case: Case) -> tuple[Series, ...]:
    """Figure 5."""
    return runs.still.curves


@measure
def ratios_of_blocks(runs: HarmonicRuns, _case: Case) -> list[Series]:
    """The curves of Figure 5 with more than one block."""
    return [curve for curve in runs.still.curves if curve.name != "k=1"]


@measure
def best_of_curve(_runs: HarmonicRuns, case: Case) -> Words:
    """The largest ratio of iterations."""
    x, y = case.item.x, case.item.y
    return {"value": max(y), "at": x[y.index(max(y))], "last": y[-1], "end": x[-1]}


@measure
def blocks_gain(runs: HarmonicRuns, case: Case) -> Words:
    """The largest ratios against those at the largest I."""
    curves = ratios_of_blocks(runs, case)
    best = [max(series.y) for series in curves]
    less_at_end = all(series.y[-1] < max(series.y) for series in curves)
    return {"best": max(best), "holds": min(best) > 1 and less_at_end}


@measure
def unsteady_ratio(runs: HarmonicRuns, case: Case) -> Words:
    """The largest ratio by the number of blocks."""
    best = {series.name: max(series.y) for series in ratios_of_blocks(runs, case)}
    texts = {name: f"{most:.2f}" for name, most in best.items()}
    return {"figures": texts, "holds": not all(a >= b for a, b in itertools.pairwise(best.values()))}


@measure
def shares_of_visits(runs: HarmonicRuns, _case: Case) -> list[Series]:
    """Figure 6."""
    return runs.shares


@measure
def spread_of_curve(_runs: HarmonicRuns, case: Case) -> Words:
    """The spread of Î/I in the middle of a run."""
    begin, end = plateau(case.item)
    return {"value": theory.settled_spread(case.item), "mean": fmean(case.item.y), "begin": begin, "end": end}


@measure
def level_soon(runs: HarmonicRuns, _case: Case) -> Words:
    """The shares at which Î/I comes to its level."""
    begins = [plateau(series)[0] for series in runs.shares]
    return {"earliest": min(begins), "latest": max(begins), "holds": max(begins) <= SOON}


@measure
def level_left(runs: HarmonicRuns, _case: Case) -> Words:
    """The shares at which Î/I leaves its level."""
    ends = [plateau(series)[1] for series in runs.shares]
    return {"earliest": min(ends), "latest": max(ends), "holds": min(ends) < 1}


@measure
def smaller_blocks(runs: HarmonicRuns, _case: Case) -> Words:
    """The mean of Î/I by the size of blocks."""
    means = [fmean(series.y) for series in runs.shares]
    rising = all(a <= b for a, b in itertools.pairwise(means))
    return {"largest": means[0], "smallest": means[-1], "holds": not rising}


@measure
def wrong_bits(runs: HarmonicRuns, _case: Case) -> Words:
    """Runs of Figure 5 that end with wrong bits under the published termination."""
    return {"wrong": runs.still.wrong, "runs": runs.still.runs, "holds": runs.still.wrong > 0}
