"""Ways: exact traversal, authority, and joining."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from drives_and_ways import SIDE, quarters, ways
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components.path import NEAR, STANDING_ROOM, Polyline, authority, cell_of, join
from codesign.components.robot import DifferentialDrive, Motion
from codesign.ground.errors import InputError


def exact_cells(way: Polyline) -> list[tuple[int, int]]:
    """The cells of a polyline in rational arithmetic: those of its vertices, and of the middles between borders."""
    half = Fraction(1, 2)
    found: list[tuple[int, int]] = []
    for begin, end in zip(way.points[:-1].tolist(), way.points[1:].tolist(), strict=True):
        start = [Fraction(value) for value in begin]
        moved = [Fraction(value) - first for value, first in zip(end, start, strict=True)]
        shares = {Fraction(0), Fraction(1)}
        for first, move in zip(start, moved, strict=True):
            for border in range(-2, SIDE + 2):
                if move and 0 < (share := (border + half - first) / move) < 1:
                    shares.add(share)
        ordered = sorted(shares)
        middles = [(one + other) / 2 for one, other in pairwise(ordered)]
        for share in [Fraction(0), *middles, Fraction(1)]:
            row, column = (math.floor(first + share * move + half) for first, move in zip(start, moved, strict=True))
            if not found or found[-1] != (row, column):
                found.append((row, column))
    return found or [cell_of(way.points[0].tolist())]


@given(st.lists(st.tuples(quarters, quarters), min_size=1, max_size=7).map(Polyline))
@settings(max_examples=examples(200))
def test_a_way_enters_the_cells_of_exact_arithmetic(way: Polyline) -> None:
    entry, cells = way.crossings
    assert [tuple(cell) for cell in cells[:, :2].tolist()] == exact_cells(way)
    assert (np.diff(entry) >= 0.0).all()
    for arc, (row, column, *beside) in zip(entry.tolist(), cells.tolist(), strict=True):
        y, x = way.point_at(arc)
        assert max(abs(y - row), abs(x - column)) <= 0.5 + 1e-9, "entered at its border"
        assert {(row, column)} == {tuple(beside[:2]), tuple(beside[2:])} or (
            abs(abs(y - row) - 0.5) < 1e-9 and abs(abs(x - column) - 0.5) < 1e-9
        ), "only a corner has cells beside it"


@given(ways)
@settings(max_examples=examples(100))
def test_cells_of_a_way_touch_and_a_diagonal_has_both_cells_beside_it(way: Polyline) -> None:
    _, cells = way.crossings
    assert tuple(cells[-1, :2]) == cell_of(way.points[-1].tolist())
    for before, here in zip(cells[:-1, :2], cells[1:], strict=True):
        moved = np.abs(here[:2] - before)
        assert moved.max() == 1
        if moved.min() == 1:
            beside = {tuple(here[2:4].tolist()), tuple(here[4:6].tolist())}
            assert beside == {(int(here[0]), int(before[1])), (int(before[0]), int(here[1]))}


def test_authority_ends_before_the_first_cell_that_is_not_known_free() -> None:
    known = np.ones((5, 9), np.bool_)
    straight = Polyline([(2, 0), (2, 8)])
    assert authority(straight, known) == 8.0
    known[2, 5] = False
    assert authority(straight, known) == pytest.approx(4.5 - STANDING_ROOM)
    assert authority(straight, known, start=2.0) == pytest.approx(4.5 - STANDING_ROOM)
    assert authority(straight, known, start=5.2) == 8.0, "its own cell counts as free"
    assert authority(straight, known, start=4.4999) == 4.4999, "never behind the robot"
    assert authority(Polyline([(2, 0), (2, -4)]), known) == pytest.approx(0.5 - STANDING_ROOM), "outside is closed"


@pytest.mark.parametrize("closed", [(2, 3), (3, 2)])
def test_authority_cuts_no_corner(closed: tuple[int, int]) -> None:
    known = np.ones((5, 5), np.bool_)
    diagonal = Polyline([(1, 1), (4, 4)])
    assert authority(diagonal, known) == diagonal.length
    known[closed] = False
    assert authority(diagonal, known) == pytest.approx(1.5 * math.sqrt(2) - STANDING_ROOM)


@pytest.mark.parametrize("points", [[], [[1, 2, 3]], [[0, 0], [0, math.nan]]])
def test_what_is_no_way_is_refused(points: list[list[float]]) -> None:
    with pytest.raises(InputError, match="n × 2 finite numbers"):
        Polyline(np.array(points))


def test_points_that_repeat_are_left_out() -> None:
    way = Polyline([(1, 1), (1, 1), (1, 3), (1, 3), (2, 3)])
    assert way.points.tolist() == [[1, 1], [1, 3], [2, 3]]
    assert way.arcs.tolist() == [0, 2, 3]
    assert way.cut(1.0).points.tolist() == [[1, 2], [1, 3], [2, 3]]
    assert way.cut(2.0).points.tolist() == [[1, 3], [2, 3]]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_points_closer_than_arc_lengths_can_tell_are_left_out() -> None:
    """Else a segment of no length is a bend of which nobody can tell how fast it may be driven."""
    way = Polyline([(0, 0), (0, 1), (1e-160, 1), (1, 1)])
    assert way.points.tolist() == [[0, 0], [0, 1], [1, 1]]
    assert way.arcs.tolist() == [0, 1, 2]
    straight = Polyline([(0, -0.25), (0, 0), (0, 1e-160), (0, 1)])
    drive = DifferentialDrive(0.5, 0.4, 1.5)
    motion, plain = (Motion.drive(each, drive, 9.0) for each in (straight, Polyline([(0, -0.25), (0, 0), (0, 1)])))
    assert motion is not None
    assert plain is not None
    assert (motion.end, motion.duration) == (plain.end, plain.duration)


def test_join_goes_on_along_the_way() -> None:
    way = Polyline([(1, 1), (1, 5), (5, 5)])
    assert join(way, (1.0, 2.5)).points.tolist() == [[1, 2.5], [1, 5], [5, 5]]
    assert join(way, (1.0, 5.0)).points.tolist() == [[1, 5], [5, 5]]
    assert join(way, (1.0 + NEAR / 2, 3.0)).points.tolist() == [[1 + NEAR / 2, 3], [1, 5], [5, 5]]
    twice = Polyline([(1, 1), (1, 5), (3, 5), (3, 3), (1, 3), (0, 3)])
    assert join(twice, (1.0, 3.0)).points.tolist() == [[1, 3], [0, 3]], "the later of two passes"


def test_join_from_beside_the_way_looks_ahead_but_not_through_a_wall() -> None:
    way = Polyline([(1, 0), (1, 8)])
    assert join(way, (2.0, 3.0), lookahead=1.5).points.tolist() == [[2, 3], [1, 4.5], [1, 8]]
    free = np.ones((4, 9), np.bool_)
    free[1, 4] = False
    around = Polyline([(1, 0), (1, 3), (3, 3), (3, 8)])
    assert join(around, (1.0, 5.0), free, lookahead=0.0).points.tolist() == [[1, 5], [3, 5], [3, 8]]
    assert join(Polyline([(1, 1)]), (1.0, 3.0)).points.tolist() == [[1, 3], [1, 1]]
