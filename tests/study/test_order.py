"""The order of points: a permutation that takes each value of an axis about equally often, in every prefix."""

from __future__ import annotations

import itertools
import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from codesign.study.order import MAX_POINTS, Lattice, Order, deviation
from codesign.study.space import Space

BOXES = st.lists(st.lists(st.integers(1, 7), max_size=4), min_size=1, max_size=4)


@given(BOXES, st.integers(0, 3))
def test_every_point_has_one_turn(boxes: list[list[int]], seed: int) -> None:
    order = Order(boxes, seed)
    assert sorted(order) == list(range(sum(map(math.prod, boxes)))) == list(range(len(order)))


@given(BOXES, st.integers(0, 2), st.data())
def test_a_run_of_turns_is_the_same_wherever_it_is_begun(
    boxes: list[list[int]], seed: int, data: st.DataObject
) -> None:
    order = Order(boxes, seed)
    begin = data.draw(st.integers(0, len(order)))
    end = data.draw(st.integers(begin, len(order) + 3))
    assert order.indices(begin, end).tolist() == list(order)[begin:end]


@given(BOXES, st.integers(0, 3))
def test_in_every_prefix_each_value_was_taken_as_often_as_its_share_asks(boxes: list[list[int]], seed: int) -> None:
    order = Order(boxes, seed)
    turns = order.indices(0, len(order))
    for number, values in enumerate(boxes):
        first, last = int(order.begins[number]), int(order.begins[number + 1])
        inside = (turns >= first) & (turns < last)
        # The box among all points.
        counts = np.cumsum(inside)
        share = (last - first) / len(order)
        bound = deviation(order.whole.step, order.whole.size)
        assert np.abs(counts - share * np.arange(1, len(turns) + 1)).max(initial=0) <= bound
        # Each axis among the points of the box.
        own, period = turns[inside] - first, 1
        for count in reversed(values):
            places, period = own // period % count, period * count
            for place in range(count):
                taken = np.cumsum(places == place)
                gap = np.abs(taken - np.arange(1, len(own) + 1) / count).max(initial=0)
                assert gap <= deviation(order.boxes[number].step, period)


SPACES = [(5, 2, 9, 7, 6, 4), (2,) * 14, (10, 10, 10, 10), (3, 1000), (1000, 3), (64, 7, 12, 3), (97, 101)]


def uneven(points: NDArray[np.int64], values: tuple[int, ...]) -> tuple[float, float]:
    """The greatest deviation of the share of a value, and of a pair of values, relative to its share in the whole."""
    levels = np.unravel_index(points, values)

    def of(numbers: NDArray[np.intp], count: int) -> float:
        return float(np.abs(np.bincount(numbers, minlength=count) * count / len(points) - 1).max())

    alone = max(of(level, count) for level, count in zip(levels, values, strict=True))
    pairs = itertools.combinations(range(len(values)), 2)
    return alone, max(of(levels[a] * values[b] + levels[b], values[a] * values[b]) for a, b in pairs)


@pytest.mark.parametrize("values", SPACES)
def test_a_prefix_is_more_even_than_by_chance_and_than_in_file_order(values: tuple[int, ...]) -> None:
    count = math.prod(values)
    order, chance = Order([values]), np.random.default_rng(1)
    for part in (count // 20, count // 5):
        alone, pairs = uneven(order.indices(0, part), values)
        by_chance = np.mean([uneven(chance.permutation(count)[:part], values) for _ in range(5)], axis=0)
        in_file = uneven(np.arange(part), values)
        assert alone < by_chance[0]
        assert pairs < by_chance[1] * 1.2
        assert alone <= in_file[0]


@pytest.mark.parametrize("values", SPACES)
def test_the_bound_is_small(values: tuple[int, ...]) -> None:
    lattice, period = Lattice.of(values), 1
    for count in reversed(values):
        period *= count
        assert deviation(lattice.step, period) <= 10 * math.log2(lattice.size)


def test_a_hundred_million_points_need_no_table() -> None:
    space = Space({"a.a": range(1000), "a.b": range(1000), "a.c": range(50), "a.d": [1, 2]}, "")
    order = Order.of(space)
    tracemalloc.start()
    some = order.indices(99_000_000, 99_100_000)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 200 * len(some)
    assert len(order) == len(space) == 10**8
    assert len(set(some.tolist())) == 100_000
    assert 0 <= some.min() <= some.max() < 10**8


def test_two_numbers_of_the_largest_space_multiply_without_loss() -> None:
    lattice = Lattice(MAX_POINTS - 1, MAX_POINTS - 3, MAX_POINTS - 2)
    turn = MAX_POINTS - 5
    assert lattice.at(np.array([turn], np.int64))[0] == (turn * lattice.step + lattice.shift) % lattice.size


@settings(max_examples=30)
@given(st.integers(1, 200), st.integers(0, 200), st.integers(0, 200), st.data())
def test_how_many_turns_took_a_point_before_another(size: int, step: int, shift: int, data: st.DataObject) -> None:
    lattice = Lattice(size, step % size, shift % size)
    turn, end = data.draw(st.integers(0, 300)), data.draw(st.integers(0, size))
    points = [(k * lattice.step + lattice.shift) % size for k in range(turn)]
    assert lattice.before(turn, end) == sum(point < end for point in points)


def test_a_first_turn_is_the_first_point_of_the_file() -> None:
    assert Order([(3, 4), (2,)]).indices(0, 1).tolist() == [0]
    assert Order([(3, 4)], seed=5).indices(0, 1).tolist() != [0]
