"""Whether a design fits at every value of its clock limit and of its demand."""

from __future__ import annotations

import pytest
from shipped_plans import design, result_of

from codesign.ground.figures import Figure, Status
from codesign.system.results.result import Clock, Reason, Result
from codesign.system.verdicts import fit_verdict
from codesign.system.verdicts.fits import ends_text


def limited(low: float, value: float, high: float, hz: int) -> Result:
    """A design at a clock of ``hz`` with a clock limit."""
    limit = Figure(value, "Hz", Status.ASSUMED, "a law of another family", low, high)
    return result_of(design("zynq", "breadth-first")).model_copy(update={"clock": Clock(hz=hz, limit=limit)})


@pytest.mark.parametrize(("hz", "fits"), [(90, "yes"), (100, "uncertain"), (180, "uncertain"), (210, "no")])
def test_a_declared_clock_against_the_interval_of_its_limit(hz: int, fits: str) -> None:
    fit = fit_verdict(limited(90.0, 150.0, 200.0, hz))
    assert fit.fits == fits
    if fits != "yes":
        assert (fit.decides, fit.demand, fit.limit) == ("clock", (hz, hz), (90.0, 200.0))
        assert fit.figure is not None
        assert fit.figure.source == "a law of another family"


def test_a_resource_whose_demand_has_an_interval() -> None:
    result = result_of(design("zynq", "breadth-first"))
    use = result.resources[0]
    wide = Figure(100, "1", Status.ASSUMED, "a guess", 50, use.budget + 1)
    item = use.items[0].model_copy(update={"figure": wide})
    moved = result.model_copy(update={"resources": (use.model_copy(update={"items": (item,)}),)})
    fit = fit_verdict(moved)
    assert (fit.fits, fit.decides, fit.figure) == ("uncertain", use.resource, wide)


@pytest.mark.parametrize("hz", [91, 100, 150, 180, 199])
def test_a_verdict_changes_where_demand_and_limit_meet(hz: int) -> None:
    """At the named value of a limit, the clock is the limit; at that of a demand, the sum is the budget."""
    assert fit_verdict(limited(90.0, 150.0, 200.0, hz)).flips_at == hz
    result = result_of(design("zynq", "breadth-first"))
    use = result.resources[0]
    first, second = (use.items[0], use.items[0].model_copy(update={"figure": Figure(hz, "1", Status.MEASURED, "")}))
    wide = Figure(100, "1", Status.ASSUMED, "a guess", 50, use.budget + 1)
    items = first.model_copy(update={"figure": wide}), second
    moved = result.model_copy(update={"resources": (use.model_copy(update={"items": items}),)})
    assert fit_verdict(moved).flips_at == use.budget - hz


def test_a_bound_that_is_broken_is_certain() -> None:
    reason = Reason(kind="bound", name="word depth", demand=9, limit=8, gap=1, unit="bits")
    result = result_of(design("zynq", "breadth-first")).model_copy(update={"reasons": (reason,), "feasible": False})
    assert (fit_verdict(result).fits, fit_verdict(result).decides) == ("no", "word depth")


def test_software_fits() -> None:
    assert fit_verdict(result_of(design("pc-epyc", "floor-plan"))).fits == "yes"


@pytest.mark.parametrize("alone", [True, False])
def test_the_value_at_which_it_changes_is_of_the_demand_or_of_one_item_of_it(alone: bool) -> None:
    """A value outside of the printed interval is never said to be that of the whole."""
    use = result_of(design("zynq", "breadth-first")).resources[0]
    rest = use.budget // 2
    wide = Figure(100, "1", Status.ASSUMED, "a guess", 50, use.budget)
    exact = Figure(rest, "1", Status.PUBLISHED, "counted")
    items = tuple(use.items[0].model_copy(update={"figure": each}) for each in (wide, exact)[: 1 + (not alone)])
    moved = use.model_copy(update={"items": items, "budget": use.budget - 1})
    result = result_of(design("zynq", "breadth-first")).model_copy(update={"resources": (moved,)})
    text = ends_text(fit_verdict(result))
    taken = use.budget - 1 - (0 if alone else rest)
    words = "it changes at" if alone else "it changes where one item of it takes"
    assert f"; {words} {taken:,.0f} (assumed 100)" in text
