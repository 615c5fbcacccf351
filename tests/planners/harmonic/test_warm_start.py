"""Bounds on the converged field hold at every precision, and starting from one changes time alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_harmonic import relax_reference

from codesign.ground.errors import InputError, MapError
from codesign.maps.generate import maze, rooms
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan import warm_start as module
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.warm_start import FieldBounds, warm_start


@st.composite
def problems(draw, side=7):
    rows, columns = draw(st.integers(1, side)), draw(st.integers(1, side))
    cells = st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns)
    free = np.array(draw(cells)).reshape(rows, columns)
    picked = draw(st.lists(st.integers(0, rows * columns - 1), min_size=1, max_size=3, unique=True))
    free.ravel()[picked] = True
    return free, [divmod(cell, columns) for cell in picked]


def from_zero(free, goals, precision):
    rows, columns = free.shape
    return relax_reference(free, goals, block=(rows, columns), iterations=10**6, schedule=[precision])


@settings(max_examples=60)
@given(problems(), st.lists(st.integers(1, 300), min_size=1, max_size=3))
def test_bounds_hold_at_any_precision_in_any_order(problem, precisions):
    free, goals = problem
    bounds = FieldBounds(free, goals)
    for precision in precisions:
        exact = from_zero(free, goals, precision).values
        assert (bounds.lower(precision).to_ints() <= exact).all()
        assert (exact <= bounds.upper(precision).to_ints()).all()


@settings(max_examples=40)
@given(problems(), st.integers(1, 300), st.sampled_from(["sound", "published"]))
def test_a_warm_start_ends_in_the_same_bits(problem, precision, termination):
    free, goals = problem
    rows, columns = free.shape
    warm = relax(
        free,
        goals,
        block=(rows, columns),
        iterations=1000,
        schedule=[precision],
        start=warm_start(free, goals, precision),
        termination=termination,
    )
    cold = from_zero(free, goals, precision)
    assert (warm.values == cold.values).all()
    assert warm.total_iterations <= cold.total_iterations


def noise(free, goals):
    """w of w = avg(w) + 1, by a dense solve."""
    rows, columns = free.shape
    inside = free.copy()
    inside[tuple(np.array(goals).T)] = False
    index = {tuple(cell): k for k, cell in enumerate(np.argwhere(inside))}
    matrix = np.eye(len(index))
    for (row, column), k in index.items():
        for other in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
            if other in index:
                matrix[k, index[other]] -= 0.25
    w = np.zeros((rows, columns))
    w[inside] = np.linalg.solve(matrix, np.ones(len(index)))
    return w


@pytest.mark.parametrize("precision", [12, 53, 64, 255, 1023])
def test_bounds_are_as_tight_as_the_rounding_allows(precision):
    grid = rooms(20, 24, room=(9, 11), door=2, seed=4)
    goals = [tuple(int(i) for i in np.argwhere(grid.free)[3])]
    bounds = FieldBounds(grid.free, goals)
    gap = (bounds.upper(precision).to_ints() - bounds.lower(precision).to_ints()).astype(float)
    # A start of 0, or one from doubles alone above 53 bits, would be off by up to 2^p and 2^(p - 53).
    assert (gap <= 0.8 * noise(grid.free, goals) + 2).all()
    exact = converged_field(grid.free, goals, precision, bounds=bounds).to_ints()
    assert (bounds.lower(precision).to_ints() <= exact).all()
    assert (exact <= bounds.upper(precision).to_ints()).all()


def test_a_warm_start_saves_iterations_where_many_are_needed():
    grid = maze(33, 33, corridor=3, seed=2)
    goals = [tuple(int(i) for i in np.argwhere(grid.free)[0])]
    shape = {"block": (33, 33), "iterations": 10**6, "schedule": [200]}
    cold = relax(grid.free, goals, **shape)
    warm = relax(grid.free, goals, start=warm_start(grid.free, goals, 200), **shape)
    assert warm.field == cold.field
    assert warm.total_iterations * 10 < cold.total_iterations


@pytest.mark.parametrize("error", [1e-6, 0.3, 1.5, -0.9])
def test_bounds_hold_however_badly_the_solver_rounds(monkeypatch, error):
    exact_solver = module._factorise

    def sloppy(neighbours):
        solve = exact_solver(neighbours)
        wrong = 1.0 + error * np.cos(np.arange(neighbours.shape[1]))
        return lambda right: solve(right) * wrong

    monkeypatch.setattr(module, "_factorise", sloppy)
    grid = maze(13, 13, corridor=2, seed=5)
    goals = [(1, 1)] if grid.free[1, 1] else [tuple(int(i) for i in np.argwhere(grid.free)[0])]
    bounds = FieldBounds(grid.free, goals)
    for precision in (10, 70):
        exact = from_zero(grid.free, goals, precision).values
        assert (bounds.lower(precision).to_ints() <= exact).all()
        assert (exact <= bounds.upper(precision).to_ints()).all()


def test_certificates_refuse_what_is_slightly_wrong():
    # One cell beside a goal: u = 1/4. At p = 1 it is 1/2, and floor leaves 0; at p = 2 it is 1 exactly.
    bounds = FieldBounds(np.ones((1, 2), bool), [(0, 1)])
    bounds._noise *= 0.1  # too small a share of the rounding is taken off
    assert bounds.lower(1).to_ints()[0, 0] == 0
    bounds.upper(2)
    bounds._values -= 1
    bounds._noise *= 0.0
    assert bounds.upper(2).to_ints()[0, 0] >= 1


def test_cells_that_no_way_leads_to_stay_zero():
    free = np.array([[True, True, False, True, True]])
    bounds = FieldBounds(free, [(0, 0)])
    assert bounds.lower(8).to_ints().tolist() == [[256, 64, 0, 0, 0]]
    assert bounds.upper(8).to_ints().tolist() == [[256, 64, 0, 0, 0]]


def test_a_map_of_goals_alone_has_nothing_to_solve():
    bounds = FieldBounds(np.ones((1, 2), bool), [(0, 0), (0, 1)])
    assert bounds.lower(3).to_ints().tolist() == bounds.upper(3).to_ints().tolist() == [[8, 8]]


@pytest.mark.parametrize("precision", [0, 1024])
def test_precisions_beyond_the_word_are_refused(precision):
    with pytest.raises(InputError, match=str(precision)):
        warm_start(np.ones((1, 2), bool), [(0, 0)], precision)


def test_a_goal_on_an_obstacle_is_refused():
    with pytest.raises(MapError):
        warm_start(np.zeros((1, 2), bool), [(0, 0)], 8)
