"""Harmonic control plans again: from zero, from a lower bound, from old values; and with tasks placed elsewhere."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.errors import InputError, RunError
from codesign.ground.memo import Memo
from codesign.inputs import load_platform
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.fixed_point import Field, LowerBound
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.plan.planner import PLANNER, wrong_cells
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.warm_start import warm_start
from codesign.planners.harmonic.styles import ARCHITECTURES, TASK_STYLES, resources, timing
from codesign.planners.harmonic.styles.software import block_cells
from codesign.planners.harmonic.styles.steps import remaining_precisions
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Exchange

BIT_SERIAL, SOFTWARE, SOFTWARE_LIMBS = ARCHITECTURES
TASKS = {(style.task, style.component_type): style for style in TASK_STYLES}
PARAMETERS = RelaxParameters(block=(9, 11), iterations=5, schedule=(7, 15, 40), stop="schedule_end")


def drain(steps: Any) -> tuple[list[Any], Any]:
    yielded = []
    while True:
        try:
            yielded.append(next(steps))
        except StopIteration as done:
            return yielded, done.value


def cycles(steps: list[Any], phase: str | None = None) -> int:
    return sum(int(step.cycles.sum()) for step in steps if phase in {None, step.phase})


def before_and_after(seed: int = 5, new: int = 4) -> tuple[Problem, Problem]:
    """A map of rooms, and the same with some obstacles that were not there."""
    free = maps.generate("rooms", rows=24, columns=32, room=(11, 15), door=3, seed=seed).free
    goals = ((2, 2),)
    random = np.random.Generator(np.random.PCG64(seed))
    cells = np.argwhere(maps.reachable(free, goals))
    cells = cells[(cells != goals[0]).any(axis=1)]
    closed = free.copy()
    closed[tuple(cells[random.choice(len(cells), new, replace=False)].T)] = False
    return Problem(free, goals, ()), Problem(closed, goals, ())


@pytest.mark.parametrize("style", ARCHITECTURES, ids=lambda style: style.style)
@pytest.mark.parametrize("detail", [True, False])
def test_detection_elsewhere_is_a_round_trip_a_sweep(style: Any, detail: bool) -> None:
    _, problem = before_and_after()
    whole, plan = drain(style.work(Job(problem, PARAMETERS)))
    apart = frozenset({"relax", "decide"})
    steps, again = drain(style.work(Job(problem, PARAMETERS, inside=apart, detail=detail)))
    exchanges = [step for step in steps if isinstance(step, Exchange)]
    assert len(exchanges) == sum(stage.sweeps for stage in plan.stages)
    assert {(each.to, each.bits, each.answer_bits) for each in exchanges} == {("detect", 1, 1)}
    assert all(len(each.cycles) == 0 for each in exchanges)
    assert cycles(steps) == cycles(whole)
    assert again.field == plan.field
    # Between two round trips lie the visits of one sweep: every block once.
    blocks = PARAMETERS.block_count(problem.rows, problem.columns)
    visits = 0
    for step in steps:
        if isinstance(step, Exchange):
            assert visits == blocks
            visits = 0
        elif step.phase == "relax" and len(step.cycles) > 1:
            visits += len(step.cycles)


def test_a_start_begins_at_the_first_stage_that_holds_it() -> None:
    assert remaining_precisions((7, 15, 40), None) == (7, 15, 40)
    for precision, left in ((7, (7, 15, 40)), (8, (15, 40)), (15, (15, 40)), (40, (40,))):
        assert remaining_precisions((7, 15, 40), Field(np.zeros((1, 1, 1), np.uint64), precision)) == left
    with pytest.raises(InputError, match="41 bits"):
        remaining_precisions((7, 15, 40), Field(np.zeros((1, 1, 1), np.uint64), 41))


def test_a_bound_has_the_bits_of_a_restart_that_runs_its_schedule_to_the_end() -> None:
    _, problem = before_and_after()
    parameters = PARAMETERS.model_copy(update={"schedule": (7, 50, 63)})
    bound = warm_start(problem.free, problem.goals, 63)
    for stop, same in (("schedule_end", True), ("first_without_local_maxima", False)):
        asked = parameters.model_copy(update={"stop": Stop(stop)})
        _, restart = drain(BIT_SERIAL.work(Job(problem, asked)))
        _, warm = drain(BIT_SERIAL.work(Job(problem, asked, start=bound)))
        assert (warm.field == restart.field) is same
        assert (restart.precision, warm.precision) == (63 if same else 50, 63)
        assert len(warm.stages) == 1
        # Each is the least fixed point of its own precision, so neither has a wrong cell, or a cell without a way up.
        for plan in (restart, warm):
            judged = PLANNER.quality(problem, plan)
            assert (judged.wrong_cells, judged.local_maxima) == (0, 0)


def test_what_each_start_costs_to_bring_in() -> None:
    old, problem = before_and_after()
    rows, columns = PARAMETERS.block_shape(problem.rows, problem.columns)
    blocks = PARAMETERS.block_count(problem.rows, problem.columns)
    memories = resources.memories(rows, columns, *PARAMETERS.block_grid(problem.rows, problem.columns))
    words = 2 * memories * blocks
    starts = {
        "zero": (None, words + blocks * 41),
        "bound": (warm_start(problem.free, problem.goals, 40), memories * blocks * 41),
        "old": (PLANNER.plan(Job(old, PARAMETERS)).field, words),
    }
    for start, expected in starts.values():
        steps, _ = drain(BIT_SERIAL.work(Job(problem, PARAMETERS, start=start)))
        assert cycles(steps, "load") == expected


@settings(max_examples=25)
@given(st.integers(0, 50), st.integers(1, 12), st.sampled_from([7, 15, 40, 70]))
def test_old_values_stay_above_and_wrong_cells_are_counted(seed: int, new: int, precision: int) -> None:
    old, problem = before_and_after(seed % 7, new)
    whole = problem.rows, problem.columns
    before = relax(old.free, old.goals, block=whole, iterations=64, schedule=[precision])
    after = relax(
        problem.free,
        problem.goals,
        block=(8, 8),
        iterations=1 + seed % 9,
        schedule=[precision],
        start=before.field,
        most_sweeps=1 << 14,
    )
    settled = converged_field(problem.free, problem.goals, precision)
    assert not after.from_below
    assert (after.values >= settled.to_ints()).all()
    expected = int((after.values != settled.to_ints()).sum())
    assert wrong_cells(problem, after.field, from_below=False) == expected
    if not after.fault:
        # Settled, if not at the least fixed point: every cell is what its neighbours make it.
        again = relax(problem.free, problem.goals, block=(3, 5), iterations=3, schedule=[precision], start=after.field)
        assert again.field == after.field


@pytest.mark.parametrize("style", ARCHITECTURES, ids=lambda style: style.style)
def test_old_values_lead_to_the_same_bits_where_obstacles_have_gone(style: Any) -> None:
    after, before = before_and_after(seed=3, new=9)
    old = PLANNER.plan(Job(before, PARAMETERS))
    _, plan = drain(style.work(Job(after, PARAMETERS, start=old.field)))
    assert plan.field == PLANNER.plan(Job(after, PARAMETERS)).field
    assert PLANNER.quality(after, plan).wrong_cells == 0


def test_wrong_cells_of_a_field_from_above_are_not_overlooked() -> None:
    old, problem = before_and_after(seed=2, new=8)
    plan = PLANNER.plan(Job(old, PARAMETERS))
    _, above = drain(BIT_SERIAL.work(Job(problem, PARAMETERS, start=plan.field)))
    quality = PLANNER.quality(problem, above)
    assert quality.wrong_cells == wrong_cells(problem, above.field, from_below=False)
    assert quality.wrong_cells > 0
    assert PLANNER.quality(problem, PLANNER.plan(Job(problem, PARAMETERS))).wrong_cells == 0


def chessboard() -> tuple[Problem, Field]:
    """Goals all around, and values that change sides at every iteration: they never settle."""
    free = np.ones((8, 8), np.bool_)
    edge = (0, 7)
    goals = tuple((row, column) for row in range(8) for column in range(8) if row in edge or column in edge)
    start = np.add.outer(np.arange(8), np.arange(8)) % 2 + 15
    return Problem(free, goals, ((3, 3),)), Field.from_ints(start, 4)


@pytest.mark.parametrize("detail", [True, False])
def test_values_that_never_settle_are_a_plan_with_a_fault(detail: bool) -> None:
    problem, start = chessboard()
    parameters = RelaxParameters(blocks=(1, 1), iterations=1, schedule=(4, 9), stop="schedule_end")
    steps, plan = drain(BIT_SERIAL.work(Job(problem, parameters, start=start, detail=detail, memo=Memo())))
    assert "never settle" in plan.fault
    assert plan.precision == 4, "no further stage is begun"
    assert cycles(steps, "relax") > 0
    assert "never settle" in PLANNER.figures(plan)["details"]["fault"]
    assert PLANNER.quality(problem, plan).wrong_cells > 0
    assert pickle.loads(pickle.dumps(plan)).fault == plan.fault
    with pytest.raises(RunError, match="never settle"):
        relax(problem.free, problem.goals, block=(8, 8), iterations=1, schedule=(4, 9), start=start)


def test_sweeps_are_bounded_exactly() -> None:
    _, problem = before_and_after()
    how: dict[str, Any] = {"block": (9, 11), "iterations": 2, "schedule": (30,)}
    full = relax(problem.free, problem.goals, **how)
    for bound in (1, sum(stage.sweeps for stage in full.stages) - 1):
        cut = relax(problem.free, problem.goals, most_sweeps=bound, **how)
        assert sum(stage.sweeps for stage in cut.stages) == bound
        assert f"{bound:,} sweeps" in cut.fault
        assert sum(stage.visits for stage in cut.stages) == bound * 9
    enough = relax(problem.free, problem.goals, most_sweeps=sum(stage.sweeps for stage in full.stages), **how)
    assert not enough.fault
    assert enough.field == full.field


def test_a_lower_bound_says_that_it_is_one() -> None:
    _, problem = before_and_after()
    bound = pickle.loads(pickle.dumps(warm_start(problem.free, problem.goals, 40)))
    assert isinstance(bound, LowerBound)
    _, plan = drain(SOFTWARE.work(Job(problem, PARAMETERS, start=bound)))
    assert plan.from_below
    assert PLANNER.quality(problem, plan).wrong_cells == 0


def test_a_decision_by_itself_costs_a_cycle_less_than_inside() -> None:
    _, problem = before_and_after()
    steps, plan = drain(BIT_SERIAL.work(Job(problem, PARAMETERS)))
    alone, way = drain(TASKS["decide", "fpga"].steps(Job(problem, PARAMETERS, plan=plan, position=(20.0, 20.0))))
    assert cycles(steps, "decide") == timing.decision_cycles(40) == 40 + 8
    assert cycles(alone) == timing.lone_decision_cycles(40) == 40 + 7
    assert way[0][0].tolist() == [20.0, 20.0]
    fine = PARAMETERS.model_copy(update={"schedule": (70,)})
    fine_plan = PLANNER.plan(Job(problem, fine))
    for chosen, limbs in ((plan, 1), (fine_plan, 2)):
        host, _ = drain(TASKS["decide", "processor"].steps(Job(problem, fine, plan=chosen, position=(20.0, 20.0))))
        assert cycles(host) == limbs


def test_the_decision_module_holds_the_field_beside_it() -> None:
    problem, _ = before_and_after()
    part = load_platform("virtex4-pci").components["fpga"].chip  # type: ignore[union-attr]
    demand = TASKS["decide", "fpga"].demand(Job(problem, PARAMETERS, part=part))
    assert demand.total("slices") == 3 * 40 + 682
    # Five columns of a row are read at once: five memories of 16,384 × 1 bit, each with a fifth of the 32 columns.
    assert demand.total("block_rams") == 5 * -(-24 * 7 * 41 // 16_384) == 5
    # 99 planes of 24 × 7 bits are more than one block RAM holds.
    fine = PARAMETERS.model_copy(update={"schedule": (98,)})
    longer = TASKS["decide", "fpga"].demand(Job(problem, fine, part=part))
    assert longer.total("block_rams") == 5 * -(-24 * 7 * 99 // 16_384) == 10
    limit = TASKS["decide", "fpga"].clock_limit(Job(problem, PARAMETERS, part=part))
    assert limit.value == 150e6
    static, dynamic = TASKS["decide", "fpga"].power(demand, 100_000_000, part)
    assert static.value == part.static_power.value
    assert dynamic.value == pytest.approx(part.dynamic_power.value * 802 * 1e8)


def test_software_goes_on_in_units_of_its_kernel() -> None:
    old, problem = before_and_after()
    plan = PLANNER.plan(Job(old, PARAMETERS))
    steps, after = drain(SOFTWARE.work(Job(problem, PARAMETERS, start=plan.field)))
    cells = block_cells((problem.rows, problem.columns), PARAMETERS.block_shape(24, 32))
    seen = relax(
        problem.free,
        problem.goals,
        block=PARAMETERS.block_shape(24, 32),
        iterations=5,
        schedule=(40,),
        start=plan.field,
        most_sweeps=1 << 14,
    )
    assert seen.visits is not None
    assert cycles(steps, "relax") == int((seen.visits.iterations * cells[seen.visits.block]).sum())
    assert after.field == seen.field
