"""Section 3.2.2 and section 4 of Girau et al. (2008): the estimates of the paper beside the counts of runs.

The paper estimates bits and iterations by closed forms in the size of the map alone. Here they are evaluated for the
rectangle around a map (N and M count intervals: sides plus one). The same quantities are counted on two maps: a room
without obstacles, for which the estimates are made, and a labyrinth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.figures import Status
from codesign.planners.harmonic.paper import closed_forms as theory
from codesign.planners.harmonic.paper.figures import WHOLE_MAP_ITERATIONS, Environment, labyrinth
from codesign.planners.harmonic.plan import HarmonicPlan, relax
from codesign.planners.interface import Problem
from codesign.planners.reproduction import Finding, Progress, Row, row

CORRIDORS = (10, 100, 300)
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


@dataclass(frozen=True)
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
    ratios: tuple[tuple[int, float], ...]
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
    ratios = []
    for stages in STAGES:
        result = _synchronous(place, _equal_steps(stages))
        ratios.append((stages, result.total_cycles / one_stage.total_cycles))
    best, cycles = _best_schedule(place)
    return Counts(
        name=place.name,
        rows=place.free.shape[0],
        columns=place.free.shape[1],
        gain=1.0 / (1.0 - largest_eigenvalue(place.free, place.goal)),
        error_bits=_bits_for(place, ERROR),
        first=one_stage.total_iterations,
        later=_synchronous(place, [LAST - ADDED, LAST]).stages[1].iterations,
        ratios=tuple(ratios),
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
    from codesign.planners.harmonic.plan.best_schedule import optimise_schedule
    from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop

    parameters = RelaxParameters(
        blocks=(1, 1), iterations=1_000_000, schedule=(LAST,), stop=Stop.SCHEDULE_END
    )
    schedule = optimise_schedule(Problem(place.free, (place.goal,), ()), parameters, CANDIDATES)
    return schedule.precisions, schedule.cost


def _bits_for(place: Environment, error: float) -> int:
    """Least precision with a converged field nowhere farther than ``error`` from the exact one."""
    from codesign.planners.harmonic.plan.precision import converged_field
    from codesign.planners.harmonic.plan.warm_start import FieldBounds

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
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import eigsh

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


def theory_rows(counts: Sequence[Counts]) -> tuple[Row, ...]:
    """The estimates of the paper as published figures, and the counts as modelled ones."""
    rows = _corridor_rows()
    for place in counts:
        rows += [*_gain_rows(place), *_iteration_rows(place), *_time_rows(place)]
    return tuple(rows)


def _corridor_rows() -> list[Row]:
    from codesign.planners.harmonic.plan.precision import required_precision

    rows = []
    for length in CORRIDORS:
        least = required_precision(np.ones((1, length), np.bool_), [(0, length - 1)]).least
        exponent = -math.log2(theory.corridor_estimate(1, length))
        rows.append(
            row(
                "Section 3.2.2",
                f"bits for a corridor of {length} cells",
                theory.corridor_bits(length),
                least,
                unit="bit",
                status=Status.MEASURED,
                source="least precision without local maxima, against the least with x_1 ≥ 2^-p",
                note=f"x_1 = 2^-{exponent:.1f}; a way up needs x_2 alone to be above 0",
            )
        )
    return rows


def _gain_rows(place: Counts) -> list[Row]:
    gain = place.estimated_gain
    gamma, own = theory.gamma(place.rows + 1, place.columns + 1), 1.0 - 1.0 / place.gain
    measured = partial(row, status=Status.MEASURED)
    return [
        measured(
            "Section 4.2",
            f"K, {place.name}",
            gain,
            place.gain,
            source="1 / (1 − γ), γ of the rectangle, against the largest eigenvalue of the map",
            note=f"γ = {gamma:.5f}; the map's own is {own:.5f}",
        ),
        measured(
            "Section 4.4.1",
            f"first precision, {place.name}",
            theory.first_precision(gain, MARGIN),
            place.best[0],
            unit="bit",
            source=f"p_min with λ = {MARGIN:.0f} (assumed), against the best schedule's first",
            note="fastest of all schedules: " + " ".join(map(str, place.best)),
        ),
        measured(
            "Section 4.4.1",
            f"bits for an error below 2^-16, {place.name}",
            theory.last_precision(ERROR, gain, MARGIN),
            place.error_bits,
            unit="bit",
            source=f"p_max with λ = {MARGIN:.0f} (assumed), against the least precision that has it",
        ),
    ]


def _iteration_rows(place: Counts) -> list[Row]:
    measured = partial(
        row, status=Status.MEASURED, source=f"λ = {MARGIN:.0f} (assumed), against synchronous iterations"
    )
    own_first = theory.first_iterations(LAST, place.gain, MARGIN)
    own_later = theory.next_iterations(ADDED, place.gain, MARGIN)
    return [
        measured(
            "Section 4.4.2",
            f"k_1 at {LAST} bits, {place.name}",
            round(theory.first_iterations(LAST, place.estimated_gain, MARGIN)),
            place.first,
            note=f"{own_first:,.0f} with the map's own K",
        ),
        measured(
            "Section 4.4.2",
            f"k_i for the last {ADDED} of {LAST} bits, {place.name}",
            round(theory.next_iterations(ADDED, place.estimated_gain, MARGIN)),
            place.later,
            note=f"{own_later:,.0f} with the map's own K",
        ),
    ]


def _time_rows(place: Counts) -> list[Row]:
    measured = partial(row, status=Status.MEASURED)
    rows = []
    for stages, ratio in place.ratios:
        rows.append(
            measured(
                "Section 4.4.2",
                f"time with {stages} equal stages over one, {place.name}",
                theory.increasing_precision_ratio(stages),
                ratio,
                source=f"(1 + 1/T) / 2, against cycles of synchronous runs to {LAST} bits",
                note=f"equation (6) comes to {equation_6(stages, place.estimated_gain):.3f}",
            )
        )
    rows.append(
        measured(
            "Section 4.4.2",
            f"time with the best schedule over one stage, {place.name}",
            0.5,
            place.best_ratio,
            source=f"the limit of many stages, against the fastest schedule of all to {LAST} bits",
            note=f"{len(place.best)} stages",
        )
    )
    return rows


def equation_6(stages: int, gain: float) -> float:
    """Time with equal stages over time with one by equation (6): a = k_i for no bits, b = K log 2, p + 2 cycles."""
    a, b = theory.next_iterations(0, gain, MARGIN), gain * theory.LN2
    steps = [float(precision) for precision in _equal_steps(stages)]
    return theory.stages_time(steps, a, b, 2, 1) / theory.stages_time([LAST], a, b, 2, 1)


def theory_findings(counts: Sequence[Counts]) -> tuple[Finding, ...]:
    """Findings on the estimates."""
    by_sides = [theory.first_iterations(LAST, place.estimated_gain, MARGIN) / place.first for place in counts]
    by_map = [theory.first_iterations(LAST, place.gain, MARGIN) / place.first for place in counts]
    later = [theory.next_iterations(ADDED, place.estimated_gain, MARGIN) for place in counts]
    equal = [min(ratio for _, ratio in place.ratios) for place in counts]
    return (
        Finding(
            "Obstacles make a map contract faster than the rectangle around it: K by equation (5) is for open ground.",
            {
                **_each(counts, by_sides, "estimate by the sides over the count"),
                **_each(counts, by_map, "estimate by the largest eigenvalue over the count"),
            },
            max(by_map) < 1.2 < max(by_sides),
        ),
        Finding(
            "The estimate of k_i is no bound.",
            {f"counted, {place.name}": f"{place.later:,}" for place in counts}
            | {f"estimated, {place.name}": f"{k:,.0f}" for place, k in zip(counts, later, strict=True)},
            any(place.later > k for place, k in zip(counts, later, strict=True)),
        ),
        Finding(
            "Stages take more than half of the time of one stage.",
            {
                **_each(counts, equal, "best of equal stages"),
                **_each(counts, [place.best_ratio for place in counts], "fastest of all schedules"),
            },
            min(*equal, *(place.best_ratio for place in counts)) > 0.5,
        ),
    )


def _each(counts: Sequence[Counts], values: Sequence[float], name: str) -> dict[str, str]:
    return {f"{name}, {place.name}": f"{value:.2f}" for place, value in zip(counts, values, strict=True)}
