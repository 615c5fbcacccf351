from __future__ import annotations

import itertools
import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.study.space import MAX_GROUP, Space, canonical, group_limit

AXES = {
    "relax.block": [[36, 66], [24, 44]],
    "relax.schedule": [{"first": 7, "step": 8, "last": 63}, [15, 31]],
    "fpga.part": ["XC2V6000-4", "XC4VLX160-12"],
    "relax.iterations": [1, 6, 16],
}
SPACES = st.dictionaries(
    st.sampled_from(["fpga.part", "fpga.clock", "relax.block", "relax.schedule", "relax.iterations"]),
    st.lists(st.integers(0, 20), min_size=1, max_size=5, unique=True),
)


def test_the_last_axis_moves_fastest_and_the_first_slowest() -> None:
    points = list(Space(AXES, "").points())
    assert [point.index for point in points] == list(range(24))
    assert [point.axes["relax.iterations"] for point in points[:4]] == [1, 6, 16, 1]
    assert [point.axes["relax.block"] for point in points[::12]] == [[36, 66], [24, 44]]
    assert list(points[0].axes) == list(AXES)


@given(SPACES)
def test_points_by_index_are_those_enumerated(axes: dict[str, list[int]]) -> None:
    space = Space(axes, "somewhere")
    points = list(space.points())
    assert len(points) == len(space) == math.prod(map(len, axes.values()))
    assert [space.point(point.index) for point in points] == points
    assert len({point.key for point in points}) == len(points)


def test_no_axis_is_one_point() -> None:
    assert [point.axes for point in Space({}, "").points()] == [{}]


@pytest.mark.parametrize("index", [-1, 24])
def test_a_place_outside(index: int) -> None:
    with pytest.raises(IndexError):
        Space(AXES, "").point(index)


def test_a_key_says_which_point_it_is_whatever_else_is_explored() -> None:
    (point,) = (p for p in Space(AXES, "x").points() if p.index == 7)
    fewer = {name: [value] for name, value in reversed(point.axes.items())}
    (same,) = Space(fewer, "x").points()
    assert same.key == point.key
    assert Space(fewer, "y").point(0).key != point.key
    assert Space(fewer | {"relax.iterations": [7]}, "x").point(0).key != point.key


def test_canonical_text() -> None:
    assert canonical({"b": [1, 1.5], "a": "µ"}) == '{"a":"µ","b":[1,1.5]}'
    assert json.loads(canonical(AXES)) == AXES
    with pytest.raises(ValueError, match="JSON compliant"):
        canonical(math.nan)


@st.composite
def conditional(draw: st.DrawFn) -> tuple[dict[str, list[Any]], dict[str, dict[str, list[Any]]]]:
    """Axes, and for some of them the values of axes that stand before or behind for which they exist."""
    axes = draw(
        st.dictionaries(
            st.sampled_from(list("abcdef")),
            st.lists(st.sampled_from([0, 1, 2, "x", [3, 4], None]), min_size=1, max_size=4, unique_by=repr),
            max_size=6,
        )
    )
    order = draw(st.permutations(list(axes)))
    when: dict[str, dict[str, list[Any]]] = {}
    for place, axis in enumerate(order):
        for other in draw(st.lists(st.sampled_from(order[:place]), max_size=2, unique=True)) if place else []:
            chosen = draw(st.lists(st.sampled_from(axes[other]), min_size=1, unique_by=repr))
            when.setdefault(axis, {})[other] = chosen
    return axes, when


def existing(axes: dict[str, list[Any]], when: dict[str, Any]) -> set[str]:
    """The points that exist, by the definition: every combination, less the axes that do not exist for it."""
    points = set()
    for values in itertools.product(*axes.values()):
        point = dict(zip(axes, values, strict=True))
        while True:
            gone = [
                axis
                for axis, conditions in when.items()
                if axis in point
                and not all(other in point and point[other] in chosen for other, chosen in conditions.items())
            ]
            if not gone:
                break
            point = {axis: value for axis, value in point.items() if axis not in gone}
        points.add(canonical(point))
    return points


@given(conditional())
def test_a_space_has_exactly_the_points_that_exist(axes_when: tuple[dict[str, list[Any]], dict[str, Any]]) -> None:
    axes, when = axes_when
    space = Space(axes, "", when=when)
    points = list(space.points())
    texts = [canonical(point.axes) for point in points]
    assert len(texts) == len(set(texts)) == len(space)
    assert set(texts) == existing(axes, when)
    assert [space.index(point.axes) for point in points] == list(range(len(space)))
    assert len({point.key for point in points}) == len(points)
    levels = space.levels(np.arange(len(space)))
    for point in points:
        numbers = {axis: int(column[point.index]) for axis, column in levels.items()}
        shown = {axis: space.axes[axis][number] for axis, number in numbers.items() if number >= 0}
        assert shown == point.axes
    assert [part.begin for part in space.parts] == list(
        itertools.accumulate([part.size for part in space.parts[:-1]], initial=0)
    )


def test_a_space_of_a_hundred_million_points_costs_nothing() -> None:
    axes: dict[str, Any] = {f"a.{name}": list(range(100)) for name in "bcde"}
    space = Space({"v": ["base", "host"], **axes}, "", when={"a.e": {"v": ["base"]}})
    assert len(space) == 101_000_000
    for index in (0, 99_999_999, 100_000_000, 100_999_999, 31_415_926):
        assert space.index(space.values(index)) == index
    assert "a.e" not in space.values(100_000_000)
    with pytest.raises(KeyError, match="no point has"):
        space.index({"v": "host", **{axis: 0 for axis in axes}})
    with pytest.raises(IndexError):
        space.values(101_000_000)


def test_a_key_of_a_point_is_the_same_without_conditions() -> None:
    plain = Space({"v": ["base"], "a.b": [1, 2]}, "x")
    space = Space({"v": ["base", "host"], "a.b": [1, 2]}, "x", when={"a.b": {"v": ["base"]}})
    assert [space.point(index).key for index in (0, 1)] == [plain.point(index).key for index in (0, 1)]
    assert space.point(2).axes == {"v": "host"}


@given(st.integers(0, 10**6), st.integers(1, 256))
def test_groups_are_small_enough_that_every_worker_gets_some(points: int, workers: int) -> None:
    limit = group_limit(points, workers)
    assert 1 <= limit <= MAX_GROUP
    assert limit == 1 or points / limit > 4 * workers
