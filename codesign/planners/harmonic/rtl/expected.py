"""Random design points, the load stream of a circuit, and the run that the model expects of it.

The stream has the words of the memories, then the position of the robot. Values follow from the plan, cycles from
``timing``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.planners.circuits import Events, EventsOfKind, Expected, phase_cycles
from codesign.planners.counted import index_bits
from codesign.planners.harmonic.plan.arguments import StageEnd
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.plan.planner import run_arguments, sent_map
from codesign.planners.harmonic.plan.relax import work
from codesign.planners.harmonic.plan.trajectory import chosen_triangle
from codesign.planners.harmonic.published import CLUSTER_COLUMNS, CLUSTER_ROWS
from codesign.planners.harmonic.styles import timing
from codesign.planners.harmonic.styles.bit_serial import BitSerial, relax_costs
from codesign.planners.harmonic.styles.resources import RAM_WIDTH, digits, words
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD, READ, RELAX, single_visits
from codesign.planners.interface import Problem
from codesign.planners.job import Job


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


LARGEST_ROWS, LARGEST_COLUMNS = 10, 14
DENSITIES = (0.0, 0.1, 0.25, 0.4)
LONGEST_STAGE, MOST_BITS = 5, 14
NEARLY_ALWAYS = 0.9


def random_job(seed: int) -> Job[Problem, RelaxParameters]:
    """A design point, every option at random."""
    random = np.random.default_rng(seed)
    shape = int(random.integers(1, LARGEST_ROWS + 1)), int(random.integers(1, LARGEST_COLUMNS + 1))
    free = random.random(shape) >= random.choice(DENSITIES)
    free.flat[int(random.integers(free.size))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]
    # Three goals or less: no free cell has four of them around it.
    goals = tuple(
        cells[index] for index in random.choice(len(cells), min(len(cells), int(random.integers(1, 4))), False)
    )
    parameters = _parameters(random, shape)
    start = cells[int(random.integers(len(cells)))]
    inside = None if random.random() < NEARLY_ALWAYS else frozenset({"relax", "detect"})
    position = float(start[0]), float(start[1])
    return Job(Problem(free, goals, (start,)), parameters, inside=inside, position=position)


def _parameters(random: np.random.Generator, shape: tuple[int, int]) -> RelaxParameters:
    parts = [int(random.integers(1, min(side, 3) + 1)) for side in shape]
    beyond = [int(random.random() > NEARLY_ALWAYS) for _ in range(2)]
    block = -(-shape[0] // parts[0]) + beyond[0], -(-shape[1] // parts[1]) + beyond[1]
    pipeline = int(random.integers(2))
    digit_bits = int(random.choice([1, 1, 2, 4, 8]))
    options: dict[str, Any] = {
        "block": block,
        "iterations": int(random.choice([1, 2, 3, 5, 8, 20])),
        "schedule": _schedule(random, timing.least_precision(*block, pipeline, digit_bits)),
        "termination": str(random.choice(["sound", "published"])),
        "stop": str(random.choice(["first_without_local_maxima", "schedule_end"])),
        "pockets": str(random.choice(["kept", "filled"])),
        "pipeline": pipeline,
        "digit_bits": digit_bits,
    }
    return RelaxParameters(**options)


def _schedule(random: np.random.Generator, least: int) -> tuple[int, ...]:
    """One to three rising precisions from ``least`` on."""
    steps = random.integers(1, LONGEST_STAGE + 1, int(random.integers(1, 4)))
    bits = least + np.cumsum(steps) - 1
    return tuple(int(precision) for precision in bits[bits <= max(least + LONGEST_STAGE, MOST_BITS)])


VISIT, STAGE, DECISION, BITS = range(4)
SWEEP_BITS = 24
DECISION_BITS = 6

EVENT_DELAY = 2
"""Cycles from an answer of the OR trees to its event."""


def expected_run(job: Job[Problem, RelaxParameters]) -> Expected:
    """The events and the cycles of the phases of one run."""
    parameters, problem = job.parameters, job.problem
    shape = parameters.block_shape(*problem.shape)
    blocks = parameters.block_count(*problem.shape)
    cycles, plan = phase_cycles(BitSerial().work(replace(job, detail=False, memo=None)))
    parts = [*_visits(job, cycles[LOAD])]
    begin = cycles[LOAD] + cycles[RELAX]
    if job.does(DECIDE):
        begin += cycles[DECIDE]
        value = decision_value(plan.field, *nearest_cell(job))
        parts.append((DECISION, np.array([begin], np.int64), np.array([value], np.uint64)))
    options = parameters.pipeline, parameters.digit_bits
    cycles[READ] = timing.read_cycles(*shape, blocks, plan.precision, *options)
    return Expected(Events.joined([*parts, *_bits(job, plan.field, begin)]), cycles)


def _visits(job: Job[Problem, RelaxParameters], begin: int) -> Iterator[EventsOfKind]:
    """The ends of visits and stages; the relaxation takes the cycles from ``begin`` on."""
    problem, parameters = job.problem, job.parameters
    shape = parameters.block_shape(*problem.shape)
    costs, answer = relax_costs(job), timing.answer_cycles(*shape, parameters.pipeline)
    shift = np.uint64(parameters.iterations.bit_length())
    # The circuit does not look for the local maxima of several blocks where nothing depends on them.
    tested = (
        parameters.termination is Termination.SOUND
        or parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA
        or parameters.block_count(*problem.shape) == 1
    )
    now = begin
    for item in work(**run_arguments(problem, parameters)):
        if isinstance(item, StageEnd):
            now += costs.stage_end(item.stage.precision)
            # The pass that is dropped at the end of a stage ends one cycle after the answer.
            value = item.stage.sweeps << 1 | (tested and item.stage.local_maxima > 0)
            yield STAGE, np.array([now + EVENT_DELAY], np.int64), np.array([value], np.uint64)
            continue
        visits = single_visits(parameters, item)
        cycles = costs.visits(item.precision, visits)
        passes = visits.iterations * timing.iteration_cycles(item.precision, parameters.digit_bits)
        begins = now + np.cumsum(cycles) - cycles
        values = item.block.astype(np.uint64) << shift | visits.iterations.astype(np.uint64)
        yield VISIT, begins + passes + answer + EVENT_DELAY, values
        now += int(cycles.sum())


def decision_value(field: Field, row: int, column: int) -> int:
    """The value of the event of a decision; see ``harmonic.v``."""
    value = 0
    for axis, (side, sign) in enumerate(chosen_triangle(field, row, column)):
        bits = int(side >= 2) | int(sign > 0) << 1 | int(sign != 0) << 2
        value |= bits << 3 * axis
    return value


def _bits(job: Job[Problem, RelaxParameters], field: Field, begin: int) -> Iterator[EventsOfKind]:
    """The digits of the field, row by row of every block; the read-out takes the cycles from ``begin`` on."""
    problem, parameters = job.problem, job.parameters
    height, width = parameters.block_shape(*problem.shape)
    down, across = parameters.block_grid(*problem.shape)
    digit_bits = parameters.digit_bits
    columns = timing.read_out_columns(digit_bits)
    chunks = -(-width // columns)
    limbs = np.zeros((down * height, across * width, field.limbs.shape[2]), np.uint64)
    limbs[: problem.rows, : problem.columns] = field.limbs
    # Blocks in raster order, their rows, and as many columns of each as are read together: the order of the passes.
    blocks = limbs.reshape(down, height, across, width, -1).swapaxes(1, 2)
    place = digit_bits * (np.arange(width) % columns)
    starts = np.arange(0, width, columns)
    period = timing.iteration_cycles(field.precision, digit_bits)
    passes = timing.read_passes(height, width, down * across, digit_bits)
    assert passes == down * across * height * chunks, "a word a pass"
    first = begin + timing.PREPARATION_CYCLES + timing.stream_delay(parameters.pipeline) + EVENT_DELAY
    # The bits of the lowest digit below the last one of the value are 0.
    count = digits(field.precision, digit_bits)
    below = count * digit_bits - field.precision
    words = np.zeros((count + 1, passes), np.uint64)
    for bit in range(field.precision + 1):
        digit, index = divmod(bit + below, digit_bits)
        ones = blocks[..., bit // 64] >> np.uint64(bit % 64) & np.uint64(1)
        weights = np.uint64(1) << (place + index).astype(np.uint64)
        words[digit] += np.add.reduceat(ones * weights, starts, axis=3).ravel()
    for digit, values in enumerate(words):
        yield BITS, first + digit + period * np.arange(passes, dtype=np.int64), values
