"""A command: what a robot is told, as it was when it was composed, and what the robot makes of it when it arrives.

Who composes a command knows where the robot was when it last looked around, not where it is when the command arrives.
So a command leads on from there, and the robot takes it up from where it is by then.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codesign.components.way import NEAR, SAME, Point, Way, cell_of, go_on, starts_clear

WORD = 32
"""Bits of each of the three words of a command."""


@dataclass(frozen=True, eq=False)
class Command:
    """``way`` to drive, and ``end``, the arc length of it, cells, at which to stand if no newer command comes.

    The way begins where the robot was when it looked around. Up to ``end`` it leads through cells that were known to be
    free for the robot's middle when the command was composed. ``metres``: a cell.

    Its message is three words of 32 bits, the lowest bit first: how far, in millimetres; which way, of which the word
    is the direction in which it begins, as a share of the full turn; how fast at most, which the robot knows itself.
    """

    way: Way
    end: float
    metres: float = 1.0

    def misread(self, wrong: Sequence[int]) -> Command | None:
        """The command that is read where these bits are wrong; None where it is the same.

        A wrong direction turns the whole way about its begin. The way is no longer than it was, however far the robot
        is told to go on it.
        """
        masks = [0, 0, 0]
        for bit in wrong:
            masks[min(bit // WORD, 2)] ^= 1 << bit % WORD
        far = round(self.end * self.metres * 1000.0) ^ masks[0]
        end = far / (1000.0 * self.metres) if masks[0] else self.end
        way = self.way if not masks[1] else self._turned(masks[1])
        if way is self.way and min(end, way.length) == min(self.end, way.length):
            return None
        return replace(self, way=way, end=end)

    def _turned(self, mask: int) -> Way:
        if not len(self.way.headings):
            return self.way
        word = round(float(self.way.headings[0]) / math.tau * 2**WORD) % 2**WORD
        angle = ((word ^ mask) - word) / 2**WORD * math.tau
        moved = self.way.points - self.way.points[0]
        # Headings grow from columns towards rows.
        down = moved[:, 0] * math.cos(angle) + moved[:, 1] * math.sin(angle)
        along = moved[:, 1] * math.cos(angle) - moved[:, 0] * math.sin(angle)
        return Way(self.way.points[0] + np.stack((down, along), axis=1))

    def taken_up(self, position: Point, shape: tuple[int, int]) -> Way:
        """The way of a robot that is at ``position`` when the command arrives, up to where it is to stand.

        A robot on the way goes on along it. A robot beside it goes straight to it, as ``way.go_on`` has it, through
        no other cells than its own and those of the way up to ``end``. Where that cannot be, and where the robot is
        past the end, it stands where it is: the next command begins there.

        Args:
            position: (row, column) in cells.
            shape: rows and columns of the map.
        """
        sent = self.way.head(self.end)
        arc, off = sent.closest(position)
        if off > NEAR and arc >= sent.length - SAME:
            return Way([position])
        open_cells = _cells_of(sent, position, shape)
        taken = go_on(sent, position, open_cells)
        return taken if off <= NEAR or starts_clear(taken, open_cells) else Way([position])


def _cells_of(way: Way, position: Point, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Bool, rows × columns: the cells that a way enters, those beside corners included, and that of ``position``."""
    entered = np.zeros(shape, np.bool_)
    cells = np.concatenate((way.crossings[1].reshape(-1, 2), [cell_of(position)]))
    inside = ((cells >= 0) & (cells < shape)).all(axis=1)
    entered[tuple(cells[inside].T)] = True
    return entered
