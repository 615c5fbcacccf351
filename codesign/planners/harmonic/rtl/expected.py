"""The run of the circuit that the model expects: values from the plan, cycles from ``timing``."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from codesign.planners.circuits import Events, Expected, phase_cycles
from codesign.planners.harmonic.plan.decision import chosen_triangle
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.plan.pockets import sent_map
from codesign.planners.harmonic.plan.relax import work
from codesign.planners.harmonic.plan.stages import StageEnd
from codesign.planners.harmonic.rtl.stream import nearest_cell
from codesign.planners.harmonic.styles import timing
from codesign.planners.harmonic.styles.bit_serial import BitSerial, relax_costs
from codesign.planners.harmonic.styles.resources import digits
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD, READ, RELAX, single_visits
from codesign.planners.interface import Problem
from codesign.planners.job import Job

VISIT, STAGE, DECISION, BITS = range(4)
SWEEP_BITS = 24
DECISION_BITS = 6

EVENT_DELAY = 2
"""Cycles from an answer of the OR trees to its event."""


@dataclass
class _Recorder:
    """Events in the order of their cycles, in pieces."""

    cycle: list[NDArray[np.int64]]
    kind: list[NDArray[np.uint8]]
    value: list[NDArray[np.uint64]]

    def add(self, kind: int, cycle: NDArray[np.int64], value: NDArray[np.uint64]) -> None:
        """More events of one kind."""
        self.cycle.append(cycle)
        self.kind.append(np.full(len(cycle), kind, np.uint8))
        self.value.append(value)

    def events(self) -> Events:
        """All events, sorted by their cycles."""
        cycle = np.concatenate(self.cycle)
        order = np.argsort(cycle, kind="stable")
        return Events(cycle[order], np.concatenate(self.kind)[order], np.concatenate(self.value)[order])


def expected_run(job: Job[Problem, RelaxParameters]) -> Expected:
    """The events and the cycles of the phases of one run."""
    parameters, problem = job.parameters, job.problem
    shape = parameters.block_shape(*problem.shape)
    blocks = parameters.block_count(*problem.shape)
    cycles, plan = phase_cycles(BitSerial().work(replace(job, detail=False, memo=None)))
    recorder = _Recorder([], [], [])
    _add_visits(job, cycles[LOAD], recorder)
    begin = cycles[LOAD] + cycles[RELAX]
    if job.does(DECIDE):
        begin += cycles[DECIDE]
        value = decision_value(plan.field, *nearest_cell(job))
        recorder.add(DECISION, np.array([begin], np.int64), np.array([value], np.uint64))
    options = parameters.pipeline, parameters.digit_bits
    cycles[READ] = timing.read_cycles(*shape, blocks, plan.precision, *options)
    _add_bits(job, plan.field, begin, recorder)
    return Expected(recorder.events(), cycles)


def _add_visits(job: Job[Problem, RelaxParameters], begin: int, recorder: _Recorder) -> None:
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
    for item in work(
        sent_map(problem, parameters),
        problem.goals,
        block=shape,
        iterations=parameters.iterations,
        schedule=parameters.precisions,
        termination=parameters.termination,
        stop_without_local_maxima=parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
    ):
        if isinstance(item, StageEnd):
            now += costs.stage_end(item.stage.precision)
            # The pass that is dropped at the end of a stage ends one cycle after the answer.
            value = item.stage.sweeps << 1 | (tested and item.stage.local_maxima > 0)
            recorder.add(STAGE, np.array([now + EVENT_DELAY], np.int64), np.array([value], np.uint64))
            continue
        visits = single_visits(parameters, item)
        cycles = costs.visits(item.precision, visits)
        passes = visits.iterations * timing.iteration_cycles(item.precision, parameters.digit_bits)
        begins = now + np.cumsum(cycles) - cycles
        values = item.block.astype(np.uint64) << shift | visits.iterations.astype(np.uint64)
        recorder.add(VISIT, begins + passes + answer + EVENT_DELAY, values)
        now += int(cycles.sum())


def decision_value(field: Field, row: int, column: int) -> int:
    """The value of the event of a decision; see ``harmonic.v``."""
    value = 0
    for axis, (side, sign) in enumerate(chosen_triangle(field, row, column)):
        bits = int(side >= 2) | int(sign > 0) << 1 | int(sign != 0) << 2
        value |= bits << 3 * axis
    return value


def _add_bits(job: Job[Problem, RelaxParameters], field: Field, begin: int, recorder: _Recorder) -> None:
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
        recorder.add(BITS, first + digit + period * np.arange(passes, dtype=np.int64), values)
