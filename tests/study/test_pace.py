"""The time left of an exploration, on a clock that the test moves."""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from codesign.study.budget import Budget
from codesign.study.evaluation import Done
from codesign.study.partition import Alone, Together, Work
from codesign.study.pricing.machines import Specs
from codesign.study.pricing.price import Priced
from codesign.study.space import DesignPoint
from codesign.study.tally import ExplorationPace

OWN = 1e-5
"""Seconds that the coordinator takes for each point."""


def priced(begin: int, count: int) -> Together:
    return Together(np.arange(begin, begin + count), {}, Specs({}, {}, count), str(begin))


def alone(begin: int, count: int) -> Alone:
    return Alone(tuple(DesignPoint(index, {}, str(index)) for index in range(begin, begin + count)))


@dataclass
class Cost:
    """What a work takes: seconds of its simulations, and of the rest; ``loading``: of kernels, beside them."""

    simulating: float
    rest: float
    loading: float = 0.0

    @property
    def seconds(self) -> float:
        return self.simulating + self.rest + self.loading


class Study:
    """Works that so many workers compute, on a clock of their own; and the time left that was said on the way."""

    def __init__(self, costs: Sequence[tuple[Work, Cost]], workers: int, budget: Budget | None = None) -> None:
        self.costs, self.workers, self.budget, self.now = costs, workers, budget, 0.0
        self.points = sum(len(work) for work, _ in costs)
        self.said: list[tuple[float, float | None]] = []

    def clock(self) -> float:
        return self.now

    def coming(self) -> Iterator[Done]:
        free = [0.0] * self.workers
        ends: list[tuple[float, int]] = []
        for number, (_, cost) in enumerate(self.costs):
            begin = heapq.heappop(free)
            if cost.loading:
                # One worker compiles, and the others wait for it.
                free = [begin + cost.seconds] * len(free)
            heapq.heappush(free, begin + cost.seconds)
            ends.append((begin + cost.seconds, number))
        for end, number in sorted(ends):
            work, cost = self.costs[number]
            # One worker: the coordinator's own time delays the work. Several: it does so beside them.
            self.now = self.now + cost.seconds if self.workers == 1 else max(self.now, end)
            yield done(work, cost)

    def run(self) -> list[tuple[float, float | None]]:
        """The share of the time that was over, and the time left that was said over the true one, after each work."""
        pace = ExplorationPace([work for work, _ in self.costs], self.points, self.workers, self.clock)
        for each in pace.watched(self.coming()):
            self.said.append((self.now, pace.left_s(self.budget)))
            self.now += OWN * len(each.work)
        return [
            (time / self.now, None if left is None else left / (self.now - time))
            for time, left in self.said
            if time < 0.95 * self.now  # with fewer works than workers left, some workers are idle
        ]


def done(work: Work, cost: Cost) -> Done:
    took = None if cost.loading else cost.seconds
    simulating = None if cost.loading else cost.simulating
    if isinstance(work, Together):
        # Only the number of priced points counts here, so their outcomes are left out.
        outcomes = Priced.__new__(Priced)
        return Done(work, outcomes, simulated=int(cost.simulating > 0), took_s=took, simulating_s=simulating)
    return Done(work, simulated=len(work), took_s=took, simulating_s=0.0)


def study(kinds: Sequence[Callable[[int], tuple[Work, Cost]]]) -> list[tuple[Work, Cost]]:
    works, begin = [], 0
    for kind in kinds:
        work, cost = kind(begin)
        works.append((work, cost))
        begin += len(work)
    return works


def a_price(begin: int) -> tuple[Work, Cost]:
    return priced(begin, 500), Cost(0.0, 0.01)


def a_first(begin: int) -> tuple[Work, Cost]:
    return priced(begin, 500), Cost(0.4, 0.01, loading=20.0)


def simulated_block(random: random.Random) -> Callable[[int], tuple[Work, Cost]]:
    return lambda begin: (priced(begin, 500), Cost(random.uniform(0.1, 0.7), 0.01))


def mission(random: random.Random) -> Callable[[int], tuple[Work, Cost]]:
    return lambda begin: (alone(begin, 2), Cost(0.0, random.uniform(1.0, 3.0)))


@pytest.mark.parametrize("workers", [1, 2, 8])
def test_half_priced_half_simulated(workers: int) -> None:
    """The first half is priced only, the second half simulated: a rate of points would be wrong by the factor 1,000."""
    draw = random.Random(1)
    kinds = [a_price] * 300 + [mission(draw)] * 300
    said = Study(study(kinds), workers).run()
    # Nothing is said while no simulation was timed, rather than something wrong.
    assert all(ratio is None for _, ratio in said[:300])
    known = [ratio for _, ratio in said[300 + 2 * workers :] if ratio is not None]
    assert len(known) == len(said) - 300 - 2 * workers
    assert min(known) > 0.7, min(known)
    assert max(known) < 1.4, max(known)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_simulation_seen_early_is_enough(workers: int) -> None:
    draw = random.Random(2)
    kinds = [a_first, mission(draw), mission(draw), mission(draw), *[a_price] * 300, *[mission(draw)] * 300]
    said = Study(study(kinds), workers).run()
    known = [ratio for _, ratio in said[4 + 2 * workers :]]
    assert None not in known
    # Three simulations between 1 s and 3 s are all that is known: their mean is within a factor of two.
    assert all(ratio is not None and 0.5 < ratio < 2.0 for ratio in known)


@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize("share", [0.05, 0.5, 0.9])
def test_computations_of_which_some_are_kept(workers: int, share: float) -> None:
    """Which blocks need a simulation is not known beforehand. Their share is, after some of them."""
    draw = random.Random(3)
    kinds = [a_first] + [simulated_block(draw) if draw.random() < share else a_price for _ in range(1500)]
    said = Study(study(kinds), workers).run()
    assert len(said) > 1000
    assert all(ratio is not None and 0.5 < ratio < 2.0 for _, ratio in said[200:])


def test_compiling_is_no_cost_of_the_works_that_follow() -> None:
    said = Study(study([a_first, *[simulated_block(random.Random(4))] * 50]), 1).run()
    assert said[0][1] is None
    assert all(ratio is not None and 0.5 < ratio < 2.0 for _, ratio in said[1:])


def test_blocks_that_fall_apart_are_counted_as_points() -> None:
    """Blocks of missions come back as points that are simulated each by itself."""
    draw = random.Random(5)
    blocks = [priced(20 * number, 20) for number in range(40)]
    now, left = 0.0, []
    pace = ExplorationPace(blocks, 800, 1, lambda: now)

    def coming() -> Iterator[Done]:
        nonlocal now
        for block in blocks:
            for begin in range(0, 20, 5):
                took = draw.uniform(1.0, 3.0)
                now += took
                yield Done(alone(int(block.numbers[begin]), 5), simulated=5, took_s=took, simulating_s=0.0)

    for _ in pace.watched(coming()):
        left.append((now, pace.left_s()))
    known = [(time, said) for time, said in left[:-4] if said is not None]
    assert len(known) > 140
    assert all(0.75 < said / (now - time) < 1.33 for time, said in known[8:])
    assert pace.left_s() == 0.0


def test_a_cluster_of_unknown_size() -> None:
    """Two workers are known of, sixteen compute."""
    draw = random.Random(6)
    several = Study(study([mission(draw) for _ in range(1000)]), 16)
    pace = ExplorationPace([work for work, _ in several.costs], several.points, 2, several.clock)
    said = [(several.now, pace.left_s()) for _ in pace.watched(several.coming())]
    for time, left in said[100:900]:
        assert left is not None
        assert 0.5 < left / (several.now - time) < 2.0


def test_a_budget_of_time_bounds_the_time_left() -> None:
    now = 0.0
    works = [alone(10 * number, 10) for number in range(100)]
    pace = ExplorationPace(works, 1000, 1, lambda: now)
    spent: list[tuple[float | None, ...]] = []
    budgets = (None, Budget(points=100), Budget(seconds=50.0, clock=lambda: now))

    def coming() -> Iterator[Done]:
        nonlocal now
        for work in works[:10]:
            now += 2.0
            yield Done(work, simulated=10, took_s=2.0, simulating_s=0.0)

    for _ in pace.watched(coming()):
        spent.append(tuple(pace.left_s(budget) for budget in budgets))
    assert spent[-1] == pytest.approx((180.0, 180.0, 30.0))
    assert not any(math.isnan(each) for each in spent[-1] if each is not None)
