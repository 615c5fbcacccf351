"""The true map over time: changes at exact times, a robot that is never run over, and inflation kept up to date."""

from __future__ import annotations

import itertools
import math
from itertools import pairwise

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.errors import InputError, RunError
from codesign.system.scenarios.drive.world import Appearing, Inflation, Moving, World, random_appearing
from codesign.system.scenarios.drive.world.obstacles import SECOND, rectangle
from codesign.system.scenarios.drive.world.true_map import RETRY

SIDE = 12


def an_open_map(side: int = SIDE) -> np.ndarray:
    return np.ones((side, side), np.bool_)


def run(world: World, until: int, robot: tuple[float, float] | None = None) -> list[tuple[int, set[tuple[int, int]]]]:
    """Advance through every change up to ``until``; when and what."""
    found = []
    now = 0
    while (due := world.next_change(now)) is not None and due <= until:
        now = due
        changed = world.advance(now, robot)
        if len(changed):
            found.append((now, {(row, column) for row, column in changed.tolist()}))
    return found


def grown(obstacles: np.ndarray, radius: float) -> np.ndarray:
    """Cells whose square is nearer than ``radius`` to that of an obstacle, or to the outside; in plain loops."""
    rows, columns = obstacles.shape
    result = obstacles.copy()
    reach = math.ceil(radius) + 1
    for row in range(rows):
        for column in range(columns):
            for other in range(row - reach, row + reach + 1):
                for beside in range(column - reach, column + reach + 1):
                    inside = 0 <= other < rows and 0 <= beside < columns
                    if inside and not obstacles[other, beside]:
                        continue
                    gap = [max(abs(one - two) - 1.0, 0.0) for one, two in ((row, other), (column, beside))]
                    result[row, column] |= math.hypot(*gap) < radius - 1e-9
    return result


@given(
    st.integers(0, 2**32),
    st.sampled_from([0.0, 0.5, 0.6, 0.75, 1.0, 1.5, 2.3]),
    st.tuples(st.integers(1, 9), st.integers(1, 9)),
)
@settings(max_examples=examples(100))
def test_inflation_after_changes_is_inflation_anew(seed: int, radius: float, shape: tuple[int, int]) -> None:
    random = np.random.default_rng(seed)
    obstacles = random.random(shape) < 0.2
    inflation = Inflation(obstacles, radius)
    np.testing.assert_array_equal(inflation.blocked, grown(obstacles, radius))
    for _ in range(3):
        after = random.random(shape) < 0.2
        inflation.change(np.argwhere(after & ~obstacles), np.argwhere(obstacles & ~after))
        obstacles = after
        np.testing.assert_array_equal(inflation.blocked, grown(obstacles, radius))


def test_a_radius_of_nothing_adds_nothing_and_any_other_all_cells_beside() -> None:
    obstacles = ~an_open_map(7)
    obstacles[3, 3] = True
    np.testing.assert_array_equal(Inflation(obstacles, 0.0).blocked, obstacles)
    open_cells = ~an_open_map(7)
    open_cells[1:-1, 1:-1] = True
    open_cells[2:5, 2:5] = False
    for radius in (1e-3, 0.5, 1.0):
        np.testing.assert_array_equal(Inflation(obstacles, radius).blocked, ~open_cells)


@given(st.integers(0, 2**32), st.floats(0.01, 3.0))
@settings(max_examples=50)
def test_a_disc_anywhere_in_a_cell_that_is_not_blocked_is_clear(seed: int, radius: float) -> None:
    random = np.random.default_rng(seed)
    obstacles = random.random((SIDE, SIDE)) < 0.05
    cells = np.argwhere(~Inflation(obstacles, radius).blocked)
    squares = np.argwhere(obstacles)
    for corner in itertools.product((-0.5, 0.5), repeat=2):
        places = cells + corner
        gaps = np.maximum(np.abs(places[:, None] - squares) - 0.5, 0.0)
        assert (np.hypot(gaps[..., 0], gaps[..., 1]) >= radius - 1e-6).all()
        assert ((places >= radius - 0.5 - 1e-6) & (places <= SIDE - 0.5 - radius + 1e-6)).all()
    with pytest.raises(InputError, match="radius of -1"):
        Inflation(obstacles, -1)


def test_obstacles_appear_and_vanish_at_their_times() -> None:
    one, two = rectangle(1, 1, 2, 2), rectangle(2, 2, 1, 3)
    world = World(an_open_map(), appearing=[Appearing(5, one, 20), Appearing(10, two), Appearing(10, one, 11)])
    first, second = {tuple(cell) for cell in one.tolist()}, {tuple(cell) for cell in two.tolist()}
    assert world.next_change(0) == 5
    assert run(world, 100) == [(5, first), (10, second - first), (20, first - second)]
    assert world.next_change(100) is None
    expected = an_open_map()
    expected[2, 2:5] = False
    np.testing.assert_array_equal(world.free_now, expected)
    np.testing.assert_array_equal(world.blocked_for_robot, ~expected)


def test_an_obstacle_on_a_wall_leaves_the_wall() -> None:
    free = an_open_map()
    free[3, 3] = False
    world = World(free, appearing=[Appearing(5, rectangle(3, 2, 1, 3), 9)])
    assert run(world, 10) == [(5, {(3, 2), (3, 4)}), (9, {(3, 2), (3, 4)})]
    np.testing.assert_array_equal(world.free_now, free)


def first_blocked(world: World) -> tuple[int, int]:
    """The first cell in raster order that is not free: the top left one of the only obstacle on an open map."""
    row, column = np.argwhere(~world.free_now)[0]
    return int(row), int(column)


def test_an_obstacle_moves_to_and_fro_at_exact_times() -> None:
    world = World(an_open_map(), moving=[Moving((1, 2), ((4, 0), (4, 2)), 3.0, 7)])
    step = round(SECOND / 3)
    assert run(world, 7 + 4 * step) == [
        (7, {(4, 0), (4, 1)}),
        (7 + step, {(4, 0), (4, 2)}),
        (7 + 2 * step, {(4, 1), (4, 3)}),
        (7 + 3 * step, {(4, 3), (4, 1)}),
        (7 + 4 * step, {(4, 2), (4, 0)}),
    ]
    assert first_blocked(world) == (4, 0)


def test_a_route_that_ends_as_it_began_goes_around() -> None:
    around = Moving((1, 1), ((1, 1), (1, 3), (4, 3), (1, 1)), 1.0)
    assert around.closed
    path = around.path()
    assert path[0] == path[-1] == (1, 1)
    world = World(an_open_map(), moving=[around])
    seen: list[tuple[int, tuple[int, int]]] = []
    while (due := world.next_change()) is not None and due < 30 * SECOND:
        world.advance(due, None)
        seen.append((due, first_blocked(world)))
    places = [place for _, place in seen]
    assert places[: len(path)] == path
    assert places[len(path) : 2 * len(path) - 1] == path[1:]
    diagonal = round(math.sqrt(2) * SECOND)
    for (before, here), (after, there) in pairwise(seen):
        moved = abs(here[0] - there[0]) + abs(here[1] - there[1])
        assert after - before == (SECOND if moved == 1 else diagonal)
    assert run(World(an_open_map(), moving=[Moving((1, 1), ((2, 2),), 1.0, 3)]), 9 * SECOND) == [(3, {(2, 2)})]


@pytest.mark.parametrize(("margin", "near", "far"), [(0.5, 6.49, 6.51), (1.1, 6.99, 7.01)])
def test_what_would_come_over_the_robot_waits_until_it_has_left(margin: float, near: float, far: float) -> None:
    cells = rectangle(4, 4, 2, 2)
    world = World(an_open_map(), appearing=[Appearing(1000, cells)], radius_cells=0.4, margin_cells=margin)
    assert not len(world.advance(1000, (5.0, 5.0)))
    assert world.next_change(1000) == 1000 + RETRY
    # The cell beside has to be left, from 6.5 on, and the border at 5.5 to be radius and margin away.
    assert not len(world.advance(1000 + RETRY, (5.0, near)))
    assert len(world.advance(1000 + 2 * RETRY, (5.0, far))) == 4
    [deferral] = world.deferrals
    assert (deferral.time, deferral.until, deferral.kind) == (1000, 1000 + 2 * RETRY, "appearing")


def test_what_is_over_before_the_robot_left_never_comes() -> None:
    world = World(an_open_map(), appearing=[Appearing(1000, rectangle(4, 4, 1, 1), 1000 + RETRY)])
    assert run(world, 10 * SECOND, (4.0, 4.0)) == []
    assert [deferral.until for deferral in world.deferrals] == [None]
    assert world.free_now.all()


def test_a_moving_obstacle_waits_before_the_robot_and_goes_on() -> None:
    world = World(an_open_map(), moving=[Moving((1, 1), ((4, 0), (4, 8)), 1.0)], margin_cells=0.0)
    run(world, 10 * SECOND, (4.0, 3.0))
    assert first_blocked(world) == (4, 2)
    changes = run(world, 12 * SECOND, (8.0, 3.0))
    [deferral] = world.deferrals
    assert (deferral.kind, deferral.time) == ("moving", 3 * SECOND)
    assert first_blocked(world) == (4, 4)
    assert changes[1][0] - changes[0][0] == SECOND


@given(st.integers(0, 2**32), st.sampled_from([0.0, 0.4, 0.7, 1.3, 2.2]), st.sampled_from([0.0, 0.5]))
@settings(max_examples=examples(80))
def test_no_change_ever_takes_the_robots_place(seed: int, radius: float, margin: float) -> None:
    random = np.random.default_rng(seed)
    free = an_open_map()
    moving = [Moving((2, 1), tuple(map(tuple, random.integers(0, SIDE - 1, (3, 2)).tolist())), 3.0) for _ in range(4)]
    appearing = random_appearing(free, 10, 2, 0, 5 * SECOND, seed, lasting=SECOND)
    world = World(free, appearing=appearing, moving=moving, radius_cells=radius, margin_cells=margin)
    position = tuple(random.uniform(3, SIDE - 4, 2).tolist())
    cell = tuple(math.floor(part + 0.5) for part in position)
    assert not world.blocked_for_robot[cell]
    now = 0
    while (due := world.next_change(now)) is not None and due < 6 * SECOND:
        now = due
        before = world.free_now.copy()
        changed = world.advance(now, position)
        assert {tuple(each) for each in changed.tolist()} == {
            tuple(each) for each in np.argwhere(before != world.free_now).tolist()
        }
        assert not world.blocked_for_robot[cell]
        obstacles = np.argwhere(~world.free_now)
        gaps = np.maximum(np.abs(obstacles - position) - 0.5, 0.0)
        assert (np.hypot(gaps[:, 0], gaps[:, 1]) >= radius + margin).all()
        np.testing.assert_array_equal(world.blocked_for_robot, Inflation(~world.free_now, radius).blocked)


def test_a_change_that_was_passed_over_is_refused() -> None:
    world = World(an_open_map(), appearing=[Appearing(5, rectangle(1, 1, 1, 1))])
    with pytest.raises(RunError, match=r"something was due at 5 ps\n.*every next_change"):
        world.advance(6, None)


def test_views_cannot_be_written_and_the_map_given_is_not_changed() -> None:
    free = an_open_map()
    world = World(free, appearing=[Appearing(0, rectangle(1, 1, 1, 1))])
    for view in (world.free_now, world.blocked_for_robot):
        with pytest.raises(ValueError, match="read-only"):
            view[0, 0] = True
    world.advance(0, None)
    assert free.all()
    assert not world.free_now.all()


@pytest.mark.parametrize(
    "build",
    [
        lambda: World(an_open_map(), appearing=[Appearing(0, rectangle(11, 11, 1, 2))]),
        lambda: World(an_open_map(), moving=[Moving((2, 2), ((0, 0), (11, 0)), 1.0)]),
        lambda: World(an_open_map(), margin_cells=-1.0),
        lambda: Appearing(5, rectangle(1, 1, 1, 1), 5),
        lambda: Appearing(-1, rectangle(1, 1, 1, 1)),
        lambda: rectangle(0, 0, 0, 1),
        lambda: Moving((0, 1), ((0, 0),), 1.0),
        lambda: Moving((1, 1), (), 1.0),
        lambda: Moving((1, 1), ((0, 0),), 0.0),
        lambda: Moving((1, 1), ((0, 0),), math.nan),
        lambda: random_appearing(an_open_map(), 1, SIDE + 1, 0, 1, 0),
        lambda: random_appearing(an_open_map(), -1, 1, 0, 1, 0),
        lambda: random_appearing(an_open_map(), 1, 1, 2, 1, 0),
        lambda: random_appearing(~an_open_map(), 1, 1, 0, 1, 0),
    ],
)
def test_obstacles_that_cannot_be_are_refused(build: object) -> None:
    with pytest.raises(InputError):
        build()  # type: ignore[operator]


@given(st.integers(0, 2**32), st.integers(1, 4), st.integers(0, 12))
@settings(max_examples=60)
def test_random_obstacles_stand_on_free_cells_and_keep_clear(seed: int, size: int, count: int) -> None:
    free = np.random.default_rng(seed).random((SIDE, SIDE)) >= 0.05
    free[:5, :5] = True
    clear = [(11, 11), (6, 3)]
    found = random_appearing(free, count, size, 10, 10_000, seed, clear, lasting=7)
    assert len(found) == count
    assert [obstacle.at for obstacle in found] == sorted(obstacle.at for obstacle in found)
    for obstacle in found:
        assert 10 <= obstacle.at <= 10_000
        assert obstacle.until == obstacle.at + 7
        assert free[obstacle.cells[:, 0], obstacle.cells[:, 1]].all()
        assert not {tuple(cell) for cell in obstacle.cells.tolist()} & set(clear)
        assert (obstacle.cells == rectangle(*obstacle.cells[0].tolist(), size, size)).all()
    mask = np.zeros_like(free)
    mask[tuple(np.transpose(clear))] = True
    again = random_appearing(free, count, size, 10, 10_000, seed, mask)
    assert [each.cells.tolist() for each in again] == [each.cells.tolist() for each in found]


def test_random_obstacles_are_the_same_on_every_machine() -> None:
    found = random_appearing(an_open_map(), 3, 2, 0, SECOND, 1)
    assert [(each.at, each.cells[0].tolist()) for each in found] == [
        (144159612719, [10, 4]),
        (311831452010, [4, 7]),
        (511821624700, [10, 5]),
    ]
