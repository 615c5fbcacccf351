"""Terms by themselves: bounds of a product, the mean of plans, and the plans that may be the slowest."""

from __future__ import annotations

import math

from codesign.ground.figures import Figure, Status
from codesign.laws import Monomial
from codesign.system.results.terms import ENERGY_OVER, Draw, Term, Terms, mean_of, worst_of


def figure(value: float, low: float, high: float) -> Figure:
    return Figure(value, "1", Status.ASSUMED, "a guess", low, high)


INPUTS = {"clock": figure(2, 1, 4), "cost": figure(3, 2, 5), "width": figure(4, 2, 8)}


def cycles(amount: float, where: str = "fpga") -> Term:
    return Term(amount, {"clock": -1}, where=where, what="run", seconds=amount / 2)


def units(amount: float) -> Term:
    return Term(amount, {"cost": 1}, where="host", what="run", seconds=3 * amount)


def test_bounds_of_a_product_stand_at_the_ends_that_raise_and_lower_it() -> None:
    product = Monomial(2.0, {"clock": -1, "cost": 1}, 9, ("width",))
    assert product.bounds(INPUTS) == (2 / 4 * 2 * 2, 2 / 1 * 5 * 5)


def test_a_clock_of_zero_makes_a_time_infinite() -> None:
    assert Monomial(1.0, {"clock": -1}).at({"clock": 0}) == math.inf


def test_the_mean_of_plans_adds_like_terms() -> None:
    mean = mean_of([(cycles(4), units(1)), (cycles(8),)])
    assert [(term.amount, term.seconds) for term in mean] == [(6.0, 3.0), (0.5, 1.5)]


def test_a_plan_below_another_in_every_term_is_never_the_slowest() -> None:
    slow, other, below = (cycles(9), units(1)), (cycles(1), units(2)), (cycles(4), cycles(4), units(1))
    assert worst_of([below, slow, other]) == (slow, other)
    assert worst_of([slow, below]) == (slow,)


def test_the_worst_of_several_plans_has_the_interval_of_the_greatest() -> None:
    plans = (cycles(8),), (units(2),)
    terms = Terms(inputs=INPUTS, times={"first_plan_s": plans}, draws=())
    assert terms.interval("first_plan_s") == (4.0, 10.0)


def test_energy_is_power_times_time() -> None:
    draws = (Draw(2.0, {}, where="fpga", when="always"), Draw(1.0, {"clock": 1}, where="fpga", when="busy"))
    terms = Terms(inputs=INPUTS, times={ENERGY_OVER: ((cycles(8), units(2)),)}, draws=draws)
    assert terms.plans("energy_j") == ((Monomial(16.0, {"clock": -1}), Monomial(8.0, {}), Monomial(4.0, {"cost": 1})),)
