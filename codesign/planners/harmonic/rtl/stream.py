"""The load stream of the circuit: the words of its memories, then the position of the robot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.pockets import sent_map
from codesign.planners.harmonic.published import CLUSTER_COLUMNS, CLUSTER_ROWS
from codesign.planners.harmonic.styles.resources import RAM_WIDTH, words
from codesign.planners.harmonic.styles.steps import DECIDE
from codesign.planners.interface import Problem
from codesign.planners.job import Job


def index_bits(count: int) -> int:
    """Bits that number ``count`` things, at least 1."""
    return max(1, (count - 1).bit_length())


def address_bits(blocks: int, parameters: RelaxParameters) -> int:
    """Bits of the address of a memory that holds ``blocks`` blocks at the last precision."""
    return (words(blocks, parameters.precisions[-1], parameters.digit_bits) - 1).bit_length()


def stream_bits(job: Job[Problem, RelaxParameters]) -> int:
    """The width of the load stream: a word of a memory, or the position of the robot."""
    problem, parameters = job.problem, job.parameters
    rows, columns = parameters.block_shape(*problem.shape)
    blocks = parameters.block_count(*problem.shape)
    position = index_bits(rows) + index_bits(columns) + address_bits(blocks, parameters) + 4
    return max(RAM_WIDTH, position)


def stream_words(job: Job[Problem, RelaxParameters]) -> Iterator[int]:
    """The words of the load stream: the words of each block, then the position of the robot."""
    problem, parameters = job.problem, job.parameters
    height, width = parameters.block_shape(*problem.shape)
    down, across = parameters.block_grid(*problem.shape)
    # Nodes beyond the map are obstacles.
    fixed = np.ones((down * height, across * width), np.bool_)
    goal = np.zeros_like(fixed)
    fixed[: problem.rows, : problem.columns] = ~sent_map(problem, parameters)
    for cell in problem.goals:
        fixed[cell] = goal[cell] = True
    for row in range(0, down * height, height):
        for column in range(0, across * width, width):
            block = slice(row, row + height), slice(column, column + width)
            sides = list(_side_words(goal[block], down > 1, across > 1))
            yield from _cluster_words(fixed[block])
            yield from sides
            yield from _cluster_words(goal[block])
            yield from [0] * len(sides)
    if job.does(DECIDE):
        yield position_word(job)


def _word(bits: NDArray[np.bool_]) -> int:
    return sum(1 << index for index, bit in enumerate(bits.ravel()) if bit)


def _cluster_words(nodes: NDArray[np.bool_]) -> Iterator[int]:
    """A word for each cluster of a block: bit 6 i + j is node (i, j)."""
    rows, columns = nodes.shape
    padded = np.zeros((rows + -rows % CLUSTER_ROWS, columns + -columns % CLUSTER_COLUMNS), bool)
    padded[:rows, :columns] = nodes
    for row in range(0, rows, CLUSTER_ROWS):
        for column in range(0, columns, CLUSTER_COLUMNS):
            yield _word(padded[row : row + CLUSTER_ROWS, column : column + CLUSTER_COLUMNS])


def _side_words(nodes: NDArray[np.bool_], down: bool, across: bool) -> Iterator[int]:
    """A word for each border memory: north, south, west and east side of a block."""
    sides = [nodes[0], nodes[-1]] if down else []
    for side in [*sides, *([nodes[:, 0], nodes[:, -1]] if across else [])]:
        for first in range(0, len(side), RAM_WIDTH):
            yield _word(side[first : first + RAM_WIDTH])


def nearest_cell(job: Job[Problem, RelaxParameters]) -> tuple[int, int]:
    """The cell of the map that is nearest to the robot."""
    row, column = (int(np.floor(value + 0.5)) for value in job.position)
    return min(max(row, 0), job.problem.rows - 1), min(max(column, 0), job.problem.columns - 1)


def place_words(job: Job[Problem, RelaxParameters]) -> str:
    """The cell that a run decides for, as users count it."""
    row, column = job.problem.named(nearest_cell(job))
    return f"row {row}, column {column} of the map, the last word of the stream"


def position_word(job: Job[Problem, RelaxParameters]) -> int:
    """The position of the robot; see ``harmonic.v``."""
    problem, parameters = job.problem, job.parameters
    height, width = parameters.block_shape(*problem.shape)
    down, across = parameters.block_grid(*problem.shape)
    block_words = words(1, parameters.precisions[-1], parameters.digit_bits)
    cell = nearest_cell(job)
    line, row = divmod(cell[0], height)
    place, column = divmod(cell[1], width)
    word, shift = column, index_bits(width)
    word |= row << shift
    shift += index_bits(height)
    word |= (line * across + place) * block_words << shift
    shift += address_bits(down * across, parameters)
    inside = (place > 0, line < down - 1, place < across - 1, line > 0)
    for index, side in enumerate(inside):
        word |= int(side) << shift + index
    return word
