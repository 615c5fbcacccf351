from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.arguments import Visits
from codesign.planners.harmonic.plan.best_schedule import (
    Schedule,
    SimulatedStages,
    best_schedule,
    iteration_cycles,
    optimise_schedule,
)
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.interface import Problem


def every_schedule(candidates: list[int], last: int) -> Iterator[tuple[int, ...]]:
    below = sorted({precision for precision in candidates if precision < last})
    for count in range(len(below) + 1):
        for chosen in itertools.combinations(below, count):
            yield (*chosen, last)


class TableOfStages:
    """Stages with costs from a table, and bounds that are a share of the cost."""

    def __init__(self, costs: dict[tuple[int, int], int], ending: set[int], share: float) -> None:
        self.costs, self.ending, self.share = costs, ending, share
        self.asked: Counter[tuple[int, int]] = Counter()
        self.reached = {0}

    def cost(self, begin: int, end: int) -> int:
        return self.costs.get((begin, end), 5)

    def least(self, begin: int, end: int) -> int:
        return int(self.cost(begin, end) * self.share)

    def run(self, begin: int, end: int, most: int | None) -> int | None:
        assert begin in self.reached, "a stage was run before its start was known"
        self.asked[begin, end] += 1
        cost = self.cost(begin, end)
        if most is not None and cost > most:
            return None
        self.reached.add(end)
        return cost

    def ends(self, precision: int) -> bool:
        assert precision in self.reached
        return precision in self.ending


@given(
    st.lists(st.integers(1, 12), max_size=7),
    st.integers(1, 12),
    st.dictionaries(st.tuples(st.integers(0, 12), st.integers(1, 12)), st.integers(0, 9), max_size=60),
    st.sets(st.integers(1, 12), max_size=3),
    st.sampled_from([0.0, 0.5, 1.0]),
)
def test_equals_trying_every_schedule(
    candidates: list[int], last: int, costs: dict[tuple[int, int], int], ending: set[int], share: float
) -> None:
    stages = TableOfStages(costs, ending, share)

    def cost_and_stages(schedule: tuple[int, ...]) -> tuple[int, int]:
        ends = next((place + 1 for place, p in enumerate(schedule) if p in ending), len(schedule))
        walked = schedule[:ends]
        return sum(stages.cost(*pair) for pair in itertools.pairwise((0, *walked))), len(walked)

    schedule = best_schedule(stages, candidates, last, may_end=bool(ending))
    best = min(map(cost_and_stages, every_schedule(candidates, last)))
    assert (schedule.cost, len(schedule.precisions)) == best == cost_and_stages(schedule.precisions)
    assert schedule.precisions[-1] == last or schedule.precisions[-1] in ending
    assert all(times == 1 for times in stages.asked.values())
    assert schedule.simulated + schedule.cut == len(stages.asked)
    assert schedule.simulated + schedule.cut + schedule.bounded == schedule.stages
    assert schedule.schedules == 2 ** len({each for each in candidates if each < last})


def test_exact_bounds_leave_the_stages_of_the_series_and_of_the_best() -> None:
    squares = {(begin, end): (end - begin) ** 2 + 3 for begin in range(9) for end in range(begin + 1, 10)}
    stages = TableOfStages(squares, set(), 1.0)
    best = best_schedule(stages, range(1, 9), 9, may_end=False)
    assert (best.cost, best.cut) == (5 * 3 + 4 * 4 + 1, 0)
    assert (best.simulated, best.stages) == (len(stages.asked), 45)
    assert best.bounded > 20


@pytest.mark.parametrize("candidates", [[0, 4], [-3]])
def test_precisions_below_one_are_refused(candidates: list[int]) -> None:
    with pytest.raises(InputError, match="precision"):
        best_schedule(TableOfStages({}, set(), 0.0), candidates, 8)


def problem_of(seed: int) -> Problem:
    generator = np.random.default_rng(seed)
    free = generator.random((7, 9)) > 0.25
    free[3, 4] = True
    return Problem(free=free, goals=((3, 4),), starts=())


def with_switches(precision: int, visits: Visits) -> int:
    return iteration_cycles(precision, visits) + 3 * int(visits.count.sum()) + int(visits.early.sum())


@settings(max_examples=12)
@given(
    st.integers(0, 1000),
    st.sampled_from([(7, 9), (3, 4), (2, 9)]),
    st.sampled_from([1, 3, 20]),
    st.sampled_from(list(Stop)),
)
def test_equals_running_every_schedule(seed: int, block: tuple[int, int], iterations: int, stop: Stop) -> None:
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
        return sum(stage.cycles for stage in done.stages), len(done.stages)

    parameters = RelaxParameters(block=block, iterations=iterations, schedule=(1, last), stop=stop)
    schedule = optimise_schedule(problem, parameters, candidates)
    best = min(map(run, every_schedule(candidates, last)))
    assert (schedule.cost, len(schedule.precisions)) == best == run(schedule.precisions)


TEN_MAPS = [
    ("maze", {"rows": 16, "columns": 21, "corridor": 2, "seed": 1}),
    ("maze", {"rows": 20, "columns": 20, "corridor": 1, "seed": 2, "loops": 0.2}),
    ("maze", {"rows": 13, "columns": 31, "corridor": 3, "seed": 3, "loops": 0.5}),
    ("rooms", {"rows": 18, "columns": 18, "room": (5, 5), "door": 1, "seed": 4}),
    ("rooms", {"rows": 20, "columns": 26, "room": (8, 5), "door": 2, "seed": 5}),
    ("random", {"rows": 16, "columns": 16, "density": 0.1, "seed": 6}),
    ("random", {"rows": 14, "columns": 22, "density": 0.3, "seed": 7}),
    ("spiral", {"rows": 15, "columns": 15, "corridor": 2}),
    ("corridor", {"length": 30, "width": 2}),
    ("empty", {"rows": 14, "columns": 17}),
]


@pytest.mark.parametrize("number", range(len(TEN_MAPS)))
def test_equals_brute_force_over_eleven_candidates(number: int) -> None:
    kind, options = TEN_MAPS[number]
    free = maps.generate(kind, **options).free
    goal = maps.nearest_free(free, (2, 2))
    assert goal is not None
    problem = Problem(free, (goal,), ())
    # Precisions 1 to 12: 2,048 schedules, and every stage by itself for their sums.
    last = 12
    block = [problem.shape, (8, 9), (5, 30)][number % 3]
    parameters = RelaxParameters(
        block=block, iterations=[6, 1, 40][number % 3], schedule=(last,), stop=Stop.SCHEDULE_END
    )
    stages = SimulatedStages(problem, parameters, Memo(), with_switches)
    costs = {}
    for begin in range(last):
        for end in range(begin + 1, last + 1):
            costs[begin, end] = stages.run(begin, end, None)
    best = optimise_schedule(problem, parameters, range(1, last), cost=with_switches)

    def cost_of(schedule: tuple[int, ...]) -> int:
        return sum(costs[pair] or 0 for pair in itertools.pairwise((0, *schedule)))

    sums = {schedule: cost_of(schedule) for schedule in every_schedule(list(range(1, last)), last)}
    assert len(sums) == best.schedules == 2048
    assert best.cost == min(sums.values()) == sums[best.precisions]
    assert best.series == sums[tuple(range(1, last + 1))]


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([(7, 9), (3, 4), (2, 9), (1, 1), (4, 5)]),
    st.sampled_from([1, 2, 5, 20]),
    st.sampled_from([(3, 5, 8), (1, 7, 15), (2, 3, 9), (4, 12, 20)]),
)
def test_a_higher_start_bounds_a_lower_one(
    seed: int, block: tuple[int, int], iterations: int, precisions: tuple[int, int, int]
) -> None:
    problem = problem_of(seed)
    low, high, last = precisions
    parameters = RelaxParameters(block=block, iterations=iterations, schedule=(last,))
    whole = SimulatedStages(problem, parameters, Memo(), with_switches)
    for end in (low, high):
        whole.run(0, end, None)
    costs = {}
    bounds = []
    for begin in (high, low, 0):
        bounds.append((begin, whole.least(begin, last)))
        costs[begin] = whole.run(begin, last, None)
    for begin, bound in bounds:
        assert bound <= (costs[begin] or 0)
    # The cost of a stage that was cut off bounds it, and the stages from lower starts.
    cut = SimulatedStages(problem, parameters, Memo(), with_switches)
    for end in (low, high):
        cut.run(0, end, None)
    most = (costs[high] or 0) // 2
    assert cut.run(high, last, most) is None
    for begin in (high, low, 0):
        assert cut.least(begin, last) <= (costs[begin] or 0)


@settings(max_examples=50, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([(9, 14), (1, 30), (13, 13)]),
    st.sampled_from([1, 7, 1000]),
    st.floats(0.0, 0.45),
)
def test_the_decay_of_one_block_bounds_every_stage(
    seed: int, shape: tuple[int, int], iterations: int, density: float
) -> None:
    generator = np.random.default_rng(seed)
    free = generator.random(shape) >= density
    goals = tuple({(0, int(generator.integers(shape[1]))), (shape[0] - 1, 3)})
    for goal in goals:
        free[goal] = True
    problem = Problem(free, goals, ())
    parameters = RelaxParameters(blocks=(1, 1), iterations=iterations, schedule=(70,))
    rungs = [0, 3, 9, 15, 31, 70]
    stages = SimulatedStages(problem, parameters, Memo(), with_switches)
    for end in rungs[1:]:
        stages.run(0, end, None)
    for begin, end in itertools.combinations(rungs[1:], 2):
        bound = stages.least(begin, end)
        assert bound <= (stages.run(begin, end, None) or 0)


def test_the_decay_is_a_sharp_bound_in_a_room() -> None:
    problem = Problem(np.ones((24, 24), bool), ((1, 1),), ())
    parameters = RelaxParameters(blocks=(1, 1), iterations=1000, schedule=(63,))
    stages = SimulatedStages(problem, parameters, Memo(), iteration_cycles)
    for end in (31, 63):
        stages.run(0, end, None)
    bound, cost = stages.least(31, 63), stages.run(31, 63, None)
    assert cost is not None
    assert 0.7 * cost < bound <= cost


def test_searches_share_a_memo_and_one_without_room_gives_the_same() -> None:
    problem = problem_of(5)
    parameters = RelaxParameters(block=(3, 4), iterations=4, schedule=(20,), stop=Stop.SCHEDULE_END)
    memo = Memo()
    first = optimise_schedule(problem, parameters, range(4, 20, 4), memo)
    again = optimise_schedule(problem, parameters, range(4, 20, 4), memo)
    assert without_account(again) == without_account(first)
    roomless = optimise_schedule(problem, parameters, range(4, 20, 4), Memo(max_bytes=0))
    assert without_account(roomless) == without_account(first)


def without_account(schedule: Schedule) -> Schedule:
    return replace(schedule, simulated=0, cut=0)


@pytest.mark.parametrize(
    ("changes", "remedy"), [({"termination": "published"}, "sound"), ({"promote": {"after": 2}}, "never")]
)
def test_costs_that_do_not_add_up_are_refused(changes: dict[str, object], remedy: str) -> None:
    parameters = RelaxParameters.model_validate({"block": (3, 4), "iterations": 4, "schedule": (8,), **changes})
    with pytest.raises(InputError, match="do not add up") as caught:
        optimise_schedule(problem_of(5), parameters, [4])
    assert remedy in str(caught.value.hint)
