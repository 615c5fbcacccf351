"""One search on a map, and its outcome."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.maps.grid import as_free
from codesign.maps.reach import check_cells
from codesign.planners.grid_search.plan import reference
from codesign.planners.grid_search.plan.parameters import Heuristic, Method, SearchParameters

kernels = late("codesign.planners.grid_search.plan.kernels")
navfn = late("codesign.planners.grid_search.plan.navfn")

Cell = tuple[int, int]

RULES = {Heuristic.OCTILE: reference.OCTILE, Heuristic.EUCLIDEAN: reference.EUCLIDEAN, Heuristic.NONE: reference.NONE}


@dataclass(frozen=True, eq=False)
class GridPlan:
    """The outcome of a search.

    Attributes:
        parameters: the parameters of the search.
        start: the first cell; None where the search ran over the whole map.
        path: float64 n × 2, (row, column) from the start to a goal: cells next to each other, points of a line no
            farther apart than a cell (theta_star), or half a cell apart (navfn). 0 × 2 where there is no way.
        expanded: cells taken from the heap and looked around; of navfn updates of a cell.
        entries: entries of the heap.
        looked: cells that jumps and lines of sight looked at.
        lengths: of each cell of the map with its ring, flat: int64 in units of ``reference.STRAIGHT``, float64 in
            cells (theta_star), or the potential in float32 (navfn). Valid where ``settled``.
        before: int32, of each such cell the next one on the way to a goal; empty of navfn.
        states: uint8, of each such cell, as ``kernels`` has it: closed where the search has its length. Of navfn
            the map alone.
        shape: rows and columns of the map.
        smooth: True if the path follows the gradient of navfn between cells.
    """

    parameters: SearchParameters
    start: Cell | None
    path: NDArray[np.float64]
    expanded: int
    entries: int
    looked: int
    lengths: NDArray[np.generic]
    before: NDArray[np.int32]
    states: NDArray[np.uint8]
    shape: Cell
    smooth: bool = False

    @property
    def reached(self) -> bool:
        """True if there is a path."""
        return len(self.path) > 0

    @property
    def stride(self) -> int:
        """Cells of a row of the map with its ring."""
        return self.shape[1] + 2

    @cached_property
    def settled(self) -> NDArray[np.bool_]:
        """Bool, of each cell of the map with its ring: the search has its length."""
        if self.parameters.method is Method.NAVFN:
            return np.asarray(self.lengths < navfn.HIGH)
        return np.asarray(self.states == reference.CLOSED)

    @cached_property
    def length(self) -> float | None:
        """The length of the path, cells; None without one."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum()) if self.reached else None

    @property
    def field(self) -> NDArray[np.float64]:
        """Float64, rows × columns: the length from each settled cell, cells; infinite elsewhere.

        Of navfn the potential, 50 a cell, from the start.
        """
        unit = reference.STRAIGHT if self.parameters.exact else 1
        values = np.full(self.lengths.size, np.inf)
        np.divide(self.lengths, unit, out=values, where=self.settled)
        return values.reshape(-1, self.stride)[1:-1, 1:-1]

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Bool, rows × columns: the cells from which the plan knows a way."""
        if self.parameters.method is not Method.NAVFN:
            return self.settled.reshape(-1, self.stride)[1:-1, 1:-1]
        cells = np.zeros(self.shape, np.bool_)
        cells[tuple(np.floor(self.path + 0.5).astype(np.int64).T)] = True
        return cells

    def path_of(self, cell: Cell) -> NDArray[np.float64]:
        """The path from a cell, as ``path``: 0 × 2 where the plan knows none.

        Of navfn only the path from the start is known, as its potential leads there.
        """
        if cell == self.start:
            return self.path
        return self.path[:0] if self.parameters.method is Method.NAVFN else self.chain(cell)

    def chain(self, cell: Cell) -> NDArray[np.float64]:
        """The path from a cell along ``before``, as ``path``: 0 × 2 where the cell is not settled."""
        at = (cell[0] + 1) * self.stride + cell[1] + 1
        if self.states[at] != reference.CLOSED:
            return np.zeros((0, 2))
        points: NDArray[np.float64] = kernels.way(self.before, at, self.stride, self.parameters.exact)
        return points


def search(
    free: NDArray[np.bool_], start: Cell | None, goals: Sequence[Cell], parameters: SearchParameters | None = None
) -> GridPlan:
    """The path from ``start`` to the nearest of ``goals``.

    Args:
        free: bool, rows × columns; outside of the map is obstacle.
        start: (row, column) of a free cell; None for a search over the whole map, of method astar only.
        goals: (row, column) of free cells.
        parameters: by default A* with the octile heuristic that cuts no corner.

    A goal that cannot be reached is an answer: the path is empty.

    Raises:
        MapError: the map is unusable, or start or goal lies outside of it or on an obstacle.

    >>> free = np.array([[True, True, True], [True, False, True]])
    >>> plan = search(free, (1, 0), [(1, 2)])
    >>> plan.path.tolist(), plan.length
    ([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 2.0]], 4.0)
    """
    free = as_free(free, "free")
    parameters = parameters or SearchParameters()
    ends = check_cells(free, goals, where="goal")
    stride = free.shape[1] + 2
    sources = (ends[:, 0] + 1) * stride + ends[:, 1] + 1
    target = -1
    if start is not None:
        ((row, column),) = check_cells(free, [start], name="start", where="start").tolist()
        start, target = (row, column), (row + 1) * stride + column + 1
    cells = kernels.padded(free)
    if parameters.method is Method.NAVFN:
        return _potential(parameters, free, cells, start, target, sources)
    if parameters.method is Method.THETA_STAR:
        end, lengths, before, expanded, entries, looked = kernels.theta_star(cells, stride, sources, target)
    else:
        end, lengths, before, expanded, entries, looked = kernels.astar(
            cells,
            stride,
            sources,
            target,
            RULES[parameters.heuristic],
            reference.successors(parameters.corner_cutting),
            parameters.corner_cutting,
            parameters.method is Method.JUMP_POINT,
        )
    none = np.zeros((0, 2))
    plan = GridPlan(parameters, start, none, expanded, entries, looked, lengths, before, cells, free.shape)
    if end >= 0 and start is not None:
        object.__setattr__(plan, "path", plan.chain(start))
    return plan


def _potential(
    parameters: SearchParameters,
    free: NDArray[np.bool_],
    cells: NDArray[np.uint8],
    start: Cell | None,
    target: int,
    goals: NDArray[np.int64],
) -> GridPlan:
    """The potential of NavFn from ``start`` to the first goal, and the path from there, turned round.

    NavFn counts on inflated obstacles: without them a path between cells may leave the free ones. Such a path is
    replaced by one from cell to cell down the same potential.
    """
    stride = free.shape[1] + 2
    values, updates = navfn.potential(cells, stride, target, goals)
    nearest = int(goals[np.argmin(values[goals])])
    path, smooth = np.zeros((0, 2)), False
    if values[nearest] < navfn.HIGH:
        points = navfn.descend(values, stride, nearest, target, 4 * free.size + 4)
        path = points[::-1].astype(np.float64) - 1.0
        if not (smooth := _keeps_free(free, path)):
            steps = navfn.from_cell_to_cell(values, cells, stride, nearest, target)
            path = np.stack(np.divmod(steps[::-1], stride), axis=1).astype(np.float64) - 1.0
    none = np.zeros(0, np.int32)
    return GridPlan(parameters, start, path, updates, 0, 0, values, none, cells, free.shape, smooth)


def _keeps_free(free: NDArray[np.bool_], path: NDArray[np.float64]) -> bool:
    """True if there is a path, whose points lie a cell apart or less, and it keeps to free cells."""
    if not len(path):
        return False
    shares = np.linspace(0.0, 1.0, 11)[:, None, None]
    dense = (path[:-1] + shares * np.diff(path, axis=0)).reshape(-1, 2)
    cells = np.floor(dense + 0.5).astype(np.int64)
    inside = (cells >= 0).all(axis=1) & (cells < free.shape).all(axis=1)
    return bool(inside.all() and free[cells[:, 0], cells[:, 1]].all())
