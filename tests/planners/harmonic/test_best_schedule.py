from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.errors import InputError
from codesign.memo import Memo
from codesign.planners.harmonic.plan import Stage, relax
from codesign.planners.harmonic.plan.best_schedule import best_schedule, optimise_schedule
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.interface import Problem


def every_schedule(candidates: list[int], last: int) -> Iterator[tuple[int, ...]]:
    below = sorted({precision for precision in candidates if precision < last})
    for count in range(len(below) + 1):
        for chosen in itertools.combinations(below, count):
            yield (*chosen, last)


@given(
    st.lists(st.integers(1, 12), max_size=7),
    st.integers(1, 12),
    st.dictionaries(st.tuples(st.integers(0, 12), st.integers(1, 12)), st.integers(0, 9), max_size=60),
    st.sets(st.integers(1, 12), max_size=3),
)
def test_equals_trying_every_schedule(
    candidates: list[int], last: int, costs: dict[tuple[int, int], int], ending: set[int]
) -> None:
    asked: Counter[tuple[int | None, int]] = Counter()

    def stage_cost(begin: int | None, end: int) -> int:
        asked[begin, end] += 1
        return costs.get((begin or 0, end), 5)

    def cost_and_stages(schedule: tuple[int, ...]) -> tuple[int, int]:
        ends = next((place + 1 for place, p in enumerate(schedule) if p in ending), len(schedule))
        walked = schedule[:ends]
        return sum(costs.get(pair, 5) for pair in zip((0, *walked), walked, strict=False)), len(walked)

    schedule = best_schedule(stage_cost, candidates, last, ends=lambda precision: precision in ending)
    best = min(map(cost_and_stages, every_schedule(candidates, last)))
    assert (schedule.cost, len(schedule.precisions)) == best == cost_and_stages(schedule.precisions)
    assert schedule.precisions[-1] == last or schedule.precisions[-1] in ending
    assert all(times == 1 for times in asked.values())


def test_a_stage_whose_start_is_too_dear_to_reach_is_never_run() -> None:
    def stage_cost(begin: int | None, end: int) -> int:
        assert begin != 4, "to reach 4 costs more than the whole best schedule"
        return 100 if end == 4 else 1

    assert best_schedule(stage_cost, [2, 4], 8).precisions == (8,)


@pytest.mark.parametrize("candidates", [[0, 4], [-3]])
def test_precisions_below_one_are_refused(candidates: list[int]) -> None:
    with pytest.raises(InputError, match="precision"):
        best_schedule(lambda begin, end: 1, candidates, 8)


def problem_of(seed: int) -> Problem:
    generator = np.random.default_rng(seed)
    free = generator.random((7, 9)) > 0.25
    free[3, 4] = True
    return Problem(free=free, goals=((3, 4),), starts=())


def cycles_with_switches(stage: Stage) -> int:
    return stage.cycles + 3 * stage.visits


@settings(max_examples=12)
@given(
    st.integers(0, 1000),
    st.sampled_from([(7, 9), (3, 4), (2, 9)]),
    st.sampled_from([1, 3, 20]),
    st.sampled_from(list(Stop)),
)
def test_equals_running_every_schedule(
    seed: int, block: tuple[int, int], iterations: int, stop: Stop
) -> None:
    problem = problem_of(seed)
    candidates, last = [4, 6, 9, 13], 18

    def run(schedule: tuple[int, ...]) -> tuple[int, int]:
        done = relax(
            problem.free,
            problem.goals,
            block=block,
            iterations=iterations,
            schedule=schedule,
            stop_without_local_maxima=stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
        )
        return sum(map(cycles_with_switches, done.stages)), len(done.stages)

    parameters = RelaxParameters(block=block, iterations=iterations, schedule=(1, last), stop=stop)
    schedule = optimise_schedule(problem, parameters, candidates, cycles=cycles_with_switches)
    best = min(map(run, every_schedule(candidates, last)))
    assert (schedule.cost, len(schedule.precisions)) == best == run(schedule.precisions)


def test_searches_share_a_memo_and_one_without_room_gives_the_same() -> None:
    problem = problem_of(5)
    parameters = RelaxParameters(block=(3, 4), iterations=4, schedule=(20,), stop=Stop.SCHEDULE_END)
    memo = Memo()
    first = optimise_schedule(problem, parameters, range(4, 20, 4), memo)
    run = memo.misses
    assert optimise_schedule(problem, parameters, range(4, 20, 4), memo) == first
    assert memo.misses == run
    assert optimise_schedule(problem, parameters, range(4, 20, 4), Memo(max_bytes=0)) == first


def test_published_termination_is_refused() -> None:
    parameters = RelaxParameters(block=(3, 4), iterations=4, schedule=(8,), termination="published")
    with pytest.raises(InputError, match="do not add up") as caught:
        optimise_schedule(problem_of(5), parameters, [4])
    assert "sound" in str(caught.value.hint)
