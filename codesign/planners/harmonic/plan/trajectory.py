"""The direction up a field (section 5.3), exactly; a robot that follows it, and the cell-by-cell ascent.

Coordinates are (row, column) in cells; a cell's centre has whole coordinates, and the cell of a point is the
closest grid point (section 5.3). Outside of the map is obstacle.

A node forms four triangles with two consecutive neighbours. The published rule takes the triangle with the greatest
(h − h')² + (h − h'')², and goes up the plane through its corners. Squares hide signs, so the chosen triangle may lie on
the downhill side. Then the direction points away from it, "or to their opposite values". Beside an obstacle the fall to
0 is often the steepest difference, and the direction points away from the wall. In a passage one cell wide both sides
fall by h, and the direction points from one wall to the other.

Measured with converged fields without local maxima and steps of half a cell, from every reachable cell:

- The plain rule arrives from all cells where passages are at least two cells wide (mazes, rooms, a spiral), from 1 % of
  the cells of a maze or spiral with passages one cell wide, and from 2 % among random obstacles (72 × 132 cells, 20 %).
- ``ASCENDING_TRIANGLE``, ours, counts differences to lower neighbours as 0. It arrives from all, all and 92 %, on paths
  shorter by 1 to 14 %.

``Ascent`` keeps a robot away from the walls under any rule.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.late import late
from codesign.maps.grid import as_free
from codesign.maps.reach import check_cells, led_to
from codesign.planners.harmonic.plan.fixed_point import Field

ascent_kernels = late("codesign.planners.harmonic.plan.ascent_kernels")


class Rule(StrEnum):
    """The rule that chooses the direction at a cell."""

    TRIANGLE = "triangle"
    ASCENDING_TRIANGLE = "ascending_triangle"
    NEIGHBOUR = "neighbour"


def directions(field: Field, free: NDArray[np.bool_], rule: Rule | str = Rule.TRIANGLE) -> NDArray[np.float64]:
    """Float64 rows × columns × 2: unit vectors (row, column) up the field; zero on obstacles and where it is flat.

    The choice of triangle is exact at any precision. Components come from the leading 65 to 128 bits of the
    differences, each within a relative 2^-50 of the larger.

    Raises:
        InputError: the field and the map differ in shape; unknown rule.
    """
    check_field(field, free)
    rule = _rule(rule)
    if rule is Rule.NEIGHBOUR:
        steps = np.array([(-1.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (0.0, 0.0)])
        return np.asarray(steps[ascent_kernels.best_neighbours(field.limbs, free)])
    result: NDArray[np.float64] = ascent_kernels.triangle_directions(field.limbs, free, rule is Rule.ASCENDING_TRIANGLE)
    return result


def chosen_triangle(field: Field, row: int, column: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """The corners of the triangle that the published rule takes at a cell: the vertical, then the horizontal one.

    Each as (side, sign): 0..3 = north, east, south, west, and the sign of h' - h, 0 where the two are equal.
    """
    chosen, other = np.empty((2, field.limbs.shape[2]), np.uint64)
    corners = []
    for axis in range(2):
        side, sign = ascent_kernels.choose_side(field.limbs, row, column, axis, chosen, other, False)
        corners.append((int(side), int(sign) if chosen.any() else 0))
    return corners[0], corners[1]


def best_neighbours(field: Field, free: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Int8 rows × columns: the greatest strictly greater neighbour, 0..3 = north, east, south, west; else -1.

    The first in that order among equals; -1 on obstacles.
    """
    check_field(field, free)
    result: NDArray[np.int8] = ascent_kernels.best_neighbours(field.limbs, free)
    return result


def goal_mask(free: NDArray[np.bool_], goals: Sequence[tuple[int, int]]) -> NDArray[np.bool_]:
    """Bool rows × columns, true on the goals. Raises MapError for a goal that is no free cell of the map."""
    mask = np.zeros(free.shape, np.bool_)
    mask[tuple(check_cells(free, goals).T)] = True
    return mask


def check_field(field: Field, free: NDArray[np.bool_]) -> None:
    """Refuse a map that is no bool rows × columns (MapError) and a field of another shape (InputError)."""
    as_free(free, "free")
    if field.shape != free.shape:
        raise InputError(f"a field of {field.shape} values for a map of {free.shape} cells", "field")


def _rule(rule: Rule | str) -> Rule:
    try:
        return Rule(rule)
    except ValueError:
        raise InputError(f"rule {rule!r} is unknown", "rule", choose_hint(str(rule), list(Rule))) from None


DEFAULT_STEP = 0.5


class Ending(StrEnum):
    """The end of a trajectory: at a goal, before an obstacle, where no direction rises, at the bound on steps."""

    GOAL = "goal"
    OBSTACLE = "obstacle"
    FLAT = "flat"
    STEPS = "steps"


_ENDINGS = (Ending.GOAL, Ending.OBSTACLE, Ending.FLAT, Ending.STEPS)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A path through the map.

    Attributes:
        points: float64 n × 2, (row, column) in cells, start first; the last is the goal's centre if it
            arrives.
        ending: the reason for the end.
        fallbacks: steps that left the decision's direction for the greatest neighbour.
    """

    points: NDArray[np.float64]
    ending: Ending
    fallbacks: int = 0

    @property
    def arrived(self) -> bool:
        """True if it ends at a goal."""
        return self.ending is Ending.GOAL

    @property
    def length(self) -> float:
        """Length in cells."""
        return float(np.sqrt((np.diff(self.points, axis=0) ** 2).sum(axis=1)).sum())


class Ascent:
    """A field with the directions and the greatest neighbours of all cells, computed once for many trajectories.

    Args:
        field: the values.
        free: bool, rows × columns.
        goals: (row, column) pairs on free cells.
        rule: how the direction at a cell is chosen.
        step: length of a step in cells, above 0, at most 1.
        guarded: True if the robot keeps to a rising path (see ``follow``).
        most_steps: bound on the steps of one trajectory; None means twice the most steps of a rising path.

    Raises:
        MapError: a goal is not on a free cell. InputError: another argument is unusable.
    """

    def __init__(
        self,
        field: Field,
        free: NDArray[np.bool_],
        goals: Sequence[tuple[int, int]],
        *,
        rule: Rule | str = Rule.TRIANGLE,
        step: float = DEFAULT_STEP,
        guarded: bool = True,
        most_steps: int | None = None,
    ) -> None:
        check_field(field, free)
        if not (math.isfinite(step) and 0.0 < step <= 1.0):
            raise InputError(f"a step of {step} cells is outside of 0..1", "step", "0.5 is usual")
        if most_steps is not None and most_steps < 1:
            raise InputError(f"{most_steps} steps are fewer than 1", "most_steps")
        self.field = field
        self.free = np.ascontiguousarray(free)
        self.goal = goal_mask(free, goals)
        self.directions = directions(field, self.free, rule)
        self.best = best_neighbours(field, self.free)
        self._arrays = field.limbs, self.free, self.goal, self.directions, self.best
        self.step = step
        self.guarded = guarded
        # A rising path enters each cell once, and crosses it in at most √2 / step steps.
        self.most_steps = most_steps or 2 * self.free.size * math.ceil(1.0 + math.sqrt(2.0) / step)

    def follow(self, start: tuple[float, float]) -> Trajectory:
        """The path of a robot from ``start``, (row, column) in cells. The closest cell to it is required to be free.

        At every step the robot goes ``step`` cells in the direction decided at the closest grid point (section 5.3).
        The paper says nothing about walls, so there are two kinds of robots. Neither ever enters an obstacle or cuts a
        corner (a diagonal step needs both cells beside it free).

        - Not guarded, the plain rule: the robot stops before an obstacle. It may also wander across a ridge without
          end, until ``most_steps``.
        - Guarded, ours: the next point may lie in an obstacle, cut a corner, or lie in another cell that is not
          strictly higher. Then the robot goes to the centre of the greatest neighbour instead, straight through two
          free cells. The values of the entered cells rise strictly. So the robot never comes back, and it arrives from
          every cell of a field without local maxima.

        Raises:
            InputError: the start is not in a free cell.
        """
        y, x = self._check_start(start)
        points, ending, fallbacks = ascent_kernels.follow(*self._arrays, y, x, self.step, self.most_steps, self.guarded)
        return Trajectory(points.copy(), _ENDINGS[ending], int(fallbacks))

    def endings(self, cells: NDArray[np.bool_]) -> dict[Ending, int]:
        """The number of trajectories by their ending, from the centres of the free cells of a mask."""
        starts = np.argwhere(cells & self.free).astype(np.float64)
        codes = ascent_kernels.arrivals(*self._arrays, starts, self.step, self.most_steps, self.guarded)
        counts = np.bincount(codes, minlength=len(_ENDINGS))
        return {ending: int(count) for ending, count in zip(_ENDINGS, counts, strict=True)}

    def climbs_to_goal(self) -> NDArray[np.bool_]:
        """Bool rows × columns: cells from which the steepest ascent ends at a goal (goals included)."""
        return led_to(self.best, ((-1, 0), (0, 1), (1, 0), (0, -1)), self.goal)

    def _check_start(self, start: tuple[float, float]) -> tuple[float, float]:
        y, x = float(start[0]), float(start[1])
        if math.isfinite(y) and math.isfinite(x):
            row, column = math.floor(y + 0.5), math.floor(x + 0.5)
            rows, columns = self.free.shape
            if 0 <= row < rows and 0 <= column < columns and self.free[row, column]:
                return y, x
        raise InputError(f"start {tuple(start)} is not in a free cell", "start", "move it to a free cell")
