"""The plan that a robot follows, and the path that it makes of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.components.path import Polyline, join, starts_clear
from codesign.system.bind import planner_code
from codesign.system.chain import Answer

OFF_PATH = 1.0
"""Cells: a robot farther than this from its path gets a new path of the same plan."""


class ActivePlan:
    """The plan that the robot follows, and the path that it makes of it.

    Args:
        answer: the plan.
        planner: the one that made it.
        position: where its path begins.
        again: whether a decision is asked for at every turn (``planners.interface.POSE``). The plan is then asked for
            another path where the robot was seen off this one. Otherwise the answer was sent once, and only this path
            of the plan is known here.
        number: which plan of the drive it is, from 1.
    """

    def __init__(
        self, answer: Answer, planner: Any, position: tuple[float, float], *, again: bool, number: int = 1
    ) -> None:
        self.answer, self.number = answer, number
        self._planner, self._again = planner, again
        self.path, self.arrives = self._make(position)

    def from_here(self, position: tuple[float, float], passable: NDArray[np.bool_]) -> Polyline:
        """The path from ``position``. The plan makes a new one where the robot is off it and the plan can be asked."""
        if self._again and self.path.closest(position)[1] > OFF_PATH:
            self.path, self.arrives = self._make(position)
        return join(self.path, position, passable)

    @property
    def target(self) -> tuple[int, int]:
        """The cell in which the path ends."""
        row, column = self.path.points[-1]
        return round(float(row)), round(float(column))

    def lost(self, position: tuple[float, float], passable: NDArray[np.bool_]) -> bool:
        """True if the plan knows no path from ``position``, which is not where it was planned from."""
        if not self._again:
            off = self.path.closest(position)[1] > OFF_PATH
            return off and not starts_clear(join(self.path, position, passable), passable)
        return not self.arrives and self.path.length == 0.0 and self.target != self.answer.problem.starts[0]

    def _make(self, position: tuple[float, float]) -> tuple[Polyline, bool]:
        """The path from ``position``; else from where the plan begins: the robot left that while the plan was made."""
        problem = self.answer.problem
        points, arrives = self._ask(position)
        if not arrives and len(points) == 1:
            row, column = problem.starts[0]
            begun = self._ask((float(row), float(column)))
            if Polyline(begun[0]).closest(position)[1] <= OFF_PATH:
                points, arrives = begun
        return Polyline(around_corners(points, problem.free)), arrives

    def _ask(self, position: tuple[float, float]) -> tuple[NDArray[np.float64], bool]:
        """The planner's path from a position.

        Raises:
            RunError: the planner gives no path.
        """
        with planner_code(self._planner):
            given, arrives = self._planner.path_from(self.answer.problem, self.answer.plan, position)
            points = np.asarray(given, np.float64)
            if points.ndim != 2 or points.shape[1] != 2 or not len(points) or not np.isfinite(points).all():
                raise ValueError("its way is not n × 2 finite numbers, n at least 1")
            if not _inside(points, self.answer.problem.free.shape):
                raise ValueError("its way leaves the map")
            return points, bool(arrives)


def _inside(points: NDArray[np.float64], shape: tuple[int, ...]) -> bool:
    """True if all points, float64 n × 2, lie on a map of ``shape``, its rim included."""
    return bool(((points >= -0.5) & (points <= np.array(shape) - 0.5)).all())


def around_corners(points: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The path with every diagonal step past one obstacle led through the free cell beside it.

    Planners on eight neighbours may pass the corner of an obstacle; a robot would touch it. ``points``: float64 n × 2;
    only steps between the middles of two cells are looked at.
    """
    cells = np.rint(points).astype(np.int64)
    whole = np.abs(points - cells).max(axis=1) < 1e-9
    diagonal = (np.abs(np.diff(cells, axis=0)) == 1).all(axis=1) & whole[:-1] & whole[1:]
    bent = [points[0]]
    for index in range(len(points) - 1):
        if diagonal[index]:
            (row, column), (next_row, next_column) = cells[index], cells[index + 1]
            by_row, by_column = free[next_row, column], free[row, next_column]
            if by_row != by_column:
                bent.append(np.array((next_row, column) if by_row else (row, next_column), np.float64))
        bent.append(points[index + 1])
    return np.array(bent)
