"""The circuits of harmonic control: Verilog, and what the model expects a run of them to report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from codesign.ground.errors import Fault, UnsuitedError
from codesign.planners.circuits import SHARED, Bits, Circuit, CircuitStyle, Expected, Image
from codesign.planners.counted import index_bits
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop, Termination
from codesign.planners.harmonic.rtl.alone import DecisionCircuit
from codesign.planners.harmonic.rtl.expected import (
    DECISION_BITS,
    SWEEP_BITS,
    expected_run,
    place_words,
    random_job,
    stream_bits,
    stream_words,
)
from codesign.planners.harmonic.styles import timing
from codesign.planners.harmonic.styles.resources import ARRAY
from codesign.planners.harmonic.styles.steps import DECIDE, DETECT, LOAD, READ, RELAX
from codesign.planners.interface import Problem
from codesign.planners.job import Job

__all__ = ["CIRCUITS"]


FOLDER = Path(__file__).parent
SOURCES = tuple(
    FOLDER / f"{name}.v"
    for name in (
        "harmonic",
        "harmonic_load",
        "harmonic_control",
        "harmonic_address",
        "harmonic_array",
        "harmonic_cluster",
        "harmonic_node",
        "harmonic_digit_node",
        "harmonic_border",
        "harmonic_or_tree",
        "harmonic_decision",
        "harmonic_delay",
    )
)
STAGE_BITS = 10
"""Bits of a stage in the parameter ``PRECISIONS``."""

PHASES = (LOAD, RELAX, DECIDE, READ)
KINDS = ("visit", "stage", "decision", "bits")

PIECES = {
    "nodes": ("harmonic_node", "harmonic_digit_node"),
    "clusters": ("harmonic_cluster",),
    "array control": ("harmonic_array",),
    "OR trees": ("harmonic_or_tree",),
    "borders": ("harmonic_border",),
    "border addresses": ("harmonic_address",),
    "control": ("harmonic", "harmonic_control", "harmonic_load", "harmonic_delay"),
    "decision": ("harmonic_decision",),
}
"""The modules of each line of the demand."""


class BitSerialCircuit(CircuitStyle):
    """The block-synchronous array with its control."""

    planner = "harmonic"
    style = "bit_serial"
    laws = ARRAY

    def circuit(self, job: Job[Problem, RelaxParameters]) -> Circuit:
        """The circuit of a design point; see ``harmonic.v`` for its phases, stream and events.

        Raises:
            UnsuitedError: a start, another component that detects, a first precision below the least of the circuit, a
                free cell between four goals.
        """
        _check(job)
        problem, parameters = job.problem, job.parameters
        block = parameters.block_shape(*problem.shape)
        grid = parameters.block_grid(*problem.shape)
        return Circuit(
            top="harmonic",
            sources=(*SOURCES, SHARED / "ram_1w1r.v"),
            parameters=_parameters(job),
            stream=Image(stream_bits(job), list(stream_words(job))),
            phases=PHASES,
            kinds=KINDS,
            event_bits=event_bits(block, grid, parameters),
            pieces=PIECES,
            elements=block[0] * block[1],
            notes=(f"A run decides for one position: {place_words(job)}.",) if job.does(DECIDE) else (),
        )

    def expected(self, job: Job[Problem, RelaxParameters]) -> Expected:
        """The visits, stages, decision and bits of the plan at the cycles of ``timing``."""
        return expected_run(job)

    def sample(self, seed: int) -> Job[Problem, RelaxParameters]:
        """A map of at most 10 × 14 cells in up to 9 blocks."""
        return random_job(seed)


def _check(job: Job[Problem, RelaxParameters]) -> None:
    """Raise UnsuitedError with all that no circuit has."""
    problem, parameters = job.problem, job.parameters
    shape = parameters.block_shape(*problem.shape)
    faults = []
    if job.start is not None:
        faults.append(("start", "no circuit loads start values", "plan from zero: policy restart"))
    if not job.does(DETECT):
        faults.append(("detect", "no circuit leaves the test of a sweep to another component", "place it with relax"))
    if parameters.promote_after:
        what = "no circuit leaves a stage before it has settled"
        faults.append(("relax.promote", what, "plan with promote: never"))
    least = timing.least_precision(*shape, parameters.pipeline, parameters.digit_bits)
    first = parameters.precisions[0]
    if first < least:
        what = f"a pass of {first} bits ends before the OR trees over {shape[0]} × {shape[1]} nodes answer"
        faults.append(("relax.schedule", what, f"begin at {least} bits or more"))
    goal = np.zeros((problem.rows + 2, problem.columns + 2), np.bool_)
    goal[tuple(np.array(problem.goals).T + 1)] = True
    around = goal[:-2, 1:-1] & goal[2:, 1:-1] & goal[1:-1, :-2] & goal[1:-1, 2:]
    if (around & problem.free & ~goal[1:-1, 1:-1]).any():
        what = "a free cell between four goals has the value 1, and the circuit keeps values below 1"
        faults.append(("problem.goals", what, "make that cell a goal"))
    if faults:
        raise UnsuitedError(Fault("circuit", 0, 0, *fault) for fault in faults)


def event_bits(block: tuple[int, int], grid: tuple[int, int], parameters: RelaxParameters) -> int:
    """The width of an event: a visit, a stage, a decision, or up to 64 bits of a row."""
    return max(
        index_bits(grid[0] * grid[1]) + parameters.iterations.bit_length(),
        SWEEP_BITS + 1,
        DECISION_BITS,
        min(block[1] * parameters.digit_bits, timing.READ_OUT_BITS),
    )


def _parameters(job: Job[Problem, RelaxParameters]) -> Mapping[str, int]:
    problem, parameters = job.problem, job.parameters
    rows, columns = parameters.block_shape(*problem.shape)
    down, across = grid = parameters.block_grid(*problem.shape)
    precisions = parameters.precisions
    packed = sum(precision << STAGE_BITS * index for index, precision in enumerate(precisions))
    return {
        "ROWS": rows,
        "COLUMNS": columns,
        "DOWN": down,
        "ACROSS": across,
        "LAST_PRECISION": precisions[-1],
        "STAGES": len(precisions),
        "PRECISIONS": Bits(packed, STAGE_BITS * len(precisions)),
        "ITERATIONS": parameters.iterations,
        "SOUND": int(parameters.termination is Termination.SOUND),
        "STOP_WITHOUT_MAXIMA": int(parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA),
        "DECISION": int(job.does(DECIDE)),
        "DIGIT_BITS": parameters.digit_bits,
        "PIPELINE": parameters.pipeline,
        "IN_BITS": stream_bits(job),
        "EVENT_BITS": event_bits((rows, columns), grid, parameters),
    }


CIRCUITS = (BitSerialCircuit(), DecisionCircuit())
