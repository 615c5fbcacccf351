"""The planner's visits as steps of a clock: what the styles of harmonic control have in common."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.architectures.interface import Step
from codesign.planners.harmonic.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.relax import Relaxation, Stage, StageEnd, VisitBatch, work
from codesign.planners.interface import Problem
from codesign.records import StageRecord, VisitsRecord

LOAD, RELAX, DECIDE = "load", "relax", "decide"
"""The phases that cycles are booked under, named as the tasks."""

VisitCost = Callable[[VisitBatch], NDArray[np.int64]]
"""Cycles (or units of a processor's kernel) of each visit of a batch, int64, at least 1 each."""


@dataclass
class _StageClock:
    """When the stage under way began, known once its first visits have been told of."""

    begin: int | None = None


def relax_steps(
    problem: Problem, parameters: RelaxParameters, visit_cost: VisitCost, stage_end_cost: int | None
) -> Generator[Step, None, Relaxation]:
    """The relaxation as steps of phase ``relax``: one for each batch of visits, one for each end of a stage.

    ``stage_end_cost``: cycles between two stages; None: none, and the step is left out.
    """
    # Lazily, as maps.reach brings scipy only where it is called.
    from codesign.maps.reach import reachable

    stages: list[Stage] = []
    clock = _StageClock()
    field = None
    for item in work(
        problem.free,
        problem.goals,
        block=parameters.block_shape(problem.rows, problem.columns),
        iterations=parameters.iterations,
        schedule=parameters.precisions,
        termination=parameters.termination,
        stop_without_local_maxima=parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
    ):
        if isinstance(item, VisitBatch):
            yield Step(RELAX, visit_cost(item), _visits_story(item, clock))
            continue
        stages.append(item.stage)
        field = item.field
        if stage_end_cost is not None:
            yield Step(RELAX, np.array([stage_end_cost], np.int64), _stage_story(item, clock))
    assert field is not None, "a schedule has at least one stage"
    return Relaxation(tuple(stages), field, reachable(problem.free, problem.goals), None)


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
            potential=item.field.to_float().astype(np.float32),
        )

    return tell
