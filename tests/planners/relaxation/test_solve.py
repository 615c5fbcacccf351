"""The relaxation: kernels against plain loops, closed forms, the theory of the method, and what it refuses."""

from __future__ import annotations

import math
import pickle
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from reference_relaxation import iterate

from codesign import maps
from codesign.ground.errors import InputError, MapError
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, Boundary, Method, Search
from codesign.planners.relaxation.plan import solve as solve_by_default
from codesign.planners.relaxation.plan.parameters import ACCELERATION
from codesign.planners.relaxation.plan.solve import diagonals

# The paper's convention: kernels and convergence do not depend on how a run ends (``test_relaxation_descents``).
solve = partial(solve_by_default, tolerance=PUBLISHED_TOLERANCE, boundary=Boundary.LOW_GOAL)

ITERATED = [method for method in Method if method is not Method.DIRECT]
FULL = [method for method in ITERATED if method is not Method.HALF_SWEEP_AM]


@st.composite
def problems(draw: st.DrawFn, side: int = 9) -> tuple[NDArray[np.bool_], tuple[int, int]]:
    rows, columns = draw(st.integers(1, side)), draw(st.integers(1, side))
    free = np.array(draw(st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns)))
    free = free.reshape(rows, columns)
    goal = draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))
    free[goal] = True
    return free, goal


accelerations = st.floats(0.05, 1.99)


def padded(free: NDArray[np.bool_], goal: tuple[int, int], boundary: Boundary) -> Any:
    """Values and movable nodes of the padded grid, as the paper sets them up."""
    wall, low = boundary.values
    values, movable = np.full((free.shape[0] + 2, free.shape[1] + 2), wall), np.pad(free, 1)
    values[goal[0] + 1, goal[1] + 1] = low
    movable[goal[0] + 1, goal[1] + 1] = False
    return values, movable


def chosen(method: Method, omega: float, r: float) -> dict[str, float]:
    takes = ACCELERATION[method]
    given = {"omega": omega} if takes[0] is not None else {}
    return given | ({"r": r} if takes[1] is not None else {})


@given(
    problems(), st.sampled_from(ITERATED), st.sampled_from(Boundary), accelerations, accelerations, st.integers(1, 6)
)
@settings(max_examples=examples(250))
def test_kernels_give_the_bits_of_the_plain_loops(
    problem: Any, method: Method, boundary: Boundary, omega: float, r: float, count: int
) -> None:
    free, goal = problem
    own = chosen(method, omega, r)
    solution = solve(free, [goal], method=method, boundary=boundary, max_iterations=count, **own)
    values, movable = padded(free, goal, boundary)
    colour = (np.indices(movable.shape).sum(0) + sum(goal)) % 2 == 0
    if method is Method.HALF_SWEEP_AM:
        movable = movable & colour
    before = values
    for _ in range(solution.iterations):
        before, values = values, iterate(values, movable, method, own.get("omega"), own.get("r"))
    seen = colour[1:-1, 1:-1] if method is Method.HALF_SWEEP_AM else np.ones_like(free)
    assert np.array_equal(solution.potential[seen], values[1:-1, 1:-1][seen])
    assert solution.change == np.abs(values - before).max() / boundary.scale
    assert solution.iterations == count or solution.change < 1e-15


def test_cutting_a_run_into_calls_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    module = sys.modules["codesign.planners.relaxation.plan.solve"]
    free = maps.rooms(20, 31, room=(9, 9), door=3, seed=4).free
    for method in ITERATED:
        monkeypatch.setattr(module, "_UPDATES_A_CALL", 1 << 26)
        whole = solve(free, [(1, 1)], method=method)
        monkeypatch.setattr(module, "_UPDATES_A_CALL", 1000)
        pieces = solve(free, [(1, 1)], method=method)
        assert pieces.potential.tobytes() == whole.potential.tobytes()
        assert pieces.iterations == whole.iterations > 3


@given(problems(7), st.sampled_from(Boundary))
@settings(max_examples=60)
def test_every_method_ends_at_the_dense_solution(problem: Any, boundary: Boundary) -> None:
    free, goal = problem
    values, movable = padded(free, goal, boundary)
    number = {(int(i), int(j)): k for k, (i, j) in enumerate(np.argwhere(movable))}
    matrix, right = 4.0 * np.eye(len(number)), np.zeros(len(number))
    for (i, j), k in number.items():
        for beside in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if beside in number:
                matrix[k, number[beside]] = -1.0
            else:
                right[k] += values[beside]
    exact = values.copy()
    for cell, value in zip(number, np.linalg.solve(matrix, right), strict=True):
        exact[cell] = value
    for method in FULL:
        found = solve(free, [goal], method=method, boundary=boundary, tolerance=1e-14)
        assert found.converged
        assert np.abs(found.potential - exact[1:-1, 1:-1]).max() < 1e-10 * boundary.scale
    # The direct solver leaves cells that no way joins to a goal at the value of obstacles, and so do exact sweeps.
    direct = solve(free, [goal], method="direct", boundary=boundary).potential
    assert np.abs(direct - exact[1:-1, 1:-1]).max() < 1e-12 * boundary.scale


@pytest.mark.parametrize("length", [2, 7, 40])
def test_one_cell_wide_corridor_has_a_closed_form(length: int) -> None:
    # 4 u(k) = u(k-1) + u(k+1) between the goal and the wall behind the last cell: a hyperbolic sine with cosh θ = 2.
    free = np.ones((1, length), np.bool_)
    theta = math.acosh(2.0)
    exact = [-math.sinh(theta * (length - k)) / math.sinh(theta * length) for k in range(length)]
    for method in ("gs", "sor", "mam", "direct"):
        potential = solve(free, [(0, 0)], method=method, tolerance=1e-15).potential
        assert potential[0] == pytest.approx(exact, rel=1e-9, abs=1e-13)
    direct = solve(free, [(0, 0)], method="direct").potential
    assert direct[0] == pytest.approx(exact, rel=1e-12), "small values keep their digits"


@given(problems(7), accelerations, accelerations)
@settings(max_examples=60)
def test_mean_contracts_in_the_energy_norm(problem: Any, omega: float, r: float) -> None:
    """The proof that AM and MAM converge for all parameters between 0 and 2 (``solve``), watched at work."""
    free, goal = problem
    exact = solve(free, [goal], method="direct").potential
    energies = []
    for count in (1, 2, 3, 5, 8):
        error = np.pad(solve(free, [goal], method="mam", omega=omega, r=r, max_iterations=count).potential - exact, 1)
        energies.append(sum(float((np.diff(error, axis=axis) ** 2).sum()) for axis in (0, 1)))
    assert all(late <= early * (1.0 + 1e-9) + 1e-25 for early, late in pairwise(energies))


@given(problems(), st.integers(1, 5), accelerations)
@settings(max_examples=60)
def test_identities_between_methods_and_boundaries(problem: Any, count: int, omega: float) -> None:
    free, goal = problem

    def run(method: str, **own: Any) -> NDArray[np.float64]:
        return solve(free, [goal], method=method, max_iterations=count, **own).potential

    assert np.array_equal(run("mam", omega=omega, r=omega), run("am", omega=omega))
    assert np.array_equal(run("sor", omega=1.0), run("gs"))
    assert np.array_equal(run("mam", boundary="high_goal"), -run("mam"))
    falling = solve(free, [goal], method="gs", max_iterations=count + 1).potential
    assert (falling <= run("gs")).all(), "from obstacles down to the goal nothing rises"


def test_diagonals_hold_every_node_once() -> None:
    for rows, columns in ((3, 3), (3, 9), (8, 4), (17, 5)):
        layout = diagonals(rows, columns)
        assert sorted(layout.position.ravel().tolist()) == list(range(rows * columns))


def test_stalled_runs_end_and_say_so() -> None:
    free = np.ones((40, 40), np.bool_)
    stalled = solve(free, [(20, 20)], method="sor", omega=1.9, boundary="high_walls", tolerance=1e-17)
    assert stalled.stagnated
    assert not stalled.converged
    assert 1e-17 <= stalled.change < 1e-13
    assert stalled.iterations < 5000
    # Gauss-Seidel settles bit for bit, so the least tolerance is met.
    settled = solve(free, [(20, 20)], method="gs", boundary="high_walls", tolerance=1e-300)
    assert settled.converged != settled.stagnated
    cut = solve(free, [(20, 20)], method="gs", max_iterations=7)
    assert (cut.iterations, cut.converged, cut.stagnated) == (7, False, False)


def test_a_run_that_is_slow_is_not_taken_for_stalled() -> None:
    free = np.ones((30, 30), np.bool_)
    slow = solve(free, [(15, 15)], method="sor", omega=0.02, tolerance=1e-9)
    assert slow.converged
    assert slow.iterations > 10_000


def test_half_sweeps_close_narrow_passages_and_need_one_colour() -> None:
    narrow, wide = np.zeros((7, 21), np.bool_), np.zeros((7, 21), np.bool_)
    for free in (narrow, wide):
        free[1:6, 1:8] = True
        free[1:6, 13:20] = True
    narrow[3, 8:13] = True
    wide[2:5, 8:13] = True
    for free, open_ in ((narrow, False), (wide, True)):
        potential = solve(free, [(3, 3)], method="half_sweep_am").potential
        assert bool((potential[1:6, 14:20] < 0.0).any()) is open_
        assert Search(potential, free, [(3, 3)]).follow((3, 18)).arrived is open_
    with pytest.raises(InputError, match="one colour"):
        solve(wide, [(3, 3), (3, 4)], method="half_sweep_am")
    exact = solve(wide, [(3, 3)], method="direct").potential
    half = solve(wide, [(3, 3)], method="half_sweep_am").potential
    assert np.abs(half - exact).max() < 0.15


def test_maps_without_anything_to_compute() -> None:
    alone = np.array([[True]])
    for method in Method:
        solution = solve(alone, [(0, 0)], method=method)
        assert solution.potential.tolist() == [[-1.0]]
        assert solution.converged
    assert pickle.loads(pickle.dumps(solution)).method is Method.DIRECT


FREE = np.ones((6, 6), np.bool_)
BLOCKED = np.array([[True, False], [True, True]])


@pytest.mark.parametrize(
    ("free", "goals", "options", "where", "words"),
    [
        (FREE, [(1, 1)], {"omega": 2.0}, "omega", "outside of (0, 2)"),
        (FREE, [(1, 1)], {"omega": 0.0}, "omega", "outside of (0, 2)"),
        (FREE, [(1, 1)], {"omega": -1}, "omega", "outside of (0, 2)"),
        (FREE, [(1, 1)], {"omega": math.nan}, "omega", "outside of (0, 2)"),
        (FREE, [(1, 1)], {"omega": "1.9"}, "omega", "not a number"),
        (FREE, [(1, 1)], {"omega": True}, "omega", "not a number"),
        (FREE, [(1, 1)], {"method": "mam", "r": 2.5}, "r", "outside of (0, 2)"),
        (FREE, [(1, 1)], {"method": "am", "r": 1.5}, "r", "takes no r"),
        (FREE, [(1, 1)], {"method": "gs", "omega": 1.5}, "omega", "takes no omega"),
        (FREE, [(1, 1)], {"method": "ssor"}, "method", "unknown"),
        (FREE, [(1, 1)], {"tolerance": 0.0}, "tolerance", "tolerance"),
        (FREE, [(1, 1)], {"tolerance": math.inf}, "tolerance", "tolerance"),
        (FREE, [(1, 1)], {"boundary": "neumann"}, "boundary", "unknown"),
        (FREE, [(1, 1)], {"max_iterations": 0}, "max_iterations", "0 iterations"),
        (FREE, [(1, 1)], {"max_iterations": 2.5}, "max_iterations", "2.5 iterations"),
        (FREE, [(6, 0)], {}, None, "outside of the map"),
        (FREE, [], {}, None, "there is no goal"),
        (BLOCKED, [(0, 1)], {}, None, "on an obstacle"),
        (FREE.astype(float), [(1, 1)], {}, None, "bool array"),
        (np.ones((1025, 1025), np.bool_), [(1, 1)], {"method": "direct"}, "method", "direct solver"),
    ],
)
def test_bad_input_is_told(free: Any, goals: Any, options: dict[str, Any], where: str | None, words: str) -> None:
    with pytest.raises((InputError, MapError)) as told:
        solve(free, goals, **options)
    assert words in str(told.value)
    assert told.value.where == where
    assert pickle.loads(pickle.dumps(told.value)).args == told.value.args
