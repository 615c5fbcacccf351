"""The steps of the styles: cycles of the plan and the waits, the planner's plan and bits, records, software."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from codesign.ground.memo import Memo
from codesign.ground.records import StageRecord, VisitsRecord
from codesign.planners.harmonic.plan.fixed_point import limbs_needed
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import relax
from codesign.planners.harmonic.styles import ARCHITECTURES, resources, timing
from codesign.planners.harmonic.styles.software import block_cells
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Step

BIT_SERIAL, SOFTWARE, SOFTWARE_LIMBS = ARCHITECTURES


def drain(style: Any, task: Problem, chosen: RelaxParameters, **how: Any) -> tuple[list[Step], Any]:
    steps, work = [], style.work(Job(task, chosen, **how))
    while True:
        try:
            steps.append(next(work))
        except StopIteration as done:
            return steps, done.value


MAZE = np.array(
    [[c != "#" for c in line] for line in ("....#...", ".##.#.#.", ".#..#.#.", ".#.#..#.", "...#.##.", "##.....#")]
)


@pytest.mark.parametrize("blocks", [(1, 1), (2, 2), (2, 3)])
def test_bit_serial_cycles_are_those_of_the_planner_and_the_waits(blocks: tuple[int, int]) -> None:
    task = Problem(MAZE, ((0, 0),), ())
    chosen = RelaxParameters(blocks=blocks, iterations=3, schedule=(5, 9, 20), stop="schedule_end")
    steps, plan = drain(BIT_SERIAL, task, chosen)
    assert [phase for phase, _ in itertools.groupby(step.phase for step in steps)] == ["load", "relax", "decide"]
    assert all(step.cycles.dtype == np.int64 and (step.cycles >= 1).all() for step in steps)
    total = sum(int(step.cycles.sum()) for step in steps if step.phase == "relax")
    shape = chosen.block_shape(*MAZE.shape)
    count = math.prod(blocks)
    visits = relax(MAZE, [(0, 0)], block=shape, iterations=3, schedule=(5, 9, 20)).visits
    assert visits is not None
    # With I = 3 every stage ends with visits of one iteration, which are early.
    early = int((visits.iterations < 3).sum()) if count > 1 else len(plan.stages)
    assert total == plan.total_cycles + early * timing.dropped_pass_cycles(*shape)
    assert plan.total_cycles == sum(stage.iterations * (stage.precision + 2) for stage in plan.stages)
    memories = resources.memories(*shape, *blocks)
    assert int(steps[0].cycles[0]) == count * 21 + 2 * count * memories
    assert int(steps[-1].cycles[0]) == timing.decision_cycles(20)


@pytest.mark.parametrize("style", ARCHITECTURES, ids=lambda style: style.style)
def test_coarse_steps_and_a_memo_change_no_cycle_and_no_bit(style: Any) -> None:
    task = Problem(MAZE, ((0, 0),), ())
    chosen = RelaxParameters(block=(4, 3), iterations=3, schedule=(5, 9, 70), stop="schedule_end")
    memo = Memo(max_bytes=1 << 20)
    fine, plan = drain(style, task, chosen)
    for repeat in range(2):
        coarse, again = drain(style, task, chosen, memo=memo, detail=False)
        assert sum(int(step.cycles.sum()) for step in coarse) == sum(int(step.cycles.sum()) for step in fine), repeat
        assert again.stages == plan.stages
        assert again.field == plan.field


def test_plan_of_every_style_is_the_planner_s() -> None:
    from codesign.planners.harmonic.plan.planner import PLANNER

    task = Problem(MAZE, ((0, 0),), ())
    chosen = RelaxParameters(block=(3, 3), iterations=4, schedule=(6, 12, 30))
    expected = PLANNER.plan(Job(task, chosen))
    for style in ARCHITECTURES:
        _, plan = drain(style, task, chosen)
        assert plan.stages == expected.stages
        assert plan.field == expected.field
        assert np.array_equal(plan.reachable, expected.reachable)


def test_records_tell_visits_and_stages_with_their_times() -> None:
    task = Problem(MAZE, ((0, 0),), ())
    steps, plan = drain(
        BIT_SERIAL, task, RelaxParameters(block=(3, 4), iterations=3, schedule=(5, 9), stop="schedule_end")
    )
    now, records = 0, []
    for step in steps:
        end = now + int(step.cycles.sum())
        if step.record is not None:
            records.append(step.record(now, end, "fpga"))
        now = end
    stages = [record for record in records if isinstance(record, StageRecord)]
    assert [record.precision for record in stages] == [5, 9]
    assert stages[1].begin == stages[0].time
    assert stages[0].begin == int(steps[0].cycles.sum())
    assert stages[1].potential.dtype == np.float64
    assert stages[1].potential[0, 0] == 1.0
    visits = [record for record in records if isinstance(record, VisitsRecord)]
    assert sum(int(record.iterations.sum()) for record in visits) == plan.total_iterations


def test_software_updates_every_cell_of_a_visited_block() -> None:
    assert block_cells((5, 7), (3, 4)).tolist() == [12, 9, 8, 6]
    task = Problem(MAZE, ((0, 0),), ())
    whole = RelaxParameters(blocks=(1, 1), iterations=1, schedule=(9, 70), stop="schedule_end")
    flat, plan = drain(SOFTWARE, task, whole)
    grown, _ = drain(SOFTWARE_LIMBS, task, whole)
    updates = {stage.precision: stage.iterations * MAZE.size for stage in plan.stages}
    total = [sum(int(step.cycles.sum()) for step in steps if step.phase == "relax") for steps in (flat, grown)]
    assert total == [sum(updates.values()), updates[9] + limbs_needed(70) * updates[70]]
    assert limbs_needed(70) == 2
    assert SOFTWARE.demand(Job(task, whole)).items == ()
