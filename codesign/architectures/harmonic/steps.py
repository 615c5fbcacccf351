"""The planner's visits as steps of a clock: what the styles of harmonic control have in common."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from codesign.architectures.interface import Step
from codesign.memo import Memo
from codesign.planners.harmonic.fixed_point import Field
from codesign.planners.harmonic.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.relax import Relaxation, work
from codesign.planners.harmonic.stages import Stage, StageEnd, VisitBatch
from codesign.planners.interface import Problem
from codesign.records import StageRecord, TaskRecord, VisitsRecord

LOAD, RELAX, DECIDE = "load", "relax", "decide"
"""The phases that cycles are booked under, named as the tasks."""


class VisitCost(Protocol):
    """What visits cost, in cycles or in units of a processor's kernel."""

    def __call__(
        self, precision: int, block: NDArray[np.int32], iterations: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """The cost of visits of ``iterations`` iterations each, int64: a sum over visits of what it depends on
        linearly (the iterations), with nothing for a visit as such."""


@dataclass(frozen=True)
class Costs:
    """The costs of a style: of the iterations of a visit, of a visit as such, and of the end of a stage.

    Split so, costs add up: a stage costs the same told visit by visit or from its sums. ``ram_addresses``: addresses
    that each block RAM is given in every cycle (an iteration reads one word and writes another).
    """

    iterations: VisitCost
    visit: int = 0
    stage_end: int = 0
    ram_addresses: int = 0


@dataclass(frozen=True, eq=False)
class _StageSums:
    """A stage without its single visits: ``iterations`` of each block summed (int64), every block visited alike."""

    stage: Stage
    field: Field
    iterations: NDArray[np.int64]


@dataclass
class _StageClock:
    """When the stage under way began, known once its first visits have been told of."""

    begin: int | None = None


def relax_steps(
    problem: Problem, parameters: RelaxParameters, costs: Costs, memo: Memo | None, detail: bool
) -> Generator[Step, None, Relaxation]:
    """The relaxation as steps of phase ``relax``; returns what ``relax`` gives.

    With ``detail`` a unit of a step is a visit or the end of a stage; without, a unit is a whole stage, and stages
    that ``memo`` holds are not computed again.
    """
    from codesign.maps.reach import reachable

    told = (
        _each_visit(problem, parameters, costs)
        if detail
        else _each_stage(problem, parameters, costs, Memo() if memo is None else memo)
    )
    stages, field = yield from told
    return Relaxation(tuple(stages), field, reachable(problem.free, problem.goals), None)


def _each_visit(
    problem: Problem, parameters: RelaxParameters, costs: Costs
) -> Generator[Step, None, tuple[list[Stage], Field]]:
    stages: list[Stage] = []
    clock = _StageClock()
    field: Field | None = None
    for item in _work(problem, parameters, parameters.precisions, None):
        if isinstance(item, VisitBatch):
            cycles = (
                costs.iterations(item.precision, item.block, item.iterations.astype(np.int64)) + costs.visit
            )
            yield Step(RELAX, cycles, _visits_story(item, clock), costs.ram_addresses)
        else:
            stages.append(item.stage)
            field = item.field
            ending = [costs.stage_end] if costs.stage_end else []
            yield Step(RELAX, np.array(ending, np.int64), _stage_story(item, clock), costs.ram_addresses)
    assert field is not None, "a schedule has at least one stage"
    return stages, field


def _each_stage(
    problem: Problem, parameters: RelaxParameters, costs: Costs, memo: Memo
) -> Generator[Step, None, tuple[list[Stage], Field]]:
    stages: list[Stage] = []
    field: Field | None = None
    partition = (
        parameters.block_shape(problem.rows, problem.columns),
        parameters.iterations,
        parameters.termination,
    )
    for precision in parameters.precisions:
        start = None if field is None else field.digest()
        key = ("harmonic stage", problem.digest, *partition, start, precision)
        compute = partial(_stage_sums, problem, parameters, precision, field)
        sums = memo.get(key, compute)
        block = np.arange(len(sums.iterations), dtype=np.int32)
        cycles = int(costs.iterations(precision, block, sums.iterations).sum())
        total = np.array([cycles + costs.visit * sums.stage.visits + costs.stage_end], np.int64)
        yield Step(RELAX, total, ram_addresses=costs.ram_addresses)
        stages.append(sums.stage)
        field = sums.field
        if parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA and sums.stage.local_maxima == 0:
            break
    assert field is not None, "a schedule has at least one stage"
    return stages, field


def _stage_sums(
    problem: Problem, parameters: RelaxParameters, precision: int, start: Field | None
) -> _StageSums:
    """Run one stage from the field of an earlier one."""
    iterations = np.zeros(parameters.block_count(problem.rows, problem.columns), np.int64)
    for item in _work(problem, parameters, (precision,), start):
        if isinstance(item, StageEnd):
            return _StageSums(item.stage, item.field, iterations)
        iterations += np.bincount(item.block, item.iterations, len(iterations)).astype(np.int64)
    raise AssertionError("a stage has an end")


def _work(
    problem: Problem, parameters: RelaxParameters, precisions: tuple[int, ...], start: Field | None
) -> Iterator[VisitBatch | StageEnd]:
    return work(
        problem.free,
        problem.goals,
        block=parameters.block_shape(problem.rows, problem.columns),
        iterations=parameters.iterations,
        schedule=precisions,
        termination=parameters.termination,
        start=start,
        stop_without_local_maxima=parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
    )


def task_step(task: str, cycles: int, ram_addresses: int = 0) -> Step:
    """One step that is a task by itself, told as a ``TaskRecord``."""

    def tell(begin: int, end: int, source: str) -> TaskRecord:
        return TaskRecord(begin, source, task, end, cycles)

    return Step(task, np.array([cycles], np.int64), tell, ram_addresses)


def _visits_story(batch: VisitBatch, clock: _StageClock) -> Callable[[int, int, str], VisitsRecord]:
    def tell(begin: int, end: int, source: str) -> VisitsRecord:
        if clock.begin is None:
            clock.begin = begin
        return VisitsRecord(
            time=begin,
            source=source,
            end=end,
            stage=batch.stage_index,
            precision=batch.precision,
            block=batch.block,
            iterations=batch.iterations,
        )

    return tell


def _stage_story(item: StageEnd, clock: _StageClock) -> Callable[[int, int, str], StageRecord]:
    def tell(begin: int, end: int, source: str) -> StageRecord:
        stage_begin, clock.begin = clock.begin, None
        return StageRecord(
            time=end,
            source=source,
            begin=begin if stage_begin is None else stage_begin,
            stage=item.stage_index,
            precision=item.stage.precision,
            sweeps=item.stage.sweeps,
            visits=item.stage.visits,
            iterations=item.stage.iterations,
            cycles=item.stage.cycles,
            local_maxima=item.stage.local_maxima,
            potential=item.field.to_float(),
        )

    return tell
