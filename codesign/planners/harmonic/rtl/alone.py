"""The circuit of task ``decide`` placed by itself: the top ``harmonic_decide``, and what a run of it has to report."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from codesign.planners.circuits import SHARED, Circuit, CircuitStyle, Events, Expected, Image, phase_cycles
from codesign.planners.counted import index_bits
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.rtl.expected import DECISION_BITS, decision_value, nearest_cell, place_words, random_job
from codesign.planners.harmonic.styles import timing
from codesign.planners.harmonic.styles.resources import ALONE, field_groups
from codesign.planners.harmonic.styles.steps import DECIDE, LOAD
from codesign.planners.harmonic.styles.tasks import DecisionModule
from codesign.planners.interface import Problem
from codesign.planners.job import Job

FOLDER = Path(__file__).parent
SOURCES = tuple(FOLDER / f"harmonic_{name}.v" for name in ("decide", "field", "decision"))

RelaxJob = Job[Problem, RelaxParameters]


class DecisionCircuit(CircuitStyle):
    """The decision module with the field in memories of its own."""

    planner = "harmonic"
    style = "bit_serial"
    task = DECIDE
    laws = ALONE

    def circuit(self, job: RelaxJob) -> Circuit:
        """The circuit for a map and the last precision. The field is ``job.plan``'s, or is planned here."""
        rows, columns = job.problem.shape
        last = job.parameters.precisions[-1]
        bits = stream_bits(rows, columns, last)
        return Circuit(
            top="harmonic_decide",
            sources=(*SOURCES, SHARED / "ram_1w1r.v"),
            parameters={"ROWS": rows, "COLUMNS": columns, "LAST_PRECISION": last, "IN_BITS": bits},
            stream=Image(bits, list(stream_words(job))),
            phases=(LOAD, DECIDE),
            kinds=("decision",),
            event_bits=DECISION_BITS,
            pieces={"decision": ("harmonic_decide", "harmonic_decision", "harmonic_field"), "field": ("ram_1w1r",)},
            notes=(
                f"The field is loaded once a plan. A run of the circuit decides for one position: {place_words(job)}.",
            ),
        )

    def expected(self, job: RelaxJob) -> Expected:
        """The decision of the plan, one cycle after the phases."""
        plan = _plan(job)
        cycles, _ = phase_cycles(DecisionModule().steps(replace(job, plan=plan)))
        cycles[LOAD] = timing.field_load_cycles(job.problem.shape, plan.precision)
        end = np.array([sum(cycles.values())], np.int64)
        value = np.array([decision_value(plan.field, *nearest_cell(job))], np.uint64)
        return Expected(Events(end, np.zeros(1, np.uint8), value), cycles)

    def sample(self, seed: int) -> RelaxJob:
        """A robot anywhere on a small map."""
        job = random_job(seed)
        return replace(job, inside=frozenset({DECIDE}), plan=PLANNER.plan(job))


def _plan(job: RelaxJob) -> HarmonicPlan:
    return PLANNER.plan(job) if job.plan is None else job.plan


def stream_bits(rows: int, columns: int, last: int) -> int:
    """The width of the load stream: a precision, a word of the field, or a position."""
    return max(index_bits(rows * field_groups(columns)) + 9, index_bits(last + 2))


def stream_words(job: RelaxJob) -> Iterator[int]:
    """The precision, the planes of the field, and the position of the robot; see ``harmonic_decide.v``."""
    plan = _plan(job)
    yield plan.precision
    yield from field_words(plan.field)
    yield position_word(job)


def field_words(field: Field) -> Iterator[int]:
    """A word for each five columns of a row: bit k is for memory k; plane by plane, the lowest bit first."""
    rows, columns = field.shape
    groups = field_groups(columns)
    limbs = np.zeros((rows, 5 * groups, field.limbs.shape[2]), np.uint64)
    limbs[:, :columns] = field.limbs
    memory = (np.arange(rows)[:, None] + 2 * np.arange(5 * groups)) % 5
    weights = np.uint64(1) << memory.astype(np.uint64)
    for bit in range(field.precision + 1):
        ones = limbs[..., bit // 64] >> np.uint64(bit % 64) & np.uint64(1)
        yield from (ones * weights).reshape(rows * groups, 5).sum(axis=1, dtype=np.uint64).tolist()


def position_word(job: RelaxJob) -> int:
    """The cell of the robot: address, crossings to other groups of columns, memory, and sides inside of the map."""
    rows, columns = job.problem.shape
    row, column = nearest_cell(job)
    groups = field_groups(columns)
    group, place = divmod(column, 5)
    word, shift = row * groups + group, index_bits(rows * groups)
    sides = column > 0, row < rows - 1, column < columns - 1, row > 0
    high = int(place == 0) | int(place == 4) << 1 | (row + 2 * column) % 5 << 2
    return word | (high | sum(1 << index for index, side in enumerate(sides) if side) << 5) << shift
