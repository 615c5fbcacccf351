"""Stages that designs share: equal to those of a relaxation that shares nothing, whatever was computed before."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.arguments import Stage, Visits
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.relax import relax
from codesign.planners.harmonic.styles.steps import StageRuns
from codesign.planners.interface import Problem

SCHEDULES = [(5,), (5, 9, 20), (5, 9, 20, 70), (5, 20), (3, 9), (5, 9, 33)]


def problem_of(seed: int) -> Problem:
    chance = np.random.default_rng(seed)
    free = chance.random((9, 14)) > 0.25
    free[0, 0] = True
    return Problem(free, ((0, 0),), ())


def parameters_of(
    blocks: tuple[int, int], iterations: int, schedule: tuple[int, ...], termination: str
) -> RelaxParameters:
    return RelaxParameters(
        blocks=blocks, iterations=iterations, schedule=schedule, termination=termination, stop="schedule_end"
    )


def by_itself(problem: Problem, chosen: RelaxParameters) -> tuple[tuple[Stage, ...], Field, list[list[int]]]:
    """Stages, field, and of each stage and block the iterations, of a relaxation that shares nothing."""
    shape = chosen.block_shape(*problem.shape)
    plan = relax(
        problem.free,
        problem.goals,
        block=shape,
        iterations=chosen.iterations,
        schedule=chosen.precisions,
        termination=chosen.termination,
    )
    assert plan.visits is not None
    count = chosen.block_count(*problem.shape)
    sums = [
        np.bincount(plan.visits.block[chosen_], plan.visits.iterations[chosen_], count).astype(int).tolist()
        for chosen_ in (plan.visits.stage == number for number in range(len(plan.stages)))
    ]
    return plan.stages, plan.field, sums


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("iterations", [1, 2, 7])
def test_shared_stages_are_those_of_each_design_by_itself(seed: int, iterations: int) -> None:
    """Both terminations, several partitions and schedules in any order, under one memo."""
    problem, memo = problem_of(seed), Memo()
    designs = list(itertools.product([(1, 1), (2, 2), (3, 2)], [iterations], SCHEDULES, ["sound", "published"]))
    random.Random(seed).shuffle(designs)
    for blocks, each, schedule, termination in designs:
        chosen = parameters_of(blocks, each, schedule, termination)
        runs = StageRuns(problem, chosen, True, memo)
        field, stages, visits = None, [], []
        for precision in chosen.precisions:
            sums = runs.sums(precision, field)
            field = sums.field
            stages.append(sums.stage)
            visits.append(sums.visits)
        expected, last, iterated = by_itself(problem, chosen)
        assert tuple(stages) == expected
        assert field == last
        assert [own.iterations.tolist() for own in visits] == iterated
        assert [int(own.count.sum()) for own in visits] == [stage.visits for stage in expected]


def test_early_visits_are_counted_alike() -> None:
    problem = problem_of(3)
    for termination in ("published", "sound"):
        chosen = parameters_of((2, 2), 4, (5, 9), termination)
        memo = Memo()
        # The published stages first, so that the sound ones are made of them.
        StageRuns(problem, parameters_of((2, 2), 4, (5, 9), "published"), True, memo).sums(5, None)
        shared, alone = (StageRuns(problem, chosen, True, held).sums(5, None).visits for held in (memo, None))
        for name in ("block", "iterations", "count", "early"):
            assert getattr(shared, name).tolist() == getattr(alone, name).tolist()
        assert isinstance(shared, Visits)


def test_the_second_termination_costs_no_stage() -> None:
    problem, memo = problem_of(1), Memo()
    for termination in ("published", "sound"):
        StageRuns(problem, parameters_of((2, 2), 64, (5,), termination), True, memo).sums(5, None)
    # The engine that stands, and a stage of each termination: asked for twice, and put there once more.
    assert memo.misses == 3
