"""Section 3.2.2 and section 4 of Girau et al. (2008): the estimates of the paper beside the counts of runs.

The paper estimates bits and iterations by closed forms in the size of the map alone. Here they are evaluated for the
rectangle around a map (N and M count intervals: sides plus one). The same quantities are counted on two maps: a room
without obstacles, for which the estimates are made, and a labyrinth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import eigsh

from codesign import maps
from codesign.planners.harmonic.paper import closed_forms as theory
from codesign.planners.harmonic.paper.figures import WHOLE_MAP_ITERATIONS, Environment, labyrinth
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.harmonic.plan.best_schedule import optimise_schedule
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.warm_start import FieldBounds
from codesign.planners.interface import Problem
from codesign.planners.reproduction import Progress

MARGIN = 1.0
"""λ, which the paper leaves open. With 1 the error of the field may be twice its asymptote."""
LAST = 255
ADDED = 8
ERROR = 2.0**-16
SIDE = 40
QUICK_SIDE = 12
STAGES = (2, 4, 8, 16)
CANDIDATES = (4, 8, 12, *range(16, LAST, 16))
"""Precisions that the best schedule may have before the last."""


@dataclass(frozen=True, eq=False)
class Counts:
    """The counts on one map of ``rows`` × ``columns`` cells, computed as one block.

    Attributes:
        gain: K = 1 / (1 − γ) with the largest eigenvalue γ of the map's own matrix (4.2).
        error_bits: least precision with a converged field within ``ERROR`` of the exact one.
        first: iterations from zero until no bit of ``LAST`` changes.
        later: iterations of a stage that adds the last ``ADDED`` bits.
        ratios: number of equal stages to ``LAST`` bits, and time with them over time with one stage.
        best: the precisions of the fastest schedule of all through ``CANDIDATES``.
        best_ratio: its time over time with one stage.
    """

    name: str
    rows: int
    columns: int
    gain: float
    error_bits: int
    first: int
    later: int
    ratios: dict[int, float]
    best: tuple[int, ...]
    best_ratio: float

    @property
    def estimated_gain(self) -> float:
        """K of the rectangle around the map (4.2)."""
        return theory.noise_gain(self.rows + 1, self.columns + 1)


def count_maps(quick: bool, progress: Progress) -> tuple[Counts, ...]:
    """The counts of the room and the labyrinth; ``quick``: of a smaller room."""
    side = QUICK_SIDE if quick else SIDE
    places = (Environment("room", maps.empty(side, side).free, (0, 0)), labyrinth(1))
    counts = []
    for place in places:
        progress(f"section 4: estimates for the {place.name}")
        counts.append(_count(place))
    return tuple(counts)


def _count(place: Environment) -> Counts:
    one_stage = _synchronous(place, [LAST])
    ratios = {}
    for stages in STAGES:
        result = _synchronous(place, _equal_steps(stages))
        ratios[stages] = result.total_cycles / one_stage.total_cycles
    best, cycles = _best_schedule(place)
    return Counts(
        name=place.name,
        rows=place.free.shape[0],
        columns=place.free.shape[1],
        gain=1.0 / (1.0 - largest_eigenvalue(place.free, place.goal)),
        error_bits=_bits_for(place, ERROR),
        first=one_stage.total_iterations,
        later=_synchronous(place, [LAST - ADDED, LAST]).stages[1].iterations,
        ratios=ratios,
        best=best,
        best_ratio=cycles / one_stage.total_cycles,
    )


def _equal_steps(stages: int) -> list[int]:
    return [LAST * stage // stages for stage in range(1, stages + 1)]


def _synchronous(place: Environment, schedule: list[int]) -> HarmonicPlan:
    return relax(
        place.free,
        [place.goal],
        block=(place.free.shape[0], place.free.shape[1]),
        iterations=WHOLE_MAP_ITERATIONS,
        schedule=schedule,
        record_visits=False,
    )


def _best_schedule(place: Environment) -> tuple[tuple[int, ...], int]:
    """The fastest schedule of synchronous stages, and its cycles."""
    parameters = RelaxParameters(blocks=(1, 1), iterations=1_000_000, schedule=(LAST,), stop=Stop.SCHEDULE_END)
    schedule = optimise_schedule(Problem(place.free, (place.goal,), ()), parameters, CANDIDATES)
    return schedule.precisions, schedule.cost


def _bits_for(place: Environment, error: float) -> int:
    """Least precision with a converged field nowhere farther than ``error`` from the exact one."""
    goals = [place.goal]
    bounds = FieldBounds(place.free, goals)
    # At 60 bits what is left to the exact field is far below any error asked for here.
    exact = converged_field(place.free, goals, 60, bounds=bounds).to_float()
    precision = 1
    while (exact - converged_field(place.free, goals, precision, bounds=bounds).to_float()).max() > error:
        precision += 1
    return precision


def largest_eigenvalue(free: NDArray[np.bool_], goal: tuple[int, int]) -> float:
    """γ of the map itself: the factor by which an iteration of the free cells finally shrinks an error (4.2)."""
    movable = free.copy()
    movable[goal] = False
    number = np.cumsum(movable).reshape(free.shape) - 1
    across, down = movable[:, :-1] & movable[:, 1:], movable[:-1] & movable[1:]
    cell = np.concatenate([number[:, :-1][across], number[:-1][down]])
    neighbour = np.concatenate([number[:, 1:][across], number[1:][down]])
    ends = np.concatenate([cell, neighbour]), np.concatenate([neighbour, cell])
    count = int(movable.sum())
    matrix = coo_array((np.full(2 * len(cell), 0.25), ends), shape=(count, count)).tocsr()
    # A start of its own makes the same digits at every run.
    return float(eigsh(matrix, k=1, which="LA", v0=np.ones(count), return_eigenvectors=False)[0])


def equation_6(stages: int, gain: float) -> float:
    """Time with equal stages over time with one by equation (6): a = k_i for no bits, b = K log 2, p + 2 cycles."""
    a, b = theory.next_iterations(0, gain, MARGIN), gain * theory.LN2
    steps = [float(precision) for precision in _equal_steps(stages)]
    return theory.stages_time(steps, a, b, 2, 1) / theory.stages_time([LAST], a, b, 2, 1)
