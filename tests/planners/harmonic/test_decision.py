"""The triangle rule in plain integers against the kernels over limbs, at any precision."""

import math
import pickle

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_harmonic import exact_direction, local_maxima, relax_reference, share_reaching_goal

from codesign.ground.errors import CodesignError, InputError, MapError
from codesign.maps import reachable
from codesign.planners.harmonic.plan import Field
from codesign.planners.harmonic.plan.trajectory import Rule, best_neighbours, directions

SIDES = ((-1, 0), (0, 1), (1, 0), (0, -1))


@st.composite
def fields(draw):
    """Values that tie often, differ in their last bits alone, borrow through limbs, or are anything."""
    rows, columns = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    precision = draw(st.sampled_from([3, 62, 63, 64, 200, 300]))
    top = 1 << precision
    base = draw(st.integers(0, top))
    limbs = st.lists(st.sampled_from([0, 1, 2**64 - 1]), min_size=1, max_size=5)
    value = st.one_of(
        limbs.map(lambda parts: sum(part << 64 * k for k, part in enumerate(parts)) % (top + 1)),
        st.integers(0, min(top, 3)),
        st.integers(-2, 2).map(lambda step: min(max(base + step, 0), top)),
        st.integers(0, top),
    )
    values = np.empty((rows, columns), object)
    for cell in np.ndindex(rows, columns):
        values[cell] = draw(value)
    cells = st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns)
    free = np.array(draw(cells)).reshape(rows, columns)
    values[~free] = 0
    return Field.from_ints(values, precision), free


def at(values, row, column):
    inside = 0 <= row < values.shape[0] and 0 <= column < values.shape[1]
    return values[row, column] if inside else 0


@settings(max_examples=examples(300))
@given(fields(), st.booleans())
def test_directions_are_the_exact_rule_normalised(problem, only_ascending):
    field, free = problem
    values = field.to_ints()
    rule = Rule.ASCENDING_TRIANGLE if only_ascending else Rule.TRIANGLE
    vectors = directions(field, free, rule)
    for row, column in np.ndindex(values.shape):
        if not free[row, column]:
            assert (vectors[row, column] == 0).all()
            continue
        exact = exact_direction(values, row, column, only_ascending=only_ascending)
        # One common shift keeps the ratio while the integers come into the range of doubles.
        shift = max(max(map(abs, exact)).bit_length() - 200, 0)
        down, right = (float((abs(part) >> shift) * (1 if part > 0 else -1)) for part in exact)
        length = math.hypot(down, right) or 1.0
        assert vectors[row, column] == pytest.approx([down / length, right / length], abs=1e-14)


@settings(max_examples=examples(300))
@given(fields())
def test_the_chosen_triangle_has_the_greatest_sum_of_squares(problem):
    field, free = problem
    values = field.to_ints()
    for row, column in np.argwhere(free):
        here = values[row, column]
        falls = [here - at(values, row + down, column + right) for down, right in SIDES]
        greatest = max(falls[k] ** 2 + falls[(k + 1) % 4] ** 2 for k in range(4))
        down, right = exact_direction(values, row, column)
        assert down**2 + right**2 == greatest
        # Each component is the slope to a neighbour on its axis, signed to point uphill on that side.
        assert down in (falls[0], -falls[2])
        assert right in (-falls[1], falls[3])


@settings(max_examples=examples(200))
@given(fields())
def test_best_neighbours_are_the_first_of_the_greatest(problem):
    field, free = problem
    values = field.to_ints()
    best = best_neighbours(field, free)
    moves = directions(field, free, Rule.NEIGHBOUR)
    for row, column in np.ndindex(values.shape):
        around = [at(values, row + down, column + right) for down, right in SIDES]
        rises = free[row, column] and max(around) > values[row, column]
        assert best[row, column] == (around.index(max(around)) if rises else -1)
        assert tuple(moves[row, column]) == (SIDES[best[row, column]] if rises else (0, 0))


def test_ties_go_north_and_east():
    values = np.array([[0, 3, 0], [3, 5, 3], [0, 3, 0]])
    assert exact_direction(values, 1, 1) == (2, -2)  # away from the lower north and east
    values = np.array([[0, 7, 0], [8, 5, 6], [0, 7, 0]])
    assert exact_direction(values, 1, 1) == (-2, -3)


def test_the_published_rule_points_at_a_wall_in_a_narrow_corridor():
    values = np.array([[1, 4, 15]])
    assert exact_direction(values, 0, 1) == (4, 11)
    assert exact_direction(values, 0, 1, only_ascending=True) == (0, 11)


def test_the_last_of_300_bits_decides():
    values = np.full((3, 3), 1 << 299, object)
    values[1, 2] += 1
    field = Field.from_ints(values, 300)
    free = np.ones((3, 3), bool)
    assert best_neighbours(field, free)[1, 1] == 1
    assert tuple(directions(field, free)[1, 1]) == (0, 1)


def test_a_borrow_runs_through_equal_limbs():
    # East: 2^128 − 1 borrows through a limb of equal halves; south is the yardstick.
    values = np.array([[(5 << 64) + 1, (1 << 128) + (5 << 64)], [(1 << 127) + (5 << 64), 0]], object)
    vectors = directions(Field.from_ints(values, 190), np.ones((2, 2), bool))[0, 0]
    assert vectors[1] / vectors[0] == pytest.approx(2.0)


@st.composite
def problems(draw):
    rows, columns = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    cells = st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns)
    free = np.array(draw(cells)).reshape(rows, columns)
    picked = draw(st.lists(st.integers(0, rows * columns - 1), min_size=1, max_size=3, unique=True))
    free.ravel()[picked] = True
    return free, [divmod(cell, columns) for cell in picked]


@settings(max_examples=examples(100))
@given(problems(), st.integers(1, 40))
def test_a_share_below_one_means_local_maxima(problem, precision):
    free, goals = problem
    rows, columns = free.shape
    result = relax_reference(free, goals, block=(rows, columns), iterations=10**6, schedule=[precision])
    maxima = local_maxima(result.field, free, goals)
    pockets = free & ~reachable(free, goals)
    assert maxima.sum() + pockets.sum() == result.local_maxima
    share = share_reaching_goal(result.field, free, goals)
    assert (share == 1.0) == (not maxima.any())
    # Walked cell by cell: the slow twin of pointer jumping.
    values = result.values
    arrived = total = 0
    for cell in np.argwhere(result.reachable):
        row, column = cell
        if (row, column) in goals:
            continue
        total += 1
        while (row, column) not in goals:
            around = [(row + down, column + right) for down, right in SIDES]
            best = max(around, key=lambda other: at(values, *other))
            if at(values, *best) <= values[row, column]:
                break
            row, column = best
        arrived += (row, column) in goals
    assert share == (arrived / total if total else 1.0)


def test_what_cannot_be_decided_on_is_refused():
    field = Field.from_ints(np.zeros((2, 2), np.int64), 4)
    free = np.ones((2, 2), bool)
    with pytest.raises(InputError, match=r"\(2, 2\)"):
        directions(field, np.ones((2, 3), bool))
    with pytest.raises(MapError):
        directions(field, free.astype(int))
    with pytest.raises(InputError, match="did you mean triangle") as caught:
        directions(field, free, "triangel")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    for goals in ([], [(5, 5)]):
        with pytest.raises(CodesignError):
            local_maxima(field, free, goals)
