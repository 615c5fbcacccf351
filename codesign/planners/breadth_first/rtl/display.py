"""The outputs of the display: the syncs in every cycle, and the picture once the search has ended."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import Task
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.circuits import Pins
from codesign.planners.interface import Problem

PINS = {"horizontal_sync": 1, "vertical_sync": 1, "colour": 3}
"""The outputs of the display, and their bits, the lowest first."""

_SYNCS, _ALL, _DIRECTION = 0b00011, 0b11111, 0b01100
_HORIZONTAL, _VERTICAL, _COLOUR = 0, 1, 2
_COLOURS = np.array([0b000, 0b111, 0b100, 0b010], np.uint16)
"""Of an obstacle or the start, a free cell, a goal or path, a visited cell: the words of the memory of the cells."""


@dataclass(frozen=True)
class Screen:
    """Pixels of a line with its borders, lines of a frame, where the syncs lie, and clocks of a pixel.

    ``half``: the first pixel of the right half. The numbers stand in ``breadth_first_display.v`` too.
    """

    half: int = 400
    line: int = 1344
    sync: tuple[int, int] = (936, 1072)
    frame: int = 806
    line_sync: tuple[int, int] = (687, 693)
    pixel_cycles: int = 2


SCREEN = Screen()

_LATER = 2
"""Cycles from the first one to that in which the first pixel after the reset is put out."""
_SETTLED = 3
"""Cycles from the last one of a run to a pixel that shows what it left in the memories."""


def shown_pins(problem: Problem, plan: BreadthFirstPlan, visited: int, tracked: bool, end: int, screen: Screen) -> Pins:
    """The outputs over a run of ``end`` cycles, and over one frame and the lines of the map after it.

    ``visited``: how many cells the search marked; it may have ended early. ``tracked``: whether a path was marked.
    While the search runs, the colour is said outside of the map only.
    """
    shown = (screen.frame + problem.rows) * screen.line
    pixels = shown + -(-(end + _SETTLED) // screen.pixel_cycles)
    begin = _LATER + screen.pixel_cycles * np.arange(pixels, dtype=np.int64)
    value, known = (
        np.resize(each, pixels) for each in _frame(problem, screen, *_memories(problem, plan, visited, tracked))
    )
    known[(begin < end + _SETTLED) & _on_map(problem, screen, pixels)] = _SYNCS
    both = value | known << np.uint16(8)
    first = np.append(0, np.flatnonzero(both[1:] != both[:-1]) + 1)
    return Pins(
        begin[first],
        value[first].astype(np.uint64),
        known[first].astype(np.uint64),
        int(begin[-1]) + screen.pixel_cycles,
    )


def _columns(problem: Problem, screen: Screen) -> NDArray[np.int64]:
    """The column of the map under each pixel of a line of it; -1 where none is."""
    x = np.arange(screen.line, dtype=np.int64)
    column = np.where(x < screen.half, x, x - screen.half)
    return np.where(column < problem.columns, column, -1)


def _on_map(problem: Problem, screen: Screen, pixels: int) -> NDArray[np.bool_]:
    lines = np.zeros((screen.frame, screen.line), np.bool_)
    lines[: problem.rows] = _columns(problem, screen) >= 0
    return np.resize(lines, pixels)


def _frame(
    problem: Problem, screen: Screen, code: NDArray[np.int64], direction: NDArray[np.int64]
) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Uint16, lines × pixels: the outputs at each pixel of a frame after the run, and which bits are known."""
    x, y = np.arange(screen.line), np.arange(screen.frame)[:, None]
    value = np.zeros((screen.frame, screen.line), np.uint16)
    value |= ((x >= screen.sync[0]) & (x < screen.sync[1])).astype(np.uint16) << _HORIZONTAL
    value |= ((y >= screen.line_sync[0]) & (y < screen.line_sync[1])).astype(np.uint16) << _VERTICAL
    known = np.full_like(value, _ALL)
    left = _COLOURS[code]
    right = np.where(code >= 2, 0b100 | np.maximum(direction, 0), 0).astype(np.uint16)
    # No direction was written where nothing was discovered: a goal that was not reached, the start of the path.
    unwritten = (code >= 2) & (direction < 0)
    column, rows = _columns(problem, screen), slice(0, problem.rows)
    colour = np.where(x < screen.half, left[:, column], right[:, column])
    value[rows] |= np.where(column >= 0, colour, 0).astype(np.uint16) << _COLOUR
    known[rows][(column >= 0) & (x >= screen.half) & unwritten[:, column]] &= ~np.uint16(_DIRECTION)
    return value, known


def _memories(
    problem: Problem, plan: BreadthFirstPlan, visited: int, tracked: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Int64, rows × columns: the cells and the directions that a run leaves; direction -1 where none was written."""
    code = problem.free.astype(np.int64)
    direction = np.full(problem.shape, -1, np.int64)
    if problem.task is Task.FIELD:
        code[problem.goals[0]] = 0
    else:
        for goal in problem.goals:
            code[goal] = 2
        code[problem.starts[0]] = 0
    cells = plan.pushed[1 : 1 + visited].astype(np.int64)
    code.flat[cells] = 3
    direction.flat[cells] = plan.directions.ravel()[cells]
    if tracked:
        code[tuple(plan.path.T)] = 2
    return code, direction
