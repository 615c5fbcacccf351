"""Relaxation, decision and ascent in plain Python: slow, short, and what the fast kernels are held against."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.maps.reach import reachable
from codesign.planners.harmonic.plan.arguments import Arguments, Stage, StageEnd, VisitBatch, check_arguments
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.relax import HarmonicPlan, VisitRecord
from codesign.planners.harmonic.plan.trajectory import Ascent, Ending, Trajectory, best_neighbours, goal_mask

NEIGHBOURS = ((-1, 0), (0, 1), (1, 0), (0, -1))
"""(row, column) steps to north, east, south and west, as ``best_neighbours`` numbers them."""


def relax_reference(
    free: Any, goals: Any, *, termination: str = "sound", start: Any = None, **rest: Any
) -> HarmonicPlan:
    """``relax`` over the whole schedule, by :func:`relax_stage`. It never ends where values never settle."""
    arguments = check_arguments(free, goals, termination=termination, start=start, **rest)
    field, stages, visits = arguments.start, [], []
    for index, precision in enumerate(arguments.schedule):
        for item in relax_stage(arguments, index, field.shifted(precision)):
            if isinstance(item, StageEnd):
                field = item.field
                stages.append(item.stage)
            else:
                visits += [(index, *visit) for visit in zip(item.block, item.iterations, strict=True)]
    record = VisitRecord(*np.array(visits, np.int32).T)
    return HarmonicPlan(tuple(stages), field, arguments.reachable, record)


def relax_stage(arguments: Arguments, index: int, start: Field) -> Iterator[VisitBatch | StageEnd]:
    """One stage at the precision of ``start``, a batch a sweep."""
    values = _framed(start.to_ints())
    movable = np.pad(arguments.movable, 1)
    (rows, columns), (height, width) = arguments.free.shape, arguments.block
    blocks_down, blocks_across = -(-rows // height), -(-columns // width)
    corners = [(1 + height * i, 1 + width * j) for i in range(blocks_down) for j in range(blocks_across)]
    sweeps = total = 0
    converged = False
    while not converged:
        converged = True
        iterations = []
        for top, left in corners:
            bottom, right = min(top + height, values.shape[0] - 1), min(left + width, values.shape[1] - 1)
            count, changed, settled = _visit(values, movable, (top, bottom, left, right), arguments.iterations)
            iterations.append(count)
            converged &= not changed if arguments.termination == "sound" else settled
        sweeps += 1
        total += sum(iterations)
        yield VisitBatch(
            index, start.precision, np.arange(len(corners), dtype=np.int32), np.array(iterations, np.int32)
        )
    inner = values[1:-1, 1:-1]
    maxima = count_local_maxima(inner, arguments.movable)
    stage = Stage(start.precision, sweeps, sweeps * len(corners), total, maxima)
    yield StageEnd(index, stage, Field.from_ints(inner, start.precision))


def _visit(
    values: NDArray[np.object_], movable: NDArray[np.bool_], bounds: tuple[int, int, int, int], most: int
) -> tuple[int, bool, bool]:
    """Iterations made, whether any bit changed, and whether the last iteration changed none."""
    top, bottom, left, right = bounds
    inside = np.s_[top:bottom, left:right]
    changed = False
    for count in range(1, most + 1):
        around = (
            values[top - 1 : bottom - 1, left:right]
            + values[top + 1 : bottom + 1, left:right]
            + values[top:bottom, left - 1 : right - 1]
            + values[top:bottom, left + 1 : right + 1]
        )
        updated = np.where(movable[inside], around // 4, values[inside])
        if (updated == values[inside]).all():
            return count, changed, True
        values[inside] = updated
        changed = True
    return most, changed, False


def count_local_maxima(values: NDArray[np.object_], candidates: NDArray[np.bool_]) -> int:
    """Candidates none of whose four neighbours is strictly greater."""
    padded = _framed(values)
    greatest = np.maximum.reduce([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
    return int((candidates & (greatest <= values)).sum())


def _framed(values: NDArray[np.object_]) -> NDArray[np.object_]:
    # Outside the map all is obstacle. np.pad would put machine integers, which overflow, into the frame.
    frame = np.zeros((values.shape[0] + 2, values.shape[1] + 2), object)
    frame[1:-1, 1:-1] = values
    return frame


def exact_direction(values: NDArray[Any], row: int, column: int, *, only_ascending: bool = False) -> tuple[int, int]:
    """The triangle rule at one cell, in exact integers: the (row, column) components of the way up.

    Args:
        values: integers (or objects of Python int), rows × columns; outside of the map is 0.
        row, column: the cell.
        only_ascending: differences to lower neighbours count as 0 (``Rule.ASCENDING_TRIANGLE``).

    Ties go to the triangle that comes first of N-E, W-N, E-S, S-W: to north and to east.
    """

    def rise(down: int, right: int) -> int:
        r, c = row + down, column + right
        inside = 0 <= r < values.shape[0] and 0 <= c < values.shape[1]
        difference = (int(values[r, c]) if inside else 0) - int(values[row, column])
        return max(difference, 0) if only_ascending else difference

    north, east, south, west = rise(-1, 0), rise(0, 1), rise(1, 0), rise(0, -1)
    triangles = (
        (north**2 + east**2, (-north, east)),
        (west**2 + north**2, (-north, -west)),
        (east**2 + south**2, (south, east)),
        (south**2 + west**2, (south, -west)),
    )
    return max(triangles, key=lambda triangle: triangle[0])[1]


def climb(ascent: Ascent, start: tuple[int, int]) -> Trajectory:
    """The cell-by-cell steepest ascent from a free cell: each step goes to the greatest neighbour."""
    row, column = start
    points = [(row, column)]
    while not ascent.goal[row, column] and ascent.best[row, column] >= 0:
        down, right = NEIGHBOURS[ascent.best[row, column]]
        row, column = row + down, column + right
        points.append((row, column))
    ending = Ending.GOAL if ascent.goal[row, column] else Ending.FLAT
    return Trajectory(np.array(points, np.float64), ending)


def local_maxima(field: Field, free: NDArray[np.bool_], goals: Sequence[tuple[int, int]]) -> NDArray[np.bool_]:
    """Bool rows × columns: reachable free cells, goals left out, with no strictly greater neighbour (4.1)."""
    cells = reachable(free, goals) & ~goal_mask(free, goals)
    return cells & (best_neighbours(field, free) < 0)


def share_reaching_goal(field: Field, free: NDArray[np.bool_], goals: Sequence[tuple[int, int]]) -> float:
    """Share of the reachable cells, goals left out, from which the steepest ascent ends at a goal; 1.0 of no cell.

    The share is 1.0 if and only if there is no local maximum: values rise strictly along an ascent, so it ends at a
    goal or at a local maximum.
    """
    ascent = Ascent(field, free, goals)
    cells = reachable(free, goals) & ~ascent.goal
    return float((ascent.climbs_to_goal() & cells).sum() / cells.sum()) if cells.any() else 1.0
