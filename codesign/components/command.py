"""A drive command, as the host composes it, and how the robot follows it when it arrives.

The host knows the position of the robot at its last scan, not its position when the command arrives. So the path of a
command begins at the position of the scan, and the robot joins it from its position at that time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codesign.components.path import NEAR, SAME, Point, Polyline, cell_of, continue_along, starts_clear

WORD = 32
"""Bits of each of the three words of a command."""


@dataclass(frozen=True, eq=False)
class Command:
    """A ``path`` to drive, and ``end``: the arc length, cells, at which to stop if no newer command arrives.

    The path begins at the position of the robot's scan. Up to ``end`` it leads through cells that were known free for
    the robot's middle when the command was composed. ``metres``: the side of a cell.

    Its message is three words of 32 bits, the lowest bit first:

    1. the distance to ``end``, in millimetres;
    2. the first direction of the path, as a share of the full turn;
    3. the greatest speed, which the robot knows itself.
    """

    path: Polyline
    end: float
    metres: float = 1.0

    def misread(self, wrong: Sequence[int]) -> Command | None:
        """The command that the robot reads where the bits ``wrong`` are wrong; None where it is the same.

        A wrong direction turns the whole path about its begin. The path keeps its length, whatever distance is read.
        """
        masks = [0, 0, 0]
        for bit in wrong:
            masks[min(bit // WORD, 2)] ^= 1 << bit % WORD
        millimetres = round(self.end * self.metres * 1000.0) ^ masks[0]
        end = millimetres / (1000.0 * self.metres) if masks[0] else self.end
        path = self.path if not masks[1] else self._turned(masks[1])
        if path is self.path and min(end, path.length) == min(self.end, path.length):
            return None
        return replace(self, path=path, end=end)

    def _turned(self, mask: int) -> Polyline:
        if not len(self.path.headings):
            return self.path
        word = round(float(self.path.headings[0]) / math.tau * 2**WORD) % 2**WORD
        angle = ((word ^ mask) - word) / 2**WORD * math.tau
        moved = self.path.points - self.path.points[0]
        # Headings grow from columns (x) towards rows (y), so a turn by the angle a is
        #   y' = y cos a + x sin a
        #   x' = x cos a - y sin a
        down = moved[:, 0] * math.cos(angle) + moved[:, 1] * math.sin(angle)
        along = moved[:, 1] * math.cos(angle) - moved[:, 0] * math.sin(angle)
        return Polyline(self.path.points[0] + np.stack((down, along), axis=1))

    def taken_up(self, position: Point, shape: tuple[int, int]) -> Polyline:
        """The path of a robot at ``position`` when the command arrives, up to ``end``.

        A robot on the path continues along it. A robot beside it drives straight to it (``path.continue_along``),
        through its own cell and the cells of the path up to ``end`` only. Where that is not possible, and where the
        robot is past the end, the robot stops where it is, and the next command begins there.

        Args:
            position: (row, column) in cells.
            shape: rows and columns of the map.
        """
        sent = self.path.head(self.end)
        arc, off = sent.closest(position)
        if off > NEAR and arc >= sent.length - SAME:
            return Polyline([position])
        open_cells = _cells_of(sent, position, shape)
        taken = continue_along(sent, position, open_cells)
        return taken if off <= NEAR or starts_clear(taken, open_cells) else Polyline([position])


def _cells_of(path: Polyline, position: Point, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Bool, rows × columns: the cells that a path enters, those beside corners, and the cell of ``position``."""
    entered = np.zeros(shape, np.bool_)
    cells = np.concatenate((path.crossings[1].reshape(-1, 2), [cell_of(position)]))
    inside = ((cells >= 0) & (cells < shape)).all(axis=1)
    entered[tuple(cells[inside].T)] = True
    return entered
