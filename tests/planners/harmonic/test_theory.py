"""Closed forms of the paper, against each other, against linear algebra, and as an oracle for the field."""

import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_harmonic import relax_reference

from codesign.ground.errors import InputError
from codesign.maps import reachable
from codesign.planners.harmonic.paper import theory
from codesign.planners.harmonic.plan.precision import RequiredPrecision, required_precision


def corridor_value(i, length):
    """x_i of the corridor of section 3.2.2, exactly: the solution of x_i = (x_(i−1) + x_(i+1)) / 4."""
    values = theory.corridor(length)
    return Fraction(values[i], values[length])


@given(st.integers(2, 60))
def test_corridor_solves_its_equation(length):
    x = [corridor_value(i, length) for i in range(length + 1)]
    assert (x[0], x[-1]) == (0, 1)
    assert all(4 * x[i] == x[i - 1] + x[i + 1] for i in range(1, length))


@given(st.integers(1, 400), st.data())
def test_corridor_closed_form_is_the_exact_value(length, data):
    i = data.draw(st.integers(0, length))
    exact = corridor_value(i, length)
    assert theory.corridor_estimate(i, length) == pytest.approx(float(exact), rel=1e-11, abs=0.0)


@given(st.integers(1, 200))
def test_corridor_bits_are_the_least_that_tell_the_first_cell_from_the_obstacle(length):
    bits, first = theory.corridor_bits(length), corridor_value(1, length)
    assert first >= Fraction(1, 2**bits)
    assert bits == 0 or first < Fraction(1, 2 ** (bits - 1))


def test_corridor_bits_grow_with_the_logarithm_of_the_root():
    assert theory.corridor_bits(1000) / 1000 == pytest.approx(math.log2(2 + math.sqrt(3)), rel=2e-3)


@settings(max_examples=25)
@given(st.integers(1, 20), st.integers(1, 150))
def test_corridor_is_an_oracle_for_the_relaxed_field(length, precision):
    # Floor loses at most 3/4 at a node and w = (w + w)/4 + 1 is at most 2, so 2^p·x − h lies in 0..1.5.
    free = np.ones((1, length), bool)
    result = relax_reference(free, [(0, length - 1)], block=(1, length), iterations=10**6, schedule=[precision])
    for i in range(1, length + 1):
        loss = corridor_value(i, length) * 2**precision - int(result.values[0, i - 1])
        assert 0 <= loss <= Fraction(3, 2)


@pytest.mark.parametrize(("rows", "columns"), [(3, 3), (5, 8), (12, 7)])
def test_gamma_is_the_greatest_eigenvalue_inside_the_rectangle(rows, columns):
    def path(intervals):
        return np.eye(intervals - 1, k=1) + np.eye(intervals - 1, k=-1)

    step = np.kron(path(rows), np.eye(columns - 1)) + np.kron(np.eye(rows - 1), path(columns))
    assert theory.gamma(rows, columns) == pytest.approx(np.linalg.eigvalsh(step / 4).max(), rel=1e-12)


def noise_gain_of_large(rows, columns):
    """Equation (5)."""
    return 4 / (math.pi**2 * (1 / rows**2 + 1 / columns**2))


@given(st.integers(2, 10**5), st.integers(2, 10**5))
def test_noise_gain_is_the_inverse_of_one_minus_gamma(rows, columns):
    gain = theory.noise_gain(rows, columns)
    # 1 − γ in doubles keeps an error of about 2^-53, which K² multiplies.
    assert 1 / gain == pytest.approx(1 - theory.gamma(rows, columns), rel=1e-9, abs=1e-15)
    assert noise_gain_of_large(rows, columns) <= gain * (1 + 1e-12)


def test_equation_5_nears_the_gain_on_large_maps():
    assert noise_gain_of_large(500, 300) == pytest.approx(theory.noise_gain(500, 300), rel=1e-4)


@given(st.floats(1e-12, 0.99), st.floats(1, 1e6), st.floats(1e-3, 10))
def test_last_precision_meets_its_error_with_equality(error, gain, margin):
    bits = theory.last_precision(error, gain, margin)
    assert (1 + margin) * gain * 2.0**-bits == pytest.approx(error, rel=1e-9)
    assert theory.last_precision(1 - 1e-15, gain, margin) == pytest.approx(
        theory.first_precision(gain, margin), abs=1e-9
    )


def test_iterations_are_affine_in_bits_with_slope_k_log_2():
    gain, margin = theory.noise_gain(36, 66), 0.5
    for estimate in (theory.first_iterations, theory.next_iterations):
        slopes = np.diff([estimate(bits, gain, margin) for bits in (8, 16, 24)]) / 8
        assert slopes == pytest.approx(gain * math.log(2))
    shift = theory.first_iterations(8, gain, margin, 0.25) - theory.first_iterations(8, gain, margin)
    assert shift == pytest.approx(-2 * gain * math.log(2))
    assert theory.next_iterations(7, gain, 1.0) == pytest.approx(8 * gain * math.log(2))


@given(st.integers(1, 40))
def test_equation_6_halves_the_time_with_many_equal_stages(stages):
    schedule = [1000.0 * i / stages for i in range(1, stages + 1)]
    leading = theory.stages_time(schedule, 0, 1, 0, 1) / theory.stages_time([1000.0], 0, 1, 0, 1)
    assert leading == pytest.approx(theory.increasing_precision_ratio(stages))


def test_equation_6_term_by_term():
    assert theory.stages_time([4, 10], a=3, b=2, alpha=5, beta=7) == (3 + 2 * 4) * (5 + 28) + (3 + 12) * 75


@pytest.mark.parametrize(
    "call",
    [
        lambda: theory.corridor(0),
        lambda: theory.corridor_estimate(-1, 4),
        lambda: theory.gamma(0, 4),
        lambda: theory.noise_gain(4, 0),
        lambda: theory.first_precision(0.0, 1.0),
        lambda: theory.first_precision(10.0, math.nan),
        lambda: theory.last_precision(0.0, 10.0, 1.0),
        lambda: theory.first_iterations(8, 10.0, 1.0, 0.0),
        lambda: theory.stages_time([], 1, 1, 1, 1),
        lambda: theory.stages_time([8, 8], 1, 1, 1, 1),
        lambda: theory.increasing_precision_ratio(0),
    ],
)
def test_impossible_arguments_are_refused(call):
    with pytest.raises(InputError):
        call()


@st.composite
def small_maps(draw):
    rows, columns = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    free = np.array(draw(st.lists(st.booleans(), min_size=rows * columns, max_size=rows * columns))).reshape(
        rows, columns
    )
    goal = draw(st.integers(0, rows * columns - 1))
    free.ravel()[goal] = True
    return free, [divmod(goal, columns)]


@settings(max_examples=16)
@given(small_maps())
def test_required_precision_is_that_of_trying_every_one(problem):
    free, goals = problem
    required = required_precision(free, goals, survey=True)
    rows, columns = free.shape
    counts = {}
    for precision in range(1, required.certified + 4):
        result = relax_reference(free, goals, block=(rows, columns), iterations=10**6, schedule=[precision])
        counts[precision] = result.local_maxima - (free & ~reachable(free, goals)).sum()
    assert required.least == min(p for p, maxima in counts.items() if maxima == 0)
    assert all(counts[p] > 0 for p in range(1, required.first_candidate))
    assert all(counts[p] == 0 for p in counts if p >= required.certified)
    assert dict(required.local_maxima) == {p: counts[p] for p in range(required.first_candidate, required.certified)}


@pytest.mark.parametrize("length", [2, 5, 40, 300])
def test_required_precision_of_a_corridor_is_about_its_closed_form(length):
    required = required_precision(np.ones((1, length), bool), [(0, length - 1)])
    # A way up needs x_2 > 0 alone: log2(2 + √3) = 1.9 bits less than telling x_1 from the obstacle.
    assert theory.corridor_bits(length) - required.least in (1, 2)


def test_more_precision_may_do_harm():
    required = required_precision(np.ones((5, 3), bool), [(1, 0), (3, 2)], survey=True)
    assert (required.least, required.relapses) == (3, (4,))
    assert required.certified > 4


def test_required_precision_beyond_the_limit_is_none():
    required = required_precision(np.ones((1, 700), bool), [(0, 0)])
    assert required.least is None
    assert required.certified is None
    assert required.first_candidate > 1023
    assert required.relapses == ()


def test_no_precision_suffices_where_the_real_solution_is_level():
    free = np.ones((3, 3), bool)
    free[0, 2] = free[2, 0] = False
    required = required_precision(free, [(0, 0), (2, 2)], tries=5)
    assert (required.least, required.certified) == (None, None)
    assert list(required.local_maxima.values()) == [1] * 5


def test_required_precision_of_a_map_of_goals_is_one_bit():
    assert required_precision(np.ones((1, 1), bool), [(0, 0)]).least == 1
    assert required_precision(np.ones((1, 2), bool), [(0, 0), (0, 1)]).least == 1


def test_required_precision_refuses_impossible_bounds():
    for arguments in ({"limit": 0}, {"limit": 1024}, {"tries": 0}):
        with pytest.raises(InputError):
            required_precision(np.ones((1, 2), bool), [(0, 0)], **arguments)


def test_relapses_are_the_precisions_above_the_least_that_fail_again():
    required = RequiredPrecision(5, 9, 3, {3: 4, 4: 1, 5: 0, 6: 2, 7: 0, 8: 0}, 1023)
    assert required.relapses == (6,)
    assert pickle.loads(pickle.dumps(required)) == required
