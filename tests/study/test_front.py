from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.study import front
from codesign.study.front import dominators, non_dominated

# Few distinct values, so that ties in one objective and equal points are common.
FIGURES = st.one_of(st.integers(0, 3).map(float), st.sampled_from([math.nan, math.inf, -math.inf, -0.0, 0.5]))


def by_definition(points: list[list[float]], maximise: list[bool]) -> list[bool]:
    def better_or_equal(a: float, b: float, up: bool) -> bool:
        return a >= b if up else a <= b

    def dominates(a: list[float], b: list[float]) -> bool:
        triples = list(zip(a, b, maximise, strict=True))
        return all(better_or_equal(*t) for t in triples) and any(x != y for x, y, _ in triples)

    complete = [not any(math.isnan(figure) for figure in point) for point in points]
    return [
        whole and not any(ok and dominates(other, point) for ok, other in zip(complete, points, strict=True))
        for whole, point in zip(complete, points, strict=True)
    ]


@settings(max_examples=examples(300))
@given(st.data())
def test_equals_the_definition(data: st.DataObject) -> None:
    count = data.draw(st.integers(1, 5))
    maximise = data.draw(st.lists(st.booleans(), min_size=count, max_size=count))
    points = data.draw(st.lists(st.lists(FIGURES, min_size=count, max_size=count), max_size=40))
    assert non_dominated(points, maximise).tolist() == by_definition(points, maximise)


@pytest.mark.parametrize("objectives", [2, 5])
def test_blocks_change_nothing(objectives: int) -> None:
    values = np.random.default_rng(1).integers(0, 30, (1500, objectives)).astype(float)
    maximise = [index % 2 == 1 for index in range(objectives)]
    assert non_dominated(values, maximise).tolist() == by_definition(values.tolist(), maximise)


def test_a_front_of_everything() -> None:
    rising = np.arange(3000.0)
    assert non_dominated(np.column_stack([rising, -rising]), [False, False]).all()


def test_equal_points_stand_together() -> None:
    assert non_dominated([[1, 1], [1, 1], [2, 1], [2, 1]], [False, False]).tolist() == [True, True, False, False]


def test_a_missing_figure_is_off_the_front_and_pushes_nobody_off() -> None:
    assert non_dominated([[0, math.nan], [1, 1]], [False, False]).tolist() == [False, True]


def test_of_nothing() -> None:
    assert non_dominated([], [False, True]).tolist() == []
    assert non_dominated([[math.nan]], [False]).tolist() == [False]


@cache
def by_definition_of(spread: int, objectives: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of this spread, and which of them are not dominated: computed once for all sizes of groups."""
    values = np.random.default_rng(spread).integers(0, spread, (700, objectives)).astype(float)
    values[:300] /= np.linalg.norm(values[:300] + 1, axis=1, keepdims=True)
    return values, np.array(by_definition(values.tolist(), [False] * objectives))


@pytest.mark.parametrize("groups", [1, 3, 1024])
@pytest.mark.parametrize("spread", [3, 40, 10**6])
@pytest.mark.parametrize("objectives", [1, 2, 3, 5])
def test_groups_of_values_change_nothing(
    monkeypatch: pytest.MonkeyPatch, groups: int, spread: int, objectives: int
) -> None:
    monkeypatch.setattr(front, "_GROUPS", groups)
    values, expected = by_definition_of(spread, objectives)
    maximise = [False] * objectives
    assert (non_dominated(values, maximise) == expected).all()
    best = values[expected]
    places = dominators(values, maximise, best)
    assert ((places < 0) == expected).all()
    others = ~expected
    assert (best[places[others]] <= values[others]).all()
    assert (best[places[others]] < values[others]).any(axis=1).all()


def test_no_points_and_an_empty_front() -> None:
    assert not len(non_dominated(np.empty((0, 3)), [False] * 3))
    assert dominators([[1.0, 2.0]], [False, False], np.empty((0, 2))).tolist() == [-1]
    assert not len(dominators(np.empty((0, 2)), [False, True], [[1.0, 2.0]]))
