"""The fit of a host's costs to the times of plans, and load and jitter, with clocks that are injected."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import yaml

from codesign.hardware.calibrate.host_costs import MeasuredHost, host_document, host_text, processor_text
from codesign.hardware.calibrate.host_fit import (
    TimedPlan,
    Timing,
    all_timed,
    disturbance_of,
    fit_programs,
    plans_on,
    questions,
    time_plans,
)
from codesign.inputs.library import HOSTS

TRUE = {"cell": 6e-9, "wall": 9e-9, "map": 2e-10}
FIRST = {"cell": 1e-9, "wall": 1e-9, "map": 1e-10}


def maps(random: np.random.Generator, count: int, spread: float, noise: float, runs: int = 20) -> list[Timing]:
    """Timings of true costs, with a factor of each map and one of each run."""
    timings = []
    for number in range(count):
        cells = int(random.integers(10_000, 500_000))
        units = {"cell": int(cells * random.uniform(0.2, 1)), "wall": int(cells * random.uniform(0, 0.6)), "map": cells}
        seconds = sum(TRUE[each] * units[each] for each in units) * math.exp(random.normal(0, spread))
        each = tuple(seconds * np.exp(random.normal(0, noise, runs)))
        timings.append(Timing("search", f"map {number}", units, each, each))
    return timings


def test_costs_that_explain_every_time_are_found() -> None:
    (fit,) = fit_programs(maps(np.random.default_rng(1), 12, 0.0, 0.0), FIRST, "here")
    for residual in fit.residuals:
        assert residual.predicted == pytest.approx(residual.measured, rel=0.02)
    assert fit.costs["cell"].value == pytest.approx(TRUE["cell"], rel=0.1)
    assert fit.error < 0.05


@pytest.mark.parametrize(("spread", "noise"), [(0.05, 0.01), (0.2, 0.05), (0.02, 0.2)])
def test_a_run_on_one_more_map_lies_in_the_interval(spread: float, noise: float) -> None:
    """In 95 % of the draws: each has a fit of its own."""
    inside, random = [], np.random.default_rng(7)
    for _ in range(100):
        (fit,) = fit_programs(maps(random, 10, spread, noise), FIRST, "here")
        for one in maps(random, 4, spread, noise, runs=1):
            low, high = (sum(fit.costs[each].interval[end] * one.units[each] for each in one.units) for end in (0, 1))
            inside.append(low <= one.seconds <= high)
    assert np.mean(inside) >= 0.93


def test_the_interval_is_no_wider_than_the_maps_differ() -> None:
    """A quiet machine on which one cost explains all has a narrow interval: it is not wide by rule."""
    (fit,) = fit_programs(maps(np.random.default_rng(3), 12, 0.01, 0.005), FIRST, "here")
    low, high = fit.costs["cell"].interval
    assert high / low < 1.2


def test_a_kernel_that_was_fitted_is_held_for_the_next_program() -> None:
    rows = maps(np.random.default_rng(2), 8, 0.0, 0.0)
    other = [
        Timing("other", row.map, {**row.units, "more": 1000}, *((row.seconds + 1000 * 5e-7,) * 5,) * 2) for row in rows
    ]
    first, second = fit_programs([*rows, *other], FIRST, "here")
    assert set(second.costs) == {"more"}
    assert second.costs["more"].value == pytest.approx(5e-7, rel=0.1)
    assert "cell" in first.costs


def test_load_and_jitter_are_of_the_two_clocks() -> None:
    """Each run takes 1 s of the processor; every other one waits 1 s for it: a third of the wall is not ours."""
    wall, busy = (1.0, 2.0) * 10, (1.0,) * 20
    found = disturbance_of([Timing("p", "m", {"cell": 1}, wall, busy)], "here")
    assert found.load.value == pytest.approx(1 / 3, abs=1e-4)
    assert found.load.interval == (0.0, 0.5)
    assert found.p99.value == 1.0, "the load says it all"
    quiet = disturbance_of([Timing("p", "m", {"cell": 1}, (1.0,) * 99 + (5.0,), (1.0,) * 100)], "here")
    assert quiet.load.value == pytest.approx(4 / 104, abs=1e-4)
    assert quiet.median.value == 1.0


class Clocks:
    """Clocks that move by what a run is said to take."""

    def __init__(self) -> None:
        self.wall = self.processor = 0.0

    def run(self, wall: float, processor: float) -> Callable[[], None]:
        def act() -> None:
            self.wall += wall
            self.processor += processor

        return act


def test_plans_are_timed_by_both_clocks_less_a_call() -> None:
    clocks = Clocks()
    plan = TimedPlan("p", "m", None, {"cell": 10}, clocks.run(3.0, 2.0), clocks.run(0.5, 0.5))  # type: ignore[arg-type]
    (timing,) = time_plans([plan], 0.0, clocks=(lambda: clocks.wall, lambda: clocks.processor))
    assert timing.wall == (2.5,) * 3
    assert timing.processor == (1.5,) * 3
    assert len(time_plans([plan], 100.0, clocks=(lambda: clocks.wall, lambda: clocks.processor))[0].wall) > 3


def timings() -> Iterator[Timing]:
    """Every plan that is timed, at 1 ns a unit with no noise."""
    asked = [*questions((("rooms", {"rows": 30, "columns": 40, "seed": 1}), ("empty", {"rows": 25, "columns": 20})))]
    for plan in plans_on(asked, [*HOSTS.find("epyc-9004").costs]):
        each = (1e-9 * sum(plan.units.values()),) * 3
        yield Timing(plan.program, plan.map, plan.units, each, each)


def measured() -> MeasuredHost:
    first = dict.fromkeys(HOSTS.find("epyc-9004").costs, 1e-9)
    all_timings = [*timings()]
    fits = fit_programs(all_timings, first, "a machine")
    costs = {name: cost for fit in fits for name, cost in fit.costs.items()}
    return MeasuredHost("a machine", 4, None, costs, disturbance_of(all_timings, "a machine"), fits, {})


def test_every_timed_plan_counts_in_kernels_and_equal_costs_are_found() -> None:
    host = measured()
    on_board = {"relaxation sequential gs 1e-15 8"}
    assert {fit.program for fit in host.fits} == set(all_timed()) - on_board, "its kernels stand in those before it"
    for name, cost in host.costs.items():
        assert cost.value == pytest.approx(1e-9, rel=0.02), name


def test_a_host_file_holds_what_was_measured_and_says_what_was_not(tmp_path: Any) -> None:
    host = measured()
    (tmp_path / "mine.yaml").write_text(host_text(host, "mine", "cortex-a72"))
    loaded = HOSTS.find("mine", [tmp_path])
    assert loaded.cores == 4
    assert loaded.load is not None
    assert loaded.costs.keys() == host.costs.keys()
    assert loaded.all_costs()["occupancy_cell"].status == "assumed"
    assert loaded.power.busy.source.startswith("of host cortex-a72; ")
    assert yaml.safe_load(processor_text(host))["cores"] == 4
    (tmp_path / "mine.yaml").write_text(host_text(host, "mine", None))
    low, high = HOSTS.find("mine", [tmp_path]).power.busy.interval
    assert high / low > 1000, "any computer's"
    assert host_document(host)["fits"][0]["maps"][0].keys() == {"map", "measured_s", "predicted_s", "held_out_s"}
