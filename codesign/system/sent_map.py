"""The map from the task that keeps it to the one that plans: all of it, or the cells that changed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codesign.planners.interface import Problem
from codesign.system.messages import Wrong

OBSTACLE, FREE, GOAL = 0, 1, 2
"""The two bits of a cell; 3 is read as an obstacle (assumed)."""

STATE_BITS, PLACE_BITS = 2, 16
CHANGE_BITS = 2 * PLACE_BITS + STATE_BITS
"""One changed cell: row and column, 16 bits each, and what it became, 2 bits. Assumed."""


def states(problem: Problem) -> NDArray[np.int8]:
    """Int8, rows × columns: the state of each cell of a problem's map."""
    cells = np.where(problem.free, FREE, OBSTACLE).astype(np.int8)
    for goal in problem.goals:
        cells[goal] = GOAL
    return cells


@dataclass(frozen=True, eq=False)
class MapMessage:
    """A map in its message.

    ``cells``: int64 n × 2, (row, column), the cells that it has, in raster order; ``states``: int8, one each.
    ``bits``: its size; ``whole``: whether it is all of the map. Then all cells take as many bits, and the lowest two
    are the state. A change is row, column and state, the lowest bit first.
    """

    cells: NDArray[np.int64]
    states: NDArray[np.int8]
    bits: int
    whole: bool

    def misread(self, wrong: Wrong) -> MapMessage | None:
        """The message as it is read where these bits are wrong."""
        cells, read = self.cells.copy(), self.states.copy()
        width = self.bits // len(cells) if self.whole else CHANGE_BITS
        for bit in wrong:
            index, place = divmod(bit, width)
            if index >= len(cells):
                continue
            if self.whole or place >= 2 * PLACE_BITS:
                place -= 0 if self.whole else 2 * PLACE_BITS
                read[index] ^= 1 << place if place < STATE_BITS else 0
            else:
                cells[index, place // PLACE_BITS] ^= 1 << place % PLACE_BITS
        if np.array_equal(cells, self.cells) and np.array_equal(read, self.states):
            return None
        return replace(self, cells=cells, states=read)


class SentMap:
    """The map that a planner holds over the plans of a drive, and the one that its sender believes it to hold.

    They differ once a message was misread, until the cell is sent again.
    """

    def __init__(self) -> None:
        self._sent: NDArray[np.int8] | None = None
        self._held: NDArray[np.int8] | None = None

    def message(self, problem: Problem, bits: int) -> MapMessage:
        """The message to send: the changes, or the whole map of ``bits`` bits where that is no longer."""
        now = states(problem)
        changed = np.ones(now.shape, np.bool_) if self._sent is None else now != self._sent
        cells = np.argwhere(changed)
        size = max(1, len(cells)) * CHANGE_BITS
        whole = self._sent is None or size >= bits
        if whole:
            cells, size = np.argwhere(np.ones(now.shape, np.bool_)), bits
        self._sent = now
        return MapMessage(cells, now[tuple(cells.T)], size, whole)

    def take(self, message: MapMessage, problem: Problem) -> Problem:
        """The problem that the planner then plans: ``problem``, but on the map that it holds."""
        held = np.zeros((problem.rows, problem.columns), np.int8) if self._held is None else self._held.copy()
        inside = (message.cells < held.shape).all(axis=1)
        held[tuple(message.cells[inside].T)] = message.states[inside]
        self._held = held
        if np.array_equal(held, states(problem)):
            return problem
        goals = [goal for goal in problem.goals if held[goal] == GOAL]
        goals += [(int(row), int(column)) for row, column in np.argwhere(held == GOAL)]
        free = (held == FREE) | (held == GOAL)
        return replace(problem, free=free, goals=tuple(dict.fromkeys(goals)))
