"""Costs, load and jitter of a host, fitted to the times of plans on several maps.

A cost is a time a unit of a kernel, and the time of a plan is a sum of units times costs. On another map the same units
take another time: caches, branches and prefetching differ. So the costs of a program are fitted on maps of several
kinds and sizes, and their interval is the one in which the time of a plan on one more map lies with 95 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from statistics import median

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.hardware.calibrate.calibration import student
from codesign.inputs.fields import MOST_LOAD

optimize = late("scipy.optimize")

Floats = NDArray[np.float64]

HOLD = 0.02
"""The weight of the first costs beside that of a map: it decides between kernels that no map tells apart."""


@dataclass(frozen=True)
class Timing:
    """The times of a plan on a map, run after run.

    ``program``: of whose kernels it counts ``units``. ``wall``, ``processor``: seconds of each run, by the clock on the
    wall and of the processor.
    """

    program: str
    map: str
    units: Mapping[str, int]
    wall: tuple[float, ...]
    processor: tuple[float, ...]

    @property
    def seconds(self) -> float:
        """The median of the processor's time."""
        return median(self.processor)

    def predicted(self, costs: Mapping[str, float]) -> float:
        """Units times costs, s; a kernel without a cost counts as none."""
        return math.fsum(units * costs.get(kernel, 0.0) for kernel, units in self.units.items())


@dataclass(frozen=True)
class Residual:
    """A map of a fit: the measured median, s; what the fit predicts; and what one without this map does."""

    map: str
    measured: float
    predicted: float
    held_out: float


@dataclass(frozen=True)
class ProgramFit:
    """The costs of the kernels that a program is the first to count in, s, and what the fit leaves."""

    program: str
    costs: Mapping[str, Figure]
    residuals: tuple[Residual, ...]

    @property
    def error(self) -> float:
        """The greatest error on a map held out, as a share of its time."""
        return max(abs(each.held_out / each.measured - 1.0) for each in self.residuals)


def fit_programs(timings: Sequence[Timing], first: Mapping[str, float], where: str) -> tuple[ProgramFit, ...]:
    """The costs of all programs, in the order of their timings.

    Args:
        timings: of at least two maps a program.
        first: costs to begin with, s a unit of a kernel; their ratios decide where the maps do not.
        where: the machine, for the source.
    """
    known: dict[str, float] = {}
    fits = []
    for program, rows in map_reduce(timings, lambda each: each.program).items():
        fit = _fit(program, rows, first, known, where)
        known |= {kernel: cost.value for kernel, cost in fit.costs.items()}
        fits.append(fit)
    return tuple(fits)


def _fit(
    program: str, rows: Sequence[Timing], first: Mapping[str, float], known: dict[str, float], where: str
) -> ProgramFit:
    kernels = [*dict.fromkeys(kernel for row in rows for kernel in row.units if kernel not in known)]
    costs = _least_squares(rows, kernels, first, known)
    maps = map_reduce(rows, lambda row: row.map)
    without = {
        name: _least_squares([row for row in rows if row.map != name], kernels, first, known) | known for name in maps
    }
    residuals = tuple(
        Residual(row.map, row.seconds, row.predicted(costs | known), row.predicted(without[row.map])) for row in rows
    )
    errors = [math.log(each.measured / each.held_out) for each in residuals]
    width = student(len(maps) - 1) * math.sqrt(math.fsum(error**2 for error in errors) / len(errors))
    repeated = [np.array(row.processor) / row.seconds for row in rows]
    fast, slow = np.quantile(np.concatenate(repeated), (0.01, 0.99)).tolist()
    # Maps and runs vary apart from each other: the two widths add up as squares.
    low, high = (math.exp(sign * math.hypot(width, math.log(each))) for sign, each in ((-1, fast), (1, slow)))
    off = [each.measured / each.held_out - 1.0 for each in residuals]
    source = (
        f"{program}: fit to {sum(map(len, repeated)):,} runs on {len(maps)} maps, on each held out by turns"
        f" {min(off):+.0%} to {max(off):+.0%}; interval of a run on one more map with 95 %; {where}"
    )
    figures = {
        kernel: Figure(cost, "s", Status.MEASURED, source, cost * low, cost * high) for kernel, cost in costs.items()
    }
    return ProgramFit(program, figures, residuals)


def _least_squares(
    rows: Sequence[Timing], kernels: Sequence[str], first: Mapping[str, float], known: Mapping[str, float]
) -> dict[str, float]:
    """The costs of kernels, none below 0, with the least sum of squares of predicted / measured - 1."""
    if not kernels:
        return {}
    begun = {kernel: first.get(kernel, 1e-9) for kernel in kernels}
    left = [max(row.seconds - row.predicted(known), 1e-3 * row.seconds) for row in rows]
    scale = median(rest / max(row.predicted(begun), 1e-15) for rest, row in zip(left, rows, strict=True))
    # One row a map: Σ units · cost / measured = 1 - what is known; and one a kernel, that keeps the first ratios.
    shares = [[scale * row.units.get(each, 0) * begun[each] / row.seconds for each in kernels] for row in rows]
    aims = [rest / row.seconds for rest, row in zip(left, rows, strict=True)]
    hold = HOLD * math.sqrt(len(rows))
    system = np.vstack([np.array(shares), hold * np.eye(len(kernels))])
    times, _ = optimize.nnls(system, np.array([*aims, *([hold] * len(kernels))]))
    # A kernel that costs nothing at all is one that the maps cannot tell from another.
    return {each: scale * begun[each] * max(float(time), 0.01) for each, time in zip(kernels, times, strict=True)}


@dataclass(frozen=True)
class Disturbance:
    """What other programs and the system take: see the keys ``load`` and ``jitter`` of a processor."""

    load: Figure
    median: Figure
    p99: Figure


def disturbance_of(timings: Sequence[Timing], where: str) -> Disturbance:
    """The load and the jitter of a machine, by the time on the wall of each run over that of the processor.

    The load is the share that the runs together did not get; its interval reaches from the least disturbed runs to the
    most disturbed round over all maps. Jitter is what remains of a run's ratio.
    """
    wall, busy = (_rounds([getattr(each, name) for each in timings]) for name in ("wall", "processor"))
    # A processor's clock may be coarse: no run took more of it than of the time on the wall.
    late_by = np.maximum(1.0, np.concatenate([each for each in wall]) / np.concatenate([each for each in busy]))
    load = _within(1.0 - sum(map(np.sum, busy)) / sum(map(np.sum, wall)))
    worst = max(load, *(_within(1.0 - used.sum() / spent.sum()) for used, spent in zip(busy, wall, strict=True)))
    least = min(load, _within(1.0 - 1.0 / float(np.quantile(late_by, 0.01))))
    mid, late = np.quantile(late_by, (0.5, 0.99)).tolist()
    mid, late = max(1.0, mid * (1 - load)), max(1.0, late * (1 - worst))
    source = f"{late_by.size:,} runs timed on the wall and on the processor; {where}"
    return Disturbance(
        Figure(
            round(load, 4), "1", Status.MEASURED, source, math.floor(1e4 * least) / 1e4, math.ceil(1e4 * worst) / 1e4
        ),
        *(Figure(round(each, 4), "1", Status.MEASURED, source) for each in (mid, max(mid, late))),
    )


def _rounds(runs: Sequence[Sequence[float]]) -> list[Floats]:
    """The runs of each round over all plans and maps."""
    count = max(map(len, runs), default=0)
    return [np.array([*chain.from_iterable(each[turn : turn + 1] for each in runs)]) for turn in range(count)]


def _within(load: float) -> float:
    return float(min(max(load, 0.0), MOST_LOAD))
